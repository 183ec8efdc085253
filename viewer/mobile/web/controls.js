// SPDX-License-Identifier: BSD-3-Clause
// Commands of the user, the browser or an embedding page: buttons, keys, back and forward, tokens. Also reacts to changes of the
// network and of the canvas.

import { takeToken } from "./line.js";
import { entryOf, pageOf } from "./list.js";
import { askForPreviews, showPreview, showsPreview } from "./previews.js";
import { lastStatus, redraw, rest, wake } from "./frames.js";
import { loadStyle } from "./rest.js";
import { canClosePreview, closePreview, colourBy, followLink, linkInAddress, models, refreshing, takeLink, tryNow } from "./choosing.js";
import { closeSheets, openAbout, openHelp, openMenu, openTools, shownSheet } from "./sheets.js";
import { canvas, fingers, find, isEmbedded, line, viewer } from "./shared.js";

export let contextLost = false;
export let embedding = null; // set if the page is in a frame of another page

// ---- back and forth

// Full screen has an entry of its own in the browser's history, so that "back" leaves it.
export function followMode(before, { mode, model }) {
  if (mode === "full screen" && before !== mode && !history.state?.model && !isEmbedded) {
    history.pushState({ model }, "", location.hash || !pageOf(model) ? location.href : pageOf(model) + location.search);
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

// The keyboard focus moves to where work continues, because the focused element may be hidden.
function keepFocus(mode, model) {
  if (!document.activeElement?.checkVisibility?.() || document.activeElement === document.body) {
    (mode === "full screen" ? canvas : entryOf(model))?.focus({ preventScroll: true });
  }
}

// Colours of partitions and detail are only for full screen; beside the list, models have their own colours.
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

// ---- buttons and keys

// The actions of the menu.
const options = {
  detail: (value) => viewer.setDetail(Number(value)),
  turning: (value) => viewer.setTurning(Number(value)),
  ahead: (value) => viewer.setPrefetch(Number(value)),
  rings: (value) => viewer.setRings(Number(value)),
  coloring: colourBy,
  previews: (value) => askForPreviews(value === "asked"),
};

export function listenToButtons() {
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
  for (const [sheet, open] of Object.entries({ menu: openMenu, tools: openTools, about: openAbout, help: openHelp })) {
    find(`${sheet}-button`).addEventListener("click", () => open(find(sheet).hidden));
  }
  for (const form of ["tools", "menu"]) {
    find(form).addEventListener("submit", (event) => event.preventDefault());
  }
  find("menu").addEventListener("change", async ({ target }) => {
    await rest.wait();
    options[target.name]?.(target.value);
    line.exchange();
    wake();
  });
  canvas.addEventListener("pointerdown", () => shownSheet() === "tools" || closeSheets()); // tools stay open: taps use them
  listenToKeys();
}

const isField = ({ nodeName }) => /^(input|select|textarea)$/i.test(nodeName);

function listenToKeys() {
  // The focus is only shown to users who navigate by keyboard, and not after a single key press, or after a link was opened.
  const isBy = (way) => (document.body.dataset.by = way);
  addEventListener("pointerdown", () => isBy("pointer"), true);
  addEventListener("keydown", ({ key }) => key === "Tab" && isBy("keys"), true);
  document.addEventListener("keydown", (event) => {
    const { key, target } = event;
    const open = shownSheet();
    if (event.defaultPrevented || target.closest?.("dialog")) {
      return;
    }
    if (key === "Escape" && open) {
      closeSheets();
      find(`${open}-button`).focus();
    } else if (key === "Escape" && (canClosePreview() || (lastStatus.mode === "full screen" && !isEmbedded))) {
      goBack();
    } else if (key === "?" && lastStatus.mode === "full screen" && !isEmbedded && !isField(target)) {
      openHelp(find("help").hidden);
    } else if (key === "/" && !find("search").hidden && !isField(target)) {
      event.preventDefault(); // otherwise "/" would be typed into the field
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

// ---- the browser

export function listenToBrowser() {
  addEventListener("popstate", followHistory);
  addEventListener("online", tryNow);
  addEventListener("offline", () => line.drop());
  addEventListener("hashchange", () => {
    if (takeToken()) {
      location.reload();
    } else if (linkInAddress()) {
      takeLink();
    }
  });
  document.addEventListener("visibilitychange", () => {
    if (!document.hidden) {
      tryNow();
    }
  });
  canvas.addEventListener("webglcontextlost", (event) => {
    event.preventDefault(); // otherwise the browser never restores the context
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

export async function answerEmbedder() {
  await rest.wait();
  const { Embedding } = await import("./embedding.js");
  embedding = new Embedding({
    canvas, viewer, fingers, wake, redraw,
    exchange: () => line.exchange(),
    follow: followLink,
    status: () => lastStatus,
  });
  wake();
}

export async function askForToken() {
  const [{ askForToken: ask }] = await Promise.all([import("./access.js"), loadStyle()]);
  if (await ask()) {
    tryNow();
  }
}
