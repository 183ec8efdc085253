// SPDX-License-Identifier: BSD-3-Clause
// Where our first view has its eye (viewer/session/Camera.cxx, FitTo): before the middle of a box, so that it just fits.

export const viewAngle = 30; // degrees, vertical

const margin = 1.08;

// sides: of the box; aspect: of the picture, width / height. From the middle.
export function eyeDistance([x, y, z], aspect) {
  const size = Math.max(y, x / aspect) / 2 / Math.tan(viewAngle * Math.PI / 360);
  return margin * size + z / 2;
}
