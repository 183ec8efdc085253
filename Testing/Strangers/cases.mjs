// SPDX-License-Identifier: BSD-3-Clause
// Writes a file of each kind that was once read wrongly or refused. A case has these members. `name`. `file`: the file
// to read. `files`, { name: bytes }: files that are written before. `right`: values that must be measured
// (measures.mjs), in addition to those that the small readers find. `says`: what a warning must say. `refused`: what
// the error must say instead. `colors`: all colours, 0 to 255, of the resulting model. `mustRefuse`: the file must not
// be read. `silent`: what no warning may say. `comesBack`: the ending of a file that is extracted, too.

import { deflateSync, gzipSync } from "node:zlib";

const corners = [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]];
const quads = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
const triangles = quads.flatMap(([a, b, c, d]) => [[a, b, c], [a, c, d]]);
const cube = { triangles: 12, volume: 8, area: 24, places: 8 };
const shiny = [[1, 0, 0], [0, 0, 1]];

// ---- texts

const objOf = (points, faces) =>
  [...points.map((point) => `v ${point.join(" ")}`), ...faces.map((face) => `f ${face.map((i) => i + 1).join(" ")}`), ""].join("\n");
const cubeObj = objOf(corners, quads);

function plyOf(points, faces, { properties = "", row = () => "" } = {}) {
  return ["ply", "format ascii 1.0", `element vertex ${points.length}`, "property double x", "property double y",
    "property double z", ...(properties ? [properties] : []), `element face ${faces.length}`,
    "property list uchar int vertex_indices", "end_header", ...points.map((point, i) => `${point.join(" ")} ${row(i)}`.trim()),
    ...faces.map((face) => `${face.length} ${face.join(" ")}`), ""].join("\n");
}

const stlText = (end = "endloop") => ["solid cube", ...triangles.map((triangle) =>
  `facet normal 0 0 0\nouter loop\n${triangle.map((i) => `vertex ${corners[i].join(" ")}`).join("\n")}\n${end}\nendfacet`),
  "endsolid cube", ""].join("\n");

function stlBytes() {
  const bytes = Buffer.alloc(84 + 50 * triangles.length);
  bytes.writeUInt32LE(triangles.length, 80);
  triangles.forEach((triangle, i) => triangle.forEach((index, k) =>
    corners[index].forEach((value, axis) => bytes.writeFloatLE(value, 84 + 50 * i + 12 + 12 * k + 4 * axis))));
  return bytes;
}

// A star with `count` points; every second corner is a notch.
const star = (count) => Array.from({ length: 2 * count }, (_, i) => {
  const [radius, angle] = [i % 2 ? 1 : 3, Math.PI * i / count];
  return [radius * Math.cos(angle), radius * Math.sin(angle), 0];
});
const starArea = (count) => count * 3 * Math.sin(Math.PI / count);

const scatter = (count) => Array.from({ length: count }, (_, i) => [i % 7 - 3.25, (5 * i) % 11 / 2, (3 * i) % 13 / 4]);

// ---- glTF

// A .glb with one mesh, the cube, and these nodes. more: further properties. blocks: further accessors [component type,
// shape, rows], whose numbers begin at 2.
function glb(nodes, { more = {}, blocks = [], primitive = {}, positions = [5126, "VEC3", corners] } = {}) {
  const writes = { 5122: ["writeInt16LE", 2], 5123: ["writeUInt16LE", 2], 5126: ["writeFloatLE", 4] };
  const all = [positions, [5123, "SCALAR", triangles.flat().map((index) => [index])], ...blocks];
  const parts = [], bufferViews = [], accessors = [];
  let length = 0;
  for (const [componentType, type, rows] of all) {
    const [write, size] = writes[componentType];
    const stride = Math.ceil(rows[0].length * size / 4) * 4;
    const isIndex = type === "SCALAR";
    const step = isIndex ? size : stride;
    const part = Buffer.alloc(Math.ceil(rows.length * step / 4) * 4);
    rows.forEach((row, i) => row.forEach((value, k) => part[write](value, i * step + k * size)));
    bufferViews.push({ buffer: 0, byteOffset: length, byteLength: part.length, ...(isIndex ? {} : { byteStride: step }) });
    accessors.push({ bufferView: bufferViews.length - 1, componentType, type, count: rows.length,
      ...(type === "VEC3" && componentType === 5126 ? { min: [0, 1, 2].map((k) => Math.min(...rows.map((row) => row[k]))),
        max: [0, 1, 2].map((k) => Math.max(...rows.map((row) => row[k]))) } : {}) });
    length += part.length;
    parts.push(part);
  }
  const json = { asset: { version: "2.0" }, buffers: [{ byteLength: length }], bufferViews, accessors,
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1, ...primitive }] }], nodes,
    scenes: [{ nodes: nodes.map((_, i) => i) }], scene: 0, ...more };
  if (nodes.some(({ children }) => children)) {
    const inner = new Set(nodes.flatMap(({ children = [] }) => children));
    json.scenes[0].nodes = json.scenes[0].nodes.filter((i) => !inner.has(i));
  }
  const text = Buffer.from(JSON.stringify(json));
  const padded = Buffer.concat([text, Buffer.alloc(-text.length & 3, " ")]);
  const head = Buffer.alloc(20), middle = Buffer.alloc(8);
  head.write("glTF");
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(28 + padded.length + length, 8);
  head.writeUInt32LE(padded.length, 12);
  head.write("JSON", 16);
  middle.writeUInt32LE(length);
  middle.write("BIN\0", 4);
  return Buffer.concat([head, padded, middle, ...parts]);
}

// The same with its JSON and bytes changed: change(json, bytes) returns the new bytes, or nothing.
function glbChanged(bytes, change) {
  const length = bytes.readUInt32LE(12);
  const json = JSON.parse(bytes.toString("utf8", 20, 20 + length));
  const old = bytes.subarray(28 + length);
  const body = change(json, old) ?? old;
  json.buffers[0].byteLength = body.length;
  const text = Buffer.from(JSON.stringify(json));
  const padded = Buffer.concat([text, Buffer.alloc(-text.length & 3, " ")]);
  const head = Buffer.from(bytes.subarray(0, 20)), middle = Buffer.alloc(8);
  head.writeUInt32LE(28 + padded.length + body.length, 8);
  head.writeUInt32LE(padded.length, 12);
  middle.writeUInt32LE(body.length);
  middle.write("BIN\0", 4);
  return Buffer.concat([head, padded, middle, body]);
}

// The cube in a .glb whose binary chunk (BIN) has another name. before: the name of another chunk in front of it.
function withChunk(name, before = "") {
  const bytes = glb([{ mesh: 0 }]);
  const end = 20 + bytes.readUInt32LE(12);
  const chunk = before ? Buffer.from(`\x04\0\0\0${before}wxyz`) : Buffer.alloc(0);
  const changed = Buffer.concat([bytes.subarray(0, end), chunk, bytes.subarray(end)]);
  changed.write(name, end + chunk.length + 4);
  changed.writeUInt32LE(changed.length, 8);
  return changed;
}

const redGlossy = { extensions: { KHR_materials_pbrSpecularGlossiness: { diffuseFactor: [1, 0, 0, 1], glossinessFactor: 0.2 } } };

// Encodes at most 16 attributes of `stride` bytes for EXT_meshopt_compression (mode 0): for each byte of an attribute
// 16 differences, not packed; then the first attribute.
function meshopt(values, stride) {
  const count = values.length / stride;
  const all = [0xa0];
  for (let k = 0; k < stride; ++k) {
    all.push(3);
    for (let i = 0; i < 16; ++i) {
      const difference = i > 0 && i < count ? (values[i * stride + k] - values[(i - 1) * stride + k]) & 255 : 0;
      all.push(((difference << 1) ^ (difference & 128 ? 255 : 0)) & 255);
    }
  }
  return Buffer.from([...all, ...new Array(Math.max(0, 32 - stride)).fill(0), ...values.subarray(0, stride)]);
}

// ---- pictures

// A PNG of one colour.
function png(color) {
  const crc = (bytes) => {
    let sum = ~0;
    for (const byte of bytes) {
      sum ^= byte;
      for (let bit = 0; bit < 8; ++bit) {
        sum = (sum >>> 1) ^ (sum & 1 ? 0xedb88320 : 0);
      }
    }
    return ~sum >>> 0;
  };
  const chunk = (type, data) => {
    const body = Buffer.concat([Buffer.from(type), data]), ends = Buffer.alloc(8);
    ends.writeUInt32BE(data.length);
    ends.writeUInt32BE(crc(body), 4);
    return Buffer.concat([ends.subarray(0, 4), body, ends.subarray(4)]);
  };
  const row = Buffer.from([0, ...color, ...color]);
  return Buffer.concat([Buffer.from("\x89PNG\r\n\x1a\n", "latin1"), chunk("IHDR", Buffer.from([0, 0, 0, 2, 0, 0, 0, 2, 8, 2, 0, 0, 0])),
    chunk("IDAT", deflateSync(Buffer.concat([row, row]))), chunk("IEND", Buffer.alloc(0))]);
}

// The cube with a texture; `line` is the line of its material library that names the picture.
const texturedBy = (line, picture) => ({ "a.mtl": `newmtl m\n${line}\n`, [picture]: png([250, 20, 20]),
  "a.obj": ["mtllib a.mtl", objOf(corners, []), "vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1", "usemtl m",
    ...quads.map((quad) => `f ${quad.map((index, k) => `${index + 1}/${k + 1}`).join(" ")}`), ""].join("\n") });
const texturedCube = { file: "a.obj", right: cube, colors: [[250, 20, 20]] };

// ---- VRML

const cubeWrl = (more = "") => `Shape { geometry IndexedFaceSet { coord Coordinate { point [ ${corners.map((c) => c.join(" ")).join(", ")} ] }
  coordIndex [ ${quads.map((quad) => `${quad.join(" ")} -1`).join(" ")} ] ${more} } }`;
const wrl = (text) => `#VRML V2.0 utf8\n${text}\n`;
const wrlOne = (text, points = corners, faces = quads) => `#VRML V1.0 ascii\nSeparator { ${text} Coordinate3 { point [ ${points.map((c) => c.join(" ")).join(", ")} ] }
  IndexedFaceSet { coordIndex [ ${faces.map((face) => `${face.join(" ")} -1`).join(" ")} ] } }\n`;
const h = Math.SQRT1_2;

// ---- LAS 1.2, points of format 2

function las({ counted = 300, held = 300, color = () => [200, 100, 50] } = {}) {
  const bytes = Buffer.alloc(227 + 26 * held);
  bytes.write("LASF");
  bytes.writeUInt8(1, 24);
  bytes.writeUInt8(2, 25);
  bytes.writeUInt16LE(227, 94);
  bytes.writeUInt32LE(227, 96);
  bytes.writeUInt8(2, 104);
  bytes.writeUInt16LE(26, 105);
  bytes.writeUInt32LE(counted, 107);
  [0.001, 0.001, 0.001, 10, 20, 30].forEach((value, i) => bytes.writeDoubleLE(value, 131 + 8 * i));
  const points = scatter(held);
  [0, 1, 2].forEach((k) => {
    bytes.writeDoubleLE(Math.max(...points.map((p) => p[k])) + 10 * (k + 1), 179 + 16 * k);
    bytes.writeDoubleLE(Math.min(...points.map((p) => p[k])) + 10 * (k + 1), 187 + 16 * k);
  });
  points.forEach((point, i) => {
    point.forEach((value, k) => bytes.writeInt32LE(Math.round(1000 * value), 227 + 26 * i + 4 * k));
    color(i).forEach((value, k) => bytes.writeUInt16LE(value, 227 + 26 * i + 20 + 2 * k));
  });
  return bytes;
}

// With another box in its header.
function lasBox(bytes, low, high) {
  [0, 1, 2].forEach((axis) => [high, low].forEach((value, i) => bytes.writeDoubleLE(value, 179 + 16 * axis + 8 * i)));
  return bytes;
}

const pcd = (fields, data) => ["# .PCD v0.7", "VERSION 0.7", fields, "SIZE 4 4 4", "TYPE F F F", "COUNT 1 1 1", "WIDTH 40",
  "HEIGHT 1", "VIEWPOINT 0 0 0 1 0 0 0", "POINTS 40", `DATA ${data}`, ""].join("\n");
const pcdMore = (type, size) => pcd("FIELDS x y z label", "ascii").replace("SIZE 4 4 4", `SIZE 4 4 4 ${size}`).replace("TYPE F F F", `TYPE F F F ${type}`).replace("COUNT 1 1 1", "COUNT 1 1 1 1");
const floats = (rows) => Buffer.from(new Float32Array(rows.flat()).buffer);

const utf16 = (text) => Buffer.from(`\ufeff${text}`, "utf16le");
const mtl = (first, second) => [first, second].map((name, i) => `newmtl ${name}\nKd ${shiny[i].join(" ")}\n`).join("");
// Two cubes that share no vertex: otherwise their colours would mix.
const twoMaterials = (first, second) => ["mtllib a.mtl", objOf([...corners, ...corners.map(([x, y, z]) => [x + 5, y, z])], []),
  `usemtl ${first}`, objOf([], quads), `usemtl ${second}`, objOf([], quads.map((quad) => quad.map((i) => i + 8)))].join("\n");
const twoCubes = { triangles: 24, volume: 16 };
const twoColors = [[255, 0, 0], [0, 0, 255]];

const coloredObj = (color) => objOf(corners.map((corner, i) => [...corner, ...color(i)]), quads);
// A material library whose picture does not exist.
const gone = "newmtl m\nmap_Kd gone.png\n";

// The cube's PLY with changes in its text.
const plyWith = (changes, options) => changes.reduce((text, [from, to]) => text.replace(from, to), plyOf(corners, quads, options));
const plyInLines = (text) => text.replace(/end_header\n([^]*)$/, (_, body) => `end_header\n${body.trim().replaceAll("\n", " ")}\n`);

// A binary PLY of the cube with 64-bit coordinates and another type for faces.
function plyBytes(type) {
  const head = `ply\nformat binary_little_endian 1.0\nelement vertex 8\nproperty int64 x\nproperty int64 y\nproperty int64 z\nproperty uint64 id
element face 6\nproperty list float ${type} vertex_indices\nend_header\n`;
  const vertices = Buffer.from(new BigInt64Array(corners.flatMap((corner, i) => [...corner, i].map(BigInt))).buffer);
  const indices = { float: Float32Array, double: Float64Array, uint64: BigUint64Array }[type];
  const faces = quads.map((quad) => Buffer.concat([floats([[4]]), Buffer.from(new indices(quad.map((i) => (type === "uint64" ? BigInt(i) : i))).buffer)]));
  return Buffer.concat([Buffer.from(head), vertices, ...faces]);
}

// A binary PLY of the cube whose byte order is the opposite of what its header says.
function plyInOtherOrder(counts) {
  const vertices = Buffer.alloc(96), size = counts === "int" ? 4 : 1;
  corners.flat().forEach((value, i) => vertices.writeFloatBE(value, 4 * i));
  const faces = quads.map((quad) => {
    const face = Buffer.alloc(size + 16);
    face[size - 1] = 4;
    quad.forEach((index, k) => face.writeInt32BE(index, size + 4 * k));
    return face;
  });
  return Buffer.concat([Buffer.from(plyOf(corners, quads).split("end_header")[0].replace("ascii", "binary_little_endian").replaceAll("double", "float").replace("uchar", counts)),
    Buffer.from("end_header\n"), vertices, ...faces]);
}

