// SPDX-License-Identifier: BSD-3-Clause
// The viewer in WebAssembly, as an object: what WebViewer.cxx exports, with texts and bytes carried in and out.

import { bytesAt, forgetObjects, gainCanvas, picturesAreWaiting, useContext } from "./gl.js";
import { loadFirstPart, whole } from "./parts.js";

const toBytes = new TextEncoder();
const toText = new TextDecoder();

export const Action = { none: 0, connect: 1, send: 2, close: 3, fetch: 4, search: 5 };

// heard: called whenever some of it has come, with the bytes so far. The rest of it comes later (rest.js).
export async function loadViewer(heard) {
  functions = await loadFirstPart(heard);
  return new Viewer(functions);
}

// The functions of the WebAssembly, once it is loaded. A viewer has its own session and canvas.
let functions = null;
export const anotherViewer = () => new Viewer(functions);

const colorings = ["own", "none", "partition", "resolution"];
export const colorMaps = ["viridis", "cividis", "diverging"];

// The array that colours are by, as links have them; "" for none.
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

  // Set permanently when the viewer has stopped for lack of memory. Every call does nothing then.
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

  // Copies bytes to where the next call finds them. False where they are too many.
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

  // The viewer's JSON of this name; `otherwise` if the viewer has stopped.
  #describe(name, otherwise) {
    this.#call(name);
    return JSON.parse(this.#text() || otherwise);
  }

  // ---- what the person does; places in pixels of the canvas

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

  // All pointers that are down now: [{ id, x, y, isPair }]. isPair: the pointer stands for two fingers; the other finger has the
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

  // What keys do in the middle of the canvas: "Drag" (right, down: -1, 0 or 1; pans; seconds), "Tap" (times, seconds) or
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

  // "front", "back", "left", "right", "top" or "bottom".
  lookFromSide(side) {
    this.#putText(side);
    this.#call("LookFromSide");
  }

  setSpinning(spins) {
    this.#call("SetSpinning", spins);
  }

  // The text after the # of a URL: model=…; errors in it are in the status.
  follow(link) {
    this.#putText(link);
    this.#call("Follow");
  }

  // A link to the present view, without colours.
  link() {
    this.#call("Link");
    return this.#text();
  }

  // 0 none, 1 measure, 2 section, 3 light, 4 second light.
  setTool(tool) {
    this.#call("SetTool", tool);
  }

  // "front", "side", "above", "view", "flip" or "off".
  setSectionAlong(side) {
    this.#putText(side);
    this.#call("SetSectionAlong");
  }

  setSectionDepth(depth) {
    this.#call("SetSectionDepth", depth);
  }

  // As SVG.
  sectionOutline() {
    this.#call("SectionOutline");
    return this.#text();
  }

  // Intensities of the two lights, 0-2, and the relief, 0-1.
  dim(light, secondLight, relief) {
    this.#call("Dim", light, secondLight, relief);
  }

  setStandardLight() {
    this.#call("StandardLight");
  }

  measurements() {
    return this.#describe("Measurements", "[]");
  }

  // Marks the surface where the views of these links look at it.
  setMarks(links) {
    this.#putText(links.join("\n"));
    this.#call("SetMarks");
  }

  // [x, y, isSeen] of each mark in order, in pixels of the canvas; null without marks.
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

  // 0 upright, 1 free.
  setTurning(turning) {
    this.#call("SetTurning", turning);
  }

  // 0 by the view, 1 one level for the whole model.
  setDetail(detail) {
    this.#call("SetDetail", detail);
  }

  // Bytes that are fetched ahead of what is wanted.
  setPrefetch(bytes) {
    this.#call("SetPrefetch", bytes);
  }

  // Whether anything moves by itself.
  setMotion(motion) {
    this.#call("SetMotion", motion);
  }

  setRings(rings) {
    this.#call("SetRings", rings);
  }

  // Colours as links have them: own, partition, resolution, none, or by:NAME[:MAP[:LOW:HIGH]].
  setColors(colors) {
    const [by, , map, low, high] = colors.split(":");
    this.#putText(arrayOf(colors));
    this.#call("SetColors", colorings.indexOf(by), colorMaps.indexOf(map), low, high);
  }

  // Sets the background, 0xrrggbb each.
  setBackground(bottom, top) {
    this.#call("SetBackground", bottom, top);
  }

  // The limit of WebAssembly's and graphics memory together; what is shown adapts to it.
  setMemory(bytes) {
    this.#call("SetMemory", bytes);
  }

  // ---- the canvas

  // False where the browser has no WebGL 2.
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

  // The next frame draws, whatever has changed.
  redraw() {
    this.#call("Redraw");
  }

  // Draws what has changed; returns whether anything had.
  frame() {
    return this.#call("Frame") === 1;
  }

  // ---- the line to the server

  // The list of models as the server sent it. Returns why it is not a list, or "".
  setModels(bytes) {
    if (!this.#put(bytes)) {
      return "it is too long";
    }
    return this.#call("SetModels") ? "" : this.#text();
  }

  socketOpened(now) {
    this.#call("SocketOpened", now);
  }

  // False where the message is too long to be true.
  socketMessage(data, now) {
    const isText = typeof data === "string";
    const known = isText ? this.#putText(data) : this.#put(new Uint8Array(data));
    if (known) {
      this.#call(isText ? "SocketText" : "SocketFrame", now);
    }
    return known;
  }

  // refused: the server answers, but has no stream for us. retryAfter: the seconds that a busy one asks for, or 0.
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

  // ---- what comes out

  // Call after every input; then do what nextAction says until it says Action.none.
  exchange(now) {
    this.#call("Exchange", now);
  }

  nextAction() {
    const kind = this.#call("NextAction");
    const texts = [Action.send, Action.fetch, Action.search].includes(kind);
    return { kind, text: texts ? this.#text() : "", mostBytes: this.#call("MostBytes") };
  }

  // An ArrayBuffer that is kept of what a search is for, by its place there.
  found(search, index, bytes) {
    if (this.#put(new Uint8Array(bytes))) {
      this.#call("Found", search, index);
    }
  }

  // The rest of it is not kept. isKept: the model is, on purpose.
  endSearch(search, isKept, now) {
    this.#call("EndSearch", search, isKept, now);
  }

  // Whether arriving blobs are returned by nextArrival, and stored ones are searched first.
  setKeeps(keeps) {
    this.#call("SetKeeps", keeps);
  }

  // A blob that has come: { path, bytes }, or null.
  nextArrival() {
    const begin = this.#call("Arrival");
    return begin ? { path: this.#text(), bytes: bytesAt(begin, this.#call("ArrivalBytes")).slice().buffer } : null;
  }

  // What the colours of detail mean: [{ level, color }], the finest first; -1 is the original, color 0xrrggbb.
  legend() {
    return this.#describe("Legend", "[]");
  }

  // The arrays that the model may be coloured by; and for the current array the range of the map, and the classes: { arrays, low,
  // high, classes }.
  arrays() {
    this.#call("Arrays");
    return JSON.parse(this.#text());
  }

  // 0xrrggbb, of a number of that array.
  shade(number) {
    return this.#call("Shade", number);
  }

  // { budget, heap, used, pieces, graphics } in bytes.
  memory() {
    return this.#describe("Memory", "{}");
  }

  // The message for the user: page.js describes its members.
  status() {
    const status = this.#describe("Status", "{}");
    status.idle &&= !picturesAreWaiting();
    return status;
  }
}
