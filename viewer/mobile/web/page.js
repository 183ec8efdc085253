// SPDX-License-Identifier: BSD-3-Clause
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
//     shownLevel, targetLevel, finestLevel; by the view the finest of what is shown and wanted
//     original      by the view: whether some of it is the original; errorLeft: points that a budget leaves
//                   levels of detail: shown, asked for by the zoom, there at all; null or missing before they are known
//     region        null, or { cell, rings, partitions, shown }: the region around the last double tap, and how many of
//                   its partitions are shown as the original
//     vertices, triangles
//                   of the drawn surface; `surface` is its version, `colored` whether it came with colours
//     blobsLoaded, blobsWanted, bytesLoaded
//                   since nothing was outstanding last
//     waits         whether more of the viewer must come first (rest.js)
//     idle          whether all that is wanted has come and is drawn, and nothing moves
//     canUndo       whether there is a jump of the view to take back; turnsOn: the model turns, spinning: by itself
//     measuring     whether taps measure; tool: in hand, 0 none, 1 measure, 2 section, 3 light, 4 second light
//     depth         how much a section cuts away, 0-1, or null; lamp, secondLamp, relief: of raking light, where there is any
//     error         what failed last, or ""
//     connection    "connecting", "streaming", "lost" (is tried again) or "getting" (no stream: blob by blob)
//     trouble       why nothing comes, or ""
//     stale         what the list says of the selected model: "removed", "replaced" or ""
//     gliding       whether new vertices are on the way to their places
//     plain         whether hollows are still to become darker, once a slow device's view rests
//     frames        pictures drawn so far; drawingError: why the last one could not be
//     memory        { budget, heap, used, pieces, graphics } in bytes: of the WebAssembly, what of it is allocated, and of
//                   that by decoded pieces; and of buffers and textures

import { Fingers } from "./fingers.js";
import { Line, hasToken, isOffline, lacksToken, takeToken } from "./line.js";
import { entryOf, findKept, markChosen, markKept, nameOf, readList, showEntries, showSite } from "./list.js";
import { hideLoading, showLoading, watchSilence } from "./loading.js";
import { findMessage, showEnd, showMessage } from "./message.js";
import { showOrigin } from "./origin.js";
import { askForPreviews, previewsAreAsked, rememberedPreviews, showPreview, showsPreview } from "./previews.js";
import { Refreshing } from "./refreshing.js";
import { Rest } from "./rest.js";
import { arrayOf, loadViewer, tellOfPictures } from "./viewer.js";
import { chooseLanguage, describeProgress, describeSurface, t } from "./words.js";

// For what is fetched later (MakePage.cmake), which has no copies of these.
export { Line, enterToken, forgetToken, get, getOrFind, hasToken, isOffline, mayKeep, rememberToken, remembersToken } from "./line.js";
export { inPlainWords, refusalOf } from "./refusal.js";
export { emptyStorage, findBlob, findText, pinBlobs, setStorageLimit, storageLimit, storageTrouble, storeBlobs, storeText, storedBytes }
  from "./storage.js";
export { entryOf, make, nameOf } from "./list.js";
export { addressIn } from "./origin.js";
export { anotherViewer, arrayOf, colorMaps } from "./viewer.js";
export { figure, kilobytes, language, nameOfLevel, t } from "./words.js";

/* global viewerBytes: of the WebAssembly's first part, by MakePage.cmake */

const find = (id) => document.getElementById(id);
const canvas = find("view");
const coarse = matchMedia("(pointer: coarse)").matches;

let viewer = null;
let line = null;
let fingers = null;

let models = null; // the list, once one has come
const rest = new Rest(() => fingers && wake()); // of the viewer
const refreshing = new Refreshing(takeList, askAgain, wake); // asked again for what could not be had
let linked = ""; // a link to a view, that waits for the list, or for the rest of the viewer
let linkTrouble = ""; // why the last one has opened nothing
let site = { title: "", text: "" };
let tools = null; // once they have been used, or a link has brought distances
let about = null;
let notes = null; // once a model has some, or somebody writes some
let embedding = null; // in somebody's page
const isEmbedded = new URLSearchParams(location.search).has("embed") && window.parent !== window;
let gallery = null; // the pictures of the list, once there was time for them
let contextLost = false;
let update = null; // goes over to a newer page
let keptPage = false; // it has been asked for
let lastStatus = {};

