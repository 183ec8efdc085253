// SPDX-License-Identifier: BSD-3-Clause
// Measures by which meshes are compared. A mesh is { points: [[x, y, z]], faces: [[index]] }; faces may have any number
// of corners.

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

function boxOf(points) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (const point of points) {
    for (let i = 0; i < 3; ++i) {
      low[i] = Math.min(low[i], point[i]);
      high[i] = Math.max(high[i], point[i]);
    }
  }
  return { low, high };
}

// Measures a mesh by the rule of tolerance (doc/cli.md): points that are not finite are dropped together with their
// faces, and faces need three corners.
//   triangles, places   how many triangles the faces make; how many places they use (of a mesh without faces: points)
//   unused              points that no face uses
//   box                 { low, high } of the places
//   area                of the faces by Newell's formula: of the polygon, however it is cut
//   volume              signed; of an open surface that below it, seen from the box's centre
export function measure({ points, faces }) {
  const isFinite = (point) => point?.every(Number.isFinite);
  const kept = faces.filter((face) => face.length >= 3 && face.every((index) => isFinite(points[index])));
  const used = new Set(kept.flat());
  const shown = faces.length ? [...used].map((index) => points[index]) : points.filter(isFinite);
  const box = boxOf(shown);
  const centre = [0, 1, 2].map((i) => (box.low[i] + box.high[i]) / 2);
  let triangles = 0, area = 0, volume = 0;
  for (const face of kept) {
    const corners = face.map((index) => minus(points[index], centre));
    let newell = [0, 0, 0];
    corners.forEach((corner, i) => {
      const normal = cross(minus(corner, corners[0]), minus(corners[(i + 1) % corners.length], corners[0]));
      newell = newell.map((value, k) => value + normal[k]);
    });
    triangles += face.length - 2;
    area += Math.sqrt(dot(newell, newell)) / 2;
    volume += dot(corners[0], newell) / 6;
  }
  return {
    triangles, area, volume, box,
    places: new Set(shown.map(String)).size,
    unused: faces.length ? points.filter((point, index) => isFinite(point) && !used.has(index)).length : 0,
  };
}

// The differences between two measures, as text; "" if there are none. Lengths may differ by `step`.
export function differenceOf(one, other, step) {
  const wrong = [];
  const size = Math.hypot(...minus(other.box.high, other.box.low));
  const near = (what, a, b, tolerance) => Math.abs(a - b) <= tolerance || wrong.push(`${what} ${a}, not ${b}`);
  for (const what of ["triangles", "places", "unused"]) {
    near(what, one[what], other[what], 0);
  }
  for (let i = 0; i < 3; ++i) {
    near(`least ${"xyz"[i]}`, one.box.low[i], other.box.low[i], step);
    near(`greatest ${"xyz"[i]}`, one.box.high[i], other.box.high[i], step);
  }
  near("area", one.area, other.area, 10 * size * step);
  near("volume", one.volume, other.volume, 10 * size * size * step);
  return wrong.join(", ");
}
