// SPDX-License-Identifier: BSD-3-Clause
// The phone's page: the list of models, one canvas for preview and full screen, and the texts around them. WebAssembly decides
// what is shown and fetched (viewer/session, through viewer.js); this code only does what a browser must do for it. The page
// starts here; shared.js lists its parts.
//
// Tests and embedding pages may rely on this:
// - #models holds one button [data-model="ID"] per model; #view is the canvas; #back leads back to the list; #status and #message
//   show the state and errors.
// - window.kdstream.status() returns
//     mode          "no model", "browsing" (the list and a preview) or "full screen"
//     model, title  of the selected model
//     shownLevel, targetLevel, finestLevel
//                   levels of detail: the one that is shown, the one that the zoom needs, and the model's finest; if detail follows
//                   the view, the first two are the finest shown and needed. null or missing before they are known
//     original      if detail follows the view: whether a part is shown as the original; errorLeft: the error that a budget leaves,
//                   in points
//     region        null, or { cell, rings, partitions, shown }: the region around the last double tap, and how many of
//                   its partitions are shown as the original
//     vertices, triangles
//                   of the drawn surface; `surface` is its version, `colored` whether it has colours
//     blobsLoaded, blobsWanted, bytesLoaded
//                   since the last time when nothing was outstanding
//     waits         whether more of the viewer must be loaded first (rest.js)
//     idle          whether everything that is needed has arrived and is drawn, and nothing moves
//     canUndo       whether a jump of the view can be undone; turnsOn: the model still turns after a release; spinning: it turns by
//                   itself
//     measuring     whether taps measure; tool: the current one, 0 none, 1 measure, 2 section, 3 light, 4 second light
//     depth         how much a section cuts away, 0-1, or null; lamp, secondLamp, relief: of raking light, if there is any
//     error         what failed last, or ""
//     connection    "connecting", "streaming", "lost" (it is retried) or "getting" (no stream: one GET for each blob)
//     trouble       why nothing arrives, or ""
//     stale         the state of the selected model in the list: "removed", "replaced" or "" (unchanged)
//     gliding       whether new vertices are morphing to their places
//     plain         whether ambient occlusion is still missing, because a slow device draws it only when the view rests
//     frames        pictures drawn so far; drawingError: why the last one could not be drawn
//     memory        { budget, heap, used, pieces, graphics } in bytes: the limit; WebAssembly's memory, the part of it that is
//                   allocated, and the part of that for decoded pieces; and the buffers and textures

import { Fingers } from "./fingers.js";
import { Line, takeToken } from "./line.js";
import { make } from "./list.js";
import { hideLoading, showLoading, watchStall } from "./loading.js";
import { showEnd } from "./message.js";
import { rememberedPreviews } from "./previews.js";
import { listenToPictures } from "./gl.js";
import { loadViewer } from "./viewer.js";
import { chooseLanguage, t } from "./words.js";
import { lastStatus, rest, startFrames, wake } from "./frames.js";
import { linkInAddress, refreshing, takeLink } from "./choosing.js";
import { answerEmbedder, listenToBrowser, listenToButtons } from "./controls.js";
import { show } from "./status.js";
import { canvas, coarse, find, fingers, isEmbedded, line, shareLine, shareViewer, viewer } from "./shared.js";

// The address may change to that of a model's page, in a folder below. So the links in the head are made absolute here.
for (const link of document.querySelectorAll("head link:not([rel=stylesheet])")) {
  link.href += "";
}

/* global viewerBytes: of the WebAssembly's first part, by MakePage.cmake */

const options = new URLSearchParams(location.search);

// A light background if the address asks for it.
const isLight = options.get("theme") === "light";

// New vertices morph to their places, and a released model continues to turn for a moment, unless the user prefers reduced
// motion.
function moveIfLiked() {
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  const follow = () => viewer.setMotion(!still.matches);
  still.addEventListener("change", follow);
  follow();
}

// ?memory=MEGABYTES
function setMemory() {
  const megabytes = options.get("memory");
  if (megabytes > 0) {
    viewer.setMemory(1e6 * megabytes);
  }
}

// Nothing is prefetched if the browser saves data.
function saveDataIfAsked() {
  const menu = find("menu").elements;
  menu.ahead.value = navigator.connection?.saveData ? "0" : menu.ahead.value;
  viewer.setPrefetch(Number(menu.ahead.value));
}

async function start() {
  if (isEmbedded) { // in another page's frame there is one model and no list
    document.body.dataset.embedded = "";
  }
  if (isLight) {
    document.documentElement.dataset.theme = "light";
    document.querySelector("[name=theme-color]").remove();
    document.head.append(make("link", { rel: "stylesheet", href: new URL("light.css", import.meta.url).href }));
  }
  if (!window.WebAssembly) {
    hideLoading();
    showEnd(t("This browser has no WebAssembly, or it is switched off."));
    return;
  }
  find("message").hidden = true; // from here on this script shows messages itself
  find("message").className = "";
  const chosen = chooseLanguage(() => fingers && wake());
  if (linkInAddress()) {
    rest.fetch(); // nothing can be shown before it has arrived
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
  isLight && viewer.setBackground(0xd9d6cf, 0xf4f2ee); // as in light.css
  setMemory();
  if (!viewer.gainCanvas(canvas)) {
    hideLoading();
    showEnd(t("This browser cannot draw in 3D: it has no WebGL 2, or it is switched off."));
    return;
  }
  listenToPictures(() => {
    viewer.redraw();
    wake();
  });
  shareLine(new Line(viewer, wake), new Fingers(canvas, viewer, wake));
  window.kdstream = { status: () => (viewer.failure ? lastStatus : { ...viewer.status(), memory: viewer.memory() }) };
  startFrames(show);
  const bar = find("bar");
  new ResizeObserver(() => find("stage").style.setProperty("--bar", `${bar.offsetHeight}px`)).observe(bar);
  listenToButtons();
  moveIfLiked();
  saveDataIfAsked();
  find("menu").elements.previews.value = rememberedPreviews(isEmbedded);
  listenToBrowser();
  line.exchange();
  refreshing.refresh();
  if (isEmbedded) {
    fingers.enter(false);
    answerEmbedder();
  }
  wake();
}

start();
