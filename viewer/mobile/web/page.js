// SPDX-License-Identifier: BSD-3-Clause
// The phone's page: the list of models, one canvas for preview and full screen, and the texts around them. WebAssembly decides
// what is shown and fetched (viewer/session, by viewer.js); this code does only what a browser must do for it. It starts here;
// shared.js lists its parts.
//
// What tests and pages around this one may rely on:
// - #models holds one button [data-model="ID"] a model; #view is the canvas; #back leads back to the list; #status, #message say
//   how it stands and what went wrong.
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
import { Line, takeToken } from "./line.js";
import { hideLoading, showLoading, watchStall } from "./loading.js";
import { showEnd } from "./message.js";
import { rememberedPreviews } from "./previews.js";
import { tellOfPictures } from "./gl.js";
import { loadViewer } from "./viewer.js";
import { chooseLanguage, t } from "./words.js";
import { lastStatus, rest, startFrames, wake } from "./frames.js";
import { linkInAddress, refreshing, takeLink } from "./choosing.js";
import { answerEmbedder, listenToBrowser, listenToButtons } from "./controls.js";
import { show } from "./status.js";
import { canvas, coarse, find, fingers, isEmbedded, line, shareLine, shareViewer, viewer } from "./shared.js";

/* global viewerBytes: of the WebAssembly's first part, by MakePage.cmake */

// New vertices morph to their places, and a released model continues to turn for a moment, except for users who prefer reduced
// motion.
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

// If the browser saves data, nothing is prefetched.
function saveDataIfAsked() {
  const menu = find("menu").elements;
  menu.ahead.value = navigator.connection?.saveData ? "0" : menu.ahead.value;
  viewer.setPrefetch(Number(menu.ahead.value));
}

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
  const heard = watchStall();
  try {
    shareViewer(await loadViewer((bytes) => {
      heard();
      showLoading(t("Loading the viewer"), Math.min(bytes / viewerBytes, 1));
    }));
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
  takeLink();
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
  shareLine(new Line(viewer, wake), new Fingers(canvas, viewer, wake));
  window.kdstream = { status: () => (viewer.failure ? lastStatus : { ...viewer.status(), memory: viewer.memory() }) };
  startFrames(show);
  listenToButtons();
  moveIfLiked();
  saveDataIfAsked();
  find("menu").elements.previews.value = rememberedPreviews(isEmbedded);
  listenToBrowser();
  line.exchange();
  refreshing.refresh();
  if (isEmbedded) {
    document.body.dataset.embedded = "";
    fingers.enter(false);
    answerEmbedder();
  }
  wake();
}

start();
