#!/usr/bin/env node
// SPDX-License-Identifier: BSD-3-Clause
// Collects all sentences of the programs in one list, Messages.txt, so that reviewers see when a sentence changes.
//   node Testing/Documents/messages.mjs           exit code 1 and the differences, if the list is out of date
//   node Testing/Documents/messages.mjs --write   writes the list
//
// A sentence of C++ or JavaScript is a string literal with two blanks or more. Consecutive literals are one sentence.
// Values that `+`, `<<` or `${}` put between them are written as {}, and a choice between literals in parentheses as
// {one|other}. For the page's languages the list has each text and its translation. The sentences of a file are sorted,
// so that moving one does not change the list.
import { execFileSync } from "node:child_process";
import { existsSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join, relative } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

const root = join(dirname(fileURLToPath(import.meta.url)), "../..");
const list = join(dirname(fileURLToPath(import.meta.url)), "Messages.txt");
const folders = ["filters", "server", "viewer"];

// ---- tokens: { kind: "string" | "template" | "word" | "other", text }

const escapes = { n: "\\n", t: "\\t", '"': '"', "'": "'", "\\": "\\" };

function unescape(text) {
  return text.replace(/\\\r?\n/g, "").replace(/\\u([0-9a-fA-F]{4})/g, (_, code) => String.fromCharCode(parseInt(code, 16)))
    .replace(/\\(.)/gs, (all, sign) => escapes[sign] ?? all);
}

