// SPDX-License-Identifier: BSD-3-Clause
// The viewer in WebAssembly as an object: calls the exports of WebViewer.cxx, and passes texts and bytes in and out.

import { bytesAt, forgetObjects, gainCanvas, picturesAreWaiting, useContext } from "./gl.js";
import { loadFirstPart, whole } from "./parts.js";

const toBytes = new TextEncoder();
const toText = new TextDecoder();

export const Action = { none: 0, connect: 1, send: 2, close: 3, fetch: 4, search: 5 };

// heard: called with the number of bytes so far, whenever some have arrived. The rest is loaded later (rest.js).
export async function loadViewer(heard) {
  functions = await loadFirstPart(heard);
  return new Viewer(functions);
}

// The functions of the WebAssembly, once it is loaded. Each viewer has its own session and canvas.
let functions = null;
export const anotherViewer = () => new Viewer(functions);

const colorings = ["own", "none", "partition", "resolution"];
export const colorMaps = ["viridis", "cividis", "diverging"];

// Returns the array that gives the colours, from colours in the form of links; "" if there is none.
export function arrayOf(colours) {
  try {
    return decodeURIComponent(colours.split(":")[1] ?? "");
  } catch {
    return "";
  }
}

class Viewer {
  #functions;
  #self;
  #context = null; // of WebGL

  // Set for good when the viewer has stopped, for example for lack of memory. Then every call does nothing.
  failure = null;

  constructor(functions) {
    this.#functions = functions;
    this.#self = this.#functions.ViewerMake();
    whole.then(() => this.#call("BecomeWhole"));
  }

  #call(name, ...values) {
    if (this.failure) {
      return 0;
    }
    try {
      useContext(this.#context);
      return this.#functions["Viewer" + name](this.#self, ...values);
    } catch (error) {
      this.failure = error;
      return 0;
    }
  }

  // Copies bytes to where the next call finds them. Returns false if there are too many.
  #put(bytes) {
    const place = this.#call("Inbox", bytes.byteLength);
    if (place) {
      bytesAt(place, bytes.byteLength).set(bytes);
    }
    return place !== 0;
  }

