// SPDX-License-Identifier: BSD-3-Clause
// Examines pictures (PNG), and measures how much two of them differ.

import { PNG } from "pngjs";

// The number of pixels below the row `top` that have this colour, [red, green, blue].
export function countPixels(png, color, top = 0) {
  const { width, data } = PNG.sync.read(png);
  let found = 0;
  for (let i = 4 * width * top; i < data.length; i += 4) {
    found += color.every((value, k) => Math.abs(value - data[i + k]) < 2);
  }
  return found;
}

// A part of a picture as a picture; x, y, width and height are in pixels.
export function partOf(png, { x, y, width, height }) {
  const part = new PNG({ width, height });
  PNG.bitblt(PNG.sync.read(png), part, x, y, width, height);
  return PNG.sync.write(part);
}

// The share of pixels whose red, green or blue differs by more than `most` (of 255). The sizes must be equal.
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
