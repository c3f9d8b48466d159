"use strict";
// The viewer: which pictures are shown, which part of them, and the values under the pointer. All panes show the same part.

const REFERENCE = -1;
const byId = (name) => document.getElementById(name);
const state = { scene: 0, method: 0, layer: "picture", mode: "flip", stops: 0, wipe: 0.5, against: REFERENCE, zoom: 1, x: 0.5, y: 0.5, pointer: null };
const loaded = new Map();
let panes = [];

const scene = () => study.scenes[state.scene];
const nameOf = (method) => (method === REFERENCE ? "reference" : scene().methods[method].name);

/** Return the decoded pictures of a scene, or a promise of them while they are being decoded. */
function load(index) {
  if (!loaded.has(index)) {
    const { width, height, reference, methods } = study.scenes[index];
    loaded.set(index, Promise.all([
      decodePicture(reference, width, height),
      ...methods.map((entry) => decodePicture(entry.image, width, height)),
      ...methods.map((entry) => decodeCounts(entry.counts, width, height)),
    ]).then(([truth, ...rest]) => {
      const images = rest.slice(0, methods.length);
      const data = { truth, images, counts: rest.slice(methods.length), errors: images.map((image) => relativeError(image, truth)), painted: new Map() };
      loaded.set(index, data);
      return data;
    }));
  }
  return loaded.get(index);
}

/** Return a canvas with the present layer of a method, or with the picture of the reference, which has no other layer. */
function painted(data, method) {
  const layer = method === REFERENCE ? "picture" : state.layer;
  const key = `${method} ${layer} ${layer === "picture" ? state.stops : ""}`;
  if (!data.painted.has(key)) {
    if (data.painted.size > 40) data.painted.clear();
    const { width, height, errorTop, countRange: [least, most] } = scene();
    const canvas = Object.assign(document.createElement("canvas"), { width, height });
    const context = canvas.getContext("2d"), picture = context.createImageData(width, height);
    if (layer === "picture") paintPicture(picture.data, method === REFERENCE ? data.truth : data.images[method], state.stops);
    else if (layer === "error") paintValues(picture.data, data.errors[method], (error) => error / errorTop);
    else paintValues(picture.data, data.counts[method], (count) => logarithmic(count, least, most));
    context.putImageData(picture, 0, 0);
    data.painted.set(key, canvas);
  }
  return data.painted.get(key);
}

function logarithmic(count, least, most) {
  return most > least ? Math.log2(Math.max(count, 1) / Math.max(least, 1)) / Math.log2(most / Math.max(least, 1)) : 0.5;
}

/** Return the methods that have a pane in the present arrangement. */
function shownMethods() {
  return state.mode === "side" ? [REFERENCE, ...scene().methods.keys()] : [state.method];
}

/** Make the panes that the arrangement needs. */
function arrange() {
  const methods = shownMethods(), columns = state.mode === "side" ? Math.min(4, Math.ceil(Math.sqrt(methods.length))) : 1;
  const focused = byId("panes").contains(document.activeElement);
  byId("panes").style.gridTemplateColumns = `repeat(${columns}, 1fr)`;
  byId("panes").replaceChildren(...methods.map(() => makePane()));
  panes = [...byId("panes").children].map((element, k) => ({ canvas: element.firstChild, captions: [...element.querySelectorAll(".caption")], method: methods[k] }));
  if (focused) panes[0].canvas.focus();
}

function makePane() {
  const element = Object.assign(document.createElement("div"), { className: "pane" });
  const canvas = Object.assign(document.createElement("canvas"), { tabIndex: 0 });
  canvas.setAttribute("role", "img");
  element.append(canvas, Object.assign(document.createElement("span"), { className: "caption" }), Object.assign(document.createElement("span"), { className: "caption right" }));
  listen(canvas);
  return element;
}