// A binary PLY of points with the byte order `order`; its header says `said`.
function plyPoints(said, order, type = "Float") {
  const size = type === "Double" ? 8 : 4, numbers = scatter(40).flat(), bytes = Buffer.alloc(size * numbers.length);
  numbers.forEach((value, i) => bytes[`write${type}${order}`](value, size * i));
  return Buffer.concat([Buffer.from(`ply\nformat binary_${said === "LE" ? "little" : "big"}_endian 1.0\nelement vertex 40\n${["x", "y", "z"].map((name) => `property ${type.toLowerCase()} ${name}\n`).join("")}end_header\n`), bytes]);
}

function floatsOf(numbers, order) {
  const bytes = Buffer.alloc(4 * numbers.length);
  numbers.forEach((value, i) => bytes[`writeFloat${order}`](value, 4 * i));
  return bytes;
}

// Points as text, each with further columns such as a colour.
const rowsOf = (between, more = () => [], count = 40) => scatter(count).map((point, i) => [...point, ...more(i)].join(between)).join("\n");
const cloud = { triangles: 0, places: 40 };

// Points as text, with a number in front of each.
const numbered = (number) => scatter(40).map((point, i) => [number(i), ...point].join(" ")).join("\n");
const boxOfCloud = { low: [-3.25, 0, 0], high: [2.75, 5, 3] };

const offOf = (kind = "OFF\n", { row = () => "", face = () => "" } = {}) => [`${kind}8 6 12`, ...corners.map((corner, i) => `${corner.join(" ")} ${row(i)}`),
  ...quads.map((quad, i) => `${quad.length} ${quad.join(" ")} ${face(i)}`), ""].join("\n");

const vtk = (kind, parts) => `# vtk DataFile Version 3.0\nmade by hand\nASCII\nDATASET ${kind}\n${parts.join("\n")}\n`;
const vtkPoints = `POINTS 8 float\n${corners.map((corner) => corner.join(" ")).join("\n")}`;
const vtkPolygons = `POLYGONS 6 30\n${quads.map((quad) => `4 ${quad.join(" ")}`).join("\n")}`;
const vtkOffsets = `POLYGONS 7 24\nOFFSETS vtktypeint64\n${[0, ...quads.map((_, i) => 4 * i + 4)].join(" ")}\nCONNECTIVITY vtktypeint64\n${quads.flat().join(" ")}`;
const vtp = (points, polygons) => `<?xml version="1.0"?>
<VTKFile type="PolyData" version="0.1" byte_order="LittleEndian"><PolyData><Piece NumberOfPoints="${points}" NumberOfPolys="${polygons}">
<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">${corners.flat().join(" ")}</DataArray></Points>
<Polys><DataArray type="Int32" Name="connectivity" format="ascii">${quads.flat().join(" ")}</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">${quads.map((_, i) => 4 * i + 4).join(" ")}</DataArray></Polys></Piece></PolyData></VTKFile>\n`;

// A .vtp of several pieces [x, list of ends, arrays of points]: each is a cube at x; without x the piece is empty.
const vtpPieces = (...pieces) => `<VTKFile type="PolyData" version="0.1" byte_order="LittleEndian"><PolyData>${pieces.map(([x, ends, arrays = ""]) => (x === undefined
  ? '<Piece NumberOfPoints="0" NumberOfPolys="0"/>' : vtp(8, 6).replace(corners.flat().join(" "), corners.map(([a, ...rest]) => [a + x, ...rest].join(" ")).join(" "))
    .replace(/>4 8 12 16 20 24</, `>${ends ?? "4 8 12 16 20 24"}<`).replace("<Points>", `${arrays}<Points>`).replace(/^[^]*<PolyData>|<\/PolyData>[^]*$/g, "")))
  .join("\n")}</PolyData></VTKFile>\n`;
// The cube's points in base64: their length, and then their bytes.
const base64Of = (claimed, isApart = false) => {
  const [length, bytes] = [Buffer.from(new Uint32Array([claimed]).buffer), floats(corners)];
  return isApart ? length.toString("base64") + bytes.toString("base64") : Buffer.concat([length, bytes]).toString("base64");
};
const vtpBase64 = (points) => vtp(8, 6).replace(/format="ascii">[^<]*/, `format="binary">${points}`);
// A .vtp whose points and corners are appended after its XML. missing: how many bytes of the points are missing.
function vtpAppended(encoding, { claimed = 96, missing = 0, offset = 0, packs = false, between = "" } = {}) {
  const write = (bytes) => (encoding === "raw" ? bytes : Buffer.from(bytes.toString("base64")));
  const block = (claim, bytes) => {
    const packed = packs ? deflateSync(bytes) : bytes;
    const head = Buffer.from(new Uint32Array(packs ? [1, bytes.length, 0, claim === bytes.length ? packed.length : claim] : [claim]).buffer);
    return packs ? Buffer.concat([write(head), write(packed)]) : write(Buffer.concat([head, packed]));
  };
  const points = block(claimed, floats(corners).subarray(missing)), lists = block(96, Buffer.from(new Int32Array(quads.flat()).buffer));
  const text = vtp(8, 6).replace("<VTKFile", `<VTKFile${packs ? ' compressor="vtkZLibDataCompressor"' : ""}`).replace(/format="ascii">[^<]*<\/DataArray>/, `format="appended" offset="${offset}"/>`)
    .replace(/(connectivity" )format="ascii">[^<]*<\/DataArray>/, `$1format="appended" offset="${points.length}"/>`).split("</VTKFile>");
  return Buffer.concat([Buffer.from(`${text[0]}<AppendedData encoding="${encoding}">\n_`), points.subarray(0, 20), Buffer.from(between), points.subarray(20), lists, Buffer.from(`\n</AppendedData></VTKFile>\n`)]);
}
const vtpArrays = (...arrays) => `<PointData>${arrays.map(([name, components, from]) =>
  `<DataArray type="UInt8" Name="${name}" NumberOfComponents="${components}" format="ascii">${corners.map((_, i) => Array.from({ length: components }, (__, k) => from + 10 * i + k).join(" ")).join(" ")}</DataArray>`).join("")}</PointData>`;
const solid = (points, type, cell) => vtk("UNSTRUCTURED_GRID", [`POINTS ${points.length} float`, ...points.map((point) => point.join(" ")),
  `CELLS ${cell.length / type[1]} ${cell.length / type[1] * (type[1] + 1)}`, ...Array.from({ length: cell.length / type[1] }, (_, i) => [type[1], ...cell.slice(i * type[1], (i + 1) * type[1])].join(" ")),
  `CELL_TYPES ${cell.length / type[1]}`, ...Array(cell.length / type[1]).fill(type[0])]);
const mirrored = corners.map(([x, y, z]) => [-x, y, z]);
const prism = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]];

function vtkBytes() {
  const points = Buffer.alloc(96), cells = Buffer.alloc(120);
  corners.flat().forEach((value, i) => points.writeFloatBE(value, 4 * i));
  quads.flatMap((quad) => [4, ...quad]).forEach((value, i) => cells.writeInt32BE(value, 4 * i));
  return Buffer.concat([Buffer.from("# vtk DataFile Version 3.0\nmade by hand\nBINARY\nDATASET POLYDATA\nPOINTS 8 float\n"), points,
    Buffer.from("\nPOLYGONS 6 30\n"), cells, Buffer.from("\n")]);
}

// A ZIP archive that contains an empty file with this name.
function zipOf(name) {
  const entry = Buffer.alloc(46), end = Buffer.alloc(22), file = Buffer.from(`PK\x03\x04${"\0".repeat(26)}${name}`);
  file.writeUInt16LE(name.length, 26);
  entry.write("PK\x01\x02");
  entry.writeUInt16LE(name.length, 28);
  end.write("PK\x05\x06");
  end.writeUInt16LE(1, 10);
  end.writeUInt32LE(46 + name.length, 12);
  end.writeUInt32LE(file.length, 16);
  return Buffer.concat([file, entry, Buffer.from(name), end]);
}

// Writes the coordinates in a scene by write(number), with decimal commas.
const commas = (text, write) => text.replace(/point \[[^\]]*/, (list) => list.replace(/-?\d+/g, (v) => write(Number(v)).replace(".", ",")));
const fortran = (text) => text.replace(/(v|float)([^f]*)/g, (_, word, numbers) => word + numbers.replace(/-?\b1\b/g, (v) => `${v}.0D+00`));
const stlLoops = (loops, write = String) => ["solid", ...loops.map((loop) =>
  `facet normal 0 0 0\nouter loop\n${loop.map((p) => `vertex ${p.map(write).join(" ")}`).join("\n")}\nendloop\nendfacet`), "endsolid", ""].join("\n");
const stlQuads = (faces, write) => stlLoops(faces.map((face) => face.map((i) => corners[i])), write);

// A binary PLY of the cube with an integer for each vertex whose bits are those of a float.
function plyFloatRgb(bits) {
  const head = `ply\nformat binary_little_endian 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nproperty float rgb
element face 6\nproperty list uchar int vertex_indices\nend_header\n`;
  const vertices = corners.map((corner, i) => Buffer.concat([floats([corner]), Buffer.from(new Uint32Array([bits(i)]).buffer)]));
  return Buffer.concat([Buffer.from(head), ...vertices, ...quads.map((quad) => Buffer.concat([Buffer.from([4]), Buffer.from(new Int32Array(quad).buffer)]))]);
}

// A b3dm whose head has this number of bytes (28, or fewer as before version 1.0), and its table.
function b3dm(head, table = "") {
  const bytes = Buffer.alloc(head), body = glb([{ mesh: 0 }]);
  bytes.write("b3dm");
  const sizes = { 20: [3, table.length], 24: [table.length, 0, 3], 28: [0, 0, table.length, 0] }[head];
  [1, head + table.length + body.length, ...sizes].forEach((number, i) => bytes.writeUInt32LE(number, 4 + 4 * i));
  return Buffer.concat([bytes, Buffer.from(table), body]);
}
const tileset = (content) => JSON.stringify({ asset: { version: "1.0" }, geometricError: 9,
  root: { boundingVolume: { sphere: [0, 0, 0, 9] }, geometricError: 0, refine: "ADD", content: { uri: content } } });

// The cube with vertex colours as floats.
const gltfColors = (color) => glb([{ mesh: 0 }], { primitive: { attributes: { POSITION: 0, COLOR_0: 2 } }, blocks: [[5126, "VEC3", corners.map((_, i) => color(i))]] });

// A binary PLY of points with 32-bit integers as coordinates; its header says `said`.
function plyIntegers(said, order, values) {
  const bytes = Buffer.alloc(12 * values.length);
  values.flat().forEach((value, i) => bytes[`writeInt32${order}`](value, 4 * i));
  return Buffer.concat([Buffer.from(`ply\nformat binary_${said === "LE" ? "little" : "big"}_endian 1.0\nelement vertex ${values.length}\nproperty int x\nproperty int y\nproperty int z\nend_header\n`), bytes]);
}
const millimetres = scatter(40).map((point) => point.map((value) => Math.round(1000 * value)));
const byteColors = (color) => plyOf(corners, quads, { properties: "property uchar red\nproperty uchar green\nproperty uchar blue", row: () => color });

const one = (name, file, bytes, right, rest = {}) => ({ name, file, files: { [file]: bytes }, right, ...rest });

