// The phone's page: the list of models, one canvas for preview and full screen, and the words around them. All that is
// shown and fetched is decided in WebAssembly (viewer/session, by way of viewer.js); here is only what a browser has to
// do for it.
//
// What tests and pages around this one may rely on:
// - #models holds one button [data-model="ID"] a model; #view is the canvas; #back leads back to the list; #status,
//   #message say how it stands and what went wrong.
// - window.kdstream.status() returns
//     mode          "no model", "browsing" (the list and a preview) or "full screen"
//     model, title  of the selected model
//     shownLevel, targetLevel, finestLevel
//                   levels of detail: shown, asked for by the zoom, there at all; null or missing before they are known
//     region        null, or { cell, rings, partitions, shown }: the region around the last double tap, and how many of
//                   its partitions are shown as the original
//     vertices, triangles
//                   of the drawn surface; `surface` is its version
//     blobsLoaded, blobsWanted, bytesLoaded
//                   since nothing was outstanding last
//     idle          whether all that is wanted has come and is drawn
//     error         what failed last, or ""
//     connection    "connecting", "streaming", "lost" (is tried again) or "getting" (no stream: blob by blob)
//     trouble       why nothing comes, or ""
//     stale         what the list says of the selected model: "removed", "replaced" or ""
//     frames        pictures drawn so far; drawingError: why the last one could not be

import { Fingers } from "./fingers.js";

const find = (id) => document.getElementById(id);
const canvas = find("view");
const coarse = matchMedia("(pointer: coarse)").matches;

let viewer = null;
let line = null;
let fingers = null;
let getList = null;

let listed = false; // a list of models has come
let listTrouble = ""; // why the last one could not be had
let listRetry = 1; // seconds until the next try
let contextLost = false;
let dismissed = ""; // the message that the person has put away
let wasLost = false; // and nobody has said since that it is well again
let lastStatus = {};

// ---- words

const count = (number) => number.toLocaleString("en");

