// SPDX-License-Identifier: BSD-3-Clause
// Passes fingers, mouse, wheel and keys on the canvas to the session, as touches. The session decides what they mean; this code
// knows nothing about gestures.

const wheelLine = 16; // points per line that a mouse's wheel reports
const slop = 10; // points: a shorter movement is a tap, on a page that one finger scrolls

export class Fingers {
  #canvas;
  #viewer;
  #changed;
  #down = new Map(); // by pointer: { x, y, isPair } in points of the window
  #moved = 0; // time of the last move that has not been passed to the viewer
  #outside = null; // pointerdown of a finger that may scroll the embedding page
  #scale = 1; // in the last event of a trackpad's pinch

  entered = true; // otherwise one finger scrolls the embedding page (embedding.js)
  onEnter = () => {};

  // changed: called whenever the viewer has received input, or should receive it by flush.
  constructor(canvas, viewer, changed) {
    this.#canvas = canvas;
    this.#viewer = viewer;
    this.#changed = changed;
    const listen = (name, handler) => canvas.addEventListener(name, handler.bind(this), { passive: false });
    listen("pointerdown", this.#press);
    listen("pointermove", this.#move);
    listen("pointerup", this.#lift);
    listen("pointercancel", this.#cancel);
    listen("touchmove", (event) => this.#down.size && event.cancelable && event.preventDefault());
    listen("wheel", this.#wheel);
    listen("keydown", this.#key);
    for (const name of ["gesturestart", "gesturechange"]) {
      listen(name, this.#gesture);
    }
    for (const name of ["contextmenu", "selectstart"]) {
      listen(name, (event) => event.preventDefault());
    }
  }

  // Passes moves to the viewer; call this before drawing. All moves since the last frame become one.
  flush() {
    if (this.#moved) {
      this.#tell(this.#moved);
    }
  }

  // Call this when the canvas has moved or changed its size: earlier touches no longer count.
  restart() {
    this.#down.size && this.#drop();
  }

  // From now on one finger turns the model, or (false) scrolls the page again.
  enter(enters = true) {
    if (this.entered !== enters) {
      this.entered = enters;
      this.#outside = null;
      if (!enters && this.#down.size) {
        this.#down.clear();
        this.#drop();
      }
      this.onEnter();
    }
  }

  #drop() {
    this.#viewer.cancelTouches();
    this.#tell(performance.now());
  }

  #tell(milliseconds) {
    this.#moved = 0;
    const pointers = [...this.#down].map(([id, { x, y, isPair }]) => ({ id: 2 * id, isPair, ...this.#pixel(x, y) }));
    this.#viewer.touches(milliseconds / 1000, pointers);
    this.#changed();
  }

  // The canvas's pixel at a point of the window.
  #pixel(x, y) {
    const box = this.#canvas.getBoundingClientRect();
    return {
      x: (x - box.left) * this.#canvas.width / box.width,
      y: (y - box.top) * this.#canvas.height / box.height,
    };
  }

  #press(event) {
    const { pointerId, pointerType, button, shiftKey, clientX, clientY } = event;
    if (!this.entered && pointerType !== "mouse") {
      const first = this.#outside;
      this.#outside = event;
      if (!first) {
        return;
      }
      this.enter(); // two fingers
      this.#press(first);
    }
    const right = button === 2 || (button === 0 && shiftKey);
    if (pointerType === "mouse" && button !== 0 && !right) {
      return;
    }
    this.flush();
    this.#canvas.setPointerCapture(pointerId);
    this.#down.set(pointerId, { x: clientX, y: clientY, isPair: pointerType === "mouse" && right });
    this.#tell(event.timeStamp);
  }

  #move({ pointerId, clientX, clientY, timeStamp }) {
    const finger = this.#down.get(pointerId);
    if (finger) {
      finger.x = clientX;
      finger.y = clientY;
      this.#moved = timeStamp;
      this.#changed();
    }
  }

  #lift(event) {
    const first = this.#outside;
    if (first?.pointerId === event.pointerId && Math.hypot(event.clientX - first.clientX, event.clientY - first.clientY) < slop) {
      this.enter();
    }
    this.#outside = null;
    if (this.#down.has(event.pointerId)) {
      this.flush();
      this.#down.delete(event.pointerId);
      this.#tell(event.timeStamp);
    }
  }

  #cancel({ pointerId }) {
    this.#outside = null; // the finger scrolls
    this.#down.delete(pointerId) && this.#drop();
  }

  #wheel(event) {
    event.preventDefault();
    const { deltaY, deltaMode, ctrlKey, clientX, clientY } = event;
    const points = deltaMode === 0 ? deltaY : deltaY * wheelLine;
    // Except Safari, browsers report a trackpad's pinch as a wheel with the control key.
    this.#zoom(Math.exp(-Math.max(-100, Math.min(100, points)) * (ctrlKey ? .01 : .002)), clientX, clientY);
  }

  // Safari reports the scale since the pinch began. On a phone it reports a pinch in addition to the fingers.
  #gesture(event) {
    event.preventDefault();
    const { type, scale, clientX, clientY } = event;
    if (type === "gesturechange" && !this.#down.size) {
      this.#zoom(scale / this.#scale, clientX, clientY);
    }
    this.#scale = scale;
  }

  #zoom(factor, clientX, clientY) {
    const { x, y } = this.#pixel(clientX, clientY);
    this.#viewer.zoom(factor, x, y);
    this.#changed();
  }

  #key(event) {
    const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const zooms = { "+": true, "=": true, "-": false };
    const jumps = { Home: "goHome", h: "goHome", u: "undoView", Backspace: "undoView" };
    if (event.ctrlKey || event.metaKey || event.altKey || ![turns, zooms, jumps].some((keys) => event.key in keys)) {
      return;
    }
    event.preventDefault();
    if (event.key in jumps) {
      this.#viewer[jumps[event.key]]();
    } else if (event.key in turns) {
      this.#down.size || this.#viewer.byKey("Drag", ...turns[event.key], event.shiftKey, event.timeStamp / 1000);
    } else {
      this.#viewer.byKey("Zoom", zooms[event.key]);
    }
    this.#changed();
  }

  // Taps in the middle, for users without a pointer. times: 2 for a double tap.
  tap(times) {
    this.#down.size || this.#viewer.byKey("Tap", times, performance.now() / 1000);
  }
}