// ---- words

function say(element, text) {
  if (element.textContent !== text) {
    element.textContent = text;
  }
}

function selectedModel() {
  const id = lastStatus.model ?? "";
  return models?.find((model) => model.id === id) ?? { id, title: lastStatus.title };
}

// ---- what has to be said

let wasAway = false;
let wellAgain = false;

// Whether there is anything.
function showWhatIsWrong(status) {
  const away = Boolean(status.trouble) && (status.connection !== "connecting" || wasAway);
  if (wasAway && !away) {
    wellAgain = true;
    refreshing.refresh();
    setTimeout(() => {
      wellAgain = false;
      wake();
    }, 4000);
  }
  wasAway = away;
  const name = nameOf(selectedModel());
  const failed = viewer.failure;
  const listed = models !== null;
  const { trouble: listTrouble } = refreshing;
  const offline = isOffline();
  const told = { ...status, error: status.error || linkTrouble };
  return showMessage(findMessage({ status: told, name, failed, contextLost, listed, listTrouble, lacksToken: lacksToken(), away, wellAgain, offline, rest, update, tryNow, askAgain, askForToken }));
}

// ---- the list of models

// As it came; how many models it has. Throws where it is none.
function takeList(bytes) {
  const trouble = viewer.setModels(bytes);
  if (trouble) {
    throw new Error(trouble);
  }
  showModels(readList(bytes));
  return models.length;
}

function showModels(list) {
  site = list.site;
  showSite(site);
  if (JSON.stringify(list.models) !== JSON.stringify(models)) {
    models = list.models;
    showEntries(models, choose);
    gallery?.show(models);
  }
  markKept(models);
  const none = find("empty");
  none.hidden = models.length > 0;
  say(none, t("This server has no models yet. They appear here as soon as it has one."));
  if (models.length && viewer.status().mode === "no model") {
    selectFirst();
  }
  if (!find("search").hidden) {
    openGallery();
  }
}

// Pictures, and the search.
async function openGallery() {
  const { Gallery } = await import("./gallery.js");
  if (!gallery) {
    gallery = new Gallery({ status: () => lastStatus, savesData: () => find("menu").elements.ahead.value === "0" });
    gallery.show(models);
  }
}

// What a link shows, or, after a reload in full screen, that model again. Without a network one that is kept, or none.
async function selectFirst() {
  if (linked) {
    followLink(linked);
    return;
  }
  const earlier = models.find(({ id }) => id === history.state?.model);
  if (!earlier && previewsAreAsked()) {
    goOnOnce(); // there may be no picture for long
    return;
  }
  const first = earlier ?? (isOffline() ? await findKept(models) : models)[0];
  if (!first) {
    goOnOnce();
  } else if (viewer.status().mode === "no model") {
    viewer.select(first.id);
    earlier && viewer.enterFullScreen();
    line.exchange();
    wake();
  }
}

