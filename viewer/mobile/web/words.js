// SPDX-License-Identifier: BSD-3-Clause
// Localization: translations of the page's texts, and numbers in the user's language. English texts are in the code. For each
// other language one file (such as words/de.js) translates these texts. It is fetched if the browser asks for that language, or
// if the URL does (?lang=de). Texts that a file lacks are shown in English.

const directions = { de: "ltr", ar: "rtl" }; // of the available languages
const longestWait = 3000; // ms to wait for a language's file; until then the page is in English
const withOne = (one, other) => ({ one: `{n} ${one}`, other: `{n} ${other}` });
export const manyForms = {
  "{n} triangles": withOne("triangle", "triangles"),
  "{n} points": withOne("point", "points"),
  "{n} vertices": withOne("vertex", "vertices"),
  "{n} models found": withOne("model found", "models found"),
  "in {n} seconds": { one: "in {n} second", other: "in {n} seconds" },
};

let texts = manyForms;
let sentences = []; // [pattern, text]: for sentences of the session and the server
let plurals = new Intl.PluralRules("en");

export let language = "en"; // for numbers and times, too

// Call this before anything is shown except index.html's content. A language that loads late is used from then on. changed:
// called whenever one has been loaded.
export async function chooseLanguage(changed) {
  const asked = [new URLSearchParams(location.search).get("lang") ?? "", ...navigator.languages]
    .map((each) => each.split("-")[0].toLowerCase());
  const chosen = asked.find((each) => each === "en" || Object.hasOwn(directions, each));
  if (!chosen || chosen === "en") {
    return;
  }
  const late = new Promise((resolve) => setTimeout(resolve, longestWait));
  const come = import(new URL(`words/${chosen}.js`, import.meta.url).href).then((file) => {
    speak(chosen, file);
    changed();
  }, () => {});
  await Promise.race([come, late]);
}

function speak(chosen, file) {
  texts = file.texts;
  sentences = Object.entries(file.sentences).map(([english, text]) => [patternOf(english), text]);
  plurals = new Intl.PluralRules(chosen);
  language = chosen === "ar" ? "ar-u-nu-latn" : chosen; // Western digits, as in the models' units and the session's sentences
  document.documentElement.lang = chosen;
  document.documentElement.dir = directions[chosen];
  translate(document.documentElement);
}

function patternOf(english) {
  const literal = english.replace(/[.*+?^$()|[\]\\]/g, "\\$&");
  return new RegExp(`^${literal.replace(/\{(\w+)\}/g, "(?<$1>.*?)")}$`, "s");
}

// Wraps a name or sentence that comes from others, because its direction may differ from that of the text around it.
export function apart(text) {
  return document.documentElement.dir === "rtl" || /[\u0590-\u08ff\ufb1d-\ufeff]/.test(text) ? `\u2068${text}\u2069` : text;
}

function fill(text, values) {
  return text.replace(/\{(\w+)\}/g, (_, name) =>
    (typeof values[name] === "number" ? count(values[name]) : apart(values[name] ?? "")));
}

// Returns the text in the user's language with its {names} filled in; if the text has several forms, the form for the number n.
export function t(text, values = {}) {
  const found = texts[text] ?? manyForms[text] ?? text;
  return fill(typeof found === "object" ? found[plurals.select(values.n)] ?? found.other : found, values);
}

// Returns the translation of a whole sentence that another program has made.
export function translated(sentence) {
  for (const [pattern, text] of sentences) {
    const found = pattern.exec(sentence);
    if (found) {
      const values = Object.entries(found.groups ?? {}).map(([name, value]) => [name, translated(value)]);
      return fill(text, Object.fromEntries(values));
    }
  }
  return sentence;
}

// Translates index.html.
function translate(root) {
  const known = (text) => texts[text.trim().replace(/\s+/g, " ")];
  const walk = document.createTreeWalker(root, NodeFilter.SHOW_ELEMENT | NodeFilter.SHOW_TEXT);
  for (let node = root; node; node = walk.nextNode()) {
    if (node.nodeType === Node.TEXT_NODE) {
      node.data = known(node.data) ?? node.data;
    } else {
      for (const name of ["aria-label", "aria-roledescription", "placeholder"]) {
        const text = known(node.getAttribute(name) ?? "");
        text && node.setAttribute(name, text);
      }
    }
  }
}

// ---- numbers

export const count = (number) => number.toLocaleString(language);

// A number and its unit, which keep this order in right-to-left text.
export function figure(number, unit) {
  const text = `${number}\u00a0${unit}`;
  return document.documentElement.dir === "rtl" ? `\u2066${text}\u2069` : text;
}

export function kilobytes(bytes, digits = 1) {
  return bytes < 1e6
    ? figure(count(Math.ceil(bytes / 1000)), "kB")
    : figure((bytes / 1e6).toLocaleString(language, { minimumFractionDigits: digits, maximumFractionDigits: digits }), "MB");
}

// level: -1 for the original.
export const nameOfLevel = (level) => (level < 0 ? t("Original") : t("Level\u00a0{n}", { n: level }));