export const cases = [
  one("an OBJ with a byte order mark", "a.obj", `\ufeff${cubeObj}`, cube),
  one("an OBJ with CR alone", "a.obj", cubeObj.replaceAll("\n", "\r"), cube),
  one("an OBJ that ends in Ctrl-Z", "a.obj", `${cubeObj}\x1a`, cube),
  one("an OBJ in UTF-16", "a.obj", utf16(cubeObj), cube, { refused: /UTF-16/ }),
  one("an OBJ with a face of two corners", "a.obj", `${cubeObj}f 1 2\n`, cube, { says: /two|fewer than three/ }),
  one("an OBJ with indices of attributes that are not there", "a.obj",
    cubeObj.replace(/f (\d+) (\d+) (\d+) (\d+)/g, "f $1/0/9 $2/7/0 $3/0/9 $4/0/9"), cube, { says: /texture|normal|attribute/ }),
  // The advice in each kind of refusal.
  one("advice: a PLY that is cut off", "a.ply", plyOf(corners, quads).split("\n").slice(0, -4).join("\n"), cube, { mustRefuse: true, refused: /truncated: .*: copy the file again, or export it again$/m }),
  one("advice: an OBJ with a word for a number", "a.obj", cubeObj.replace("v 1", "v one"), cube, { mustRefuse: true, refused: /line \d+\).*: correct the file, or export it again$/m }),
  one("advice: a text that is no STL", "a.stl", "some words\n", cube, { mustRefuse: true, refused: /: is not an STL file.*: give the file the ending of its format, or export it again$/m }),
  one("advice: an OFF of four dimensions", "a.off", "4OFF\n1 0 0\n0 0 0 1\n", cube, { mustRefuse: true, refused: /which is not read: export it in another way, for example as \.ply$/m }),
  one("advice: a glTF that is cut off", "a.glb", glb([{ mesh: 0 }]).subarray(0, -40), cube, { mustRefuse: true, refused: /it is truncated: copy the file again, or export it again$/m }),
  one("an OBJ with an index of a place that is not there", "a.obj", `${cubeObj}f 1 2 99\n`, cube, { refused: /a\.obj.*99|99/ }),
  one("a star as one polygon, OBJ", "a.obj", objOf(star(9), [star(9).map((_, i) => i)]), { area: starArea(9), triangles: 16 }),
  one("a star as one polygon, PLY", "a.ply", plyOf(star(25), [star(25).map((_, i) => i)]), { area: starArea(25), triangles: 48 }),
  one("a star as one polygon, VRML", "a.wrl", wrl(`Shape { geometry IndexedFaceSet { convex FALSE coord Coordinate { point [ ${star(5).flat().join(" ")} ] } coordIndex [ ${star(5).map((_, i) => i).join(" ")} ] } }`),
    { area: starArea(5), triangles: 8 }),
  one("a PLY with a vertex of NaN", "a.ply", plyOf([...corners, ["nan", 0, 0]], [...triangles, [0, 1, 8]]), cube, { says: /not finite/ }),
  one("an OBJ with one colour brighter than white", "a.obj", coloredObj((i) => (i ? [0.8, 0.4, 0.2] : [1.01, 0.4, 0.2])), cube,
    { says: /most/, colors: [[204, 102, 51], [255, 102, 51]] }),
  one("an OBJ with colours of 16 bits", "a.obj", coloredObj(() => [65535, 32768, 0]), cube, { colors: [[255, 128, 0]] }),
  one("an OBJ with a weight before the colours", "a.obj", coloredObj(() => [1, 0.8, 0.4, 0.2]), cube, { says: /seven/, colors: [[204, 102, 51]] }),
  one("an OBJ with normals after the coordinates", "a.obj", coloredObj((i) => corners[i].map((value) => value * Math.sqrt(1 / 3))), cube,
    { says: /normals/, colors: [] }),
  one("an OBJ of old faces", "a.obj", cubeObj.replaceAll("f ", "fo "), cube),
  one("an OBJ with colours in comments, as ZBrush writes them", "a.obj", cubeObj.replace("f ", `#MRGB ${"ffc86432".repeat(8)}\nf `), cube, { says: /#MRGB/ }),
  one("an OBJ in capitals", "a.obj", cubeObj.toUpperCase(), cube),
  one("an OBJ with lines that nobody knows", "a.obj", `${cubeObj}facet 1 2 3\n`, cube, { says: /'facet' in line 15/ }),
  one("an OBJ whose group ends in a backslash", "a.obj", cubeObj.replace("f ", "g C:\\tmp\\\nf "), cube, { isRead: false }),
  one("an OBJ whose comment ends in a backslash", "a.obj", cubeObj.replace("\nf ", " # C:\\tmp\\\nf "), cube, { isRead: false }),
  { name: "a picture that is not there, beside colours of vertices", file: "a.obj", right: cube, says: /gone/, colors: [[255, 0, 0]],
    files: { "a.obj": `mtllib a.mtl\nusemtl m\n${coloredObj(() => [1, 0, 0])}`, "a.mtl": gone } },
  { name: "a picture that no face uses, beside colours of vertices", file: "a.obj", right: cube, colors: [[255, 0, 0]],
    files: { "a.obj": `mtllib a.mtl\n${coloredObj(() => [1, 0, 0])}`, "a.mtl": gone } },
  { name: "one material in two libraries", file: "a.obj", right: twoCubes, says: /b\.mtl.*a\.mtl/,
    files: { "a.obj": `mtllib b.mtl\n${twoMaterials("p", "q")}`, "a.mtl": mtl("p", "q"), "b.mtl": mtl("q", "p") } },
  { name: "a library in small letters that is not named", file: "a.obj", right: twoCubes, says: /a\.mtl/, colors: twoColors,
    files: { "a.obj": twoMaterials("p", "q").replace("mtllib a.mtl\n", ""), "a.mtl": mtl("p", "q").toLowerCase() } },
  { name: "a library of the mesh's name, where that which it names is not there", file: "a.obj", right: twoCubes, says: /'a\.mtl' is taken/, colors: twoColors,
    files: { "a.obj": twoMaterials("p", "q").replace("mtllib a.mtl", "mtllib scene.mtl"), "a.mtl": mtl("p", "q") } },
  one("a PLY with one colour brighter than white", "a.ply", plyOf(corners, quads,
    { properties: "property float red\nproperty float green\nproperty float blue", row: (i) => (i ? "0.8 0.4 0.2" : "2 0.4 0.2") }), cube,
  { says: /most/ }),
  one("a binary STL that counts none", "a.stl", (() => { const bytes = stlBytes(); bytes.writeUInt32LE(0, 80); return bytes; })(), cube, { says: /its header does not count them/ }),
  one("a binary STL with colours", "a.stl", (() => { const bytes = stlBytes(); bytes.writeUInt16LE(0xfc00, 132); return bytes; })(), cube, { says: /attribute/ }),
  one("an XYZ with an opacity", "a.xyz", scatter(40).map((p) => `${p.join(" ")} 200 100 50 255`).join("\n"), { triangles: 0 }, { says: /column7/, colors: [[200, 100, 50]] }),
  one("an XYZ with two numbers after the colour", "a.xyz", rowsOf(" ", (i) => [255, 0, 0, i % 4, 1000 + 7 * i]), { ...cloud, box: boxOfCloud }, { says: /read as "x y z r g b column7 column8"; they could be/, colors: [[255, 0, 0]] }),
  one("an XYZ with two numbers", "a.xyz", rowsOf(" ", (i) => [1000 + 7 * i, 0.5 * i]), { ...cloud, box: boxOfCloud }, { says: /kept as numbers are column4, column5/, colors: [] }),
  one("an XYZ with one colour brighter than white", "a.xyz", `//X Y Z Rf Gf Bf\n${scatter(40).map((p, i) => `${p.join(" ")} ${i ? 0.8 : 1.01} 0.4 0.2`).join("\n")}`,
    { triangles: 0 }, { says: /most/, colors: [[204, 102, 51], [255, 102, 51]] }),
  one("an XYZ with a part of the names of colours", "a.xyz", `//X Y Z B temp class\n${scatter(40).map((p, i) => `${p.join(" ")} ${i} 1 2`).join("\n")}`,
    { triangles: 0 }, { says: /names b/, colors: [] }),
  one("a PLY with colours as floats", "a.ply", plyOf(corners, quads,
    { properties: "property float red\nproperty float green\nproperty float blue", row: () => "1 0.5 0" }), cube, { colors: [[255, 128, 0]] }),
  one("a PLY with a blank in a name, and colours in one number", "a.ply", plyOf(corners, quads,
    { properties: "property float scalar_Scalar field\nproperty uint rgba", row: (i) => `${i} ${0xffc86432}` }), cube, { says: /rgba .*0xRRGGBB/, isRead: false }),
  one("a PLY with colours of 16 bits", "a.ply", plyOf(corners, quads,
    { properties: "property ushort r\nproperty ushort g\nproperty ushort b", row: () => "65535 0 32896" }), cube, { colors: [[255, 0, 128]] }),
  one("a PLY with a vertex far away that no face uses", "a.ply", plyOf([[5e6, 0, 0], ...corners.map((c) => c.map((v) => v + 1000))],
    triangles.map((t) => t.map((i) => i + 1))), { ...cube, unused: 1 }, { says: /no triangle uses/ }),
  one("a text STL with \"end loop\"", "a.stl", stlText("end loop"), cube),
  one("a text STL that ends in Ctrl-Z", "a.stl", `${stlText()}\x1a`, cube),
  one("a binary STL with bytes after it", "a.stl", Buffer.concat([stlBytes(), Buffer.from("..")]), cube, { says: /after/ }),
  one("an XYZ with decimal commas", "a.xyz", scatter(40).map((p) => p.map((v) => v.toFixed(2).replace(".", ",")).join(" ")).join("\n"), { triangles: 0 }),
  one("an XYZ with a class after the colour", "a.xyz", scatter(40).map((p, i) => `${p.join(" ")} 255 0 0 ${i % 4}`).join("\n"), { triangles: 0 },
    { says: /column/, colors: [[255, 0, 0]] }),
  one("a PCD with CR alone", "a.pcd", (pcd("FIELDS x y z", "ascii") + scatter(40).map((p) => p.join(" ")).join("\n")).replaceAll("\n", "\r"), { ...cloud, box: boxOfCloud },
    { isRead: false }),
  one("a PCD whose compressed points are not", "a.pcd", Buffer.concat([Buffer.from(pcd("FIELDS x y z", "binary_compressed")), Buffer.from(new Uint32Array([480, 480]).buffer),
    floats([0, 1, 2].map((k) => scatter(40).map((point) => point[k])))]), { ...cloud, box: boxOfCloud }, { isRead: false }),
  one("a PCD in upper case", "a.pcd", pcd("FIELDS X Y Z", "ascii") + scatter(40).map((p) => p.join(" ")).join("\n"), { triangles: 0 }),
  one("a PCD filled up with zeros", "a.pcd", Buffer.concat([Buffer.from(pcd("FIELDS x y z", "binary")), floats(scatter(40)), Buffer.alloc(1000)]),
    { triangles: 0 }, { says: /after/ }),
  one("a LAS that counts fewer points than it has", "a.las", las({ counted: 100 }), { triangles: 0 }, { says: /100/ }),
  one("a LAS of 8 bits but for one value", "a.las", las({ color: (i) => (i ? [200, 100, 50] : [256, 100, 50]) }), { triangles: 0 },
    { colors: [[200, 100, 50], [255, 100, 50]] }),
  one("a LAS that counts none", "a.las", las({ counted: 0 }), { triangles: 0 }, { mustRefuse: true, refused: /counts no points.*300/ }),
  { name: "materials with # in their names", file: "a.obj", files: { "a.obj": twoMaterials("a#1", "a#2"), "a.mtl": mtl("a#1", "a#2") }, right: twoCubes, colors: twoColors },
  { name: "a picture in quotes", files: texturedBy('map_Kd "my picture.png"', "my picture.png"), ...texturedCube },
  { name: "a picture in another case, after a folder that is not there", files: texturedBy("map_Kd Textures\\T.PNG", "t.png"), ...texturedCube },
  { name: "two libraries with blanks in their names", file: "a.obj", right: twoCubes, colors: twoColors,
    files: { "a.obj": twoMaterials("p", "q").replace("a.mtl", "my p.mtl my q.mtl"), "my p.mtl": mtl("p", "r"), "my q.mtl": "newmtl q\nKd 0 0 1\n" } },
  { name: "a picture beside its library, in another folder", ...texturedCube, files: (() => {
    const { "a.mtl": library, "t.png": picture, "a.obj": mesh } = texturedBy("map_Kd t.png", "t.png");
    return { "a.obj": mesh.replace("a.mtl", "looks/a.mtl"), "looks/a.mtl": library, "looks/t.png": picture };
  })() },
  { name: "a library with a byte order mark", file: "a.obj", files: { "a.obj": twoMaterials("p", "q"), "a.mtl": `\ufeff${mtl("p", "q")}` }, right: twoCubes, colors: twoColors },
  { name: "names with blanks and quotes", file: "a.obj", files: { "a.obj": twoMaterials("red paint", "blue paint").replace("a.mtl", '"my colours.mtl"'),
    "my colours.mtl": mtl("red paint", "blue paint") }, right: twoCubes, colors: twoColors },
  { name: "a library in another case, after a backslash", file: "a.obj", files: { "a.obj": twoMaterials("p", "q").replace("a.mtl", "C:\\work\\A.MTL"),
    "a.mtl": mtl("p", "q") }, right: twoCubes, colors: twoColors },
  one("a glTF whose node mirrors", "a.glb", glb([{ mesh: 0, scale: [-1, 1, 1], translation: [4, 0, 0] }, { mesh: 0 }]), { volume: 16 }),
  one("a glTF with nodes in nodes, far away", "a.glb",
    glb([{ children: [1], translation: [500000.25, 120.5, -4649776.75] }, { mesh: 0, rotation: [0, 0, h, h], scale: [0.01, 0.02, 0.03] }]), { volume: 8 * 6e-6 },
    { comesBack: ".glb" }),
  one("a glTF with instances", "a.glb", glb([{ mesh: 0, extensions: { EXT_mesh_gpu_instancing: { attributes: { TRANSLATION: 2, SCALE: 3 } } } }],
    { blocks: [[5126, "VEC3", [[0, 0, 0], [4, 0, 0], [9, 9, 9]]], [5126, "VEC3", [[1, 1, 1], [0.5, 0.5, 0.5], [-1, 1, 1]]]],
      more: { extensionsUsed: ["EXT_mesh_gpu_instancing"] } }), { triangles: 36, volume: 17 }),
  one("a quantised glTF", "a.glb", glb([{ mesh: 0, scale: [0.001, 0.001, 0.001] }], { positions: [5122, "VEC3", corners.map((c) => c.map((v) => 1000 * v))],
    more: { extensionsUsed: ["KHR_mesh_quantization"], extensionsRequired: ["KHR_mesh_quantization"] } }), cube),
  one("a glTF with a skin and a matrix", "a.glb", glb([{ mesh: 0, matrix: [2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1], skin: 0 }, { name: "joint" }],
    { more: { skins: [{ joints: [1] }] } }), { volume: 16 }),
  one("a sparse glTF", "a.glb", glbChanged(glb([{ mesh: 0 }], { positions: [5126, "VEC3", corners.map((c, i) => (i % 2 ? c : [0, 0, 0]))],
    blocks: [[5123, "SCALAR", [[0], [2], [4], [6]]], [5126, "VEC3", [corners[0], corners[2], corners[4], corners[6]]]] }),
  (json) => { json.accessors[0].sparse = { count: 4, indices: { bufferView: 2, componentType: 5123 }, values: { bufferView: 3 } }; }), cube),
  one("a glTF whose places meshoptimizer has packed, with a buffer that stands in", "a.glb", glbChanged(glb([{ mesh: 0 }]), (json, bytes) => {
    const packed = meshopt(bytes.subarray(0, 96), 12);
    json.buffers.push({ byteLength: 96, extensions: { EXT_meshopt_compression: { fallback: true } } });
    Object.assign(json.bufferViews[0], { buffer: 1, byteOffset: 0, extensions: { EXT_meshopt_compression:
      { buffer: 0, byteOffset: bytes.length, byteLength: packed.length, byteStride: 12, mode: "ATTRIBUTES", count: 8 } } });
    json.extensionsUsed = json.extensionsRequired = ["EXT_meshopt_compression"];
    return Buffer.concat([bytes, packed, Buffer.alloc(-packed.length & 3)]);
  }), cube, { refused: /meshopt/, isRead: false }),
  one("a glTF with a colour of specular and glossiness", "a.glb", glb([{ mesh: 0 }], { primitive: { material: 0 },
    more: { materials: [redGlossy], extensionsUsed: ["KHR_materials_pbrSpecularGlossiness"] } }), cube,
  { silent: /SpecularGlossiness/, colors: [[255, 0, 0]] }),
  { name: "a glTF text that ends in Ctrl-Z", file: "a.gltf", right: cube, files: (() => {
    const bytes = glb([{ mesh: 0 }]);
    const length = bytes.readUInt32LE(12);
    const json = JSON.parse(bytes.toString("utf8", 20, 20 + length));
    json.buffers[0].uri = "a.bin";
    return { "a.gltf": `${JSON.stringify(json)}\n\x1a`, "a.bin": bytes.subarray(28 + length) };
  })(), isRead: false },
  one("a glTF as a strip", "a.glb", glb([{ mesh: 0 }], { primitive: { mode: 5 } }), {}),
  one("a glTF of several scenes without a default", "a.glb", glb([{ mesh: 0 }], { more: { scene: undefined, scenes: [{ nodes: [0] }, { nodes: [] }] } }), cube),
  one("a glTF that requires what nobody knows", "a.glb", glb([{ mesh: 0 }], { more: { extensionsUsed: ["ACME_wonder"], extensionsRequired: ["ACME_wonder"] } }),
    cube, { refused: /ACME_wonder/ }),
  { name: "a glTF whose buffer has a blank in its name", file: "a.gltf", right: cube, files: (() => {
    const bytes = glb([{ mesh: 0 }]);
    const length = bytes.readUInt32LE(12);
    const json = JSON.parse(bytes.toString("utf8", 20, 20 + length));
    json.buffers[0].uri = "my%20b%C3%BCffer.bin";
    return { "a.gltf": JSON.stringify(json), "my büffer.bin": bytes.subarray(28 + length) };
  })() },
  one("VRML: two rotations of 45 degrees in each other", "a.wrl",
    wrl(`Transform { rotation 0 0 1 0.78539816 children [ Transform { translation 2 0 0 rotation 0 0 1 0.78539816 children [ ${cubeWrl()} ] } ] }`),
    { ...cube, box: { low: [Math.SQRT2 - 1, Math.SQRT2 - 1, -1], high: [Math.SQRT2 + 1, Math.SQRT2 + 1, 1] } }),
  one("VRML: centre, scale and its orientation", "a.wrl",
    wrl(`Transform { center 3 1 0 rotation 1 0 0 0.5 scale 1 2 -3 scaleOrientation 0 1 0 0.4 children [ ${cubeWrl()} ] }`), { volume: 48 }),
  one("VRML: nothing of a switch, the finest of a LOD", "a.wrl",
    wrl(`Switch { whichChoice -1 choice [ ${cubeWrl()} ] } LOD { range [ 10 ] level [ ${cubeWrl()} Shape { geometry Box { size 9 9 9 } } ] }`), cube),
  one("VRML: colours of faces", "a.wrl", wrl(cubeWrl("colorPerVertex FALSE color Color { color [ 1 0 0, 0 1 0, 0 0 1, 1 1 0, 0 1 1, 1 0 1 ] }")),
    cube, { colors: [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 0], [0, 255, 255], [255, 0, 255]] }),
  one("VRML 1: faces whose corners go clockwise", "a.wrl", wrlOne("ShapeHints { vertexOrdering CLOCKWISE }", corners, quads.map((quad) => [...quad].reverse())), cube),
  one("VRML 1: a star as one polygon", "a.wrl", wrlOne("", star(5), [star(5).map((_, i) => i)]), { area: starArea(5) }),
  one("VRML 1: a point that is not there", "a.wrl", wrlOne("", corners, [...quads, [0, 1, 9]]), {}, { refused: /names point 9, but there are 8/ }),
  one("VRML: names that begin with a digit, and one that is used anew", "a.wrl",
    wrl(`Transform { children [ DEF 1(a) ${cubeWrl()} Transform { translation 5 0 0 children USE 1(a) } ] } DEF A Group { children [ DEF A ${cubeWrl()} USE A ] }`), { volume: 32 }),
  one("VRML: a sensor that nobody knows", "a.wrl", wrl(`${cubeWrl()} Transform { children [ KeySensor { } ] }`), cube, { says: /KeySensor/ }),
  one("VRML: parts of one list of points", "a.wrl",
    wrl(quads.map((quad, i) => `Shape { geometry IndexedFaceSet { coord ${i ? "USE P" : `DEF P Coordinate { point [ ${corners.flat().join(" ")} ] }`} coordIndex [ ${quad.join(" ")} ] } }`).join("\n")),
    { ...cube, unused: 0 }, { isRead: false }),
  one("a glTF far away by CESIUM_RTC", "a.glb", glb([{ mesh: 0 }], { more: { extensionsUsed: ["CESIUM_RTC"], extensions: { CESIUM_RTC: { center: [4000000, 100, -5000000] } } } }), { volume: 8 }),
  one("a glTF with a hidden node", "a.glb", glb([{ mesh: 0 }, { mesh: 0, translation: [9, 0, 0], extensions: { KHR_node_visibility: { visible: false } } }],
    { more: { extensionsUsed: ["KHR_node_visibility"] } }), cube, { says: /hidden/ }),
  one("a gzipped VRML", "a.wrl", gzipSync(wrl(cubeWrl())), cube),
  one("a gzipped VRML in two parts, by its other name", "a.wrz", Buffer.concat([wrl(cubeWrl()).slice(0, 99), wrl(cubeWrl()).slice(99)].map((part) => gzipSync(part))), cube),
  { name: "a gzipped VRML that an Inline names", file: "a.wrl", right: cube, isRead: false,
    files: { "a.wrl": wrl('Inline { url "b.wrl" }'), "b.wrl": gzipSync(wrl(cubeWrl())) } },
  one("a gzipped VRML with bytes after it", "a.wrl", Buffer.concat([gzipSync(wrl(cubeWrl())), Buffer.from("more")]), cube, { says: /after/, isRead: false }),
  one("a gzipped VRML that is cut off", "a.wrl", gzipSync(wrl(cubeWrl())).subarray(0, 150), cube, { mustRefuse: true, refused: /truncated/ }),
  one("a gzipped VRML that is damaged", "a.wrl", (() => { const bytes = gzipSync(wrl(cubeWrl())); bytes.fill(0xff, 40, 60); return bytes; })(), cube,
    { mustRefuse: true, refused: /damaged/ }),
  one("a gzipped VRML of very many blanks", "a.wrl", gzipSync(wrl(cubeWrl()) + " ".repeat(30000000)), cube, { mustRefuse: true, refused: /gunzip/ }),
  one("a gzipped OBJ", "a.obj", gzipSync(cubeObj), cube, { mustRefuse: true, refused: /gunzip/ }),
  one("a gzipped PLY, as it is called then", "a.ply.gz", gzipSync(plyOf(corners, quads)), cube, { mustRefuse: true, refused: /gunzip/ }),
  one("a mesh that lies in a .zip as it is", "a.obj", Buffer.concat([Buffer.from("PK\x03\x04\n"), Buffer.alloc(24, 10), Buffer.from("\na.obj\n"), Buffer.from(cubeObj)]), cube,
    { mustRefuse: true, refused: /is compressed \(\.zip\).*unzip/ }),
  one("gzipped points", "a.xyz", gzipSync(rowsOf(" ")), cloud, { mustRefuse: true, refused: /gunzip/ }),
  one("an OBJ polygon of 200,000 corners", "a.obj", objOf(star(100000), [star(100000).map((_, i) => i)]), { triangles: 199998 }),
  one("an OBJ whose lines go on after a blank", "a.obj", cubeObj.replace(/f (\d+) (\d+)/g, "f $1 $2 \\  \n\t"), cube, { isRead: false }),
  one("an OBJ with a texture coordinate that is too large", "a.obj", `${cubeObj}vt 1e40 0\nvt 0 0\nf 1/1 2/2 3/2\n`, { triangles: 13 }),
  one("a PLY with vertex_indexes", "a.ply", plyWith([["vertex_indices", "vertex_indexes"]]), cube),
  one("a PLY whose only list has another name", "a.ply", plyWith([["vertex_indices", "loop"]]), cube, { says: /'loop'/ }),
  one("a PLY with elements in capitals", "a.ply", plyWith([["element vertex", "element Vertex"], ["element face", "element FACE"]]), cube),
  one("a PLY of 64 bits", "a.ply", plyBytes("uint64"), cube),
  one("a PLY with indices as floats", "a.ply", plyBytes("float"), cube),
  one("a PLY with indices as doubles", "a.ply", plyBytes("double"), cube),
  one("a text PLY with indices as floats", "a.ply", plyWith([["uchar int", "uchar float"], [/\n4 (\d) (\d)/g, "\n4 $1.0 $2.00"]]), cube),
  one("a text PLY with an index that is not whole", "a.ply", plyWith([["uchar int", "uchar float"], ["4 4 5", "4 4 5.5"]]), cube,
    { mustRefuse: true, refused: /face 1 \(line 19\)/ }),
  one("a text PLY with decimals in bytes", "a.ply", plyOf(corners, quads, { properties: "property uchar red\nproperty uchar green\nproperty uchar blue",
    row: () => "255.0 128.0 0.0" }), cube, { colors: [[255, 128, 0]] }),
  one("a PLY with a property named twice", "a.ply", plyOf(corners, quads, { properties: "property float x", row: () => "7" }), cube, { says: /twice/ }),
  one("a text PLY with further values in its lines", "a.ply", plyWith([[/end_header\n[^]*$/, (body) => body.replace(/\n(?=.)/g, " 0 1\n").replace("r 0 1", "r")]]), cube,
    { says: /more values/ }),
  one("a text PLY in one line", "a.ply", plyInLines(plyOf(corners, quads)), cube),
  one("a text PLY whose faces are in one line", "a.ply", plyWith([[/\n4 0 3 2 1[^]*$/, (faces) => `\n${faces.trim().replaceAll("\n", " ")}\n`]]), cube,
    { mustRefuse: true, refused: /face 0 \(line \d+\)/ }),
  one("points with commas and names", "a.csv", `"X","Y","Z","Red","Green","Blue","Scan Angle"\n${rowsOf(",", () => [200, 100, 50, 7])}`, cloud, { colors: [[200, 100, 50]] }),
  one("points with semicolons and decimal commas", "a.csv", `x;y;z\n${rowsOf(";").replaceAll(".", ",")}`, cloud, { says: /decimal commas/ }),
  one("points of a spreadsheet that names its separator", "a.csv", `sep=;\nX;Y;Z\n${rowsOf(";")}`, { ...cloud, box: boxOfCloud }, { silent: /names/, isRead: false }),
  // The columns are not in the order x y z: a program that reads them in the usual order mirrors the points.
  ...[["ID,North,East,Elev", ([x, y, z], i) => [i, y, x, z]], ["lat;lon;height", ([x, y, z]) => [y, x, z], /'lat' and 'lon' are degrees/],
    ["Hochwert;Rechtswert;H\u00f6he", ([x, y, z]) => [y, x, z]], ["OBJECTID,POINT_Y,POINT_X,POINT_Z", ([x, y, z], i) => [i, y, x, z]],
    ["Latitude\tLongitude\tAltitude", ([x, y, z]) => [y, x, z]], ["Z [m],Y [m],X [m]", ([x, y, z]) => [z, y, x]], ["N,E,Elev.", ([x, y, z]) => [y, x, z]],
    ['"intensity","Points:2","Points:1","Points:0"', ([x, y, z], i) => [i % 7, z, y, x]], ["y-coordinate,x-coordinate,z-coordinate", ([x, y, z]) => [y, x, z]],
    ["Cota,Norte,Este", ([x, y, z]) => [z, y, x]],
  ].map(([names, order, says]) => one(`points whose names are ${names}`, "a.csv",
    `${names}\n${scatter(40).map((point, i) => order(point, i).join(/[,;\t]/.exec(names)[0])).join("\n")}\n`, { ...cloud, box: boxOfCloud }, { isRead: false, ...(says ? { says } : { silent: /names/ }) })),
  one("points whose names are known in part, in another order", "a.csv", `what,Easting,Northing\n${rowsOf(",")}`, cloud,
    { mustRefuse: true, refused: /line 1 names column 2 as x, and by its order column 1 would be: name all columns with --columns/ }),
  one("points whose names are known in part, in the usual order", "a.csv", `Easting,Northing,what\n${rowsOf(",")}`, { ...cloud, box: boxOfCloud }, { says: /unknown names: they are read by their order/, isRead: false }),
  // Cells of several words: if commas, semicolons or tabs separate the columns, blanks do not.
  ...[[",", '"tree no 1"'], [",", '"house, old"'], [",", "tree no 1"], [";", "tree no 1"], ["\t", "tree no 1"], [";", '"house; old"']].map(([separator, words]) =>
    one(`points with the words ${words} between ${JSON.stringify(separator)}`, "a.csv", `X${separator}Y${separator}Z${separator}Note\n${scatter(40).map((point, i) =>
      [...point, i % 3 ? words : ""].join(separator)).join("\n")}\n`, { ...cloud, box: boxOfCloud }, { says: /left out: columns of text: 'Note'/, isRead: false })),
  one("points with names of two words first", "a.csv", `Name,X,Y,Z\n${scatter(40).map((point, i) => [`P ${i}`, ...point].join(",")).join("\n")}\n`,
    { ...cloud, box: boxOfCloud }, { says: /left out: columns of text: 'Name'/, isRead: false }),
  one("points whose names have units after a line", "a.csv", `X_m,Y_m,Z_m,T_degC\n${rowsOf(",", (i) => [21.5 + i])}`, { ...cloud, box: boxOfCloud }, { silent: /names/, isRead: false }),
  one("points with quotes, commas and decimal commas", "a.csv", rowsOf(",").replace(/[^,\n]+/g, (word) => `"${Number(word).toFixed(2).replace(".", ",")}"`), cloud,
    { says: /decimal commas/, isRead: false }),
  one("points with decimal commas between commas", "a.csv", `x,y,z\n${rowsOf(",").replace(/[^,\n]+/g, (word) => Number(word).toFixed(2).replace(".", ","))}`, cloud,
    { mustRefuse: true, refused: /semicolons/ }),
  one("points of a scanner, counted, twice", "a.pts", `20\n${rowsOf(" ", () => [-1200, 200, 100, 50], 20)}\n20\n${scatter(40).slice(20).map((p) => `${p.join(" ")} 300 200 100 50`).join("\n")}\n`, cloud,
    { colors: [[200, 100, 50]] }),
  one("points of CloudCompare", "a.txt", `//X Y Z Rf Gf Bf Nx Ny Nz Scalar_field\n40\n${rowsOf(" ", (i) => [1, 0.5, 0, 0, 0, 1, i / 3])}`, cloud, { colors: [[255, 128, 0]] }),
  one("points of CloudCompare, by its other ending", "a.asc", rowsOf(" ", () => [200, 100, 50]), cloud, { colors: [[200, 100, 50]] }),
  one("a grid of heights", "a.asc", "ncols 4\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3 4\n5 6 7 8\n", cloud, { mustRefuse: true, refused: /gdal_translate/ }),
  one("a text without points", "a.txt", "These are my notes.\nThere are no points in them.\n", cloud, { mustRefuse: true, refused: /line 3: none of its lines is a point/ }),
  one("points with their numbers first", "a.xyz", numbered((i) => 1000 + i), { ...cloud, box: boxOfCloud }, { says: /number x y z/, isRead: false }),
  one("points with their numbers first, in another order", "a.txt", numbered((i) => 17 + (7 * i) % 40), { ...cloud, box: boxOfCloud },
    { says: /number x y z/, isRead: false }),
  one("points that may have their numbers first", "a.xyz", numbered((i) => 5 * ((7 * i) % 40)), { triangles: 0 }, { says: /they could be "number x y z" too/ }),
  one("points with a time first", "a.txt", numbered((i) => 1600000000 + i / 4), { ...cloud, box: boxOfCloud }, { says: /time/, isRead: false }),
  one("points that a line counts too few", "a.pts", `30\n${rowsOf(" ")}\n`, cloud, { says: /10 points or faces are in the file but its header does not count/ }),
  one("points that a line counts too many", "a.pts", `50\n${rowsOf(" ")}\n`, cloud, { mustRefuse: true, refused: /line 1 declares 50 points, but the file has 40/ }),
  one("a .vtp", "a.vtp", vtp(8, 6), cube),
  one("a .vtp that counts too few polygons", "a.vtp", vtp(8, 5), { triangles: 10 }, { says: /1 point or face is in the file but its header does not count/ }),
  one("a .vtp that counts too many points", "a.vtp", vtp(9, 6), cube, { mustRefuse: true, refused: /a\.vtp: is damaged/ }),
  one("a .vtp with zeros after it", "a.vtp", `${vtp(8, 6)}${"\0".repeat(100)}`, cube, { says: /100 zeros after the end/ }),
  one("a .vtk with only CR, after a byte order mark, before Ctrl-Z", "a.vtk", `\ufeff${vtk("POLYDATA", [vtkPoints, vtkPolygons]).replaceAll("\n", "\r")}\x1a`, cube, { isRead: false }),
  one("a .vtk with a point that is not finite", "a.vtk", vtk("POLYDATA", [vtkPoints.replace("8 float", "9 float"), "nan 0 0", vtkPolygons.replace("6 30", "7 34"), "3 0 1 8"]), cube,
    { says: /1 point is not finite/, isRead: false }),
  one("a .vtk of polygons", "a.vtk", vtk("POLYDATA", [vtkPoints, vtkPolygons]), cube),
  ...["METADATA\n", `METADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 1.7 1.8\n`, "METADATA\nCOMPONENT_NAMES\nx\ny\nz\n"].flatMap((block) => [
    one(`a .vtk with ${block.split("\n")[1] || "empty"} METADATA before its DATASET`, "a.vtk", vtk("POLYDATA", [vtkPoints, vtkPolygons]).replace("DATASET", `${block}\nDATASET`), cube, { isRead: false }),
    one(`a .vtk with ${block.split("\n")[1] || "empty"} METADATA after its points`, "a.vtk", vtk("POLYDATA", [vtkPoints, block, vtkPolygons]), cube, { isRead: false })]),
  one("a .vtk whose polygons name a point that is not there", "a.vtk", vtk("POLYDATA", [vtkPoints, vtkPolygons.replace("4 3 0 4 7", "4 3 0 4 8")]), cube,
    { mustRefuse: true, refused: /a\.vtk: POLYGONS: cell 5 uses point 8, but there are 8/ }),
  one("a grid of .vtk that names a point that is not there", "a.vtk", vtk("UNSTRUCTURED_GRID", [vtkPoints, "CELLS 1 9\n8 0 1 2 3 4 5 6 8\nCELL_TYPES 1\n12"]), cube,
    { mustRefuse: true, refused: /a\.vtk: CELLS: cell 0 uses point 8, but there are 8 \(it is a hexahedron\)/ }),
  one("a .vtk whose points are cut", "a.vtk", vtk("POLYDATA", [vtkPoints.replace("\n-1 1 1", ""), vtkPolygons]), cube,
    { mustRefuse: true, refused: /a\.vtk: .*POINTS \(line 5\) has 21 of its 24 numbers, then 'POLYGONS' \(line 13\)/ }),
  one("a glTF with matrices in each other", "a.glb", glb([{ children: [1], matrix: [0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 7, 0, 0, 1] },
    { mesh: 0, matrix: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -3, 0, 1, 2, 3, 1] }]), { volume: 8 * 24 }),
  one("a glTF whose matrix is transposed", "a.glb", glb([{ mesh: 0, matrix: [1, 0, 0, 5, 0, 1, 0, 6, 0, 0, 1, 7, 0, 0, 0, 1] }]), cube,
    { mustRefuse: true, refused: /node 0 has a matrix whose last row/ }),
  one("VRML: fields that nobody knows", "a.wrl", wrl(cubeWrl("glow 0.5 shine [ 1 2 3 ]")), cube, { says: /2 fields .* 'glow' of 'IndexedFaceSet' \(line 3\)/ }),
  one("VRML: a node that is misspelt, and one of a PROTO that is not there", "a.wrl", wrl(`${cubeWrl()}\nTransfrom { children [ ${cubeWrl()} ] }\nChair { legs 4 }`),
    cube, { says: /2 nodes .* 'Transfrom', which VRML does not have \(line 4\); 'Chair'/, isRead: false }),
  one("VRML: a Script that knows itself", "a.wrl", wrl(`${cubeWrl()} DEF S Script { field SFNode self USE S url "javascript: {" }`), cube, { isRead: false }),
  one("VRML: shapes that no field names", "a.wrl", wrl(`Transform { translation 5 0 0 ${cubeWrl()} ${cubeWrl()} scale -1 1 1 }`), { triangles: 24, volume: 16 },
    { says: /'Shape' of 'Transform' \(line 2\)/, isRead: false }),
  one("VRML: a transform of Inventor", "a.wrl", wrl(`Separator { Translation { translation 5 0 0 } ${cubeWrl()} }`), { ...cube, box: { low: [4, -1, -1], high: [6, 1, 1] } }, { isRead: false }),
  one("VRML: an Inline that is not there", "a.wrl", wrl(`${cubeWrl()} Inline { url "b.wrl" }`), cube, { says: /1 node .* the Inline 'b\.wrl', which is not there/ }),
  one("VRML: a picture's name without quotes", "a.wrl", wrl(cubeWrl().replace("{ geometry", "{ appearance Appearance { texture ImageTexture { url wood.png } } geometry")), cube,
    { says: /pictures are not read/, isRead: false }),
  one("VRML 1: a picture's name without quotes", "a.wrl", wrlOne("Texture2 { filename wood.jpg }"), cube, { says: /pictures are not read/, isRead: false }),
  one("a text STL without its end", "a.stl", stlText().replace(/endsolid[^]*$/, ""), cube, { says: /end of a part is missing/ }),
  one("a text STL that is cut in a facet", "a.stl", stlText().replace(/endloop\nendfacet\nendsolid[^]*$/, ""), cube, { mustRefuse: true, refused: /truncated: facet 11/ }),
  one("a text STL with colours between its facets", "a.stl", stlText().replaceAll("\nfacet", "\ncolor 1 0.5 0\nfacet"), cube, { says: /'color'/ }),
  one("a text STL in one line", "a.stl", stlText().replaceAll("\n", " "), cube),
  one("two solids in a text STL, in capitals, after a byte order mark", "a.stl", `\ufeff\n${stlText().toUpperCase()}${stlText().toUpperCase().replace(/VERTEX (-?1)/g, (_, x) => `VERTEX ${Number(x) + 5}`)}`,
    { triangles: 24, volume: 16 }),
  one("an OFF", "a.off", offOf(), cube),
  one("an OFF with its counts after the first word, remarks and empty lines", "a.off", offOf("# made by hand\nOFF ").replaceAll("\n4 ", " # corner\n\n4 "), cube),
  one("an OFF whose counts follow without a blank", "a.off", offOf("OFF"), cube),
  one("an OFF with colours of vertices", "a.off", offOf("COFF\n", { row: () => "255 128 0 255" }), cube, { colors: [[255, 128, 0]] }),
  one("an OFF with colours of vertices as floats", "a.off", offOf("COFF\n", { row: () => "1 0.5 0" }), cube, { colors: [[255, 128, 0]] }),
  one("an OFF with normals and colours as MeshLab writes them", "a.off", offOf("NCOFF\n", { row: (i) => `200 100 50 255 ${corners[i].map((v) => v * Math.sqrt(1 / 3)).join(" ")}` }), cube,
    { says: /MeshLab/, colors: [[200, 100, 50]] }),
  one("an OFF with colours of faces", "a.off", offOf("OFF\n", { face: (i) => `${i} 128 255` }), cube),
  one("an OFF with a colour of one face", "a.off", offOf("OFF\n", { face: (i) => (i ? "" : "0.5 0.5 0.5") }), cube, { says: /more values/ }),
  one("an OFF that counts too few faces", "a.off", offOf().replace("8 6 12", "8 5 12"), { triangles: 10 }, { says: /after the end/ }),
  one("an OFF that counts too many faces", "a.off", offOf().replace("8 6 12", "8 7 12"), cube, { mustRefuse: true, refused: /truncated: face 6 of 7/ }),
  one("an OFF with an index that is not there", "a.off", offOf().replace("4 3 0 4 7", "4 3 0 4 8"), cube, { mustRefuse: true, refused: /face 5 \(line 16\) names vertex 8/ }),
  one("a binary OFF", "a.off", Buffer.from("OFF BINARY\n\0\0\0\x08\0\0\0\x06\0\0\0\0"), cube, { mustRefuse: true, refused: /binary OFF/ }),
  one("a binary STL with a colour in its header", "a.stl", (() => { const bytes = stlBytes(); bytes.write("COLOR=\x80\x40\x20\xff", 0, "latin1"); return bytes; })(), cube, { says: /left out: the colour in the header/ }),
  one("a big-endian STL", "a.stl", (() => { const bytes = stlBytes(); bytes.writeUInt32BE(triangles.length, 80); return bytes; })(), cube, { mustRefuse: true, refused: /is big-endian: its 12 triangles/ }),
  one("an OBJ with two numbers after its coordinates", "a.obj", coloredObj(() => [0.5, 0.25]), cube, { says: /two numbers after the coordinates/ }),
  one("an OBJ with colours that let light through", "a.obj", coloredObj(() => [1, 0.5, 0, 0.5]).replace("1 0.5 0 0.5", "0.5 0.5 0 0.5"), cube, { says: /numbers after the colours/, colors: [[128, 128, 0], [255, 128, 0]] }),
  one("a big-endian PLY that says it is not", "a.ply", plyInOtherOrder("uchar"), cube, { mustRefuse: true, refused: /face 0 names vertex 50331648, but there are only 8, .*with its bytes swapped it is 3: the header's format may be wrong/ }),
  one("a big-endian PLY with long counts that says it is not", "a.ply", plyInOtherOrder("int"), cube, { mustRefuse: true, refused: /claims 67108864 values.* with its bytes swapped it is 4/ }),
  one("a .pvtp", "a.pvtp", '<?xml version="1.0"?>\n<VTKFile type="PPolyData" version="0.1"><PPolyData><Piece Source="a_0.vtp"/></PPolyData></VTKFile>\n', cube, { mustRefuse: true, refused: /with the parts of a mesh, which is not read: open it in ParaView/ }),
  one("a .vtp with copies of cells", "a.vtp", vtp(8, 6).replace("</Polys>", '</Polys><CellData><DataArray type="UInt8" Name="vtkGhostType" format="ascii">0 0 0 0 0 1</DataArray></CellData>'), { triangles: 10, volume: 20 / 3 },
    { says: /left out: 1 ghost cell .*vtkGhostType/, isRead: false }),
  one("a binary STL called .ply", "a.ply", stlBytes(), cube, { mustRefuse: true, refused: /a\.ply: looks like a \.stl file.*rename it to end in \.stl/ }),
  one("a binary STL called .xyz", "a.xyz", stlBytes(), cube, { mustRefuse: true, refused: /a\.xyz: looks like a \.stl file/ }),
  one("an OBJ called .ply", "a.ply", `# made by hand\n${cubeObj}`, cube, { mustRefuse: true, refused: /a\.ply: looks like a \.obj file/ }),
  one("a 3MF", "a.3mf", zipOf("3D/3dmodel.model"), cube, { mustRefuse: true, refused: /a\.3mf: is a 3MF file, which is not read: .*\.stl/ }),
  one("a 3MF called .stl", "a.stl", zipOf("3D/3dmodel.model"), cube, { mustRefuse: true, refused: /a\.stl: is a 3MF file/ }),
  one("a packed IFC", "a.ifczip", zipOf("house.ifc"), cube, { mustRefuse: true, refused: /is an IFC file/ }),
  one("splats that are packed", "a.spz", gzipSync("NGSP"), cube, { mustRefuse: true, refused: /is a file of Gaussian splats, which is not read: take the \.ply/ }),
  one("a file of HDF5", "a.vtp", Buffer.from("\x89HDF\r\n\x1a\n", "latin1"), cube, { mustRefuse: true, refused: /is an HDF5 file/ }),
  one("a material library", "a.mtl", mtl("p", "q"), cube, { mustRefuse: true, refused: /is that of a material library, which is not read: give the \.obj/ }),
  one("an archive with an OBJ in it", "a.zip", zipOf("statue.obj"), cube, { mustRefuse: true, refused: /holds 'statue\.obj': unpack it first, by unzip/ }),
  one("an IFC called .glb", "a.glb", "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC4'));\nENDSEC;\n", cube, { mustRefuse: true, refused: /is an IFC file/ }),
  one("an OFF called .stl", "a.stl", offOf(), cube, { mustRefuse: true, refused: /a\.stl: looks like a \.off file/ }),
  // Numbers as programs write them in other locales.
  one("VRML with decimal commas", "a.wrl", commas(wrl(cubeWrl()), (v) => v.toFixed(6)), cube, { says: /decimal commas.*'point' \(line 2\)/, isRead: false }),
  one("VRML with decimal commas in some of its numbers", "a.wrl", commas(wrl(cubeWrl()), (v) => String(1.25 * v + 0.25)), { ...cube, area: 37.5, volume: 15.625, box: { low: [-1, -1, -1], high: [1.5, 1.5, 1.5] } },
    { says: /decimal commas/, isRead: false }),
  one("VRML 1 with decimal commas, and no others between its points", "a.wrl", commas(wrlOne("").replaceAll(", ", "  "), (v) => v.toExponential(3)), cube, { says: /decimal commas/, isRead: false }),
  one("VRML with decimal commas in its transforms and sizes", "a.wrl", wrl("Transform { translation 1,5 0 -2,50 scale 0,5 1 1 children Shape { geometry Box { size 2,0 3,0 4 } } }"),
    { ...cube, volume: 12, area: 38, box: { low: [1, -1.5, -4.5], high: [2, 1.5, -0.5] } }, { says: /decimal commas.*'translation'/, isRead: false }),
  one("VRML with decimal commas in a grid of heights", "a.wrl", wrl("Shape { geometry ElevationGrid { xDimension 2 zDimension 2 xSpacing 2,5 height [ 0,5 1,5\n0,5 1,5 ] } }"),
    { triangles: 2, box: { low: [0, 0.5, 0], high: [2.5, 1.5, 1] } }, { says: /decimal commas/, isRead: false }),
  one("VRML with decimal commas in an Extrusion", "a.wrl", wrl("Shape { geometry Extrusion { crossSection [ 0,5 0,5, 0,5 -0,5, -0,5 -0,5, -0,5 0,5, 0,5 0,5 ] spine [ 0 0 0, 0 2,5 0 ] } }"),
    { volume: 2.5, area: 12, box: { low: [-0.5, 0, -0.5], high: [0.5, 2.5, 0.5] } }, { says: /decimal commas/, isRead: false }),
  one("VRML that exports names of nodes", "a.wrl", wrl(`DEF A ${cubeWrl()}\nEXPORT A\nEXPORT A AS B`), cube, { isRead: false }),
  one("VRML with a field of no value", "a.wrl", wrl(cubeWrl().replace("coordIndex [ 0", "coordIndex [ zero")), cube,
    { mustRefuse: true, refused: /line 3: a value that this field does not allow \('coordIndex'\), in or before .*: correct the file, or export it again/ }),
  one("VRML with a PROTO twice", "a.wrl", wrl(`PROTO A [ ] { ${cubeWrl()} }\nA { }\nPROTO A [ ] { Transform { scale 2 2 2 children ${cubeWrl()} } }
    Transform { translation 5 0 0 children A { } }`), { triangles: 24, volume: 8 + 64, box: { low: [-1, -2, -2], high: [7, 2, 2] } }, { says: /a second PROTO 'A' \(line \d\)/, isRead: false }),
  one("VRML with a PROTO within another that has the name of a third", "a.wrl", wrl(`PROTO A [ ] { ${cubeWrl()} }\nPROTO B [ ] { PROTO A [ ] { Transform { scale 2 2 2 children ${cubeWrl()} } } A { } }
    A { } Transform { translation 5 0 0 children B { } } Transform { translation 20 0 0 children A { } }`), { triangles: 36, volume: 8 + 64 + 8, box: { low: [-1, -2, -2], high: [21, 2, 2] } }, { silent: /PROTO/, isRead: false }),
  one("VRML with a PROTO within another that is used outside", "a.wrl", wrl(`PROTO B [ ] { PROTO A [ ] { ${cubeWrl()} } A { } }\nB { }\nTransform { translation 20 0 0 children A { } }`), cube,
    { says: /1 node cannot be read and is left out: 'A', which is a PROTO only within the body of another \(line 5\)/, isRead: false }),
  one("VRML with a PROTO without the field that a node has of it", "a.wrl", wrl(`PROTO A [ field SFVec3f size 4 4 4 ] { Shape { geometry Box { size IS sizes } } }\nA { }`), cube,
    { says: /left out: 'size' of 'Box' \(line 2\), which IS 'sizes', but its PROTO 'A' has no such field/, isRead: false }),
  one("VRML with events of a PROTO", "a.wrl", wrl(`PROTO A [ eventIn SFVec3f set_at exposedField SFVec3f at 1 0 0 eventOut SFVec3f at_changed ] { Transform { set_translation IS set_at translation IS at translation_changed IS at_changed children ${cubeWrl()} } }\nA { at 5 0 0 }`),
    { ...cube, box: { low: [4, -1, -1], high: [6, 1, 1] } }, { silent: /field/, isRead: false }),
  one("VRML with a PROTO of two nodes, of which one is shown", "a.wrl", wrl(`PROTO A [ ] { ${cubeWrl()} Transform { translation 9 0 0 children ${cubeWrl()} } }\nA { }`), cube, { isRead: false }),
  one("VRML with a field that the PROTO of the node does not have", "a.wrl", wrl(`PROTO A [ field SFVec3f size 4 4 4 ] { Shape { geometry Box { size IS size } } }\nA { scale 3 3 3 size 2 2 2 }`), cube,
    { says: /left out: 'scale' of 'A' \(line 3\)/, isRead: false }),
  one("VRML with an index of more than 32 bits", "a.wrl", wrl(cubeWrl().replace("coordIndex [ ", "coordIndex [ 4294967296 1 2 -1 ")), cube,
    { mustRefuse: true, refused: /line 3: '4294967296' is too large for an index or a count/ }),
  one("VRML with decimal commas in a PROTO", "a.wrl", wrl(`PROTO P [ field MFVec3f places [ 0,5 0,5 0,5 ] field SFVec3f size 1,5 1,5 1,5 field SFVec3f at 0 0,5 0 ] {
    Transform { translation IS at children [ Shape { geometry Box { size IS size } } Shape { geometry PointSet { coord Coordinate { point IS places } } } ] } }
    P { size 2,5 2 2 at 1,5 0 0 places [ 0,25 1 1,5, 0 0 0,5 ] }`), { triangles: 12, unused: 2, volume: 10, area: 28, box: { low: [0.25, -1, -1], high: [2.75, 1, 1] } }, { says: /decimal commas/, isRead: false }),
  one("VRML with commas alone between its numbers", "a.wrl", wrl(cubeWrl().replace(/point \[[^\]]*/, `point [ ${corners.map((c) => c.map((v) => v + 1).join(",")).join(" ")}`)), cube, { silent: /commas/ }),
  one("VRML with commas alone between its points", "a.wrl", wrl(cubeWrl().replace(/point \[[^\]]*/, `point [ ${corners.map((c) => c.map((v) => v + 1).join(" ")).join(",")}`)), cube, { silent: /commas/ }),
  one("VRML: an Extrusion with commas within its points", "a.wrl", wrl("Shape { geometry Extrusion { crossSection [ 1,1 1,-1 -1,-1 -1,1 1,1 ] spine [ 0,0,0 0,2,0 ] } }"), { volume: 8, area: 24 },
    { silent: /commas/, isRead: false }),
  one("a .vtk with decimal commas", "a.vtk", vtk("POLYDATA", [vtkPoints.replace("1 1 1", "1,5 1 1"), vtkPolygons]), cube, { mustRefuse: true, refused: /'1,5' \(line 12\) \(a decimal comma/ }),
  one("a .vtp with decimal commas", "a.vtp", vtp(8, 6).replace("-1 -1 -1", "-1,5 -1 -1"), cube, { mustRefuse: true, refused: /<Points> of piece 0 \(line 3\)/ }),
  one("an OFF with decimal commas", "a.off", offOf().replace("-1 -1 -1", "-1,5 -1 -1"), cube, { mustRefuse: true, refused: /vertex 0 \(line 3\).*decimal comma/ }),
  one("a PCD with decimal commas", "a.pcd", pcd("FIELDS x y z", "ascii") + rowsOf(" ").replaceAll(".", ","), cloud, { mustRefuse: true, refused: /line 12.*decimal comma/ }),
  one("an OBJ with exponents of Fortran", "a.obj", fortran(cubeObj), cube, { isRead: false }),
  one("a PLY with exponents of Fortran", "a.ply", plyWith([[/(-?)1 (-?)1 (-?)1 *\n/g, "$10.1D+01 $21.0d0 $31D0\n"]]), cube, { isRead: false }),
  one("an XYZ with exponents of Fortran", "a.xyz", rowsOf(" ").replace(/\S+/g, (v) => `${v}D+00`), { ...cloud, box: boxOfCloud }, { isRead: false }),
  one("a PCD with exponents of Fortran", "a.pcd", pcd("FIELDS x y z", "ascii") + rowsOf(" ").replace(/\S+/g, (v) => `${v}D+00`), { ...cloud, box: boxOfCloud }, { isRead: false }),
  one("a .vtk with exponents of Fortran", "a.vtk", vtk("POLYDATA", [fortran(vtkPoints), vtkPolygons]), cube, { isRead: false }),
  one("VRML with exponents of Fortran", "a.wrl", wrl(cubeWrl().replace(/point \[[^\]]*/, (list) => list.replace(/-?1/g, (v) => `${v}.0D+00`))), cube, { isRead: false }),
  one("a text STL of quads, with exponents of Fortran", "a.stl", stlQuads(quads, (v) => `${v}.0D+00`), cube, { isRead: false }),
  one("a text STL with a star for a facet, and a facet of two vertices", "a.stl", stlLoops([star(5), star(5).slice(0, 2)]), { area: starArea(5), triangles: 8 },
    { says: /1 face has fewer than three corners/, isRead: false }),
  one("a PLY with a remark that does not say so", "a.ply", plyWith([["element vertex", "Created by Blender3D 247 - www.blender.org, source file: \nelement vertex"]]), cube,
    { says: /left out.*'Created' \(header line 3\)/ }),
  one("a PLY with colours in the bits of a float", "a.ply", plyFloatRgb((i) => (i % 2 ? 0x00c86432 : 0x00123456)), cube, { says: /rgb .*0xRRGGBB/, colors: [[18, 52, 86], [200, 100, 50]], isRead: false }),
  one("a PLY with opaque colours in the bits of a float", "a.ply", plyFloatRgb((i) => (i % 2 ? 0xffc86432 : 0xff123456)), cube, { says: /rgb .*0xRRGGBB/, colors: [[18, 52, 86], [200, 100, 50]], isRead: false }),
  one("a PLY with a float rgb that is no colour", "a.ply", plyOf(corners, quads, { properties: "property float rgb", row: (i) => i / 8 }), cube, { says: /rgb of type float32 is not shown/, colors: [] }),
  one("a .vtk with fields before its DATASET", "a.vtk", vtk("POLYDATA", [vtkPoints, vtkPolygons]).replace("DATASET", "FIELD FieldData 2\nTIME 1 1 double\n0.5\nNAMES 1 2 string\nPOINTS%205\nb\nDATASET"),
    cube, { isRead: false }),
  one("a .vtk without a DATASET", "a.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nFIELD f 1\na 1 1 float\n1\n", cube, { mustRefuse: true, refused: /has no DATASET/ }),
  one("a .vtk of polygons in a grid", "a.vtk", vtk("UNSTRUCTURED_GRID", [vtkPoints, vtkPolygons]), cube, { mustRefuse: true, refused: /POLYGONS \(line 14\) cannot be in a DATASET/ }),
  one("a .vtk of a table", "a.vtk", vtk("TABLE", ["ROW_DATA 1", "FIELD f 1", "a 1 1 int", "7"]), cube, { mustRefuse: true, refused: /'TABLE', which is not a mesh/ }),
  one("a .glb whose second chunk is not that of the bytes", "a.glb", withChunk("XXXX"), cube, { mustRefuse: true, refused: /buffer 0 is in the binary chunk \(BIN\), which is missing: the second chunk is 'XXXX' \(byte \d+\): copy the file again/ }),
  one("a .glb with a chunk before that of the bytes", "a.glb", withChunk("BIN\0", "ABCD"), cube, { says: /the chunk 'ABCD' \(byte \d+\) before the binary chunk/, isRead: false }),
  one("a .glb of rubbish", "a.glb", Buffer.from("rubbish of some bytes, no scene"), cube, { mustRefuse: true, refused: /a\.glb: is not a glTF file: it begins neither/ }),
  one("a .vtp whose text ends in an element", "a.vtp", vtp(8, 6).slice(0, 400), cube, { mustRefuse: true, refused: /line \d+, column \d+: the text ends/ }),
  // Variants of the shared cases, in other formats.
  one("points in quotes under names in quotes", "a.csv", `"X","Y","Z"\n${scatter(40).map((point) => point.map((v) => `"${v}"`).join(",")).join("\n")}`, { ...cloud, box: boxOfCloud }, { silent: /names/ }),
  one("points in quotes", "a.csv", scatter(40).map((point) => point.map((v) => `"${v}"`).join(";")).join("\n"), { ...cloud, box: boxOfCloud }, { silent: /names/ }),
  one("points under names in quotes, with units, in another order", "a.csv", `"Z [m]";"Y [m]";"X [m]"\n${scatter(40).map(([x, y, z]) => `${z};${y};${x}`).join("\n")}`,
    { ...cloud, box: boxOfCloud }, { silent: /names/, isRead: false }),
  one("points with points between thousands and decimal commas", "a.csv", `X;Y;Z\n${scatter(40).map(([x, y], i) => `1.0${10 + i},5;${x};${y}`.replace(/(\d)\.(\d+);/g, "$1,$2;")).join("\n")}`, cloud,
    { mustRefuse: true, refused: /line 2: has commas and decimal points/ }),
  one("points with an empty column", "a.csv", `X,Class,Y,Z,R,G,B\n${scatter(40).map(([x, y, z]) => `${x},,${y},${z},200,100,50`).join("\n")}`, { ...cloud, box: boxOfCloud }, { silent: /names/, colors: [[200, 100, 50]], isRead: false }),
  one("points of which some have no class, and one no z", "a.csv", `X;Y;Z;Class\n${scatter(41).map(([x, y, z], i) => `${x};${y};${i === 40 ? "" : z};${i % 2 ? 3 : ""}`).join("\n")}`, { ...cloud, box: boxOfCloud }, { says: /1 point is not finite and is dropped: line 42/, isRead: false }),
  one("an OBJ with a byte order mark in its middle", "a.obj", cubeObj.replace(/\nv 1 1 1/, "\n\ufeffv 1 1 1"), cube, { isRead: false }),
  { name: "a library that was joined of two with byte order marks", file: "a.obj", right: twoCubes, colors: twoColors,
    files: { "a.obj": twoMaterials("p", "q"), "a.mtl": `\ufeff${mtl("p", "r")}\ufeffnewmtl q\nKd 0 0 1\n` } },
  one("points with a byte order mark in their middle", "a.xyz", rowsOf(" ").replace(/\n(?=[^\n]*$)/, "\n\ufeff"), { ...cloud, box: boxOfCloud }, { isRead: false }),
  one("two text STL that were joined, with byte order marks", "a.stl", `\ufeff${stlText()}\ufeff${stlText().replace(/vertex (-?1)/g, (_, x) => `vertex ${Number(x) + 5}`)}`, { triangles: 24, volume: 16 }),
  one("a text STL with bytes after a Ctrl-Z", "a.stl", `${stlText()}\x1arubbish`, cube, { says: /8 bytes after the end .* a Ctrl-Z/ }),
  one("a text PLY whose lines end with CR CR LF", "a.ply", plyOf(corners, quads).replaceAll("\n", "\r\r\n"), cube, { isRead: false }),
  one("a .vtk with a polygon of two corners", "a.vtk", vtk("POLYDATA", [vtkPoints, vtkPolygons.replace("6 30", "7 33"), "2 0 1"]), cube, { says: /1 face has fewer than three corners and is dropped: POLYGONS: cell 6/ }),
  one("a .vtp with a polygon of two corners", "a.vtp", vtp(8, 7).replace("3 0 4 7</D", "3 0 4 7 0 1</D").replace("24</D", "24 26</D"), cube, { says: /1 face has fewer than three corners/ }),
  one("a .vtk that counts too few polygons", "a.vtk", vtk("POLYDATA", [vtkPoints, vtkPolygons.replace("6 30", "5 30")]), cube, { says: /1 point or face is in the file but its header does not count it: POLYGONS \(line 14\) counts 5 cells/ }),
  one("a .vtk that counts too many polygons", "a.vtk", vtk("POLYDATA", [vtkPoints, vtkPolygons.replace("6 30", "7 30")]), cube, { mustRefuse: true, refused: /POLYGONS \(line 14\) declares 7 cells, but has 6/ }),
  one("a .vtk with METADATA after its polygons", "a.vtk", `${vtk("POLYDATA", [vtkPoints, vtkPolygons])}METADATA\nINFORMATION 0\n\n`, cube, { isRead: false }),
  one("a .vtk with values for other points", "a.vtk", vtk("POLYDATA", [vtkPoints, vtkPolygons, "POINT_DATA 5", "SCALARS q float", "LOOKUP_TABLE default", "1 2 3 4 5"]), cube,
    { mustRefuse: true, refused: /POINT_DATA \(line 21\) has values for 5 points, but there are 8/ }),
  one("a binary .vtk", "a.vtk", vtkBytes(), cube, { isRead: false }),
  one("a binary .vtk with zeros after it", "a.vtk", Buffer.concat([vtkBytes(), Buffer.alloc(300)]), cube, { says: /300 zeros after the end/, isRead: false }),
  one("a binary .vtk with bytes after it", "a.vtk", Buffer.concat([vtkBytes(), Buffer.from("..")]), cube, { says: /2 bytes after the end/, isRead: false }),
  one("a glTF with texture coordinates and a normal that are not there", "a.glb", glb([{ mesh: 0 }], { primitive: { attributes: { POSITION: 0, NORMAL: 77, TEXCOORD_0: 8 } } }), cube,
    { says: /12 faces name .* 'NORMAL' names accessor 77, but there are 2/ }),
  one("a .vtp of a type that is not known", "a.vtp", vtp(8, 6).replace("Float32", "Quad"), cube, { mustRefuse: true, refused: /'Quad', which is not known/ }),
  one("a .vtp with colours of another name", "a.vtp", vtp(8, 6).replace("<Polys>", `<PointData><DataArray type="UInt8" Name="SurfaceColor" NumberOfComponents="3" format="ascii">${corners.map(() => "255 128 0").join(" ")}</DataArray></PointData><Polys>`), cube,
    { says: /SurfaceColor/, isRead: false }),
  one("a .vtk with colours of cells", "a.vtk", vtk("POLYDATA", [vtkPoints, vtkPolygons, "CELL_DATA 6", "COLOR_SCALARS c 3", ...quads.map(() => "1 0.5 0")]), cube, { says: /triangle colours are kept/ }),
  one("a .vtp without its polygons' ends", "a.vtp", vtp(8, 6).replace('"offsets"', '"ends"'), cube, { mustRefuse: true, refused: /<Polys>.*'offsets'/ }),
  // The opposite byte order, if only the coordinates could show it.
  one("points of a big-endian PLY that says it is not", "a.ply", plyPoints("LE", "BE"), cloud, { mustRefuse: true, refused: /its numbers seem to have the opposite of the byte order that it states: x of point 0 is .*, and with its bytes swapped -3\.25: correct the file/ }),
  one("points of a PLY that says it is big-endian", "a.ply", plyPoints("BE", "LE"), cloud, { mustRefuse: true, refused: /its numbers seem to have the opposite of the byte order/ }),
  one("doubles of a big-endian PLY that says it is not", "a.ply", plyPoints("LE", "BE", "Double"), cloud, { mustRefuse: true, refused: /its numbers seem to have the opposite of the byte order/ }),
  one("a PLY of doubles that are nearly 0", "a.ply", plyOf(corners.map((corner) => corner.map((v) => v * 1e-20)), quads), { triangles: 12, places: 8 }, { silent: /order/, isRead: false }),
  one("a big-endian PCD", "a.pcd", Buffer.concat([Buffer.from(pcd("FIELDS x y z", "binary")), floatsOf(scatter(40).flat(), "BE")]), cloud, { mustRefuse: true, refused: /its numbers seem to have the opposite of the byte order/ }),
  one("points of a little-endian .vtk", "a.vtk", Buffer.concat([Buffer.from("# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\nPOINTS 40 float\n"), floatsOf(scatter(40).flat(), "LE"), Buffer.from("\n")]), cloud,
    { mustRefuse: true, refused: /its numbers seem to have the opposite of the byte order/ }),
  one("a .vtk of version 4 with lists of cells of version 5", "a.vtk", vtk("POLYDATA", [vtkPoints, vtkOffsets]).replace("3.0", "4.2"), cube, { mustRefuse: true, refused: /POLYGONS \(line 14\) is followed by OFFSETS, as in version 5, but the first line names an earlier version/ }),
  one("a .vtk of version 5", "a.vtk", vtk("POLYDATA", [vtkPoints, vtkOffsets]).replace("3.0", "5.1"), cube, { isRead: false }),
  one("a .vtk of version 5 with lists of cells of before", "a.vtk", vtk("POLYDATA", [vtkPoints, vtkPolygons]).replace("3.0", "5.1"), cube, { mustRefuse: true, refused: /POLYGONS \(line 14\) is not followed by OFFSETS/ }),
  one("VRML with an index of -2", "a.wrl", wrl(cubeWrl().replace("coordIndex [ 0", "coordIndex [ -2")), cube, { mustRefuse: true, refused: /line 3: '-2' is not an index, and only -1 ends a face/ }),
  one("a PLY of vertices and faces", "a.ply", plyWith([["element vertex", "element vertices"], ["element face", "element faces"]]), cube, { isRead: false }),
  // Old statements of OBJ and of its material libraries.
  one("an OBJ with a picture without a material", "a.obj", cubeObj.replace("f ", "maplib m.map\nusemap off\nusemap t.png\nf "), cube, { says: /pictures without a material: 'usemap t\.png' in line 11/ }),
  one("an OBJ whose usemap is off", "a.obj", cubeObj.replace("f ", "usemap off\nf "), cube, { silent: /usemap/ }),
  one("an OBJ that takes in another", "a.obj", `${cubeObj}call other.obj\n`, cube, { says: /calls of other files or programs: 'call other\.obj' in line 15/ }),
  one("an OBJ with an old patch", "a.obj", `${cubeObj}bsp 1 2 3 4\n`, cube, { says: /1 line, free-form curve or surface/ }),
  one("an OBJ with weights of 2", "a.obj", cubeObj.replace(/^v (.*)$/gm, "v $1 2.0"), cube, { says: /a fourth number of vertices that is not 1 \(a weight\): coordinates are not divided by it/ }),
  one("an OBJ with weights of 1", "a.obj", cubeObj.replace(/^v (.*)$/gm, "v $1 1.0"), cube, { silent: /weight/ }),
  { ...texturedCube, name: "a picture in letters and marks, whose file has letters with marks", files: texturedBy("map_Kd Mu\u0308nster \u30cf\u3099.png", "M\u00fcnster \u30d0.png") },
  { ...texturedCube, name: "a picture in letters with marks, whose file has letters and marks", files: texturedBy("map_Kd M\u00dcNSTER \u0439.png", "Mu\u0308nster \u0438\u0306.png") },
  { name: "a library whose colours are bytes", file: "a.obj", right: twoCubes, colors: twoColors, says: /a\.mtl, line 2: 'Kd 255 0 0' is taken for a colour from 0 to 255/,
    files: { "a.obj": twoMaterials("p", "q"), "a.mtl": mtl("p", "q").replaceAll("1", "255") } },
  // A whole OFF in one line.
  one("an OFF in one line", "a.off", offOf().replaceAll("\n", " "), cube, { isRead: false }),
  one("an OFF in one line after a byte order mark, CR LF at its end", "a.off", `\ufeff${offOf().replaceAll("\n", " ")}\r\n`, cube, { isRead: false }),
  one("an OFF whose first vertex is in the line of its numbers", "a.off", offOf().replace("8 6 12\n", "8 6 12 "), cube, { isRead: false }),
  one("an OFF in one line, with colours", "a.off", offOf("COFF\n", { row: () => "255 0 0" }).replaceAll("\n", " "), cube, { mustRefuse: true, refused: /line 1: .*colours cannot be distinguished from coordinates: write a line for each/ }),
  one("an OFF with four counts", "a.off", offOf().replace("8 6 12", "8 6 12 0"), cube, { mustRefuse: true, refused: /line \d: / }),
  // glTF files that contradict themselves.
  one("a glTF with a matrix and another translation", "a.glb", glb([{ mesh: 0, matrix: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1], translation: [0, 7, 0] }]), { ...cube, box: { low: [4, -1, -1], high: [6, 1, 1] } },
    { says: /node 0 has a matrix and a different translation, rotation or scale: the matrix is used/, isRead: false }),
  one("a glTF with a matrix and the same translation", "a.glb", glb([{ mesh: 0, matrix: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1], translation: [5, 0, 0] }]), { ...cube, box: { low: [4, -1, -1], high: [6, 1, 1] } }, { silent: /matrix/, isRead: false }),
  one("a glTF that needs a later version", "a.glb", glbChanged(glb([{ mesh: 0 }]), (json, old) => { json.asset = { version: "2.1", minVersion: "2.1" }; return old; }), cube, { mustRefuse: true, refused: /needs a reader for glTF '?"?2\.1.*/ }),
  // Points with numbers of rows, with remarks, and with unexpected blanks.
  one("points with their rows and columns first", "a.txt", scatter(40).map((point, i) => [Math.floor(i / 8), i % 8, ...point].join(" ")).join("\n"), { ...cloud, box: boxOfCloud }, { says: /read as "row column x y z", not "x y z column4 column5": the first two count rows and columns/, isRead: false }),
  one("points with their rows and columns first, and colours", "a.txt", scatter(40).map((point, i) => [1 + i % 8, 1 + Math.floor(i / 8), ...point, 200, 100, 50].join(" ")).join("\n"), { ...cloud, box: boxOfCloud }, { colors: [[200, 100, 50]], isRead: false }),
  one("points of a grid with normals", "a.txt", Array.from({ length: 40 }, (_, i) => [Math.floor(i / 8), i % 8, (5 * i) % 11 / 2, 0.6, 0.8, 0].join(" ")).join("\n"), { ...cloud, box: { low: [0, 0, 0], high: [4, 7, 5] } }, { silent: /rows/, isRead: false }),
  one("points under lines of a program", "a.txt", `Project: Test\nDate: 2026-01-01\nCRS: EPSG:25832\n\nY X Z\n${scatter(40).map(([x, y, z]) => `${y} ${x} ${z}`).join("\n")}`, { ...cloud, box: boxOfCloud }, { says: /3 lines before the points are not points and are skipped; the first: line 1/, isRead: false }),
  one("points of a .ptx", "a.txt", ["8", "5", "0 0 0", "1 0 0", "0 1 0", "0 0 1", rowsOf(" ", () => [0.5])].join("\n"), cloud, { mustRefuse: true, refused: /lines 1 and 2 count columns and rows, as Leica's \.ptx does/ }),
  one("points with blanks between thousands", "a.csv", scatter(40).map(([, y, z], i) => `1 0${10 + i};${y};${z}`).join("\n"), cloud, { mustRefuse: true, refused: /line 1: has blanks in the number '1 010': write numbers without them/ }),
  one("points with colours as #c86432", "a.txt", rowsOf(" ", () => ["#c86432"]), { ...cloud, box: boxOfCloud }, { says: /line 1: what follows # is a comment, and looks like a colour/, isRead: false }),
  one("points by x, with whole numbers after the coordinates", "a.pts", Array.from({ length: 40 }, (_, i) => [i / 2, (5 * i) % 11 / 2, (3 * i) % 13 / 4, 7 * i - 100].join(" ")).join("\n"), cloud, { silent: /could be/ }),
  one("atoms", "a.xyz", "3\nwater\nO 0 0 0.117\nH 0 0.757 -0.469\nH 0 -0.757 -0.469\n", cloud, { mustRefuse: true, refused: /line 3: 'O' \(column 1\) is not a number; --columns "- x y z" leaves out what is called -/ }),
  one("points with several words after the coordinates", "a.csv", scatter(40).map((point, i) => [...point, i ? "house old" : "tree no 1"].join(";")).join("\n"), cloud, { mustRefuse: true, refused: /line 1: 'tree' \(column 4\) is not a number; --columns "x y z -" leaves out/ }),
  // Parts that are named twice, mirrored, split, or older than a format's first version.
  one("a glTF whose scene names a node twice", "a.glb", glb([{ mesh: 0 }], { more: { scenes: [{ nodes: [0, 0] }] } }), cube, { says: /node 0 is named twice .*: it is read once/, isRead: false }),
  one("a glTF with a child twice", "a.glb", glb([{ children: [1, 1] }, { mesh: 0 }]), cube, { says: /node 1 is named twice/, isRead: false }),
  one("a glTF whose scene also names a child", "a.glb", glb([{ children: [1], translation: [3, 0, 0] }, { mesh: 0 }], { more: { scene: 1, scenes: [{ nodes: [] }, { nodes: [1, 0] }] } }), { ...cube, box: { low: [2, -1, -1], high: [4, 1, 1] } }, { says: /node 1 is named twice/, isRead: false }),
  one("a glTF with a node below two parents", "a.glb", glb([{ children: [2], translation: [3, 0, 0] }, { children: [2] }, { mesh: 0 }]), { volume: 16 }, { says: /node 2 has several parents/ }),
  one("a glTF with colours to 255 as floats", "a.glb", gltfColors((i) => [255, 0, i % 2 ? 255 : 0]), cube, { says: /mesh 0, part 0: in COLOR_0 255 is white/, colors: [[255, 0, 0], [255, 0, 255]] }),
  one("a glTF with one colour brighter than white", "a.glb", gltfColors((i) => [i ? 1 : 1.5, 0, 0]), cube, { says: /mesh 0, part 0: in COLOR_0 1 is white, .*1 of 8 is above it/, colors: [[255, 0, 0]] }),
  one("a glTF with colours to 1 as floats", "a.glb", gltfColors(() => [1, 0, 0]), cube, { silent: /COLOR_0/, colors: [[255, 0, 0]] }),
  one("a .vtk of an image with a negative spacing", "a.vtk", vtk("STRUCTURED_POINTS", ["DIMENSIONS 3 3 3", "ORIGIN 0 0 0", "SPACING -1 1 1"]), { triangles: 48, volume: 8 }, { isRead: false }),
  one("a .vtk of an image", "a.vtk", vtk("STRUCTURED_POINTS", ["DIMENSIONS 3 3 3", "ORIGIN 0 0 0", "SPACING 1 1 1"]), { triangles: 48, volume: 8 }, { isRead: false }),
  one("a .vtk with coordinates that decrease", "a.vtk", vtk("RECTILINEAR_GRID", ["DIMENSIONS 2 2 2", "X_COORDINATES 2 float", "1 0", "Y_COORDINATES 2 float", "0 1", "Z_COORDINATES 2 float", "0 1"]), { volume: 1 }, { isRead: false }),
  one("a .vtk of a mirrored grid", "a.vtk", vtk("STRUCTURED_GRID", ["DIMENSIONS 2 2 2", "POINTS 8 float", "0 0 0\n-1 0 0\n0 1 0\n-1 1 0\n0 0 1\n-1 0 1\n0 1 1\n-1 1 1"]), { volume: 1 }, { isRead: false }),
  one("a .vtk with a mirrored hexahedron beside a right one", "a.vtk", solid([...mirrored, ...corners.map(([x, y, z]) => [x + 5, y, z])], [12, 8], [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15]), { volume: 16 }, { isRead: false }),
  one("a .vtk with prisms in both orders", "a.vtk", solid([...prism, ...prism.map(([x, y, z]) => [x + 5, y, z])], [13, 6], [0, 1, 2, 3, 4, 5, 6, 8, 7, 9, 11, 10]), { volume: 1 }, { isRead: false }),
  one("a .vtp with an empty first piece", "a.vtp", vtpPieces([], [0, undefined, vtpArrays(["q", 1, 0], ["RGB", 3, 100])]), cube, { isRead: false, colors: corners.map((_, i) => [100 + 10 * i, 101 + 10 * i, 102 + 10 * i]) }),
  one("a .vtp with an empty piece between others", "a.vtp", vtpPieces([0], [], [5]), { triangles: 24, volume: 16 }, { isRead: false }),
  one("a .vtp whose pieces have arrays in another order", "a.vtp", vtpPieces([0, undefined, vtpArrays(["q", 3, 0], ["RGB", 3, 100])], [5, undefined, vtpArrays(["RGB", 3, 100], ["q", 3, 0])]), { triangles: 24, volume: 16 },
    { isRead: false, colors: corners.map((_, i) => [100 + 10 * i, 101 + 10 * i, 102 + 10 * i]) }),
  one("a .vtp with an array that its second piece does not have", "a.vtp", vtpPieces([0, undefined, vtpArrays(["RGB", 3, 100])], [5]), { triangles: 24, volume: 16 }, { isRead: false, colors: [], says: /array "RGB" is dropped: not all pieces have it, of one type/ }),
  one("a .vtp with an array that its first piece does not have", "a.vtp", vtpPieces([0, undefined, vtpArrays(["RGB", 3, 100])], [5, undefined, vtpArrays(["RGB", 3, 100], ["q", 1, 0])]), { triangles: 24, volume: 16 }, { isRead: false, says: /array "q" is dropped/ }),
  one("a .vtp whose offsets begin with 0", "a.vtp", vtpPieces([0, "0 4 8 12 16 20 24"]), cube, { isRead: false, silent: /counted|corners/ }),
  one("a .vtp of pieces whose offsets begin with 0", "a.vtp", vtpPieces([0], [5, "0 4 8 12 16 20 24"], [10, "0 4 8 12 16 20 24"]), { triangles: 36, volume: 24 }, { isRead: false, silent: /counted|corners/ }),
  one("a .vtp whose offsets begin with 0, and name corners that are not there", "a.vtp", vtpPieces([0, "0 4 8 12 16 20 26"]), cube, { mustRefuse: true, refused: /<Polys> of piece 0/ }),
  ...[20, 24, 28].flatMap((head) => ["", '{"id":[1,2,3]} '].map((table) => ({ name: `a b3dm with a head of ${head} bytes${table && " and a table"}`, file: "tileset.json", right: cube, isRead: false,
    files: { "tileset.json": tileset("a.b3dm"), "a.b3dm": b3dm(head, table) }, ...(table ? { says: /"id"/ } : { silent: /table/ }) }))),
  one("whole numbers of a big-endian PLY that says it is not", "a.ply", plyIntegers("LE", "BE", millimetres), cloud, { mustRefuse: true, refused: /its numbers seem to have the opposite of the byte order that it states: x of point 0 is .*, and with its bytes swapped -3.25e\+03/ }),
  one("whole numbers of a big-endian PLY", "a.ply", plyIntegers("BE", "BE", millimetres), { ...cloud, box: { low: [-3250, 0, 0], high: [2750, 5000, 3000] } }),
  one("large whole numbers of a PLY", "a.ply", plyIntegers("LE", "LE", millimetres.map((point) => point.map((value) => 500000000 + value))), cloud),
  one("a PLY with colours of 0 and 1 in bytes", "a.ply", byteColors("1 0 1"), cube, { says: /RGB has only the bytes 0 and 1/, colors: [[1, 0, 1]] }),
  one("a black PLY", "a.ply", byteColors("0 0 0"), cube, { silent: /RGB/, colors: [[0, 0, 0]] }),
  one("a .vtp with colours of 0 and 1 in bytes", "a.vtp", vtpPieces([0, undefined, vtpArrays(["RGB", 3, 0]).replace(/\b\d+(?= |<\/D)/g, "1")]), cube, { isRead: false, says: /RGB has only the bytes 0 and 1/ }),
  one("a .vtp with pieces whose points are of other types", "a.vtp", vtpPieces([0], [5]).replace(/Float32(?![^]*Float32)/, "Float64"), cube, { mustRefuse: true, refused: /the points of its pieces are of several types: Float32 and Float64/ }),
  // Bytes in a .vtp: VTK reads on beyond their end, and accepts any character as base64.
  one("a .vtp in base64", "a.vtp", vtpBase64(base64Of(96)), cube, { isRead: false }),
  one("a .vtp in base64 of lines", "a.vtp", vtpBase64(base64Of(96).replace(/.{76}/g, "$&\n")), cube, { isRead: false }),
  one("a .vtp in base64 whose length is encoded by itself", "a.vtp", vtpBase64(base64Of(96, true)), cube, { isRead: false }),
  one("a .vtp with another sign in its base64", "a.vtp", vtpBase64(base64Of(96).replace(/^(.{40})./, "$1*")), cube, { mustRefuse: true, refused: /the array \(line \d+\) has '\*' in its base64/ }),
  one("a .vtp whose base64 is cut", "a.vtp", vtpBase64(base64Of(96).slice(0, 60)), cube, { mustRefuse: true, refused: /the array \(line \d+\) claims 96 bytes; it has 41/ }),
  one("a .vtp whose base64 ends within four characters", "a.vtp", vtpBase64(base64Of(96).slice(0, 61)), cube, { mustRefuse: true, refused: /ends inside of its base64/ }),
  one("a .vtp whose base64 claims too many bytes", "a.vtp", vtpBase64(base64Of(196)), cube, { mustRefuse: true, refused: /claims 196 bytes; it has 96/ }),
  ...["raw", "base64"].flatMap((encoding) => [
    one(`a .vtp with appended bytes, ${encoding}`, "a.vtp", vtpAppended(encoding), cube, { isRead: false }),
    one(`a .vtp whose appended bytes are cut, ${encoding}`, "a.vtp", vtpAppended(encoding).subarray(0, -70), cube, { mustRefuse: true, refused: /<AppendedData> has no end: the file was cut/ }),
    one(`a .vtp with a gap in its appended bytes, ${encoding}`, "a.vtp", vtpAppended(encoding, { missing: 4 }), cube, { mustRefuse: true, refused: /the array \(line \d+\) claims 96 bytes; it has 9[0-5]/ }),
    one(`a .vtp whose appended bytes claim more, ${encoding}`, "a.vtp", vtpAppended(encoding, { claimed: 100000 }), cube, { mustRefuse: true, refused: /claims 100000 bytes/ }),
    one(`a .vtp with an offset after its appended bytes, ${encoding}`, "a.vtp", vtpAppended(encoding, { offset: 5000 }), cube, { mustRefuse: true, refused: /the array .*begins at 5000, after the end/ }),
    one(`a .vtp with an offset below 0, ${encoding}`, "a.vtp", vtpAppended(encoding, { offset: -4 }), cube, { mustRefuse: true, refused: /has an invalid offset: '-4'/ }),
    one(`a .vtp with compressed appended bytes, ${encoding}`, "a.vtp", vtpAppended(encoding, { packs: true }), cube, { isRead: false }),
    one(`a .vtp with compressed appended bytes that claim more, ${encoding}`, "a.vtp", vtpAppended(encoding, { packs: true, claimed: 100000 }), cube, { mustRefuse: true, refused: /claims \d+ bytes; it has/ }),
  ]),
  one("a .vtp with line ends in its appended base64", "a.vtp", vtpAppended("base64", { between: "\n" }), cube, { mustRefuse: true, refused: /<AppendedData> has blanks or line ends in its base64/ }),
  one("a .vtp with a comment before its bytes", "a.vtp", vtpBase64(base64Of(96)).replace("<Points>", '<!-- "> <x format=\'binary\'> --><Points>'), cube, { isRead: false }),
  one("a text STL with a remark before it", "a.stl", `; made by hand\n${stlText()}`, cube, { mustRefuse: true, refused: /is not an STL file: a text begins with 'solid'/ }),
  // Parts of a .vtk that contradict each other.
  ...[["too few coordinates", "3 2 2", "2 float\n0 1", /holds 2 X_COORDINATES, but DIMENSIONS requires 3/], ["too many coordinates", "2 2 2", "3 float\n0 1 2", /holds 3 X_COORDINATES, but DIMENSIONS requires 2/]].map(([what, sides, x, refused]) =>
    one(`a .vtk with ${what}`, "a.vtk", vtk("RECTILINEAR_GRID", [`DIMENSIONS ${sides}`, `X_COORDINATES ${x}`, "Y_COORDINATES 2 float\n0 1", "Z_COORDINATES 2 float\n0 1"]), {}, { mustRefuse: true, refused })),
  one("a .vtk without one of its coordinates", "a.vtk", vtk("RECTILINEAR_GRID", ["DIMENSIONS 2 2 2", "X_COORDINATES 2 float\n0 1", "Y_COORDINATES 2 float\n0 1"]), {}, { mustRefuse: true, refused: /holds 0 Z_COORDINATES/ }),
  one("a .vtk of an image with sides below 1", "a.vtk", vtk("STRUCTURED_POINTS", ["DIMENSIONS -3 3 3", "ORIGIN 0 0 0", "SPACING 1 1 1"]), {}, { mustRefuse: true, refused: /DIMENSIONS \(line 5\) has '-3' \(line 5\), which is not a number of points/ }),
  one("a .vtk of an image with a decimal comma", "a.vtk", vtk("STRUCTURED_POINTS", ["DIMENSIONS 3 3 3", "ORIGIN 0,5 0 0", "SPACING 1 1 1"]), {}, { mustRefuse: true, refused: /ORIGIN \(line 6\) has 0 of its 3 numbers, then '0,5' \(line 6\) \(a decimal comma/ }),
  one("a .vtk of an image with two of three lengths", "a.vtk", vtk("STRUCTURED_POINTS", ["DIMENSIONS 3 3 3", "SPACING 1 1", "ORIGIN 0 0 0"]), {}, { mustRefuse: true, refused: /SPACING \(line 6\) has 2 of its 3 numbers, then 'ORIGIN'/ }),
  one("a .vtk of an image with Fortran's exponents", "a.vtk", vtk("STRUCTURED_POINTS", ["DIMENSIONS 3 3 3", "ORIGIN 0 0 0", "SPACING 2.0D+00 1 1"]), { volume: 16 }, { isRead: false }),
  one("a .vtk with points twice", "a.vtk", vtk("POLYDATA", [vtkPoints, vtkPoints, vtkPolygons]), {}, { mustRefuse: true, refused: /POINTS \(line 14\) is there a second time/ }),
  one("a .vtk with polygons twice", "a.vtk", vtk("POLYDATA", [vtkPoints, vtkPolygons, vtkPolygons]), {}, { mustRefuse: true, refused: /POLYGONS \(line 21\) is there a second time/ }),
  one("a .vtk with its polygons after its arrays", "a.vtk", vtk("POLYDATA", [vtkPoints, "POINT_DATA 8\nSCALARS q float\nLOOKUP_TABLE default\n1 2 3 4 5 6 7 8", vtkPolygons]), {}, { mustRefuse: true, refused: /POLYGONS \(line 18\) is after POINT_DATA or CELL_DATA/ }),
  one("a .vtk with too few types of cells", "a.vtk", vtk("UNSTRUCTURED_GRID", [vtkPoints, "CELLS 2 8\n3 0 1 2\n3 1 2 3", "CELL_TYPES 1\n5"]), {}, { mustRefuse: true, refused: /CELL_TYPES \(line 17\) has 1 type, but there are 2 cells/ }),
  // Colours and classes in front of the coordinates, and colours that are not from 0 to 1.
  one("points with their colours first", "a.txt", scatter(40).map((point, i) => [i % 4 ? 200 : 10, 100, 50, ...point].join(" ")).join("\n"), { ...cloud, box: boxOfCloud },
    { isRead: false, says: /read as "r g b x y z", not "x y z column4 column5 column6": .* some of them alike/, colors: [[10, 100, 50], [200, 100, 50]] }),
  one("points with their colours first, and normals", "a.txt", scatter(40).map((point, i) => [i % 4 ? 200 : 10, 100, 50, ...point, 0, 0.6, 0.8].join(",")).join("\n"), { ...cloud, box: boxOfCloud },
    { isRead: false, says: /read as "r g b x y z nx ny nz", not/, colors: [[10, 100, 50], [200, 100, 50]] }),
  one("voxels with a vector each", "a.txt", Array.from({ length: 64 }, (_, i) => [i % 4, Math.floor(i / 4) % 4, Math.floor(i / 16), i / 8 - 3, 0.5 * i, 7 - i / 4].join(" ")).join("\n"),
    { triangles: 0, places: 64, box: { low: [0, 0, 0], high: [3, 3, 3] } }, { says: /could be "r g b x y z" too/, colors: [] }),
  one("points with a class first", "a.txt", scatter(40).map((point, i) => [2 + i % 3, ...point.map((v) => (v + 0.1).toFixed(2))].join(" ")).join("\n"), cloud, { says: /first could be a class/ }),
  one("VRML with colours to 255", "a.wrl", wrl(cubeWrl(`color Color { color [ ${corners.map((_, i) => (i ? "200 100 50" : "0 0 1")).join(", ")} ] }`)), cube,
    { says: /in a node Color 255 is white/, colors: [[200, 100, 50], [0, 0, 1]] }),
  one("VRML with a material's colour to 255", "a.wrl", wrl(cubeWrl().replace("Shape {", "Shape { appearance Appearance { material Material { diffuseColor 200 100 50 } }")), cube,
    { says: /in a node Material 255 is white/, colors: [[200, 100, 50]] }),
  one("VRML 1 with a material's colour to 255", "a.wrl", wrlOne("Material { diffuseColor 200 100 50 }"), cube, { says: /in a node Material 255 is white/, colors: [[200, 100, 50]] }),
  one("VRML with a colour brighter than white", "a.wrl", wrl(cubeWrl(`color Color { color [ ${corners.map((_, i) => (i ? "1 0.4 0" : "1.5 0.4 0")).join(", ")} ] }`)), cube,
    { says: /in a node Color 1 is white, .*1 of 16 is above it/, colors: [[255, 102, 0]] }),
  one("a PLY with colours as color_r", "a.ply", plyOf(corners, quads, { properties: "property uchar color_r\nproperty uchar color_g\nproperty uchar color_b", row: () => "200 100 50" }), cube,
    { says: /color_r, color_g, color_b/, colors: [[200, 100, 50]] }),
  one("a tileset with long metadata and without content", "tileset.json", JSON.stringify({ asset: { version: "1.1" }, schema: { id: "s", description: "word ".repeat(30000) }, geometricError: 2,
    root: { boundingVolume: { sphere: [0, 0, 0, 9] }, geometricError: 1 } }), cube, { mustRefuse: true, refused: /: holds no points/ }),
  // Numbers that a library reads as others: '1.#QNAN' as 1, and values that do not fit their field.
  ...["1.#QNAN", "-1.#IND", "1.#INF00"].flatMap((number) => [
    one(`a PCD with ${number}`, "a.pcd", pcd("FIELDS x y z", "ascii").replaceAll("40", "41") + rowsOf(" ") + `\n${number} 0 0\n`, { ...cloud, box: boxOfCloud }, { isRead: false, says: /1 point is not finite/ }),
    one(`an OFF with ${number}`, "a.off", offOf().replace("8 6 12", "9 6 12 # counts").replace("\n4 ", `\n${number} 0 0 # none\n4 `), cube, { isRead: false, says: /1 point is not finite/ }),
  ]),
  ...[["I", 4, "2.5"], ["U", 1, "300"], ["U", 4, "-1"], ["I", 2, "40000"], ["U", 4, "1.87e-38"]].map(([type, size, number]) =>
    one(`a PCD with ${number} in a field of TYPE ${type}, SIZE ${size}`, "a.pcd", pcdMore(type, size) + rowsOf(" ").replace(/$/gm, ` ${number}`), cloud,
      { mustRefuse: true, refused: new RegExp(`line 12: '${number}' is not a whole number that fits the field 'label' \\(TYPE ${type}, SIZE ${size}\\)`) })),
  ...[["U", 1, "255"], ["I", 2, "-32768"], ["U", 8, "18446744073709551615"], ["I", 8, "-9223372036854775808"]].map(([type, size, number]) =>
    one(`a PCD with ${number}, which just fits`, "a.pcd", pcdMore(type, size) + rowsOf(" ").replace(/$/gm, ` ${number}`), { ...cloud, box: boxOfCloud }, { isRead: false })),
  one("a PCD with whole numbers as decimals", "a.pcd", pcdMore("U", 1) + rowsOf(" ").replace(/$/gm, " 2.55e2"), { ...cloud, box: boxOfCloud }, { isRead: false }),
  one("a LAS whose header has another box", "a.las", lasBox(las(), 5000, 6000), { triangles: 0 }, { says: /300 of 300 points are outside of the box that the header states/ }),
  one("a LAS whose header has no box", "a.las", lasBox(las(), 0, 0), { triangles: 0 }, { silent: /outside of the box/ }),
  one("a LAS whose header has a large box", "a.las", lasBox(las(), -1e9, 1e9), { triangles: 0 }, { silent: /outside of the box/ }),
];
