// SPDX-License-Identifier: BSD-3-Clause
// The legend, and the choice of a model's arrays to colour it by. Fetched when they are first shown.

import { make } from "./list.js";
import { arrayOf, colorMaps } from "./viewer.js";
import { language, nameOfLevel, t } from "./words.js";

const inFigures = (number) => Number(number.toPrecision(6)).toLocaleString(language, { maximumSignificantDigits: 6 });
const hex = (color) => `#${color.toString(16).padStart(6, "0")}`;

// Sets attributes, because the page's policy forbids styles in elements.
function drawing(tag, attributes, ...inner) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  Object.entries(attributes).forEach(([name, value]) => element.setAttribute(name, value));
  element.append(...inner);
  return element;
}

function entryOf({ color, text }) {
  const square = drawing("rect", { width: 1, height: 1, fill: color });
  return make("li", {}, drawing("svg", { viewBox: "0 0 1 1" }, square), text);
}

// The names that LAS gives to its most frequent classes, as in ColorLegend.cxx.
const classes = {
  1: "unclassified", 2: "ground", 3: "low vegetation", 4: "medium vegetation", 5: "high vegetation", 6: "building",
  7: "low point (noise)", 9: "water", 11: "road", 17: "bridge deck", 18: "high noise",
};

function classesOf(name, present, viewer) {
  return present.map((value) => ({
    color: hex(viewer.shade(value)),
    text: `${inFigures(value)} ${name.includes("lassification") && classes[value] ? t(classes[value]) : ""}`,
  }));
}

// Returns the legend. It has the array's name, or "" for colours of detail, and either `entries`, [{ color, text }], or a bar:
// `colors` from the low end to the high one, and `ends`, the labels at both ends and between them. Returns null if the model does
// not have the array.
export function keyOf(viewer, colouring) {
  const name = arrayOf(colouring);
  if (!name) {
    return { name, colors: [], entries: viewer.legend().map(({ level, color }) => ({ color: hex(color), text: nameOfLevel(level) })) };
  }
  const { arrays, low, high, classes: present } = viewer.arrays();
  if (!arrays.includes(name)) {
    return null;
  }
  const shades = present.length ? 0 : 40;
  return {
    name,
    entries: classesOf(name, present, viewer),
    colors: Array.from({ length: shades }, (_, i) => hex(viewer.shade(low + (high - low) * (i + 0.5) / shades))),
    ends: [low, (low + high) / 2, high].map(inFigures),
  };
}

function barOf({ name, colors, ends }) {
  const width = 200, step = width / colors.length;
  const bar = drawing("svg", { viewBox: `0 0 ${width} 22`, role: "img", "aria-label": name },
    ...colors.map((fill, i) => drawing("rect", { x: i * step, width: step + 0.5, height: 8, fill })),
    ...ends.map((text, i) => drawing("text", {
      x: i * width / 2, y: 20, "font-size": 11, "text-anchor": ["start", "middle", "end"][i], fill: "currentColor", direction: "ltr",
    }, text)));
  bar.style.width = `${width}px`;
  bar.style.height = "22px";
  return make("li", {}, `${name} `, bar);
}

// Shows the legend. Returns whether the model has these colours.
export function showColours(list, viewer, colouring) {
  const key = keyOf(viewer, colouring);
  list.hidden = !key;
  list.style.flexWrap = "wrap";
  list.setAttribute("aria-label", key?.name || t("Colours by detail"));
  list.replaceChildren(...!key ? [] : key.colors.length ? [barOf(key)] : key.entries.map(entryOf));
  return Boolean(key);
}

let offered; // the arrays in the menu
let array, map, from, to, rows;

// choose: called with colours in the form of links; without a range if one of its ends is empty.
function makeControls(arrays, choose) {
  array = make("select", { ariaLabel: t("By array") }, make("option", { value: "" }, t("By array")),
    ...arrays.map((value) => make("option", { value }, value)));
  map = make("select", { ariaLabel: t("Colour map") }, ...colorMaps.map((value, i) => make("option", { value }, i < 2 ? value : t("Blue to red"))));
  [from, to] = ["From", "To"].map((label) => make("input", { className: "plain", type: "number", step: "any", ariaLabel: t(label) }));
  [from, to].forEach(({ style }) => (style.flex = 1));
  const byMap = () => `by:${encodeURIComponent(array.value)}:${map.value}`;
  const isRange = () => from.value && to.value && Number(from.value) < Number(to.value);
  const inRange = () => byMap() + (isRange() ? `:${Number(from.value)}:${Number(to.value)}` : "");
  array.addEventListener("change", () => choose(array.value ? byMap() : "own"));
  [map, from, to].forEach((control) => control.addEventListener("change", () => choose(inRange())));
  rows = [[array], [map], [from, to]].map((controls) => make("div", { className: "row" }, ...controls));
  document.querySelector("[name=coloring]").closest("fieldset").append(...rows);
}

export function offerArrays(viewer, colouring, choose) {
  const { arrays, low, high, classes: present } = viewer.arrays();
  if (offered !== arrays.join()) {
    offered = arrays.join();
    rows?.forEach((row) => row.remove());
    makeControls(arrays, choose);
  }
  rows[0].hidden = !arrays.length;
  array.value = arrayOf(colouring);
  rows[1].hidden = rows[2].hidden = !array.value || present.length > 0;
  map.value = colouring.split(":")[2] || colorMaps[0];
  if (!rows[2].contains(document.activeElement)) {
    [from.value, to.value] = [low, high].map((number) => Number(number.toPrecision(6)));
  }
}
