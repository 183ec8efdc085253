// SPDX-License-Identifier: BSD-3-Clause
// What the page says about its state after each frame: messages, hints, what is being loaded, the legend, the status line.

import { contact, isOffline, lacksToken, mayHaveOriginal } from "./line.js";
import { markChosen, nameOf } from "./list.js";
import { hideLoading, showLoading } from "./loading.js";
import { findMessage, showMessage } from "./message.js";
import { showOrigin } from "./origin.js";
import { arrayOf } from "./viewer.js";
import { t } from "./words.js";
import { lastStatus, rest, wake } from "./frames.js";
import { askAgain, colourBy, colouring, goOnOnce, linkTrouble, linked, missColours, models, refreshing, selectedModel, site, tryNow, update } from "./choosing.js";
import { showDetails, showFinger, showNotes, showTools, shownSheet } from "./sheets.js";
import { askForToken, contextLost, embedding, followMode } from "./controls.js";
import { canvas, coarse, fingers, find, say, viewer } from "./shared.js";

// before: the status before this frame.
export function show(before) {
  const wrong = showWhatIsWrong(lastStatus);
  if (viewer.failure) {
    return;
  }
  if (before.gliding || lastStatus.gliding) {
    wake();
  }
  showTools();
  embedding?.show();
  showNotes(lastStatus);
  showStatus(lastStatus);
  showDetails();
  showHint(lastStatus, wrong);
  showWhatComes(lastStatus, wrong);
  showLegend(lastStatus);
  followMode(before.mode, lastStatus);
  if (lastStatus.shownLevel !== null || lastStatus.waits) {
    rest.fetch();
  }
  if (lastStatus.idle && lastStatus.shownLevel !== null) {
    tellAloud(lastStatus);
    lastStatus.mode === "full screen" && fingers.entered && showFinger();
    goOnOnce(); // not before, because it would slow down the first picture
  }
}

// ---- messages

let wasAway = false;
let wellAgain = false;

// Returns whether there is a message.
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
  const withLink = { ...status, error: status.error || linkTrouble };
  return showMessage(findMessage({ status: withLink, name, failed, contextLost, listed, listTrouble, lacksToken: lacksToken(), contact, away, wellAgain, offline, rest, update, tryNow, askAgain, askForToken }));
}

// ---- the state

let knowsDoubleTap = false;

function showHint({ mode, shownLevel, original, region, measuring, tool }, wrong) {
  if (mode !== "full screen") {
    say(find("hint"), "");
    return;
  }
  if (coarse && !fingers.entered) {
    say(find("hint"), t("Tap to turn the model"));
    return;
  }
  if (measuring) {
    say(find("hint"), t(coarse ? "Tap two points on the surface" : "Click two points on the surface"));
    return;
  }
  knowsDoubleTap ||= region !== null;
  const needed = shownLevel !== null && !original && !knowsDoubleTap && !tool && !wrong && !shownSheet() && mayHaveOriginal();
  const words = t(coarse ? "Double-tap the surface for its original detail" : "Double-click the surface for its original detail");
  say(find("hint"), needed ? words : "");
}

// Shows progress until there is a picture, or until the page can do what the user asked for.
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

let legendShown = ""; // the colours and the surface that the legend is for

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
  say(find("status"), status.region?.shown || status.original ? t("Original") : "");
  const busy = status.blobsWanted > 0 || status.waits;
  find("progress").classList.toggle("busy", busy);
  find("progress").firstElementChild.style.transform =
    `scaleX(${status.waits ? rest.part() : busy ? status.blobsLoaded / status.blobsWanted : 1})`;
}

// Tells screen readers what is visible, when it has arrived.
function tellAloud(status) {
  const { mode, region } = status;
  const name = nameOf(selectedModel());
  say(find("live"), mode !== "full screen" ? t("Preview of {name}", { name })
    : region?.shown ? t("{name}: original detail is shown", { name })
      : t("{name}: full screen", { name }));
}
