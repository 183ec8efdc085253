// SPDX-License-Identifier: BSD-3-Clause
// Frames, only when something has changed; the viewer's state after each, and the rest of it, for all that need it.

import { Rest } from "./rest.js";
import { canvas, fingers, line, viewer } from "./shared.js";

export let lastStatus = {};
export const rest = new Rest(() => fingers && wake()); // of the viewer
let show; // startFrames
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
  // After each picture one more frame: it shows how fast the device is.
  if (drawn || lastStatus.plain || lastStatus.turnsOn) {
    wake();
  }
}

// A canvas keeps its picture for as long as the turn lasts in which this is called.
export function redraw() {
  viewer.redraw();
  viewer.frame();
}

// From here on; the canvas has as many pixels as the screen under it. shows: called after each frame, with the status before it.
export function startFrames(shows) {
  show = shows;
  const observer = new ResizeObserver(([{ contentBoxSize: [points], devicePixelContentBoxSize: [exact] = [] }]) => {
    // An emulated screen reports points instead of pixels: the exact size only decides the rounding.
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
  viewer.frame(); // at once: a canvas that is resized is blank
  wake();
}
