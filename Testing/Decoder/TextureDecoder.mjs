// SPDX-License-Identifier: BSD-3-Clause
// A second decoder of textures, for tests, like that of pieces. It is written only from doc/formats.md (section 8).
// Throws if a blob is damaged.
import { Symbols, content, need, ordered, unordered } from "./PieceDecoder.mjs";

const context = { corner: 0, chartOf: 3, parallelogram: 4, near: 6, far: 8, chart: 10, table: 11, chartSource: 12, chartPlace: 13 };
const double = new DataView(new ArrayBuffer(8));

function bitsToDouble(bits) {
  double.setBigUint64(0, BigInt.asUintN(64, bits));
  return double.getFloat64(0);
}

function readTables(symbols, triangles) {
  const number = () => symbols.number(context.table);
  const halvings = number();
  need(halvings <= 14, "halved too often");
  const sources = [], charts = [];
  const sourceCount = number();
  need(sourceCount <= triangles, "too many sources");
  for (let i = 0; i < sourceCount; ++i) {
    const source = { picture: number(), width: number(), height: number(), rows: [] };
    for (let k = 0; k < 6; ++k) source.rows.push(bitsToDouble(symbols.big(context.table)));
    const wrap = number();
    need(wrap <= 8, "an unknown wrap mode");
    sources.push(source);
  }
  const chartCount = number();
  need(chartCount <= triangles, "too many charts");
  for (let i = 0; i < chartCount; ++i) {
    const source = symbols.number(context.chartSource);
    need(source <= sources.length, "no such source");
    const place = [symbols.signed(context.chartPlace), symbols.signed(context.chartPlace)];
    need(place.every((at) => Math.abs(at) <= 2 ** 46), "a chart's position is out of range");
    charts.push({ source: source === 0 ? null : sources[source - 1], place });
  }
  return { scale: 2 ** -halvings, charts };
}

// The places of a planar texture's corners.
function readPlanar(symbols, triangles, positions, width, height) {
  const texels = bitsToDouble(symbols.big(context.table)), charts = [], places = [], chartOf = [], lastAt = new Map();
  const chartCount = symbols.number(context.table);
  need(chartCount <= triangles.length, "too many charts");
  for (let i = 0; i < chartCount; ++i) {
    const turn = [0, 1, 2].map(() => symbols.signed(context.chartSource));
    const place = [0, 1].map(() => symbols.signed(context.chartPlace));
    need(turn.every((part) => Math.abs(part) <= 2048) && place.every((at) => Math.abs(at) <= 2 ** 46), "a chart out of range");
    const [x, y, z] = turn.map((part) => part / 2048), w = Math.sqrt(Math.max(0, 1 - x * x - y * y - z * z));
    charts.push({ place, axes: [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
      [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)]] });
  }
  triangles.forEach((triangle, t) => {
    const which = symbols.symbol(context.chartOf);
    const other = which < 3 ? lastAt.get(triangle[which]) : null;
    need(other !== undefined, "no chart there");
    chartOf.push(which < 3 ? chartOf[other] : (t === 0 ? 0 : chartOf[t - 1]) + symbols.signed(context.chart));
    const chart = charts[chartOf[t]];
    need(chart, "no such chart");
    for (const vertex of triangle) {
      lastAt.set(vertex, t);
      const from = [0, 1, 2].map((k) => positions[3 * vertex + k] - positions[k]);
      const place = chart.axes.map((axis, k) =>
        Math.fround((from[0] * axis[0] + from[1] * axis[1] + from[2] * axis[2]) * texels + chart.place[k] / 8));
      need(place[0] >= 0 && place[0] <= width && place[1] >= 0 && place[1] <= height, "a corner outside");
      places.push(...place);
    }
  });
  symbols.finish();
  return places;
}

