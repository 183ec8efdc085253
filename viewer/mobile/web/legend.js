// SPDX-License-Identifier: BSD-3-Clause
// What colours mean, and the arrays of a model that it can be coloured by. Fetched when they are first shown.

import { language, make, nameOfLevel, t } from "./page.js"; // the page that is there already

const maps = [["viridis", "Viridis"], ["cividis", "Cividis"], ["diverging", "Blue to red"]];

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

const entryOfClass = ({ value, name, color }) => entryOf(color, `${inFigures(value)} ${name && t(name)}`);

function barOf({ name, colors, ticks }) {
  const width = 200, shade = width / colors.length;
  const bar = drawing("svg", { viewBox: `-14 0 ${width + 28} 22`, role: "img", "aria-label": name },
    ...colors.map((color, i) =>
      drawing("rect", { x: i * shade, width: shade + 0.5, height: 8, fill: hex(color) })),
    ...ticks.map(([share, value]) =>
      drawing("text", { x: share * width, y: 20, "font-size": 11, "text-anchor": "middle", fill: "currentColor" },
        inFigures(value))));
  bar.style.width = "228px";
  bar.style.height = "22px";
  return make("li", {}, `${name} `, bar);
}

// legend: as viewer.legend has it.
export function showColours(list, legend) {
  list.setAttribute("aria-label", legend.name || t("Colours of detail"));
  list.replaceChildren(...legend.name === undefined
    ? legend.map(({ level, color }) => entryOf(color, nameOfLevel(level)))
    : legend.classes.length ? legend.classes.map(entryOfClass) : [barOf(legend)]);
}

const nameOfArray = (array) => decodeURIComponent(array.slice(3));

let offered = ""; // which arrays
let array, map, from, to, row;

// choose is called with what a link would have.
function makeControls(arrays, choose) {
  array = make("select", { ariaLabel: t("Colours by an array") }, make("option", { value: "" }, t("By an array")),
    ...arrays.map((value) => make("option", { value }, nameOfArray(value))));
  map = make("select", { ariaLabel: t("Colour map") }, ...maps.map(([value, name]) => make("option", { value }, t(name))));
  [from, to] = ["From", "To"].map((label) => make("input", { type: "number", step: "any", ariaLabel: t(label) }));
  const byMap = () => `${array.value}:${map.value}`;
  const inRange = () => (Number(from.value) < Number(to.value) ? `${byMap()}:${Number(from.value)}:${Number(to.value)}` : byMap());
  const usual = make("button", { type: "button", className: "plain", textContent: t("Usual range") });
  array.addEventListener("change", () => choose(array.value || "own"));
  map.addEventListener("change", () => choose(inRange()));
  from.addEventListener("change", () => choose(inRange()));
  to.addEventListener("change", () => choose(inRange()));
  usual.addEventListener("click", () => choose(byMap()));
  row = [make("div", { className: "row" }, map, usual), make("div", { className: "row" }, from, to)];
  document.getElementById("arrays").replaceChildren(make("div", { className: "row" }, array), ...row);
}

// arrays: as links have them. legend: of the one that is shown, if one is.
export function offerArrays(arrays, legend, choose) {
  if (offered !== arrays.join()) {
    offered = arrays.join();
    makeControls(arrays, choose);
  }
  array.value = arrays.find((each) => nameOfArray(each) === legend?.name) ?? "";
  row.forEach((each) => (each.hidden = !legend?.colors?.length));
  if (legend) {
    [map.value, from.value, to.value] = [legend.map, legend.low, legend.high];
  }
}