// Longer tokens come first. Preprocessor lines are left out, and so are raw strings, which are shaders and test data.
const tokensOfCpp = [
  ["skip", /\s+|\/\/[^\n]*|\/\*.*?\*\/|^[ \t]*#(?:[^\n\\]|\\.)*/msy],
  ["raw", /(?:u8|u|U|L)?R"([^(\s]*)\(.*?\)\1"/sy],
  ["string", /(?:u8|u|U|L)?"((?:[^"\\\n]|\\.)*)"/sy],
  ["other", /'(?:[^'\\\n]|\\.)*'/sy],
  ["word", /[\w.]+(?:(?:::|->)\w+)*/y],
  ["other", /<<|>>|&&|\|\||[=!<>+-]=|->|::|./sy],
];
const tokensOfJavaScript = [
  ["skip", /\s+|\/\/[^\n]*|\/\*.*?\*\//sy],
  ["string", /"((?:[^"\\\n]|\\.)*)"/sy],
  ["string", /'((?:[^'\\\n]|\\.)*)'/sy],
  ["template", /`((?:[^`\\]|\\.)*)`/sy],
  ["word", /[\w$.]+/y],
  ["other", /&&|\|\||[=!<>+-]=|=>|./sy],
];
const regularExpression = /\/(?![*/])(?:[^/\\\n[]|\\.|\[(?:[^\]\\\n]|\\.)*\])+\/[a-z]*/y;

function tokensOf(text, kinds) {
  const found = [];
  const isJavaScript = kinds === tokensOfJavaScript;
  for (let at = 0; at < text.length;) {
    const last = found.at(-1)?.text ?? "(";
    regularExpression.lastIndex = at;
    const expression = isJavaScript && /^([(,=:[!&|?{};+]|&&|\|\||=>|return)$/.test(last) && regularExpression.exec(text);
    if (expression) {
      found.push({ kind: "word", text: "expression" });
      at += expression[0].length;
      continue;
    }
    for (const [kind, pattern] of kinds) {
      pattern.lastIndex = at;
      const match = pattern.exec(text);
      if (match) {
        if (kind !== "skip") {
          found.push({ kind: kind === "raw" ? "word" : kind, text: kind === "string" || kind === "template" ? match[1] : match[0] });
        }
        at += match[0].length;
        break;
      }
    }
  }
  return found;
}

// ---- sentences

// Texts that are not sentences: SQL, shaders, the head of an HTTP message, rules of CSS.
const isCode = (text) => /^\s*(SELECT|INSERT|CREATE|PRAGMA|DELETE|UPDATE|WITH|DROP|ALTER|#version|precision|HTTP\/1)\b|gl_|VTK::|\bvec[234]\b|;\s*\\n|[;{}]$|:\s?\w+;/
  .test(text);

function isSentence(text) {
  let words = text.replace(/\\[nt]/g, " ").trim();
  while (/\{[^{}]*\}/.test(words)) { // a choice may contain values
    words = words.replace(/\{[^{}]*\}/g, "");
  }
  return (words.match(/\S /g) ?? []).length >= 2 && /\p{L}{2}/u.test(words) && !isCode(words);
}

// The parts of an expression are joined to one text until a comma, the end of a statement, or something similar.
class Level {
  text = "";
  hasLiteral = false;
  needsOperand = true;
  choices = []; // the alternatives of `? "one" : "other"`

  constructor(opener, isCall) {
    this.opener = opener;
    this.isCall = isCall;
  }

  literal(text) {
    this.text += text;
    this.hasLiteral = true;
    this.needsOperand = false;
  }

  // A value that is not a literal becomes one {}, however many tokens it has.
  operand() {
    if (this.needsOperand) {
      this.text += "{}";
    }
    this.needsOperand = false;
  }

  end(keep) {
    if (this.hasLiteral) {
      keep(this.text);
    }
    this.text = "";
    this.hasLiteral = false;
    this.needsOperand = true;
  }

  choice() {
    this.choices.push(this.hasLiteral ? this.text : "{}");
    this.text = "";
    this.hasLiteral = false;
    this.needsOperand = true;
  }
}

function sentencesOf(tokens) {
  const found = [];
  const keep = (text) => isSentence(text) && found.push(text.trim());
  const levels = [new Level("", false)];
  let before = null;
  for (const token of tokens) {
    const level = levels.at(-1);
    const { kind, text } = token;
    if (kind === "string" || kind === "template") {
      const words = kind === "template" ? unescape(text).replace(/\$\{(?:[^{}]|\{[^{}]*\})*\}/g, "{}") : unescape(text);
      level.literal(words);
    } else if (text === "(" || text === "[" || text === "{") {
      if (text === "{" && before?.text !== "(" && before?.text !== ",") {
        level.end(keep);
      }
      levels.push(new Level(text, text !== "(" || before?.kind === "word" || before?.text === ")" || before?.text === ">"));
    } else if (text === ")" || text === "]" || text === "}") {
      const inner = levels.length > 1 ? levels.pop() : new Level("", true);
      const outer = levels.at(-1);
      if (!inner.isCall && inner.choices.length) {
        inner.choices.shift(); // removes the condition
        inner.choice();
        const isChoice = inner.choices.some((each) => each !== "{}");
        if (isChoice && outer.needsOperand) {
          outer.text += `{${inner.choices.join("|")}}`;
          outer.needsOperand = false;
        } else {
          inner.choices.forEach((each) => keep(each));
          outer.operand();
        }
      } else {
        inner.choices.forEach((each) => keep(each));
        inner.end(keep);
        outer.operand();
      }
      if (text === "}" && inner.opener === "{" && outer.opener !== "(") {
        outer.end(keep);
      }
    } else if (text === "+" || text === "<<" || text === "+=") {
      if (text === "+=") {
        level.end(keep);
      }
      level.needsOperand = true;
    } else if (text === "?" || (text === ":" && level.choices.length)) {
      level.choice();
    } else if (/^([,;:=]|=>|[=!<>]=|&&|\|\||return|case|throw)$/.test(text)) {
      level.choices.forEach((each) => keep(each));
      level.choices = [];
      level.end(keep);
    } else {
      level.operand();
    }
    before = token;
  }
  while (levels.length) {
    levels.pop().end(keep);
  }
  return found;
}

// ---- files

function textsOfHtml(html) {
  const text = html.replace(/<!--.*?-->|<(script|style)\b.*?<\/\1>/gs, "\n");
  const attributes = [...text.matchAll(/(?:aria-\w+|placeholder|content|title)="([^"]*)"/g)].map((each) => each[1]);
  return [...attributes, ...text.replace(/<[^>]*>/gs, "\n\n").split(/\n\s*\n/).map((each) => each.replace(/\s+/g, " ").trim())]
    .filter((each) => isSentence(each));
}

async function textsOfLanguage(path) {
  const { texts, sentences } = await import(pathToFileURL(path));
  const forms = (text) => (typeof text === "string" ? text : Object.values(text).join(" | "));
  return [...Object.entries(texts), ...Object.entries(sentences)].map(([english, text]) => `${english} => ${forms(text)}`);
}

function* filesIn(folder) {
  for (const entry of readdirSync(folder, { withFileTypes: true })) {
    const path = join(folder, entry.name);
    if (entry.isDirectory() && !/^(Testing|node_modules|sdk)$/.test(entry.name)) {
      yield* filesIn(path);
    } else if (entry.isFile()) {
      yield path;
    }
  }
}

async function sentencesOfFile(path) {
  if (/\/words\/\w+\.js$/.test(path)) {
    return textsOfLanguage(path);
  }
  const text = readFileSync(path, "utf8");
  if (path.endsWith(".html")) {
    return textsOfHtml(text);
  }
  return sentencesOf(tokensOf(text, path.endsWith("js") ? tokensOfJavaScript : tokensOfCpp));
}

async function makeList() {
  const parts = [];
  const paths = folders.flatMap((each) => [...filesIn(join(root, each))]).filter((each) => /\.(cxx|h|in|js|mjs|html)$/.test(each));
  for (const path of paths.sort()) {
    const sentences = await sentencesOfFile(path);
    if (sentences.length) {
      const lines = sentences.map((each) => each.replace(/\r?\n/g, "\\n")).sort((a, b) => (a < b ? -1 : a > b ? 1 : 0));
      parts.push(`== ${relative(root, path)}\n${lines.join("\n")}\n`);
    }
  }
  return parts.join("\n");
}

const made = await makeList();
if (process.argv[2] === "--write") {
  writeFileSync(list, made);
} else if (!existsSync(list) || readFileSync(list, "utf8") !== made) {
  console.log("Testing/Documents/Messages.txt is not what the sources say. Read the differences, then run\n"
    + "  node Testing/Documents/messages.mjs --write\n");
  try {
    execFileSync("diff", ["-u", list, "-"], { input: made, stdio: ["pipe", "inherit", "inherit"] });
  } catch {
    // diff's exit code says that there are differences, which is already known
  }
  process.exit(1);
}
