// SPDX-License-Identifier: BSD-3-Clause
// Reads VRML 2: groups, Transform, Switch, LOD, DEF and USE; shapes that are IndexedFaceSet or Box; no PROTO, no
// Inline. Reads VRML 1: Separator, ShapeHints, Coordinate3 and IndexedFaceSet.

const tokens = /"(?:\\.|[^"\\])*"|[[\]{}]|[^\s,[\]{}"#]+|#[^\n]*/g;

function parse(text) {
  const words = text.match(tokens).filter((word) => !word.startsWith("#"));
  const named = new Map();
  let at = 0;
  const isNumber = (word) => /^[-+.\d]/.test(word ?? "");
  const node = () => {
    let name = null;
    if (words[at] === "USE") {
      at += 2;
      return named.get(words[at - 1]);
    }
    if (words[at] === "DEF") {
      name = words[at + 1];
      at += 2;
    }
    const made = { type: words[at++] };
    ++at; // skips {
    name && named.set(name, made);
    while (words[at] !== "}") {
      if (/^[A-Z]/.test(words[at])) { // a child node, such as Separator
        (made.children ??= []).push(node());
      } else {
        made[words[at++]] = value();
      }
    }
    ++at;
    return made;
  };
  const value = () => {
    if (words[at] === "[") {
      const all = [];
      for (++at; words[at] !== "]";) {
        all.push(isNumber(words[at]) ? Number(words[at++]) : words[at].startsWith('"') ? words[at++] : node());
      }
      ++at;
      return all;
    }
    if (isNumber(words[at])) {
      const all = [];
      while (isNumber(words[at])) {
        all.push(Number(words[at++]));
      }
      return all;
    }
    if (/^(TRUE|FALSE|NULL|CLOCKWISE|COUNTERCLOCKWISE)$/.test(words[at]) || words[at].startsWith('"')) {
      return words[at++];
    }
    return node();
  };
  const nodes = [];
  while (at < words.length) {
    nodes.push(node());
  }
  return nodes;
}

const times = (a, b) => Array.from({ length: 16 }, (_, i) =>
  // Matrices are stored by rows.
  [0, 1, 2, 3].reduce((sum, k) => sum + a[4 * Math.floor(i / 4) + k] * b[4 * k + i % 4], 0));
const move = ([x, y, z]) => [1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1];
const grow = ([x, y, z]) => [x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, 0, 0, 0, 1];
function turn([x, y, z, angle]) {
  const length = Math.hypot(x, y, z) || 1;
  const [u, v, w, c, s] = [x / length, y / length, z / length, Math.cos(angle), Math.sin(angle)];
  const d = 1 - c;
  return [u * u * d + c, u * v * d - w * s, u * w * d + v * s, 0, u * v * d + w * s, v * v * d + c, v * w * d - u * s, 0,
    u * w * d - v * s, v * w * d + u * s, w * w * d + c, 0, 0, 0, 0, 1];
}

const boxFaces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];

export function readVrml(bytes) {
  const points = [], faces = [];
  const addShape = ({ geometry }, m) => {
    const first = points.length;
    const place = ([x, y, z]) => points.push([0, 4, 8].map((i) => m[i] * x + m[i + 1] * y + m[i + 2] * z + m[i + 3]));
    const isMirror = m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]) < 0;
    const add = (face) => faces.push((isMirror !== (geometry.ccw === "FALSE") ? face.reverse() : face).map((i) => first + i));
    if (geometry.type === "Box") {
      const half = (geometry.size ?? [2, 2, 2]).map((size) => size / 2);
      for (let i = 0; i < 8; ++i) {
        place([0, 1, 2].map((k) => (i >> k & 1 ? half[k] : -half[k])));
      }
      boxFaces.forEach((face) => add([...face]));
      return;
    }
    for (let i = 0; i < geometry.coord.point.length; i += 3) {
      place(geometry.coord.point.slice(i, i + 3));
    }
    let face = [];
    for (const index of [...geometry.coordIndex, -1]) {
      index >= 0 ? face.push(index) : face.length && (add(face), face = []);
    }
  };
  let [coord, ccw] = [null, "TRUE"]; // VRML 1: these apply to the next face set
  const walk = (node, m) => {
    if (node.type === "Coordinate3") {
      coord = node;
    } else if (node.type === "ShapeHints") {
      ccw = node.vertexOrdering === "CLOCKWISE" ? "FALSE" : "TRUE";
    } else if (node.type === "IndexedFaceSet") {
      addShape({ geometry: { ...node, coord, ccw } }, m);
    } else if (node.type === "Shape") {
      addShape(node, m);
    } else if (node.type === "Switch") {
      const chosen = node.choice?.[node.whichChoice?.[0] ?? -1];
      chosen && walk(chosen, m);
    } else if (node.type === "LOD") {
      walk(node.level[0], m);
    } else {
      let inner = m;
      if (node.type === "Transform") {
        const { translation = [0, 0, 0], rotation = [0, 0, 1, 0], scale = [1, 1, 1], center = [0, 0, 0], scaleOrientation = [0, 0, 1, 0] } = node;
        inner = [move(translation), move(center), turn(rotation), turn(scaleOrientation), grow(scale),
          turn([...scaleOrientation.slice(0, 3), -scaleOrientation[3]]), move(center.map((c) => -c))].reduce(times, m);
      }
      [node.children ?? []].flat().forEach((child) => walk(child, inner));
    }
  };
  parse(bytes.toString("utf8").replace(/^\ufeff/, "")).forEach((node) => walk(node, grow([1, 1, 1])));
  return { points, faces, colors: [] };
}
