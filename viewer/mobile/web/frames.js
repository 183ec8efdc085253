// SPDX-License-Identifier: BSD-3-Clause
// Draws frames, but only when something has changed. Has the viewer's state after each frame, and the rest of the viewer, for all
// other parts.

import { Rest } from "./rest.js";
import { canvas, fingers, line, viewer } from "./shared.js";

export let lastStatus = {};
export const rest = new Rest(() => fingers && wake()); // the rest of the viewer
let show; // set by startFrames
let frameAsked = false;

export function wake() {
  if (!frameAsked) {
    frameAsked = true;
    requestAnimationFrame(drawFrame);
  }
}

function drawFrame() {
  frameAsked = false;
  fingers.flush();
  const drawn = viewer.frame();
  line.exchange();
  const before = lastStatus;
  lastStatus = viewer.failure ? before : viewer.status();
  show(before);
  // After each picture another frame follows, because its time shows how fast the device is.
  if (drawn || lastStatus.plain || lastStatus.turnsOn) {
    wake();
  }
}

// A canvas keeps its picture only until the task ends in which this is called.
export function redraw() {
  viewer.redraw();
  viewer.frame();
}

// Starts to draw frames; the canvas gets as many pixels as the screen has below it. shows: called after each frame, with the
// status before it.
export function startFrames(shows) {
  show = shows;
  const observer = new ResizeObserver(([{ contentBoxSize: [points], devicePixelContentBoxSize: [exact] = [] }]) => {
    // An emulated screen reports points instead of pixels, so the exact size is only used for rounding.
    const pixels = (side) => {
      const about = points[side] * devicePixelRatio;
      return Math.abs(exact?.[side] - about) < 2 ? exact[side] : Math.round(about);
    };
    resize(pixels("inlineSize"), pixels("blockSize"), points.inlineSize);
  });
  try {
    observer.observe(canvas, { box: "device-pixel-content-box" });
  } catch {
    observer.observe(canvas); // Safari
  }
}

function resize(width, height, points) {
  canvas.width = Math.max(width, 1);
  canvas.height = Math.max(height, 1);
  viewer.resize(canvas.width, canvas.height, points ? canvas.width / points : devicePixelRatio);
  fingers.restart();
  viewer.frame(); // at once, because resizing clears a canvas
  wake();
}
