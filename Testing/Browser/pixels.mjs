// SPDX-License-Identifier: BSD-3-Clause
// What is in pictures (PNG), and how far two of them differ.

import pixelmatch from "pixelmatch";
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

// The part of the pixels that differ by more than a grey differs from one that is lighter by `greys` (of 255). Sizes must be
// the same.
export function difference(one, other, greys = 24) {
  const [first, second] = [PNG.sync.read(one), PNG.sync.read(other)];
  const { width, height } = first;
  // pixelmatch's threshold is a square root in the colour space YIQ, and 1 is 263.99 greys.
  const differing = pixelmatch(first.data, second.data, null, width, height, { threshold: greys / 263.99, includeAA: true });
  return differing / (width * height);
}
