// SPDX-License-Identifier: BSD-3-Clause
// Where our viewer's eye is in its first view (viewer/session/Camera.cxx, FitTo): in front of the middle of a box, so
// that the box just fits.

export const viewAngle = 30; // degrees, vertical

const margin = 1.08;

// The distance from the middle of the box. sides: of the box; aspect: width / height of the picture.
export function eyeDistance([x, y, z], aspect) {
  const size = Math.max(y, x / aspect) / 2 / Math.tan(viewAngle * Math.PI / 360);
  return margin * size + z / 2;
}
