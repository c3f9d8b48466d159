"use strict";
// The viewer: which pictures are shown, and which part of them. All panes show the same part.

const REFERENCE = -1, GAP = 6;
const byId = (name) => document.getElementById(name);
const state = { scene: 0, method: 0, layer: "picture", mode: "flip", stops: 0, wipe: 0.5, against: REFERENCE, zoom: 1, x: 0.5, y: 0.5, pointer: null };
const loaded = new Map();
let panes = [];

const scene = () => study.scenes[state.scene];
const nameOf = (method) => (method === REFERENCE ? "reference" : scene().methods[method].name);

/** Return the pictures and maps of a scene, or a promise of them while they are being decoded. */
function load(index) {
  if (!loaded.has(index)) {
    const { reference, methods, errorTop, countRange } = study.scenes[index];
    loaded.set(index, Promise.all([
      readPicture(reference),
      Promise.all(methods.map((entry) => readPicture(entry.image))),
      Promise.all(methods.map((entry) => readErrors(entry.error, errorTop))),
      Promise.all(methods.map((entry) => readCounts(entry.counts, countRange))),
    ]).then(([truth, images, errors, counts]) => {
      const data = { truth, images, errors, counts, painted: new Map() };
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
    const { errorTop, countRange: [least, most] } = scene();
    const { width, height, values } = method === REFERENCE ? data.truth : { picture: data.images, error: data.errors, samples: data.counts }[layer][method];
    const canvas = Object.assign(document.createElement("canvas"), { width, height });
    const context = canvas.getContext("2d"), picture = context.createImageData(width, height);
    if (layer === "picture") paintPicture(picture.data, values, state.stops);
    else if (layer === "error") paintValues(picture.data, values, (error) => error / errorTop);
    else paintValues(picture.data, values, (count) => logarithmic(count, least, most));
    context.putImageData(picture, 0, 0);
    data.painted.set(key, canvas);
  }
  return data.painted.get(key);
}

function logarithmic(count, least, most) {
  return most > least ? Math.log2(Math.max(count, 1) / Math.max(least, 1)) / Math.log2(most / Math.max(least, 1)) : 0.5;
}

/** Return the width and height, in pixels of the picture, over which a method's canvas is spread: maps are coarser. */
function extent(canvas) {
  const { width, height, factor, mapFactor } = scene(), coarser = mapFactor / factor;
  if (canvas.width === width || canvas.width === 1) return { width, height };
  return { width: canvas.width * coarser, height: canvas.height * coarser };
}

/** Return the methods that have a pane in the present arrangement. */
function shownMethods() {
  return state.mode === "side" ? [REFERENCE, ...scene().methods.keys()] : [state.method];
}

/** Make the panes that the arrangement needs. */
function arrange() {
  const methods = shownMethods(), focused = byId("panes").contains(document.activeElement);
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

/** Return the number of columns, and the width and height of a pane, with which all panes are largest within the window. */
function layOut(count) {
  const { width, height } = scene(), across = byId("panes").clientWidth;
  const down = Math.max(160, Math.min(window.innerHeight - byId("scenes").offsetHeight - 24, 0.94 * window.innerHeight));
  const candidates = Array.from({ length: Math.min(count, 6) }, (_, k) => {
    const columns = k + 1, rows = Math.ceil(count / columns);
    const most = Math.min((across - GAP * k) / columns, (down - GAP * (rows - 1)) / rows * width / height);
    return { columns, width: Math.max(1, Math.floor(most)), height: Math.max(1, Math.round(most * height / width)) };
  });
  return candidates.reduce((best, candidate) => (candidate.width > best.width ? candidate : best));
}

/** Draw everything, once the scene is decoded. */
async function draw() {
  const index = state.scene, data = await load(index);
  if (index !== state.scene) return;
  if (panes.length !== shownMethods().length) arrange();
  if (state.mode !== "side") panes[0].method = state.method;
  const size = layOut(panes.length);
  byId("panes").style.gridTemplateColumns = `repeat(${size.columns}, ${size.width}px)`;
  byId("panes").classList.toggle("moving", state.zoom > 1 || state.mode === "wipe");
  for (const pane of panes) drawPane(pane, data, size);
  showControls();
  showScale();
  showValue(data);
}

function drawPane({ canvas, captions, method }, data, size) {
  const screen = window.devicePixelRatio || 1;
  const across = Math.max(1, Math.round(size.width * screen)), down = Math.max(1, Math.round(size.height * screen));
  if (canvas.width !== across || canvas.height !== down) Object.assign(canvas, { width: across, height: down });
  Object.assign(canvas.style, { width: `${size.width}px`, height: `${size.height}px` });
  const context = canvas.getContext("2d"), place = placement(canvas);
  const image = (which) => {
    const shown = painted(data, which), spread = extent(shown);
    context.drawImage(shown, place.left, place.top, spread.width * place.scale, spread.height * place.scale);
  };
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
  byId("scenes").children[next].scrollIntoView({ block: "nearest", inline: "nearest" });
}