// The view that stands behind the # of the address; "" for none.
function linkInAddress() {
  return location.hash.match(/^#((?:.*&)?model=.*)$/)?.[1].slice(0, mostOfLink) ?? "";
}

const mostOfLink = 1e4; // characters: more than any has that can be understood

let colouring = "own"; // as links have it

function colourBy(colors) {
  colouring = colors;
  viewer.setColors(colors);
  find("menu").elements.coloring.forEach((radio) => (radio.checked = radio.value === colors));
}

// The last one where there are several before it can be done.
async function followLink(link) {
  linked = link;
  await rest.wait();
  if (linked !== link) {
    return;
  }
  linked = "";
  const told = new URLSearchParams(link);
  const menu = find("menu").elements;
  menu.detail.value = told.get("detail") === "level" ? "1" : "0";
  menu.turning.value = told.get("turning") === "free" ? "1" : "0";
  colourBy(link.match(/colours=([^&]*)/)?.[1] ?? "own"); // not decoded
  viewer.follow(link);
  const { mode, error } = viewer.status();
  linkTrouble = mode === "no model" ? error : ""; // it names none of these
  if (linkTrouble && !isEmbedded) {
    selectFirst();
  }
  line.exchange();
  wake();
  if (told.has("distances")) {
    getTools().then(wake, () => {}); // else they are not seen until the tools are opened
  }
}

// The first time its preview, then the whole screen.
function choose(model) {
  linked = linkTrouble = "";
  if (!previewsAreAsked() || showsPreview() || model !== lastStatus.model) {
    viewer.select(model);
  }
  showPreview(true);
  line.exchange();
  wake();
}

const canClosePreview = () => lastStatus.mode !== "full screen" && previewsAreAsked() && showsPreview();

function closePreview() {
  showPreview(false);
  entryOf(lastStatus.model)?.focus({ preventScroll: true });
}

// ---- how it stands

let knowsDoubleTap = false;

function showHint({ mode, shownLevel, region, measuring, tool }, wrong) {
  if (mode !== "full screen") {
    say(find("hint"), "");
    return;
  }
  if (measuring) {
    say(find("hint"), t(coarse ? "Tap one point of the surface, then another" : "Click one point of the surface, then another"));
    return;
  }
  knowsDoubleTap ||= region !== null;
  const needed = shownLevel !== null && !knowsDoubleTap && !tool && !wrong && sheets.every((id) => find(id).hidden);
  const words = t(coarse ? "Double-tap the surface for its original detail" : "Double-click the surface for its original detail");
  say(find("hint"), needed ? words : "");
}

// Before there is a picture, or before what a person wants can be done.
function showWhatComes({ model, shownLevel, blobsLoaded, blobsWanted, waits, error }, wrong) {
  if ((rest.awaited || (waits && shownLevel === null)) && !wrong) {
    showLoading(t("Loading the viewer"), rest.part());
  } else if (shownLevel !== null || wrong || error || (models && !model && !linked)) {
    hideLoading();
  } else if (models) {
    showLoading(t("Loading “{name}”", { name: nameOf(selectedModel()) }), blobsWanted ? blobsLoaded / blobsWanted : null);
  } else {
    showLoading(t("Loading the list of models"), null);
  }
}

let legendShown = ""; // of which colours, of what

async function showLegend({ mode, surface, model }) {
  const legend = find("legend");
  const isShown = mode === "full screen" && (colouring === "resolution" || arrayOf(colouring));
  legend.hidden = !isShown;
  const wanted = [colouring, model, surface].join();
  if ((isShown || !find("menu").hidden) && legendShown !== wanted) {
    legendShown = wanted;
    await rest.wait();
    const { offerArrays, showColours } = await import("./legend.js");
    offerArrays(viewer, colouring, colourBy);
    isShown && showColours(legend, viewer, colouring);
  }
}

function showStatus(status) {
  document.body.dataset.mode = status.mode;
  const name = nameOf(selectedModel());
  document.title = [name, site.title || "KdStream"].filter(Boolean).join(" – ");
  markChosen(status.model);
  say(find("title"), name);
  find("title").setAttribute("aria-level", status.mode === "full screen" ? 1 : 2);
  showOrigin(find("credit"), status.credit ?? "", status.license ?? "");
  say(find("natural"), t(status.colored ? "Colours" : "Stone"));
  find("stone").hidden = !status.colored;
  find("undo").disabled = !status.canUndo;
  canvas.setAttribute("aria-label", t("{name} in 3D", { name }));
  say(find("status"), [describeSurface(status), describeProgress(status)].filter(Boolean).join(" · "));
  const busy = status.blobsWanted > 0 || status.waits;
  find("progress").classList.toggle("busy", busy);
  find("progress").firstElementChild.style.transform =
    `scaleX(${status.waits ? rest.part() : busy ? status.blobsLoaded / status.blobsWanted : 1})`;
}

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
  const drawn = viewer.frame();
  line.exchange();
  show();
  // After each picture one frame more: it tells how quick the device is.
  if (drawn || lastStatus.plain || lastStatus.turnsOn) {
    wake();
  }
}

