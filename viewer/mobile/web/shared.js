// SPDX-License-Identifier: BSD-3-Clause
// Shared by the parts of the page: the elements of its document, and the viewer with its connection and its fingers, which
// start() (page.js) sets here. The parts, each of which uses only those before it: frames.js (when to draw), choosing.js (which
// model, in which view), sheets.js (options, tools, notes), controls.js (buttons, keys, the browser) and status.js (messages
// about the state). Imports have no cycles, not even indirect ones (Testing/CheckIncludes.cmake).

export const find = (id) => document.getElementById(id);
export const canvas = find("view");
export const coarse = matchMedia("(pointer: coarse)").matches;
export const isEmbedded = new URLSearchParams(location.search).has("embed") && window.parent !== window; // in a page's frame

export let viewer = null;
export let line = null;
export let fingers = null;

export function shareViewer(loaded) {
  viewer = loaded;
}

export function shareLine(itsLine, itsFingers) {
  line = itsLine;
  fingers = itsFingers;
}

export function say(element, text) {
  if (element.textContent !== text) {
    element.textContent = text;
  }
}