/** Draw everything, once the scene is decoded. */
async function draw() {
  const index = state.scene, data = await load(index);
  if (index !== state.scene) return;
  if (panes.length !== shownMethods().length) arrange();
  if (state.mode !== "side") panes[0].method = state.method;
  for (const pane of panes) drawPane(pane, data);
  showControls();
  showScale();
  showValue(data);
}

function drawPane({ canvas, captions, method }, data) {
  const { width, height } = scene(), screen = window.devicePixelRatio || 1;
  const across = Math.max(1, Math.round(canvas.parentElement.clientWidth * screen));
  const down = Math.round(Math.min(across * height / width, 0.7 * window.innerHeight * screen));
  if (canvas.width !== across || canvas.height !== down) Object.assign(canvas, { width: across, height: down });
  const context = canvas.getContext("2d"), place = placement(canvas);
  const image = (which) => context.drawImage(painted(data, which), place.left, place.top, width * place.scale, height * place.scale);
  context.imageSmoothingEnabled = place.scale < 1;
  context.clearRect(0, 0, across, down);
  image(method);
  const wiped = state.mode === "wipe";
  if (wiped) {
    const edge = Math.round(state.wipe * across);
    context.save();
    context.beginPath();
    context.rect(edge, 0, across - edge, down);
    context.clip();
    context.clearRect(edge, 0, across - edge, down);
    image(state.against);
    context.restore();
    context.fillStyle = "#fff";
    context.fillRect(edge - 1, 0, 2, down);
  }
  if (state.pointer && place.scale > 0) {
    context.strokeStyle = "#fff";
    context.strokeRect(place.left + state.pointer.x * place.scale - 0.5, place.top + state.pointer.y * place.scale - 0.5, place.scale + 1, place.scale + 1);
  }
  captions[0].textContent = caption(method);
  captions[1].textContent = wiped ? caption(state.against) : "";
  captions[1].hidden = !wiped;
  canvas.setAttribute("aria-label", `${scene().name}, ${captions[0].textContent}${wiped ? " beside " + caption(state.against) : ""}`);
}

function caption(method) {
  if (method === REFERENCE) return "reference";
  const layer = state.layer === "picture" ? "" : ` · ${state.layer === "error" ? "relative error" : "samples per pixel"}`;
  const made = state.mode === "side" ? "" : ` · ${scene().caption}`;
  return `${nameOf(method)}${made} · ${scene().methods[method].score}${layer}`;
}

/** Return where the picture lies on a canvas: left and top edge, and screen pixels per picture pixel. */
function placement(canvas) {
  const { width, height } = scene();
  const scale = Math.min(canvas.width / width, canvas.height / height) * state.zoom;
  return { scale, left: canvas.width / 2 - state.x * width * scale, top: canvas.height / 2 - state.y * height * scale };
}

/** Return the picture coordinates of a pointer event. */
function position(canvas, event) {
  const box = canvas.getBoundingClientRect(), { scale, left, top } = placement(canvas), ratio = canvas.width / box.width;
  return { x: ((event.clientX - box.left) * ratio - left) / scale, y: ((event.clientY - box.top) * ratio - top) / scale };
}

function zoomBy(factor, canvas, at) {
  const zoom = Math.min(64, Math.max(1, state.zoom * factor)), change = state.zoom / zoom, { width, height } = scene();
  const anchor = at ? { x: at.x / width, y: at.y / height } : { x: state.x, y: state.y };
  state.x = anchor.x + (state.x - anchor.x) * change;
  state.y = anchor.y + (state.y - anchor.y) * change;
  state.zoom = zoom;
  clampPlace();
}

function clampPlace() {
  if (state.zoom === 1) state.x = state.y = 0.5;
  state.x = Math.min(1, Math.max(0, state.x));
  state.y = Math.min(1, Math.max(0, state.y));
}

