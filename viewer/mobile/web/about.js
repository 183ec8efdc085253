// SPDX-License-Identifier: BSD-3-Clause
// The sheet with information about a model: all of its texts (URLs in them are links), its size and, in the details, its number
// of triangles. Fetched when it is first opened. Texts are untrusted: they never become HTML, and only http links are made.

import { makeButton } from "./elements.js";
import { describeLengths } from "./lengths.js";
import { make, nameOf } from "./list.js";
import { addressIn } from "./origin.js";
import { kilobytes, t } from "./words.js";

// ---- links

const address = /https?:\/\/[^\s<>"'“”‘’]+/g;

function linkTo(text) {
  const found = addressIn(text);
  return found ? make("a", { href: found.href, target: "_blank", rel: "noopener noreferrer nofollow", textContent: text }) : text;
}

// Returns the text with its URLs as links. A full stop or bracket after a URL belongs to the sentence, not to the URL.
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

// ---- the sheet

function row(name, ...what) {
  return [make("dt", { textContent: name }), make("dd", { dir: "auto" }, ...what)];
}

// If a budget leaves much of the surface coarser, the text says so: "Up to" the finest level that is shown.
function describeSurface({ shownLevel, finestLevel, triangles, vertices, region, original, errorLeft }) {
  if (shownLevel === null) {
    return "";
  }
  const isCut = errorLeft > 2;
  const detail = region?.shown || original
    ? t(isCut ? "Up to the original" : "Level {level} and original", { level: shownLevel })
    : t(isCut ? "Up to level {level} of {finest}" : "Level {level} of {finest}", { level: shownLevel, finest: finestLevel });
  return `${detail} · ${triangles ? t("{n} triangles", { n: triangles }) : t("{n} points", { n: vertices })}`;
}

function describeProgress({ blobsLoaded, blobsWanted, bytesLoaded }) {
  return blobsWanted
    ? t("{done} of {all} parts, {bytes}", { done: blobsLoaded, all: blobsWanted, bytes: kilobytes(bytesLoaded) })
    : "";
}

const describeOriginal = ({ triangles, vertices }) => vertices && `${t("The original")}: ${triangles
  ? `${t("{n} triangles", { n: triangles })} · ${t("{n} vertices", { n: vertices })}` : t("{n} points", { n: vertices })}`;

// Statistics of the view.
export const describeDetails = (status) => [describeSurface(status), describeProgress(status)].filter(Boolean).join(" · ");

// Returns the content of the sheet. close: what the sheet's button does.
export function describeModel(model, { sides = [], unit, credit, license, description }, close) {
  const rows = [];
  const lengths = unit && sides.length ? describeLengths(sides, unit) : "";
  lengths && rows.push(...row(t("Size"), lengths));
  credit && rows.push(...row(t("By"), ...withLinks(credit)));
  license && rows.push(...row(t("Licence"), ...withLinks(license)));
  const text = description || model.description;
  return [
    make("h2", { dir: "auto", textContent: nameOf(model) }),
    ...(text ? [make("p", { dir: "auto" }, ...withLinks(text))] : []),
    ...(rows.length ? [make("dl", {}, ...rows)] : []),
    make("details", {}, make("summary", { textContent: t("Details") }), make("p", { textContent: describeOriginal(model) }), make("p", { id: "details" })),
    makeButton("Close", close, { className: "plain" }),
  ];
}
