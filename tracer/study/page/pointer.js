"use strict";
// What mouse, pen and finger do on a picture.

const SWIPE = 40, TAP = 10;

function listen(canvas) {
  let drag = null;
  canvas.addEventListener("wheel", (event) => {
    if (event.deltaY > 0 && state.zoom === 1) return; // the page scrolls on
    event.preventDefault();
    zoomBy(2 ** (-event.deltaY / 240), canvas, position(canvas, event));
    draw();
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => {
    const box = canvas.getBoundingClientRect(), across = (event.clientX - box.left) / box.width;
    const reach = event.pointerType === "touch" ? 30 : 10;
    drag = { x: event.clientX, y: event.clientY, from: [event.clientX, event.clientY], wipe: state.mode === "wipe" && Math.abs(across - state.wipe) * box.width < reach };
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
  canvas.addEventListener("pointerup", (event) => {
    if (drag && !drag.wipe && event.pointerType === "touch") finishTouch(canvas, event.clientX - drag.from[0], event.clientY - drag.from[1]);
    drag = null;
  });
  canvas.addEventListener("pointercancel", () => { drag = null; });
  canvas.addEventListener("pointerleave", () => { state.pointer = null; draw(); });
}

/** Take a finger's way over a picture for a tap or a swipe; while it is zoomed in, a swipe has moved it already. */
function finishTouch(canvas, across, down) {
  const tapped = Math.hypot(across, down) < TAP, swiped = Math.abs(across) > SWIPE && Math.abs(across) > Math.abs(down);
  if (tapped && state.mode === "side") Object.assign(state, { mode: "flip", method: panes.find((pane) => pane.canvas === canvas).method });
  else if (tapped) flip(1);
  else if (swiped && state.zoom === 1 && state.mode !== "side") flip(across < 0 ? 1 : -1);
  draw();
}