function listen(canvas) {
  let drag = null;
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoomBy(2 ** (-event.deltaY / 240), canvas, position(canvas, event));
    draw();
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => {
    const box = canvas.getBoundingClientRect(), across = (event.clientX - box.left) / box.width;
    drag = { x: event.clientX, y: event.clientY, wipe: state.mode === "wipe" && Math.abs(across - state.wipe) * box.width < 10 };
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    const box = canvas.getBoundingClientRect(), { width, height } = scene();
    if (drag && drag.wipe) state.wipe = Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
    else if (drag) {
      const scale = placement(canvas).scale * box.width / canvas.width;
      state.x -= (event.clientX - drag.x) / scale / width;
      state.y -= (event.clientY - drag.y) / scale / height;
      Object.assign(drag, { x: event.clientX, y: event.clientY });
      clampPlace();
    }
    const { x, y } = position(canvas, event);
    state.pointer = x >= 0 && y >= 0 && x < width && y < height ? { x: Math.floor(x), y: Math.floor(y) } : null;
    draw();
  });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, () => { drag = null; });
  canvas.addEventListener("pointerleave", () => { state.pointer = null; draw(); });
  canvas.addEventListener("keydown", (event) => {
    const pan = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (!pan || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.shiftKey) {
      state.x += 0.1 * pan[0] / state.zoom;
      state.y += 0.1 * pan[1] / state.zoom;
      clampPlace();
    } else if (pan[0]) flip(pan[0]);
    else return;
    event.preventDefault();
    draw();
  });
}

/** Go to the next or previous method; the reference comes after the last. */
function flip(step) {
  const count = scene().methods.length + 1;
  state.method = (state.method + 1 + step + count) % count - 1;
}

function goToScene(index) {
  const next = (index + study.scenes.length) % study.scenes.length;
  if (study.scenes[next].width !== scene().width || study.scenes[next].height !== scene().height) Object.assign(state, { zoom: 1, x: 0.5, y: 0.5 });
  state.scene = next;
  state.pointer = null;
  state.method = Math.min(state.method, scene().methods.length - 1);
  state.against = Math.min(state.against, scene().methods.length - 1);
  buildMethods();
  document.querySelectorAll(".scene").forEach((section, k) => { section.hidden = k !== next; });
}

function showValue(data) {
  if (!state.pointer) {
    byId("value").textContent = "Move over the picture to read values.";
    return;
  }
  const { x, y } = state.pointer, k = y * scene().width + x;
  const rgb = (values) => [0, 1, 2].map((channel) => values[3 * k + channel].toPrecision(3).padStart(9)).join(" ");
  const shown = state.mode === "side" ? [...scene().methods.keys()] : [state.method, ...(state.mode === "wipe" ? [state.against] : [])];
  const lines = [...new Set(shown)].filter((method) => method !== REFERENCE).map((method) =>
    `${nameOf(method).padEnd(24)} ${rgb(data.images[method])}   error ${data.errors[method][k].toPrecision(3).padStart(8)}   samples ${Math.round(data.counts[method][k])}`);
  byId("value").textContent = [`pixel ${x * scene().factor}, ${y * scene().factor}`.padEnd(24) + "         R         G         B", ...lines, `${"reference".padEnd(24)} ${rgb(data.truth)}`].join("\n");
}

function showScale() {
  byId("scale").style.visibility = state.layer === "picture" ? "hidden" : "visible";
  const { errorTop, countRange: [least, most] } = scene(), parts = [0, 0.25, 0.5, 0.75, 1];
  const text = state.layer === "error"
    ? parts.map((part) => (100 * errorTop * part).toPrecision(2) + " %")
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
  if (digit >= 1 && digit <= scene().methods.length) state.method = digit - 1;
  else if (keys[event.key.toLowerCase()]) keys[event.key.toLowerCase()]();
  else return;
  draw();
});

function start() {
  if (!study.scenes.length) return;
  byId("scenes").replaceChildren(...study.scenes.map((entry, k) => button(entry.name, "[ ]", {}, () => goToScene(k))));
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
