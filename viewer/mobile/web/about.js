// SPDX-License-Identifier: BSD-3-Clause
// The information about a model, for its panel: all of its texts, with links for URLs in them, its size and its triangles.
// Fetched when it is first opened. Texts are untrusted: they never become HTML, and only http links are made.

import { makeButton } from "./elements.js";
import { make, nameOf } from "./list.js";
import { addressIn } from "./origin.js";
import { figure, language, t } from "./words.js";

// ---- links

const address = /https?:\/\/[^\s<>"'“”‘’]+/g;

function linkTo(text) {
  const found = addressIn(text);
  return found ? make("a", { href: found.href, target: "_blank", rel: "noopener noreferrer nofollow", textContent: text }) : text;
}

// The text, its URLs as links. A full stop or bracket after a URL belongs to the sentence.
export function withLinks(text) {
  const parts = [];
  let end = 0;
  for (const { 0: found, index } of text.matchAll(address)) {
    const kept = found.replace(/[.,;:!?)\]]+$/, "");
    parts.push(text.slice(end, index), linkTo(kept));
    end = index + kept.length;
  }
  return [...parts, text.slice(end)].filter(Boolean);
}

// ---- lengths

const metres = { pm: 1e-12, nm: 1e-9, "µm": 1e-6, mm: 1e-3, cm: 1e-2, m: 1, km: 1e3 };
const aliases = { "μm": "µm", um: "µm", micron: "µm", microns: "µm", millimetre: "mm", millimeter: "mm", centimetre: "cm",
  centimeter: "cm", metre: "m", meter: "m", metres: "m", meters: "m", kilometre: "km", kilometer: "km" };
const preferred = ["pm", "nm", "µm", "mm", "m", "km"];

// Three digits of the longest side, in the unit of metres in which they are easily read; of other units as they are.
export function describeLengths(sides, unit) {
  const longest = Math.max(...sides);
  const known = aliases[unit.toLowerCase()] ?? unit;
  if (!(longest > 0) || !Number.isFinite(longest)) {
    return "";
  }
  let shown = unit;
  let factor = 1;
  const isOdd = longest < 0.1 || longest >= 10000;
  if (isOdd && Object.hasOwn(metres, known)) {
    shown = preferred.findLast((each) => longest * metres[known] >= metres[each]) ?? preferred[0];
    factor = metres[known] / metres[shown];
  }
  const digits = 2 - Math.floor(Math.log10(longest * factor)); // after the point, of all sides alike
  const plain = digits < 8 && digits > -7;
  const figures = sides.map((side) => {
    const value = side * factor;
    if (!plain) {
      return value.toLocaleString(language, { notation: "scientific", maximumSignificantDigits: 3 });
    }
    const step = 10 ** Math.max(-digits, 0);
    const rounded = digits < 0 ? Math.round(value / step) * step : value;
    return rounded.toLocaleString(language, { maximumFractionDigits: Math.max(digits, 0) });
  });
  return figure(figures.join(" × "), shown);
}

// ---- the sheet

function row(name, ...what) {
  return [make("dt", { textContent: name }), make("dd", { dir: "auto" }, ...what)];
}

// close: what the button does. Gives what goes into the sheet.
export function describeModel(model, { sides = [], unit, credit, license, description }, close) {
  const rows = [];
  const lengths = unit && sides.length ? describeLengths(sides, unit) : "";
  lengths && rows.push(...row(t("Size"), lengths));
  if (model.vertices) {
    rows.push(...row(t("The original"), model.triangles
      ? `${t("{n} triangles", { n: model.triangles })}, ${t("{n} vertices", { n: model.vertices })}`
      : t("{n} points", { n: model.vertices })));
  }
  credit && rows.push(...row(t("By"), ...withLinks(credit)));
  license && rows.push(...row(t("Licence"), ...withLinks(license)));
  const text = description || model.description;
  return [
    make("h2", { dir: "auto", textContent: nameOf(model) }),
    ...(text ? [make("p", { dir: "auto" }, ...withLinks(text))] : []),
    make("dl", {}, ...rows),
    makeButton("Close", close, { className: "plain" }),
  ];
}
