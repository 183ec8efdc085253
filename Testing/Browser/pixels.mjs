// SPDX-License-Identifier: BSD-3-Clause
// What is in pictures (PNG), and how far two of them differ.

import { PNG } from "pngjs";

// How many pixels have this colour, [red, green, blue], below the row `top`.
export function countPixels(png, color, top = 0) {
  const { width, data } = PNG.sync.read(png);
  let found = 0;
  for (let i = 4 * width * top; i < data.length; i += 4) {
    found += color.every((value, k) => Math.abs(value - data[i + k]) < 2);
  }
  return found;
}

// A part of a picture, as one: in pixels.
export function partOf(png, { x, y, width, height }) {
  const part = new PNG({ width, height });
  PNG.bitblt(PNG.sync.read(png), part, x, y, width, height);
  return PNG.sync.write(part);
}

// The part of the pixels of which red, green or blue differ by more than `most` (of 255). Sizes must be the same.
export function difference(one, other, most = 24) {
  const [first, second] = [PNG.sync.read(one), PNG.sync.read(other)];
  if (first.width !== second.width || first.height !== second.height) {
    throw new Error(`pictures of ${first.width} x ${first.height} and ${second.width} x ${second.height}`);
  }
  let differing = 0;
  for (let i = 0; i < first.data.length; i += 4) {
    differing += [0, 1, 2].some((k) => Math.abs(first.data[i + k] - second.data[i + k]) > most);
  }
  return differing / (first.width * first.height);
}
