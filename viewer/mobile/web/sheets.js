// SPDX-License-Identifier: BSD-3-Clause
// The sheets (options, tools, information about the model), and the model's notes. Their content is fetched when it is first
// used.

import { hasToken, mayHaveOriginal } from "./line.js";
import { nameOf } from "./list.js";
import { lastStatus, redraw, rest, wake } from "./frames.js";
import { loadStyle } from "./rest.js";
import { colouring, followLink, selectedModel, takeDistances } from "./choosing.js";
import { canvas, coarse, find, line, say, viewer } from "./shared.js";

const sheets = ["menu", "tools", "about", "help"];
let tools = null; // set once the tools are used, or a link has distances
let about = null;
let notes = null; // set once a model has notes, or somebody writes some

export const shownSheet = () => sheets.find((id) => !find(id).hidden);

async function openSheet(id, open) {
  const { mode } = lastStatus;
  open && await loadStyle();
  showSheet(id, open && lastStatus.mode === mode); // otherwise the user left the model while this was loading
}

function showSheet(id, open) {
  find(id).hidden = !open;
  find(`${id}-button`).setAttribute("aria-expanded", open);
  if (open) {
    sheets.filter((other) => other !== id).forEach((other) => showSheet(other, false));
  }
  wake(); // the hint makes room for the sheet
}

export const closeSheets = () => sheets.forEach((id) => showSheet(id, false));

export async function openTools(open) {
  await rest.wait();
  if (open && lastStatus.mode !== "full screen") {
    return; // the user left the model while this was loading
  }
  await openSheet("tools", open);
  if (open) {
    (await getTools()).show();
    find("tools").querySelector("button").focus();
  }
  wake();
}

// The tools draw the distances, too, so a link may need them.
async function getTools() {
  await rest.wait();
  const { Tools } = await import("./tools.js");
  return tools ??= new Tools({
    canvas, viewer, wake, redraw,
    exchange: () => line.exchange(),
    status: () => lastStatus,
    model: selectedModel,
    words: () => [nameOf(selectedModel()), lastStatus.credit, lastStatus.license].filter(Boolean),
    key: async () => (find("legend").hidden ? null : (await import("./legend.js")).keyOf(viewer, colouring)),
    colours, getNotes,
  });
}

export function showTools() {
  tools?.show();
  if (takeDistances()) {
    getTools().then(wake, () => {}); // if this fails, the distances appear when the tools are opened
  }
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

// Call this in each frame; notes are fetched once there is a picture.
export function showNotes({ mode, shownLevel }) {
  notes?.show();
  if (!notesAsked && mode === "full screen" && shownLevel !== null && selectedModel().notes) {
    notesAsked = true;
    getNotes().catch(() => {}); // then the model has no notes
  }
}

const colours = () => (colouring === "own" ? undefined : colouring);

export async function openMenu(open) {
  await openSheet("menu", open);
  if (open) {
    find("menu").querySelector("input:checked").focus();
    const { openOfflineOptions } = await import("./offline.js");
    openOfflineOptions(lastStatus.model, wake);
    if (hasToken()) {
      (await import("./access.js")).openAccessOptions(find("access"), tokenForgotten);
    }
  }
}

function tokenForgotten() {
  location.assign(location.pathname + location.search);
}

export async function openAbout(open) {
  await openSheet("about", open);
  if (open) {
    about ??= await import("./about.js");
    find("about").replaceChildren(...about.describeModel(selectedModel(), lastStatus, () => {
      openAbout(false);
      find("about-button").focus();
    }));
    find("about").focus();
    showDetails();
  }
}

export async function openHelp(open) {
  await openSheet("help", open);
  if (open) {
    const { describeHelp } = await import("./help.js");
    find("help").replaceChildren(...describeHelp(coarse, mayHaveOriginal(), () => {
      openHelp(false);
      find("help-button").focus();
    }));
    find("help").focus();
  }
}

let fingerShown = false;

// Shows the moving finger once there is a picture in full screen, unless the user prefers reduced motion.
export function showFinger() {
  if (!fingerShown && !matchMedia("(prefers-reduced-motion: reduce)").matches) {
    fingerShown = true;
    import("./help.js").then((help) => help.showFinger(canvas), () => {});
  }
}

export function showDetails() {
  const place = find("details");
  place && say(place, about.describeDetails(lastStatus));
}