// triangles, positions: those of the piece. Returns the places of corners in texels; for an exact texture also `given`, which are
// u and v.
export function decodeTexture(blob, triangles, positions) {
  const reader = content(blob, "KDX");
  const count = reader.varint(), width = reader.varint(), height = reader.varint(), format = reader.byte();
  need(count === triangles.length, "another number of triangles");
  need(width >= 1 && width <= 16383 && height >= 1 && height <= 16383, "no picture");
  const exact = format >= 128;
  const coarse = !exact && format >= 64, planar = !exact && !coarse && format >= 32;
  const kind = format - (exact ? 128 : coarse ? 64 : planar ? 32 : 0), steps = coarse ? 8 : 256; // in a texel
  need(kind >= 1 && kind <= 3, "no format");
  const image = reader.take(reader.varint());
  const symbols = new Symbols(reader, 14, 4);
  if (planar) {
    return { width, height, format: kind, image, places: readPlanar(symbols, triangles, positions, width, height), given: [] };
  }
  const tables = exact ? readTables(symbols, count) : null;
  const recent = new Map(), lastAt = new Map(), pairs = [], chartOf = [];
  const equal = (a, b) => a[0] === b[0] && a[1] === b[1];
  const value = (bits) => unordered(BigInt.asUintN(32, bits), 4);
  const close = (n, p, o) => {
    if (!exact) return BigInt.asIntN(64, n + p - o);
    const closed = value(n) + value(p) - value(o);
    return Math.abs(closed) < 1e30 ? ordered(Math.fround(closed), 4) : n;
  };
  // The third corner of the triangle on the other side of the edge between the corners n and p.
  const across = (t, n, p, other) => {
    if (other === undefined) return null;
    const mine = triangles[t], theirs = triangles[other];
    for (let k = 0; k < 3; ++k) {
      for (const turn of [1, 2]) {
        const a = (k + turn) % 3, b = (k + 3 - turn) % 3;
        if (theirs[a] === mine[n] && theirs[b] === mine[p] && equal(pairs[other][a], pairs[t][n]) &&
            equal(pairs[other][b], pairs[t][p])) return pairs[other][k];
      }
    }
    return null;
  };
  const predict = (t, k, known) => {
    const n = (k + 1) % 3, p = (k + 2) % 3, here = pairs[t];
    for (const at of known[n] && known[p] ? [n, p] : []) {
      const o = across(t, n, p, lastAt.get(triangles[t][at]));
      if (o) return [context.parallelogram, [close(here[n][0], here[p][0], o[0]), close(here[n][1], here[p][1], o[1])]];
    }
    if (known[n] || known[p]) return [context.near, here[known[p] ? p : n]];
    return [context.far, t === 0 ? [0n, 0n] : pairs[t - 1][2]];
  };
  const places = [], given = [];
  for (let t = 0; t < count; ++t) {
    const triangle = triangles[t];
    if (exact) {
      const which = symbols.symbol(context.chartOf);
      const other = which < 3 ? lastAt.get(triangle[which]) : null;
      need(other !== undefined, "no chart there");
      chartOf.push(which < 3 ? chartOf[other] : (t === 0 ? 0 : chartOf[t - 1]) + symbols.signed(context.chart));
      need(tables.charts[chartOf[t]], "no such chart");
    }
    const coded = triangle.map((vertex, k) => {
      const symbol = symbols.symbol(context.corner + k);
      return recent.get(vertex)?.[symbol];
    });
    pairs.push(coded.map((pair) => pair ?? [0n, 0n]));
    const known = coded.map((pair) => pair !== undefined);
    for (let k = 0; k < 3; ++k) {
      if (known[k]) continue;
      const [under, near] = predict(t, k, known);
      pairs[t][k] = near.map((number, i) => BigInt.asIntN(64, number + symbols.bigSigned(under + i)));
      known[k] = true;
    }
    triangle.forEach((vertex, k) => {
      const before = recent.get(vertex) ?? [];
      if (!before.length || !equal(before[0], pairs[t][k])) recent.set(vertex, [pairs[t][k], ...before].slice(0, 2));
      lastAt.set(vertex, t);
    });
    for (const pair of pairs[t]) {
      need(pair.every((number, i) => number >= 0n && number <= (exact ? 2n ** 32n - 1n : BigInt(steps * [width, height][i]))),
        "a corner outside");
      let place = pair.map((number) => Number(number) / steps);
      if (exact) {
        const [u, v] = pair.map(value);
        given.push(u, v);
        const { source, place: moved } = tables.charts[chartOf[t]];
        const rows = source?.rows;
        const at = source ? [(rows[0] * u + rows[1] * v + rows[2]) * source.width, (rows[3] * u + rows[4] * v + rows[5]) * source.height]
          : [0, 0];
        place = at.map((texels, i) => Math.fround((texels + moved[i]) * tables.scale));
      }
      need(place[0] >= 0 && place[0] <= width && place[1] >= 0 && place[1] <= height, "a corner outside");
      places.push(...place);
    }
  }
  symbols.finish();
  return { width, height, format: kind, image, places, given };
}
