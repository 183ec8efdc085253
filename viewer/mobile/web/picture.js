// SPDX-License-Identifier: BSD-3-Clause
// A picture to save: the canvas with the lines over it, on the page's background; below it the legend, title, credit and licence.

import { make } from "./list.js";

const dark = { ink: "#f3f0ea", foot: "#1a1c20", ground: ["rgb(33 36 41)", "rgb(92 94 99)"] };
const light = { ink: "#1d1c19", foot: "#f4f2ee", ground: ["#f4f2ee", "#d9d6cf"] }; // light.css
const look = () => (document.documentElement.dataset.theme === "light" ? light : dark);
const mostLines = 3; // per text
const mostLetters = 1000; // per text

function shorten(brush, text, width) {
  let letters = [...text];
  while (letters.length > 1 && brush.measureText(letters.join("")).width > width) {
    letters = [...letters.slice(0, -2), "…"];
  }
  return letters.join("");
}

// Breaks a text into lines of at most this width. If there are more than mostLines, the last one ends with an ellipsis.
function wrap(brush, text, width) {
  const lines = [""];
  for (const word of text.slice(0, mostLetters).split(/\s+/)) {
    const longer = `${lines.at(-1)} ${word}`.trim();
    if (lines.at(-1) && brush.measureText(longer).width > width) {
      lines.push(word);
    } else {
      lines[lines.length - 1] = longer;
    }
  }
  const rest = lines.splice(mostLines - 1).join(" ");
  return [...lines, ...rest ? [rest] : []].map((each) => shorten(brush, each, width));
}

// ---- the legend as rows; each row is a function that draws itself with its baseline at y

function entryRows(brush, entries, { left, width, line }) {
  const rows = [[]];
  let x = 0;
  for (const { color, text } of entries) {
    const wide = 1.3 * line + brush.measureText(text).width;
    if (x > 0 && x + wide > width) {
      rows.push([]);
      x = 0;
    }
    rows.at(-1).push({ color, text, x: left + x });
    x += wide;
  }
  return rows.map((row) => (y) => row.forEach(({ color, text, x: from }) => {
    brush.fillStyle = color;
    brush.fillRect(from, y - 0.6 * line, 0.6 * line, 0.6 * line);
    brush.fillStyle = look().ink;
    brush.fillText(text, from + 0.8 * line, y);
  }));
}

function barRows(brush, { colors, ends }, { left, width, line }) {
  const wide = Math.min(width, 18 * line);
  const step = wide / colors.length;
  return [
    (y) => colors.forEach((color, i) => {
      brush.fillStyle = color;
      brush.fillRect(left + i * step, y - 0.5 * line, step + 1, 0.5 * line);
    }),
    (y) => {
      brush.fillStyle = look().ink;
      ends.forEach((text, i) => {
        brush.textAlign = ["left", "center", "right"][i];
        brush.fillText(text, left + i * wide / 2, y);
      });
      brush.textAlign = "start";
    },
  ];
}

// key: as returned by keyOf (legend.js), or null.
function rowsOf(brush, key, words, place) {
  const textRow = (text) => (y) => {
    brush.fillStyle = look().ink;
    brush.fillText(text, place.left, y);
  };
  const named = key?.name ? [textRow(shorten(brush, key.name, place.width))] : [];
  const colours = key ? [...named, ...key.colors.length ? barRows(brush, key, place) : entryRows(brush, key.entries, place)] : [];
  return [...colours, ...words.flatMap((text) => wrap(brush, text, place.width)).map(textRow)];
}

// Returns a PNG as a Blob. overlay: called with the canvas's context, to draw the lines over the picture.
export function composePicture({ canvas, overlay, key, words }) {
  const ratio = canvas.width / canvas.clientWidth;
  const line = Math.round(18 * ratio);
  const picture = make("canvas", { width: canvas.width });
  const brush = picture.getContext("2d");
  const font = `${Math.round(13 * ratio)}px system-ui, sans-serif`;
  brush.font = font;
  const rows = rowsOf(brush, key, words, { left: line / 2, width: canvas.width - line, line });
  picture.height = canvas.height + (rows.length ? (rows.length + 0.7) * line : 0); // this also resets the font
  const ground = brush.createLinearGradient(0, 0, 0, canvas.height);
  look().ground.forEach((colour, i) => ground.addColorStop(i, colour));
  brush.fillStyle = ground;
  brush.fillRect(0, 0, canvas.width, canvas.height);
  brush.drawImage(canvas, 0, 0);
  overlay(brush);
  brush.fillStyle = look().foot;
  brush.fillRect(0, canvas.height, picture.width, picture.height - canvas.height);
  brush.font = font;
  rows.forEach((draw, i) => draw(canvas.height + (i + 1) * line));
  return new Promise((done) => {
    picture.toBlob(done, "image/png");
  });
}