function show() {
  const before = lastStatus;
  lastStatus = viewer.failure ? lastStatus : viewer.status();
  const wrong = showWhatIsWrong(lastStatus);
  if (viewer.failure) {
    return;
  }
  if (before.gliding || lastStatus.gliding) {
    wake();
  }
  tools?.show();
  embedding?.show();
  showNotes(lastStatus);
  showStatus(lastStatus);
  showHint(lastStatus, wrong);
  showWhatComes(lastStatus, wrong);
  showLegend(lastStatus);
  followMode(before.mode, lastStatus);
  if (lastStatus.shownLevel !== null || lastStatus.waits) {
    rest.fetch();
  }
  if (lastStatus.idle && lastStatus.shownLevel !== null) {
    tellAloud(lastStatus);
    goOnOnce(); // now that it takes nothing away from the first picture
  }
}

function goOnOnce() {
  if (!keptPage) {
    keptPage = true;
    goOnAfterFirstPicture();
  }
}

async function goOnAfterFirstPicture() {
  await rest.fetch();
  if (!isEmbedded) {
    openGallery().catch(() => {}); // then the list is without pictures
  }
  const { keepPage } = await import("./offline.js");
  keepPage((change) => {
    update = change;
    wake();
  });
}

// For who hears the page: what is seen, once it has come.
function tellAloud(status) {
  const { mode, region } = status;
  const name = nameOf(selectedModel());
  say(find("live"), mode !== "full screen" ? t("Preview of {name}", { name })
    : region?.shown ? t("{name}: original detail is shown", { name })
      : t("{name}: full screen", { name }));
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
  if (mode === "full screen" && before !== mode && !history.state?.model && !isEmbedded) {
    history.pushState({ model }, "");
  }
  if (before !== mode) {
    showPreview(showsPreview() && mode !== "full screen");
    closeSheets();
    before !== "no model" && keepFocus(mode, model);
  }
  if (before === "full screen" && mode !== before) {
    showOwnColours();
    refreshing.refresh();
  }
}

// Whoever goes by keyboard stays where things go on: what had the focus may be hidden by now.
function keepFocus(mode, model) {
  if (!document.activeElement?.checkVisibility?.() || document.activeElement === document.body) {
    (mode === "full screen" ? canvas : entryOf(model))?.focus({ preventScroll: true });
  }
}

// Partitions and detail are looked at in full screen; the list shows models as they are.
function showOwnColours() {
  colourBy("own");
}

function goBack() {
  if (canClosePreview()) {
    closePreview();
  } else if (history.state?.model) {
    history.back();
  } else {
    followHistory();
  }
}

function followHistory() {
  const model = history.state?.model;
  if (model) {
    if (model !== lastStatus.model && models?.some(({ id }) => id === model)) {
      viewer.select(model);
    }
    viewer.enterFullScreen();
  } else {
    viewer.leaveFullScreen();
  }
  line.exchange();
  wake();
}

// ---- sheets: options, tools, what is known of the model

const sheets = ["menu", "tools", "about"];

function showSheet(id, open) {
  find(id).hidden = !open;
  find(`${id}-button`).setAttribute("aria-expanded", open);
  if (open) {
    sheets.filter((other) => other !== id).forEach((other) => showSheet(other, false));
  }
  wake(); // the hint makes room
}

const closeSheets = () => sheets.forEach((id) => showSheet(id, false));

async function openTools(open) {
  await rest.wait();
  if (open && lastStatus.mode !== "full screen") {
    return; // it was left meanwhile
  }
  showSheet("tools", open);
  if (open) {
    (await getTools()).show();
    find("tools").querySelector("button").focus();
  }
  wake();
}

// They draw the distances, too.
async function getTools() {
  await rest.wait();
  const { Tools } = await import("./tools.js");
  return tools ??= new Tools({
    canvas, viewer, wake, redraw,
    exchange: () => line.exchange(),
    status: () => lastStatus,
    words: () => [nameOf(selectedModel()), lastStatus.credit, lastStatus.license].filter(Boolean),
    key: async () => (find("legend").hidden ? null : (await import("./legend.js")).keyOf(viewer, colouring)),
    colours, getNotes,
  });
}

