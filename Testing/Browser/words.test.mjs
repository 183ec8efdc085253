// SPDX-License-Identifier: BSD-3-Clause
// Each language has a translation of every text of the page, and of nothing else. Without a browser.

import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { test } from "node:test";

import { manyForms } from "../../viewer/mobile/web/words.js";

const web = fileURLToPath(new URL("../../viewer/mobile/web/", import.meta.url));
const read = (name) => readFileSync(join(web, name), "utf8");

const literals = (code) => [...code.matchAll(/"((?:[^"\\]|\\.)*)"/g)].map(([each]) => JSON.parse(each));

// The first argument of a call whose opening parenthesis is just before `begin`.
function firstArgument(code, begin) {
  let depth = 0;
  for (let i = begin; i < code.length; ++i) {
    if (code[i] === "\"") {
      i = code.indexOf("\"", i + 1);
    } else if ("([{".includes(code[i])) {
      ++depth;
    } else if (depth === 0 && ",)".includes(code[i])) {
      return code.slice(begin, i);
    } else if (")]}".includes(code[i])) {
      --depth;
    }
  }
  return "";
}

// Functions that take a text, and the index of that argument: t, and functions that pass it to t (elements.js,
// tools.js, sectionAndLight.js).
const takers = { t: 0, makeButton: 0, group: 0, "this.#note": 0, along: 0, toggle: 1, step: 1, makeSlider: 1 };

// The texts that a script passes to these functions.
function textsOfScript(code) {
  const names = Object.keys(takers).map((name) => name.replace(".", "\\.")).join("|");
  const calls = [...code.matchAll(new RegExp(`(?<![\\w.])(${names})\\(`, "g"))];
  const found = calls.flatMap(({ 0: call, 1: name, index }) => {
    const begin = index + call.length;
    const first = firstArgument(code, begin);
    return literals(takers[name] ? firstArgument(code, begin + first.length + 1) : first);
  });
  return found.filter((each) => /\p{L}/u.test(each));
}

// The texts of index.html: between tags, and in attributes that users read or hear.
function textsOfPage(text) {
  const body = text.slice(text.indexOf("<body")).replace(/<svg.*?<\/svg>/gs, "");
  const between = [...body.matchAll(/>([^<]+)</g)].map(([, each]) => each);
  const said = [...body.matchAll(/(?:aria-label|aria-roledescription|placeholder)="([^"]+)"/g)].map(([, each]) => each);
  return [...between, ...said].map((each) => each.trim().replace(/\s+/g, " ")).filter((each) => /\p{L}/u.test(each));
}

const scripts = readdirSync(web).filter((name) => name.endsWith(".js"));
const elsewhere = ["Front", "Back", "Left", "Right", "Top", "Bottom", // in tools.js, in a list
  "From", "To", "unclassified", "ground", "low vegetation", "medium vegetation", "high vegetation", "building",
  "low point (noise)", "water", "road", "bridge deck", "high noise", // in legend.js, from lists
  "this browser stores nothing for this page", "the browser's storage is full"]; // in storage.js
const wanted = new Set([...scripts.flatMap((name) => textsOfScript(read(name))), ...textsOfPage(read("index.html")), ...elsewhere]);
const namesIn = (text) => [...new Set([...text.matchAll(/\{(\w+)\}/g)].map(([, name]) => name))].sort();

test("classes of LAS are called as in the window", () => {
  const names = readFileSync(join(web, "..", "..", "session", "appearance", "ColorLegend.cxx"), "utf8").match(/lasNames\{([^}]*)\}/)[1];
  const all = [...names.matchAll(/"([^"]+)"/g)].map(([, name]) => name);
  const here = [...read("legend.js").match(/const classes = \{([^}]*)\}/)[1].matchAll(/(\d+): "([^"]+)"/g)];
  assert.ok(here.length > 8);
  here.forEach(([, number, name]) => assert.equal(name, all[number], number));
});

test("texts are found", () => {
  for (const text of ["Loading the viewer", "Copy link", "Measure", "First view", "Level\u00a0{n}", "Pause", "the server is busy"]) {
    assert.ok(wanted.has(text), text);
  }
});

for (const file of readdirSync(join(web, "words"))) {
  test(`${file} has all texts, and no other`, async () => {
    const { texts, sentences } = await import(join(web, "words", file));
    assert.deepEqual([...wanted].filter((text) => !Object.hasOwn(texts, text)), [], "missing");
    assert.deepEqual(Object.keys(texts).filter((text) => !wanted.has(text)), [], "of no use");
    const plurals = new Intl.PluralRules(file.slice(0, 2));
    for (const [english, text] of Object.entries({ ...texts, ...sentences })) {
      if (typeof text === "object") {
        assert.ok(Object.hasOwn(manyForms, english), `${english} has one form in English`);
        assert.deepEqual(Object.keys(text).sort(), [...plurals.resolvedOptions().pluralCategories].sort(), english);
      }
      for (const form of typeof text === "object" ? Object.values(text) : [text]) {
        assert.ok(form.trim() && !/[<>&]/.test(form), english);
        assert.deepEqual(namesIn(form).filter((name) => !namesIn(english).includes(name)), [], `names in “${form}”`);
        if (typeof text === "string") {
          assert.deepEqual(namesIn(form), namesIn(english), english);
        }
      }
    }
  });
}
export { wanted };
