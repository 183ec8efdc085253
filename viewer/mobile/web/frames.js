// SPDX-License-Identifier: BSD-3-Clause
// Frames, only when something has changed, and what is said of how it stands in each.

import { isOffline, lacksToken } from "./line.js";
import { markChosen, nameOf } from "./list.js";
import { hideLoading, showLoading } from "./loading.js";
import { findMessage, showMessage } from "./message.js";
import { showOrigin } from "./origin.js";
import { Rest } from "./rest.js";
import { arrayOf } from "./viewer.js";
import { describeProgress, describeSurface, t } from "./words.js";
import { askAgain, colourBy, colouring, linkTrouble, linked, missColours, models, openGallery, refreshing, selectedModel, site, tryNow } from "./choosing.js";
import { askForToken, contextLost, embedding, followMode } from "./controls.js";
import { canvas, coarse, fingers, find, isEmbedded, line, say, viewer } from "./shared.js";
import { showNotes, shownSheet, tools } from "./sheets.js";

export let lastStatus = {};
export const rest = new Rest(() => fingers && wake()); // of the viewer
let update = null; // goes over to a newer page
let keptPage = false; // it has been asked for
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

export function goOnOnce() {
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

// A canvas keeps its picture for as long as the turn lasts in which this is called.
export function redraw() {
  viewer.redraw();
  viewer.frame();
}

// The canvas has as many pixels as the screen under it.
export function watchSize() {
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

// ---- how it stands

let knowsDoubleTap = false;

function showHint({ mode, shownLevel, region, measuring, tool }, wrong) {
  if (mode !== "full screen") {
    say(find("hint"), "");
    return;
  }
  if (coarse && !fingers.entered) {
    say(find("hint"), t("Tap to turn the model"));
    return;
  }
  if (measuring) {
    say(find("hint"), t(coarse ? "Tap one point of the surface, then another" : "Click one point of the surface, then another"));
    return;
  }
  knowsDoubleTap ||= region !== null;
  const needed = shownLevel !== null && !knowsDoubleTap && !tool && !wrong && !shownSheet();
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
    if (isShown && !showColours(legend, viewer, colouring) && lastStatus.shownLevel !== null) {
      missColours();
    }
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

// For who hears the page: what is seen, once it has come.
function tellAloud(status) {
  const { mode, region } = status;
  const name = nameOf(selectedModel());
  say(find("live"), mode !== "full screen" ? t("Preview of {name}", { name })
    : region?.shown ? t("{name}: original detail is shown", { name })
      : t("{name}: full screen", { name }));
}
