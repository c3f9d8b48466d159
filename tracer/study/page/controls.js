"use strict";
// Buttons, sliders and keys, the scale of colours, and the values under the pointer.

/** Return the value of a map, and the map's pixel, under a pixel of the picture. */
function under({ width, height, values }, x, y) {
  const coarser = scene().mapFactor / scene().factor;
  return values[Math.min(height - 1, Math.floor(y / coarser)) * width + Math.min(width - 1, Math.floor(x / coarser))];
}

function showValue(data) {
  if (!state.pointer) {
    byId("value").textContent = "Move over the picture to read values.";
    return;
  }
  const { x, y } = state.pointer, k = y * scene().width + x, { factor } = scene();
  const rgb = ({ values }) => [0, 1, 2].map((channel) => values[3 * k + channel].toPrecision(3));
  const shown = state.mode === "side" ? [...scene().methods.keys()] : [state.method, ...(state.mode === "wipe" ? [state.against] : [])];
  const lines = [...new Set(shown)].filter((method) => method !== REFERENCE).map((method) =>
    [nameOf(method), ...rgb(data.images[method]), under(data.errors[method], x, y).toPrecision(2), Math.round(under(data.counts[method], x, y))]);
  const table = document.createElement("table");
  for (const [n, words] of [[`pixel ${x * factor}, ${y * factor}`, "R", "G", "B", "error", "spp"], ...lines, ["reference", ...rgb(data.truth), "", ""]].entries()) {
    const row = table.insertRow();
    row.append(...words.map((word) => Object.assign(document.createElement(n ? "td" : "th"), { textContent: word })));
  }
  byId("value").replaceChildren(table);
}

function showScale() {
  byId("scale").style.visibility = state.layer === "picture" ? "hidden" : "visible";
  const { errorTop, countRange: [least, most] } = scene(), parts = [0, 0.25, 0.5, 0.75, 1];
  const text = state.layer === "error"
    ? parts.map((part) => Number((100 * errorTop * part).toPrecision(2)) + " %")
    : parts.map((part) => String(Math.round(Math.max(least, 1) * (most / Math.max(least, 1)) ** part)));
  byId("scale-ticks").replaceChildren(...text.map((label) => Object.assign(document.createElement("span"), { textContent: label })));
}

function showControls() {
  const press = (element, pressed) => element.setAttribute("aria-pressed", String(pressed));
  for (const [k, button] of [...byId("scenes").children].entries()) press(button, k === state.scene);
  for (const button of byId("methods").children) press(button, Number(button.dataset.method) === state.method);
  for (const button of byId("layers").children) press(button, button.dataset.layer === state.layer);
  for (const button of byId("modes").children) press(button, button.dataset.mode === state.mode);
  byId("against-label").hidden = byId("wipe-label").hidden = state.mode !== "wipe";
  byId("against").value = String(state.against);
  byId("wipe").value = String(state.wipe);
  byId("exposure").value = String(state.stops);
  byId("stops").textContent = (state.stops > 0 ? "+" : "") + state.stops;
}

function button(text, title, data, action) {
  const made = Object.assign(document.createElement("button"), { type: "button", textContent: text, title });
  Object.assign(made.dataset, data);
  made.addEventListener("click", () => { action(); draw(); });
  return made;
}

function buildMethods() {
  const names = scene().methods.map((entry) => entry.name);
  const buttons = names.map((name, k) => button(name, k < 9 ? `${k + 1}` : "", { method: k }, () => { state.method = k; }));
  const focused = document.activeElement.dataset.method;
  byId("methods").replaceChildren(...buttons, button("reference", "R", { method: REFERENCE }, () => { state.method = REFERENCE; }));
  if (focused !== undefined) (byId("methods").querySelector(`[data-method="${focused}"]`) || byId("methods").lastChild).focus();
  byId("against").replaceChildren(...[...names.keys(), REFERENCE].map((k) => new Option(nameOf(k), String(k))));
}

const keys = {
  r: () => { state.method = REFERENCE; }, "[": () => goToScene(state.scene - 1), "]": () => goToScene(state.scene + 1),
  p: () => { state.layer = "picture"; }, e: () => { state.layer = "error"; }, s: () => { state.layer = "samples"; },
  f: () => { state.mode = "flip"; }, w: () => { state.mode = "wipe"; }, g: () => { state.mode = "side"; },
  ",": () => expose(state.stops - 0.5), ".": () => expose(state.stops + 0.5),
  "+": () => zoomBy(1.5), "=": () => zoomBy(1.5), "-": () => zoomBy(1 / 1.5), 0: fit, l: changeTheme,
};

function expose(stops) {
  state.stops = Math.min(8, Math.max(-8, stops));
}

function fit() {
  Object.assign(state, { zoom: 1, x: 0.5, y: 0.5 });
}

function changeTheme() {
  const dark = matchMedia("(prefers-color-scheme: dark)").matches, root = document.documentElement;
  const now = root.dataset.theme || (dark ? "dark" : "light");
  root.dataset.theme = now === "dark" ? "light" : "dark";
}

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("select, input:not([type=range])")) return;
  const digit = Number(event.key);
  if (event.key.startsWith("Arrow")) {
    if (!moveByArrow(event)) return;
    event.preventDefault();
  } else if (digit >= 1 && digit <= scene().methods.length) state.method = digit - 1;
  else if (keys[event.key.toLowerCase()]) keys[event.key.toLowerCase()]();
  else return;
  draw();
});

/** Do what an arrow key asks for where the focus is; return whether it asks for anything. */
function moveByArrow(event) {
  const [across, down] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
  const inPicture = event.target.closest("#panes"), inScenes = event.target.closest("#scenes");
  if (event.target.closest("input, .wide")) return false; // these move or scroll themselves
  if (event.shiftKey) {
    if (!inPicture) return false;
    state.x += 0.1 * across / state.zoom;
    state.y += 0.1 * down / state.zoom;
    clampPlace();
  } else if (inScenes) {
    goToScene(state.scene + across + down);
    byId("scenes").children[state.scene].focus();
  } else if (across) flip(across);
  else if (inPicture) goToScene(state.scene + down);
  else return false;
  return true;
}

/** Return the button of a scene: its reference as a small picture above its name. */
function sceneButton(entry, k) {
  const made = button("", "[ ]", {}, () => goToScene(k));
  const thumbnail = Object.assign(new Image(), { src: byId(entry.reference).src, alt: "", className: "picture" });
  made.append(thumbnail, entry.name);
  return made;
}

function start() {
  if (!study.scenes.length) return;
  byId("scenes").replaceChildren(...study.scenes.map(sceneButton));
  buildMethods();
  for (const element of byId("layers").children) element.addEventListener("click", () => { state.layer = element.dataset.layer; draw(); });
  for (const element of byId("modes").children) element.addEventListener("click", () => { state.mode = element.dataset.mode; draw(); });
  byId("exposure").addEventListener("input", (event) => { expose(Number(event.target.value)); draw(); });
  byId("wipe").addEventListener("input", (event) => { state.wipe = Number(event.target.value); draw(); });
  byId("against").addEventListener("change", (event) => { state.against = Number(event.target.value); draw(); });
  byId("fit").addEventListener("click", () => { fit(); draw(); });
  byId("theme").addEventListener("click", changeTheme);
  const context = byId("scale-colours").getContext("2d"), row = context.createImageData(256, 1);
  paintValues(row.data, Float32Array.from({ length: 256 }, (_, k) => k / 255), (value) => value);
  context.putImageData(row, 0, 0);
  window.addEventListener("resize", draw);
  draw();
}

start();
