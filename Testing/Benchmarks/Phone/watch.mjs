// SPDX-License-Identifier: BSD-3-Clause
// Functions that measure within a page, the same for all viewers. They run in the page, so they may not use anything
// outside themselves.

// Runs before the page's own scripts. Sets window.watched: { first: ms until the first frame with a model was drawn;
// drawn: triangles in the last frame's calls; memories: those of WebAssembly }.
export function watch() {
  const watched = window.watched = { first: null, drawn: 0, memories: [] };
  let triangles = 0, asked = false;

  // Whether the picture shows a model: the middle row of a mere background has only one colour.
  const showsModel = (gl) => {
    const { drawingBufferWidth: width, drawingBufferHeight: height } = gl;
    const target = gl.getParameter(gl.READ_FRAMEBUFFER_BINDING);
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, null);
    const row = new Uint8Array(4 * width);
    gl.readPixels(0, height >> 1, width, 1, gl.RGBA, gl.UNSIGNED_BYTE, row);
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, target);
    let [least, most] = [255, 0];
    for (let i = 0; i < row.length; i += 4) {
      least = Math.min(least, row[i]);
      most = Math.max(most, row[i]);
    }
    return most - least > 40;
  };

  // Called after all draw calls of a frame, while the frame's picture is still there.
  const endFrame = (gl) => {
    asked = false;
    watched.drawn = triangles;
    triangles = 0;
    if (watched.first === null && showsModel(gl)) {
      watched.first = performance.now();
    }
  };
  for (const [name, place] of [["drawElements", 1], ["drawArrays", 2], ["drawRangeElements", 3],
    ["drawElementsInstanced", 1], ["drawArraysInstanced", 2]]) {
    const draw = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function (...values) {
      draw.apply(this, values);
      triangles += values[0] === this.TRIANGLES ? values[place] / 3 : 0;
      if (!asked) {
        asked = true;
        queueMicrotask(() => endFrame(this));
      }
    };
  }
  const { instantiate } = WebAssembly;
  WebAssembly.instantiate = async (...values) => {
    const result = await instantiate(...values);
    const { memory } = (result.instance ?? result).exports;
    memory && watched.memories.push(memory);
    return result;
  };
}

// Turns the model: by a number of steps, one in each frame, each completely drawn, or for a number of seconds. Returns
// the ms of each frame, except the first three.
export async function turn({ steps, points, mostSeconds }) {
  const canvas = document.querySelector("canvas");
  const gl = canvas.getContext("webgl2");
  let step;
  const finger = (type, x) => canvas.dispatchEvent(new PointerEvent(type,
    { pointerId: 77, pointerType: "touch", isPrimary: true, button: 0, clientX: x, clientY: 400, bubbles: true }));
  if (window.peer) {
    const radians = 2 * points / canvas.clientWidth; // what turning by a finger does in our viewer
    step = () => requestAnimationFrame(() => window.peer.turn(radians));
  } else {
    canvas.setPointerCapture = () => {}; // the simulated finger cannot be captured
    let x = 100;
    finger("pointerdown", x);
    step = () => finger("pointermove", x += points);
  }
  const times = [];
  const pixel = new Uint8Array(4);
  const end = performance.now() + 1000 * mostSeconds;
  for (let i = 0; i <= steps && (i < 8 || performance.now() < end); ++i) {
    step();
    times.push(await new Promise((resolve) => {
      requestAnimationFrame(() => { // runs after the page's own callback, which was requested first
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
        resolve(performance.now());
      });
    }));
  }
  window.peer || finger("pointerup", 0);
  return times.slice(1).map((time, i) => time - times[i]).slice(3);
}

// Only for our viewer: the time from the second tap until the first partition of the region is shown, and until all of
// it is.
export function watchTap() {
  const tap = window.tap = { from: null, first: null, whole: null };
  document.getElementById("view").addEventListener("pointerup", () => (tap.from = performance.now()), true);
  const look = () => {
    const { region, idle } = window.kdstream.status();
    if (tap.from !== null && region?.shown > 0) {
      tap.first ??= performance.now() - tap.from;
      if (region.shown === region.partitions && idle) {
        tap.whole = performance.now() - tap.from;
        return;
      }
    }
    requestAnimationFrame(look);
  };
  look();
}