async function getNotes() {
  await rest.wait();
  const { Notes } = await import("./notes.js");
  return notes ??= new Notes({
    canvas, viewer,
    follow: followLink,
    status: () => lastStatus,
    hasNotes: () => selectedModel().notes > 0,
    colours,
  });
}

let notesAsked = false;

// Once there is a picture.
function showNotes({ mode, shownLevel }) {
  notes?.show();
  if (!notesAsked && mode === "full screen" && shownLevel !== null && selectedModel().notes) {
    notesAsked = true;
    getNotes().catch(() => {}); // then the model is without notes
  }
}

const colours = () => (colouring === "own" ? undefined : colouring);

async function openMenu(open) {
  showSheet("menu", open);
  if (open) {
    find("menu").querySelector("input:checked").focus();
    const { openOfflineOptions } = await import("./offline.js");
    openOfflineOptions(lastStatus.model, wake);
    if (hasToken()) {
      (await import("./access.js")).openAccessOptions(find("access"), tokenForgotten);
    }
  }
}

async function openAbout(open) {
  showSheet("about", open);
  if (open) {
    about ??= (await import("./about.js")).describeModel;
    find("about").replaceChildren(...about(selectedModel(), lastStatus, () => {
      openAbout(false);
      find("about-button").focus();
    }));
    find("about").focus();
  }
}

// A canvas keeps its picture for as long as the turn lasts in which this is called.
function redraw() {
  viewer.resize(canvas.width, canvas.height, canvas.width / canvas.clientWidth);
  viewer.frame();
}

async function answerEmbedder() {
  await rest.wait();
  const { Embedding } = await import("./embedding.js");
  embedding = new Embedding({
    canvas, viewer, wake, redraw,
    exchange: () => line.exchange(),
    follow: followLink,
    status: () => lastStatus,
  });
  wake();
}

// Asks anew for what could not be had.
function askAgain() {
  linkTrouble = "";
  line.distrustCache();
  viewer.select(lastStatus.model);
  if (lastStatus.mode !== "full screen") {
    viewer.leaveFullScreen();
  }
  line.exchange();
  wake();
}

async function askForToken() {
  const { askForToken: ask } = await import("./access.js");
  if (await ask()) {
    tryNow();
  }
}

function tokenForgotten() {
  location.assign(location.pathname + location.search);
}

function tryNow() {
  line.hurry();
  rest.hurry();
  refreshing.refresh();
  wake();
}

// New vertices glide to their places, and what is let go turns on for a moment, but for people who want nothing to move
// by itself.
function moveIfLiked() {
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  const follow = () => viewer.setMotion(!still.matches);
  still.addEventListener("change", follow);
  follow();
}

// ?memory=MEGABYTES
function setMemory() {
  const megabytes = Number(new URLSearchParams(location.search).get("memory"));
  if (megabytes > 0) {
    viewer.setMemory(1e6 * megabytes);
  }
}

// Whoever has told the browser to save data gets nothing ahead.
function saveDataIfAsked() {
  const menu = find("menu").elements;
  menu.ahead.value = navigator.connection?.saveData ? "0" : menu.ahead.value;
  viewer.setAhead(Number(menu.ahead.value));
}

function listenToButtons() {
  find("back").addEventListener("click", goBack);
  find("open").addEventListener("click", () => {
    viewer.enterFullScreen();
    line.exchange();
    wake();
  });
  const jump = (button, go) => find(button).addEventListener("click", () => {
    go();
    line.exchange();
    wake();
  });
  jump("home", () => viewer.goHome());
  jump("undo", () => viewer.undoView());
  find("menu-button").addEventListener("click", () => openMenu(find("menu").hidden));
  find("tools-button").addEventListener("click", () => openTools(find("tools").hidden));
  find("about-button").addEventListener("click", () => openAbout(find("about").hidden));
  for (const form of ["tools", "menu"]) {
    find(form).addEventListener("submit", (event) => event.preventDefault());
  }
  find("menu").addEventListener("change", async ({ target }) => {
    await rest.wait();
    if (target.name === "detail") {
      viewer.setDetail(Number(target.value));
    } else if (target.name === "turning") {
      viewer.setTurning(Number(target.value));
    } else if (target.name === "ahead") {
      viewer.setAhead(Number(target.value));
    } else if (target.name === "rings") {
      viewer.setRings(Number(target.value));
    } else if (target.name === "coloring") {
      colourBy(target.value);
    } else if (target.name === "previews") {
      askForPreviews(target.value === "asked");
    }
    line.exchange();
    wake();
  });
  canvas.addEventListener("pointerdown", closeSheets);
  listenToKeys();
}