function kilobytes(bytes) {
  return bytes < 1e6 ? `${count(Math.ceil(bytes / 1000))} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
}

function sentence(text) {
  const begun = text.charAt(0).toUpperCase() + text.slice(1);
  return /[.!?…]$/.test(begun) ? begun : begun + ".";
}

function say(element, text) {
  if (element.textContent !== text) {
    element.textContent = text;
  }
}

function nameOf({ title, id, model }) {
  return title || id || model || "";
}

// ---- what has to be said, one at a time, the worst first

// { text, label and act of the button, good, stays: cannot be put away }
function findMessage(status) {
  const reload = { label: "Reload", act: () => location.reload() };
  if (viewer.failure) {
    return { text: "The viewer has stopped: this device has not enough memory for what was to be shown.", stays: true, ...reload };
  }
  if (contextLost) {
    return { text: "The device has taken the picture's memory away. It is drawn again as soon as it is given back.", ...reload };
  }
  const again = { label: "Try now", act: tryNow };
  if (!listed && listTrouble) {
    return { text: `${sentence(`the list of models cannot be had: ${listTrouble}`)} Trying again …`, ...again };
  }
  if (status.trouble && (status.connection !== "connecting" || wasLost)) {
    wasLost = true;
    return { text: `${sentence(status.trouble)} Trying again …`, ...again };
  }
  if (status.drawingError) {
    return { text: sentence(`the picture cannot be drawn: ${status.drawingError}`), ...reload };
  }
  if (status.error) {
    return { text: sentence(status.error), label: "Try again", act: askAgain };
  }
  if (listTrouble) {
    return { text: `${sentence(`the list of models cannot be had: ${listTrouble}`)} Trying again …`, ...again };
  }
  if (status.stale === "removed") {
    return { text: `“${nameOf(status)}” is no longer on the server. What has been loaded can still be looked at.` };
  }
  if (status.stale === "replaced") {
    return { text: `“${nameOf(status)}” is another one on the server now.`, ...reload };
  }
  if (wasLost) {
    setTimeout(() => { wasLost = false; wake(); }, 4000);
    return { text: "Connected again.", good: true };
  }
  return null;
}

function showMessage(message) {
  const box = find("message");
  if (!message || message.text !== dismissed) {
    dismissed = "";
  }
  box.hidden = !message || dismissed !== "";
  if (box.hidden) {
    return;
  }
  box.className = message.good ? "good" : "";
  say(find("message-text"), message.text);
  const button = find("message-action");
  button.hidden = !message.label;
  say(button, message.label ?? "");
  button.onclick = message.act ?? null;
  find("dismiss").hidden = message.stays ?? false;
}

// Before there is a viewer, or without one.
function showEnd(text) {
  showMessage({ text, label: "Reload", act: () => location.reload(), stays: true });
}

// ---- the list of models

async function refreshList() {
  try {
    const trouble = viewer.setModels(await getList());
    if (trouble) {
      throw new Error(trouble);
    }
    listTrouble = "";
    listRetry = 1;
    listed = true;
    showModels(viewer.models());
  } catch (error) {
    listTrouble = error.message;
    setTimeout(() => { if (listTrouble) { refreshList(); } }, 1000 * listRetry);
    listRetry = Math.min(2 * listRetry, 8);
  }
  wake();
}

function showModels(models) {
  find("models").replaceChildren(...models.map(listEntry));
  const none = find("empty");
  none.hidden = models.length > 0;
  say(none, "This server has no models yet. They appear here as soon as it has one.");
  const { mode } = viewer.status();
  if (mode === "no model" && models.length) {
    // After a reload in full screen, that model again.
    const earlier = models.find(({ id }) => id === history.state?.model);
    viewer.select((earlier ?? models[0]).id);
    if (earlier) {
      viewer.enterFullScreen();
    }
    line.exchange();
  }
}

function listEntry(model) {
  const name = document.createElement("span");
  name.className = "name";
  name.textContent = nameOf(model);
  const facts = document.createElement("span");
  facts.className = "facts";
  facts.textContent = model.triangles
    ? `${count(model.triangles)} triangles · ${count(model.vertices)} vertices`
    : `${count(model.vertices)} points`;
  const button = document.createElement("button");
  button.type = "button";
  button.dataset.model = model.id;
  button.append(name, facts);
  button.addEventListener("click", () => choose(model.id));
  const item = document.createElement("li");
  item.append(button);
  return item;
}

// The first time its preview, then the whole screen.
function choose(model) {
  viewer.select(model);
  line.exchange();
  wake();
}

// ---- how it stands

function describeSurface({ shownLevel, finestLevel, triangles, vertices, region }) {
  if (shownLevel === null) {
    return "";
  }
  const detail = region?.shown ? `Level ${shownLevel} and original` : `Level ${shownLevel} of ${finestLevel}`;
  return `${detail} · ${triangles ? `${count(triangles)} triangles` : `${count(vertices)} points`}`;
}

function describeProgress({ blobsLoaded, blobsWanted, bytesLoaded }) {
  return blobsWanted ? `${blobsLoaded} of ${blobsWanted} parts, ${kilobytes(bytesLoaded)}` : "";
}

function describeModel({ credit, license, triangles }) {
  const { id, ...model } = viewer.models().find(({ id }) => id === lastStatus.model) ?? {};
  const size = model.vertices ? `The original has ${count(model.triangles)} triangles and ${count(model.vertices)} vertices.` : "";
  return [size, credit, license].filter(Boolean).join("\n");
}

function showStatus(status) {
  document.body.dataset.mode = status.mode;
  document.title = status.model ? `${nameOf(status)} – KdStream` : "KdStream";
  for (const button of find("models").querySelectorAll("button")) {
    button.setAttribute("aria-pressed", button.dataset.model === status.model);
  }
  say(find("title"), nameOf(status));
  say(find("credit"), [status.credit, status.license].filter(Boolean).join(" · "));
  canvas.setAttribute("aria-label", `${nameOf(status)} in 3D`);
  say(find("status"), [describeSurface(status), describeProgress(status)].filter(Boolean).join(" · "));
  const tap = coarse ? "Double-tap" : "Double-click";
  say(find("hint"), status.shownLevel === null || hinted ? "" : `${tap} the surface for its original detail`);
  hinted ||= status.region !== null;
  const busy = status.blobsWanted > 0;
  find("progress").classList.toggle("busy", busy);
  find("progress").firstElementChild.style.transform =
    `scaleX(${busy ? status.blobsLoaded / status.blobsWanted : 1})`;
}
let hinted = false; // a double tap has been made

// ---- frames: only when something has changed

let frameAsked = false;

function wake() {
  if (!frameAsked) {
    frameAsked = true;
    requestAnimationFrame(drawFrame);
  }
}

function drawFrame() {
  frameAsked = false;
  fingers.flush();
  viewer.frame();
  line.exchange();
  show();
}

function show() {
  const before = lastStatus;
  lastStatus = viewer.failure ? lastStatus : viewer.status();
  showMessage(findMessage(lastStatus));
  if (viewer.failure) {
    return;
  }
  showStatus(lastStatus);
  followMode(before.mode, lastStatus);
  if (before.connection && before.connection !== "streaming" && lastStatus.connection === "streaming") {
    refreshList();
  }
}

// The canvas has as many pixels as the screen under it.
function watchSize() {
  const observer = new ResizeObserver(([{ contentBoxSize: [points], devicePixelContentBoxSize: [exact] = [] }]) => {
    // An emulated screen tells points for pixels: what is told exactly only settles the rounding.
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

// ---- to and fro

// Full screen is a page of its own for the browser's back.
function followMode(before, { mode, model }) {
  if (mode === "full screen" && before !== mode && !history.state?.model) {
    history.pushState({ model }, "");
  }
  if (before === "full screen" && mode !== before) {
    openMenu(false);
    refreshList();
  }
}

function goBack() {
  if (history.state?.model) {
    history.back();
  } else {
    followHistory();
  }
}

function followHistory() {
  if (history.state?.model) {
    viewer.enterFullScreen();
  } else {
    viewer.leaveFullScreen();
  }
  line.exchange();
  wake();
}

function openMenu(open) {
  find("menu").hidden = !open;
  find("menu-button").setAttribute("aria-expanded", open);
  if (open) {
    say(find("facts"), describeModel(lastStatus));
    find("menu").querySelector("input:checked").focus();
  }
}

// Asks anew for what could not be had.
function askAgain() {
  viewer.select(lastStatus.model);
  if (lastStatus.mode !== "full screen") {
    viewer.leaveFullScreen();
  }
  line.exchange();
  wake();
}

function tryNow() {
  line.hurry();
  if (listTrouble) {
    refreshList();
  }
  wake();
}

function listenToButtons() {
  find("back").addEventListener("click", goBack);
  find("open").addEventListener("click", () => {
    viewer.enterFullScreen();
    line.exchange();
    wake();
  });
  find("dismiss").addEventListener("click", () => {
    dismissed = find("message-text").textContent;
    wake();
  });
  find("menu-button").addEventListener("click", () => openMenu(find("menu").hidden));
  find("menu").addEventListener("change", ({ target }) => {
    if (target.name === "rings") {
      viewer.setRings(Number(target.value));
    } else {
      viewer.setColoring(Number(target.value));
    }
    wake();
  });
  canvas.addEventListener("pointerdown", () => openMenu(false));
  document.addEventListener("keydown", ({ key }) => {
    if (key === "Escape" && !find("menu").hidden) {
      openMenu(false);
      find("menu-button").focus();
    } else if (key === "Escape" && lastStatus.mode === "full screen") {
      goBack();
    } else if (key === "Enter" && document.activeElement === canvas) {
      viewer.enterFullScreen();
      wake();
    }
  });
}

function listenToBrowser() {
  addEventListener("popstate", followHistory);
  addEventListener("online", tryNow);
  document.addEventListener("visibilitychange", () => {
    if (!document.hidden) {
      tryNow();
    }
  });
  canvas.addEventListener("webglcontextlost", (event) => {
    event.preventDefault(); // else it is never given back
    contextLost = true;
    viewer.contextLost();
    wake();
  });
  canvas.addEventListener("webglcontextrestored", () => {
    contextLost = false;
    viewer.contextRestored();
    wake();
  });
  setInterval(() => {
    line.tick();
    if (viewer.status().connection !== lastStatus.connection) {
      wake();
    }
  }, 500);
}

// ---- start

async function start() {
  if (typeof WebAssembly !== "object") {
    showEnd("This browser has no WebAssembly, or it is switched off. Any browser of the last few years shows the models.");
    return;
  }
  let Line;
  try {
    const { loadViewer } = await import("./viewer.js");
    ({ Line, getList } = await import("./line.js"));
    viewer = await loadViewer();
  } catch (error) {
    showEnd(sentence(`the viewer could not be loaded: ${error.message ?? error}`));
    return;
  }
  if (!viewer.gainCanvas()) {
    showEnd("This browser cannot draw in 3D: it has no WebGL 2, or it is switched off. An up-to-date browser with hardware acceleration switched on shows the models.");
    return;
  }
  line = new Line(viewer, wake);
  fingers = new Fingers(canvas, viewer, wake);
  window.kdstream = { status: () => (viewer.failure ? lastStatus : viewer.status()) };
  watchSize();
  listenToButtons();
  listenToBrowser();
  line.exchange();
  refreshList();
  wake();
}

start();
