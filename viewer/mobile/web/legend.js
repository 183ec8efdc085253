// SPDX-License-Identifier: BSD-3-Clause
// What colours mean, and the arrays of a model that it can be coloured by. Fetched when they are first shown.

import { arrayOf, colorMaps, language, make, nameOfLevel, t } from "./page.js"; // the page that is there already

const inFigures = (number) => Number(number.toPrecision(6)).toLocaleString(language, { maximumSignificantDigits: 6 });
const hex = (color) => `#${color.toString(16).padStart(6, "0")}`;

// By attributes: the page's policy lets no style into elements.
function drawing(tag, attributes, ...inner) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  Object.entries(attributes).forEach(([name, value]) => element.setAttribute(name, value));
  element.append(...inner);
  return element;
}

function entryOf(color, ...words) {
  const square = drawing("rect", { width: 1, height: 1, fill: hex(color) });
  return make("li", {}, drawing("svg", { viewBox: "0 0 1 1" }, square), ...words);
}

// What LAS calls those of its classes that most files have.
const classes = {
  1: "unclassified", 2: "ground", 3: "low vegetation", 4: "medium vegetation", 5: "high vegetation", 6: "building", 7: "noise",
  9: "water", 11: "road", 17: "bridge", 18: "noise",
};
const mostClasses = 20; // that are told

function classesOf(name, present, viewer) {
  return present.slice(0, mostClasses).map((value) =>
    entryOf(viewer.shade(value), `${inFigures(value)} ${name.includes("lassification") && classes[value] ? t(classes[value]) : ""}`));
}

// From the low end to the high one.
function barOf(name, { low, high }, viewer) {
  const width = 200, shades = 40;
  const ends = [[low, "start"], [(low + high) / 2, "middle"], [high, "end"]];
  const bar = drawing("svg", { viewBox: `0 0 ${width} 22`, role: "img", "aria-label": name },
    ...Array.from({ length: shades }, (_, i) => drawing("rect", {
      x: i * width / shades, width: width / shades + 0.5, height: 8,
      fill: hex(viewer.shade(low + (high - low) * (i + 0.5) / shades)),
    })),
    ...ends.map(([value, anchor], i) => drawing("text", {
      x: i * width / 2, y: 20, "font-size": 11, "text-anchor": anchor, fill: "currentColor", direction: "ltr",
    }, inFigures(value))));
  bar.style.width = `${width}px`;
  bar.style.height = "22px";
  return make("li", {}, `${name} `, bar);
}

export function showColours(list, viewer, colouring) {
  const name = arrayOf(colouring);
  const shown = viewer.arrays();
  list.hidden = !!name && !shown.arrays.includes(name);
  list.style.flexWrap = "wrap";
  list.setAttribute("aria-label", name || t("Colours of detail"));
  list.replaceChildren(...!name ? viewer.legend().map(({ level, color }) => entryOf(color, nameOfLevel(level)))
    : shown.classes.length ? classesOf(name, shown.classes, viewer) : [barOf(name, shown, viewer)]);
}

let offered; // which arrays
let array, map, from, to, rows;

// choose is called with what a link would have: without a range where one of its ends is empty.
function makeControls(arrays, choose) {
  array = make("select", { ariaLabel: t("By an array") }, make("option", { value: "" }, t("By an array")),
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
