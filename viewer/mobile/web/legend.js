// SPDX-License-Identifier: BSD-3-Clause
// What the colours of detail mean. Fetched when they are first shown.

import { nameOfLevel } from "./page.js"; // the page that is there already

// By an attribute: the page's policy lets no style into elements.
function entryOf({ level, color }) {
  const item = document.createElement("li");
  const dot = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  dot.setAttribute("viewBox", "0 0 1 1");
  const square = document.createElementNS("http://www.w3.org/2000/svg", "rect");
  square.setAttribute("width", "1");
  square.setAttribute("height", "1");
  square.setAttribute("fill", `#${color.toString(16).padStart(6, "0")}`);
  dot.append(square);
  item.append(dot, nameOfLevel(level));
  return item;
}

export const entriesOf = (legend) => legend.map(entryOf);