  #putText(text) {
    return this.#put(toBytes.encode(text));
  }

  #text() {
    const begin = this.#call("Text");
    return toText.decode(bytesAt(begin, this.#call("TextBytes")));
  }

  // Returns the viewer's JSON of this name; `otherwise` if the viewer has stopped.
  #describe(name, otherwise) {
    this.#call(name);
    return JSON.parse(this.#text() || otherwise);
  }

  // ---- what the user does; positions are pixels of the canvas

  select(model) {
    this.#putText(model);
    this.#call("Select");
  }

  enterFullScreen() {
    this.#call("EnterFullScreen");
  }

  leaveFullScreen() {
    this.#call("LeaveFullScreen");
  }

  // pointers: all that are down now, [{ id, x, y, isPair }]. isPair: the pointer stands for two fingers; the other finger has the
  // next id.
  touches(seconds, pointers) {
    const values = new Float64Array(pointers.flatMap(({ id, x, y, isPair }) => [id, x, y, isPair]));
    if (this.#put(new Uint8Array(values.buffer))) {
      this.#call("Touches", seconds);
    }
  }

  cancelTouches() {
    this.#call("CancelTouches");
  }

  zoom(factor, x, y) {
    this.#call("Zoom", factor, x, y);
  }

  // Does what keys do in the middle of the canvas: "Drag" (right, down: -1, 0 or 1; pans; seconds), "Tap" (times, seconds) or
  // "Zoom" (isIn).
  byKey(act, ...values) {
    this.#call(act + "ByKey", ...values);
  }

  goHome() {
    this.#call("GoHome");
  }

  undoView() {
    this.#call("UndoView");
  }

  // side: "front", "back", "left", "right", "top" or "bottom".
  lookFromSide(side) {
    this.#putText(side);
    this.#call("LookFromSide");
  }

  setSpinning(spins) {
    this.#call("SetSpinning", spins);
  }

  // link: the text after the # of a URL, model=…; the status reports errors in it.
  follow(link) {
    this.#putText(link);
    this.#call("Follow");
  }

  // Returns a link to the current view, without colours.
  link() {
    this.#call("Link");
    return this.#text();
  }

  // tool: 0 none, 1 measure, 2 section, 3 light, 4 second light.
  setTool(tool) {
    this.#call("SetTool", tool);
  }

  // side: "front", "side", "above", "view", "flip" or "off".
  setSectionAlong(side) {
    this.#putText(side);
    this.#call("SetSectionAlong");
  }

  setSectionDepth(depth) {
    this.#call("SetSectionDepth", depth);
  }

  // Returns an SVG.
  sectionOutline() {
    this.#call("SectionOutline");
    return this.#text();
  }

  // light, secondLight: intensities of the two lights, 0-2. relief: 0-1.
  dim(light, secondLight, relief) {
    this.#call("Dim", light, secondLight, relief);
  }

  setStandardLight() {
    this.#call("StandardLight");
  }

  measurements() {
    return this.#describe("Measurements", "[]");
  }

  // Marks the points of the surface that the views of these links look at.
  setMarks(links) {
    this.#putText(links.join("\n"));
    this.#call("SetMarks");
  }

  // Returns [x, y, isSeen] of each mark in order, in pixels of the canvas; null for a mark that has no place on the screen.
  marks() {
    return this.#describe("Marks", "[]");
  }

  nameMeasurement(index, name) {
    this.#putText(name);
    this.#call("NameMeasurement", index);
  }

  removeMeasurement(index) {
    this.#call("RemoveMeasurement", index);
  }

  // turning: 0 upright, 1 free.
  setTurning(turning) {
    this.#call("SetTurning", turning);
  }

  // detail: 0 as the view needs, 1 one level for the whole model.
  setDetail(detail) {
    this.#call("SetDetail", detail);
  }

  // bytes: how much is fetched before it is needed.
  setPrefetch(bytes) {
    this.#call("SetPrefetch", bytes);
  }

  // motion: whether anything moves by itself.
  setMotion(motion) {
    this.#call("SetMotion", motion);
  }

  setRings(rings) {
    this.#call("SetRings", rings);
  }

  // colors: in the form of links: own, partition, resolution, none, or by:NAME[:MAP[:LOW:HIGH]].
  setColors(colors) {
    const [by, , map, low, high] = colors.split(":");
    this.#putText(arrayOf(colors));
    this.#call("SetColors", colorings.indexOf(by), colorMaps.indexOf(map), low, high);
  }

  // Sets the colours of the background; each is 0xrrggbb.
  setBackground(bottom, top) {
    this.#call("SetBackground", bottom, top);
  }

  // Sets the limit for WebAssembly's memory and graphics memory together; what is shown adapts to it.
  setMemory(bytes) {
    this.#call("SetMemory", bytes);
  }

  // ---- the canvas

  // Returns false if the browser has no WebGL 2.
  gainCanvas(canvas) {
    this.#context = gainCanvas(canvas);
    if (this.#context) {
      this.#call("MakeRenderer");
    }
    return this.#context !== null;
  }

  // The viewer must not be used afterwards.
  drop() {
    this.#call("Drop");
    this.failure ??= new Error("dropped");
  }

  contextLost() {
    this.#call("ContextLost");
    forgetObjects(this.#context);
  }

  contextRestored() {
    this.#call("MakeRenderer");
  }

  resize(width, height, pixelRatio) {
    this.#call("Resize", width, height, pixelRatio);
  }

  // Makes the next frame draw, even if nothing has changed.
  redraw() {
    this.#call("Redraw");
  }

  // Draws if something has changed; returns whether it had.
  frame() {
    return this.#call("Frame") === 1;
  }

  // ---- the connection to the server

  // Takes the list of models as the server sent it. Returns why it is not a list, or "".
  setModels(bytes) {
    if (!this.#put(bytes)) {
      return "it is too long";
    }
    return this.#call("SetModels") ? "" : this.#text();
  }

  socketOpened(now) {
    this.#call("SocketOpened", now);
  }

  // Returns false if the message is longer than any valid one.
  socketMessage(data, now) {
    const isText = typeof data === "string";
    const known = isText ? this.#putText(data) : this.#put(new Uint8Array(data));
    if (known) {
      this.#call(isText ? "SocketText" : "SocketFrame", now);
    }
    return known;
  }

  // refused: the server answers, but has no stream for this page. retryAfter: the seconds that a busy server asks to wait, or 0.
  socketEnded(refused, why, now, retryAfter) {
    this.#putText(why);
    this.#call("SocketEnded", refused, now, retryAfter);
  }

  fetched(status, bytes, now, retryAfter) {
    this.#put(bytes);
    this.#call("Fetched", status, now, retryAfter);
  }

  fetchFailed(why, now) {
    this.#putText(why);
    this.#call("Fetched", 0, now, 0);
  }

  tick(now) {
    this.#call("Tick", now);
  }

  retryNow() {
    this.#call("RetryNow");
  }

  // ---- what the viewer returns

  // Call this after every input; then do what nextAction returns, until it returns Action.none.
  exchange(now) {
    this.#call("Exchange", now);
  }

  nextAction() {
    const kind = this.#call("NextAction");
    const texts = [Action.send, Action.fetch, Action.search].includes(kind);
    return { kind, text: texts ? this.#text() : "", mostBytes: this.#call("MostBytes") };
  }

  // Passes a stored blob (an ArrayBuffer) that a search asked for. index: its position in the search.
  found(search, index, bytes) {
    if (this.#put(new Uint8Array(bytes))) {
      this.#call("Found", search, index);
    }
  }

  // The other blobs of the search are not stored. isKept: the user has stored the model on request.
  endSearch(search, isKept, now) {
    this.#call("EndSearch", search, isKept, now);
  }

  // Whether nextArrival returns arriving blobs, and stored blobs are searched first.
  setKeeps(keeps) {
    this.#call("SetKeeps", keeps);
  }

  // Returns the next blob that has arrived, { path, bytes }, or null.
  nextArrival() {
    const begin = this.#call("Arrival");
    return begin ? { path: this.#text(), bytes: bytesAt(begin, this.#call("ArrivalBytes")).slice().buffer } : null;
  }

  // Returns the legend for colours of detail: [{ level, color }], the finest first; level -1 is the original, color is 0xrrggbb.
  legend() {
    return this.#describe("Legend", "[]");
  }

  // Returns the arrays that the model can be coloured by and, for the current array, the range of the map, and the classes: {
  // arrays, low, high, classes }.
  arrays() {
    this.#call("Arrays");
    return JSON.parse(this.#text());
  }

  // Returns the colour, 0xrrggbb, for a value of that array.
  shade(number) {
    return this.#call("Shade", number);
  }

  // Returns { budget, heap, used, pieces, graphics } in bytes.
  memory() {
    return this.#describe("Memory", "{}");
  }

  // Returns the state for the user; page.js describes its members.
  status() {
    const status = this.#describe("Status", "{}");
    status.idle &&= !picturesAreWaiting();
    return status;
  }
}