function listenToKeys() {
  // Where the keys of a keyboard go is told to whoever goes from place to place by them, not to who presses one, nor
  // to who has only opened a link.
  const isBy = (way) => (document.body.dataset.by = way);
  addEventListener("pointerdown", () => isBy("pointer"), true);
  addEventListener("keydown", ({ key }) => key === "Tab" && isBy("keys"), true);
  document.addEventListener("keydown", (event) => {
    const { key, target } = event;
    const open = sheets.find((id) => !find(id).hidden);
    if (event.defaultPrevented || target.closest?.("dialog")) {
      return;
    }
    if (key === "Escape" && open) {
      closeSheets();
      find(`${open}-button`).focus();
    } else if (key === "Escape" && (canClosePreview() || (lastStatus.mode === "full screen" && !isEmbedded))) {
      goBack();
    } else if (key === "/" && !find("search").hidden && !/^(input|select|textarea)$/i.test(target.nodeName)) {
      event.preventDefault(); // it is not what is searched
      find("search").focus();
    } else if (key === "Enter" && document.activeElement === canvas) {
      if (lastStatus.mode === "full screen") {
        fingers.tap(lastStatus.measuring ? 1 : 2);
      } else {
        viewer.enterFullScreen();
      }
      line.exchange();
      wake();
    }
  });
}

function listenToBrowser() {
  addEventListener("popstate", followHistory);
  addEventListener("online", tryNow);
  addEventListener("hashchange", () => {
    if (takeToken()) {
      location.reload();
    } else if (linkInAddress()) {
      models?.length ? followLink(linkInAddress()) : (linked = linkInAddress());
    }
  });
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
    refreshing.watch();
    const { connection, idle } = viewer.status();
    if (connection !== lastStatus.connection || !idle) {
      wake();
    }
  }, 500);
}

// ---- start

async function start() {
  if (typeof WebAssembly !== "object") {
    hideLoading();
    showEnd(t("This browser has no WebAssembly, or it is switched off."));
    return;
  }
  find("message").hidden = true; // from here on there is somebody to tell what is wrong
  find("message").className = "";
  const chosen = chooseLanguage(() => fingers && wake());
  if (linkInAddress()) {
    rest.fetch(); // nothing is shown before
  }
  const heard = watchSilence();
  try {
    viewer = await loadViewer((bytes) => {
      heard();
      showLoading(t("Loading the viewer"), Math.min(bytes / viewerBytes, 1));
    });
  } catch {
    heard(true);
    hideLoading();
    showEnd(t("The viewer could not be loaded from the server."));
    return;
  }
  heard(true);
  await chosen;
  find("around").textContent =
    t(coarse ? "Original detail around a double tap" : "Original detail around a double click");
  takeToken();
  linked = linkInAddress();
  viewer.setKeeps(true);
  setMemory();
  if (!viewer.gainCanvas(canvas)) {
    hideLoading();
    showEnd(t("This browser cannot draw in 3D: it has no WebGL 2, or it is switched off."));
    return;
  }
  tellOfPictures(() => {
    viewer.redraw();
    wake();
  });
  line = new Line(viewer, wake);
  fingers = new Fingers(canvas, viewer, wake);
  window.kdstream = { status: () => (viewer.failure ? lastStatus : { ...viewer.status(), memory: viewer.memory() }) };
  watchSize();
  listenToButtons();
  moveIfLiked();
  saveDataIfAsked();
  find("menu").elements.previews.value = rememberedPreviews(isEmbedded);
  listenToBrowser();
  line.exchange();
  refreshing.refresh();
  if (isEmbedded) {
    document.body.dataset.embedded = "";
    answerEmbedder();
  }
  wake();
}

start();
