// SPDX-License-Identifier: BSD-3-Clause
// Small readers of mesh files, written for the tests from descriptions of the formats, not from the product's code.
// They read the cases' files completely, and check little. Each returns { points: [[x, y, z]], faces: [[index]],
// colors: [[r, g, b]] }; colors are from 0 to 255 for each point, and empty if the file has none.

import { readFileSync } from "node:fs";
import { dirname, extname, join } from "node:path";
import { gunzipSync } from "node:zlib";
import { readGltf } from "./readGltf.mjs";
import { readVrml } from "./readVrml.mjs";

export function readMesh(file) {
  const whole = readFileSync(file);
  const bytes = whole[0] === 0x1f && whole[1] === 0x8b ? gunzipSync(whole) : whole;
  const readers = { ".obj": readObj, ".ply": readPly, ".stl": readStl, ".xyz": readXyz, ".pcd": readPcd, ".las": readLas,
    ".gltf": readGltf, ".glb": readGltf, ".wrl": readVrml, ".wrz": readVrml, ".txt": readXyz, ".csv": readXyz, ".pts": readXyz,
    ".asc": readXyz, ".off": readOff, ".vtk": readVtk, ".vtp": readVtp };
  return readers[extname(file).toLowerCase()](bytes, (name) => readFileSync(join(dirname(file), name)));
}

// The text in these bytes. Handles byte order marks and UTF-16; bytes after the end of the text are dropped.
export function textOf(bytes) {
  let text = bytes[0] === 0xff && bytes[1] === 0xfe ? bytes.toString("utf16le")
    : bytes[0] === 0xfe && bytes[1] === 0xff ? Buffer.from(bytes).swap16().toString("utf16le") : bytes.toString("utf8");
  text = text.replace(/^\ufeff/, "").replace(/[\0\x1a]+$/, "");
  return text;
}

const linesOf = (bytes) => textOf(bytes).replace(/\\(\r\n|\r|\n)/g, " ").split(/\r\n|\r|\n/);

function readObj(bytes) {
  const points = [], faces = [], colors = [];
  for (const line of linesOf(bytes)) {
    const [keyword, ...words] = line.replace(/(^|\s)#.*/, "").trim().split(/\s+/);
    if (/^v$/i.test(keyword)) {
      const numbers = words.map(Number);
      points.push(numbers.slice(0, 3));
      numbers.length >= 6 && colors.push(numbers.slice(3, 6).map((value) => Math.round(255 * value)));
    } else if (/^fo?$/i.test(keyword)) {
      const corners = words.map((word) => Number(word.split("/")[0]));
      faces.push(corners.map((index) => (index < 0 ? points.length + index : index - 1)));
    }
  }
  return { points, faces, colors };
}

const plyTypes = { char: ["Int8", 1], int8: ["Int8", 1], uchar: ["UInt8", 1], uint8: ["UInt8", 1], short: ["Int16", 2],
  int16: ["Int16", 2], ushort: ["UInt16", 2], uint16: ["UInt16", 2], int: ["Int32", 4], int32: ["Int32", 4], int64: ["BigInt64", 8], uint64: ["BigUInt64", 8], uint: ["UInt32", 4],
  uint32: ["UInt32", 4], float: ["Float", 4], float32: ["Float", 4], double: ["Double", 8], float64: ["Double", 8] };

function readPly(bytes) {
  const end = /end_header(\r\n|\n|\r)/.exec(bytes.toString("latin1"));
  const header = bytes.toString("latin1", 0, end.index).split(/\r\n|\n|\r/).map((line) => line.trim().split(/\s+/));
  const format = header.find(([word]) => word === "format")[1];
  let at = end.index + end[0].length;
  const words = format === "ascii" ? textOf(bytes.subarray(at)).trim().split(/\s+/) : null;
  const lines = format === "ascii" ? textOf(bytes.subarray(at)).trim().split(/[\r\n]+/).map((line) => line.trim().split(/\s+/)) : [];
  let nextWord = 0;
  const read = (type) => {
    if (words) {
      return Number(words[nextWord++]);
    }
    const [name, size] = plyTypes[type];
    const order = size === 1 ? "" : format === "binary_big_endian" ? "BE" : "LE";
    at += size;
    return Number(bytes[`read${name}${order}`](at - size));
  };
  // If each record has a line of its own, further tokens in the line are not values.
  const byLine = lines.length === header.filter(([word]) => word === "element").reduce((sum, [, , count]) => sum + Number(count), 0);
  let lineNumber = 0, lineEnd = 0;
  const points = [], faces = [], colors = [];
  const largest = { uchar: 255, uint8: 255, ushort: 65535, uint16: 65535 };
  for (let i = 0; i < header.length; ++i) {
    if (header[i][0] !== "element") {
      continue;
    }
    const [, name, count] = header[i];
    const element = name.toLowerCase();
    const properties = [];
    while (header[i + 1]?.[0] === "property") {
      properties.push(header[++i].slice(1));
    }
    for (let row = 0; row < Number(count); ++row) {
      const values = {};
      if (byLine) {
        nextWord = lineEnd;
        lineEnd += lines[lineNumber++].length;
      }
      for (const [type, ...rest] of properties) {
        values[rest.at(-1)] ??= type === "list"
          ? Array.from({ length: read(rest[0]) }, () => read(rest[1])) : read(type) * 255 / (/^(red|green|blue)$/.test(rest[0]) ? largest[type] ?? 1 : 255);
      }
      if (element === "vertex") {
        points.push([values.x, values.y, values.z]);
        "red" in values && colors.push([values.red, values.green, values.blue].map(Math.round));
      } else if (element === "face") {
        faces.push(values.vertex_indices ?? values.vertex_index ?? values.vertex_indexes ?? Object.values(values).find(Array.isArray));
      }
    }
  }
  return { points, faces, colors };
}

function readStl(bytes) {
  const points = [], faces = [];
  const counted = bytes.length >= 84 ? bytes.readUInt32LE(80) : 0;
  const count = counted && counted !== 0xffffffff ? counted : Math.floor((bytes.length - 84) / 50);
  if (/^\s*solid/i.test(textOf(bytes.subarray(0, 80))) && /\bfacet\b/i.test(bytes.toString("latin1", 0, 1000))) {
    for (const [, x, y, z] of textOf(bytes).matchAll(/vertex\s+(\S+)\s+(\S+)\s+(\S+)/gi)) {
      points.push([x, y, z].map(Number));
    }
  } else {
    for (let i = 0; i < 9 * count; i += 3) {
      const at = 84 + 50 * Math.floor(i / 9) + 12 + 4 * (i % 9);
      points.push([0, 4, 8].map((offset) => bytes.readFloatLE(at + offset)));
    }
  }
  for (let i = 0; i + 2 < points.length; i += 3) {
    faces.push([i, i + 1, i + 2]);
  }
  return { points, faces, colors: [] };
}

// OFF: one line for each vertex, and one for each face; in a COFF colours follow the coordinates.
function readOff(bytes) {
  const rows = linesOf(bytes).map((line) => line.replace(/#.*/, "").trim()).filter(Boolean);
  const [, kind, rest] = /^(\w*)OFF\s*(.*)$/i.exec(rows.shift());
  const counts = (rest || rows.shift()).split(/\s+/).map(Number);
  const numbers = rows.map((row) => row.split(/\s+/).map(Number));
  const vertices = numbers.slice(0, counts[0]);
  const colors = kind === "C" ? vertices.map((row) => row.slice(3, 6)) : [];
  const white = Math.max(0, ...colors.flat()) > 1 ? 255 : 1;
  return { points: vertices.map((row) => row.slice(0, 3)), colors: colors.map((color) => color.map((value) => Math.round(255 * value / white))),
    faces: numbers.slice(counts[0], counts[0] + counts[1]).map((row) => row.slice(1, 1 + row[0])) };
}

// VTK text files of version 3, only meshes of polygons.
function readVtk(bytes) {
  const numbersOf = (part) => new RegExp(`${part} \\d+ \\w+\\s([-+.\\deE\\s]*)`).exec(textOf(bytes))?.[1].trim().split(/\s+/).map(Number) ?? [];
  const triples = (list) => Array.from({ length: list.length / 3 }, (_, i) => list.slice(3 * i, 3 * i + 3));
  const faces = [], list = numbersOf("POLYGONS");
  for (let at = 0; at < list.length; at += list[at] + 1) {
    faces.push(list.slice(at + 1, at + 1 + list[at]));
  }
  return { points: triples(numbersOf("POINTS")), faces, colors: [] };
}

// VTP text files with one piece; reads as many points and polygons as the piece announces.
function readVtp(bytes) {
  const text = textOf(bytes);
  const count = (name) => Number(new RegExp(`${name}="(\\d+)"`).exec(text)?.[1] ?? 0);
  const [points, corners, offsets] = [...text.matchAll(/<DataArray[^>]*>([^<]*)</g)].map(([, list]) => list.trim().split(/\s+/).map(Number));
  return { points: Array.from({ length: count("NumberOfPoints") }, (_, i) => points.slice(3 * i, 3 * i + 3)), colors: [],
    faces: offsets.slice(0, count("NumberOfPolys")).map((end, i) => corners.slice(offsets[i - 1] ?? 0, end)) };
}

// Columns are separated by blanks or semicolons, else by commas. Lines of names and of counts are not points.
function readXyz(bytes) {
  const rows = linesOf(bytes).map((line) => line.trim()).filter((line) => /^"?[-+.\d]/.test(line) && !/^\d+$/.test(line))
    .map((line) => line.replaceAll('"', "")).map((line) => line.split(/[\s;]/.test(line.trim()) ? /[\s;]+/ : /,/).map((word) => Number(word.replace(",", "."))));
  return { points: rows.map((row) => row.slice(0, 3)), faces: [], colors: [] };
}

// Unpacks LZF: runs of literal bytes, and references to earlier bytes.
function unpackLzf(packed, size) {
  const bytes = Buffer.alloc(size);
  for (let from = 0, to = 0; from < packed.length;) {
    const control = packed[from++];
    if (control < 32) {
      packed.copy(bytes, to, from, from + control + 1);
      from += control + 1;
      to += control + 1;
      continue;
    }
    let length = control >> 5;
    length += length === 7 ? packed[from++] : 0;
    const back = to - ((control & 31) << 8) - packed[from++] - 1;
    for (let i = 0; i < length + 2; ++i) {
      bytes[to++] = bytes[back + i];
    }
  }
  return bytes;
}

function readPcd(bytes) {
  const data = /^DATA\s+(\w+)[^\n]*\n/im.exec(bytes.toString("latin1"));
  const header = Object.fromEntries(bytes.toString("latin1", 0, data.index).split(/\r?\n/)
    .map((line) => line.trim().split(/\s+/)).map(([name, ...values]) => [name?.toUpperCase(), values]));
  const fields = header.FIELDS.map((name) => name.toLowerCase());
  const count = Number(header.POINTS?.[0] ?? header.WIDTH[0] * header.HEIGHT[0]);
  const sizes = header.SIZE.map((size, i) => size * (header.COUNT?.[i] ?? 1));
  const stride = sizes.reduce((sum, size) => sum + size, 0);
  const start = data.index + data[0].length;
  const packed = data[1] === "binary_compressed" ? unpackLzf(bytes.subarray(start + 8, start + 8 + bytes.readUInt32LE(start)), bytes.readUInt32LE(start + 4)) : null;
  const rows = data[1] === "ascii" ? textOf(bytes.subarray(start)).trim().split(/\r?\n/).map((line) => line.trim().split(/\s+/)) : null;
  const points = [];
  for (let row = 0; row < count; ++row) {
    points.push(["x", "y", "z"].map((name) => {
      const field = fields.indexOf(name);
      const before = sizes.slice(0, field).reduce((sum, size) => sum + size, 0);
      if (packed) { // fields are stored one after the other
        return packed[sizes[field] === 8 ? "readDoubleLE" : "readFloatLE"](before * count + row * sizes[field]);
      }
      const at = start + row * stride + before;
      return rows ? Number(rows[row][field]) : sizes[field] === 8 ? bytes.readDoubleLE(at) : bytes.readFloatLE(at);
    }));
  }
  return { points, faces: [], colors: [] };
}

// Reads all points in the file, whatever its header says.
function readLas(bytes) {
  const [start, stride] = [bytes.readUInt32LE(96), bytes.readUInt16LE(105)];
  const scale = [0, 1, 2].map((i) => bytes.readDoubleLE(131 + 8 * i)), offset = [0, 1, 2].map((i) => bytes.readDoubleLE(155 + 8 * i));
  const points = [];
  for (let at = start; at + stride <= bytes.length; at += stride) {
    points.push([0, 1, 2].map((i) => bytes.readInt32LE(at + 4 * i) * scale[i] + offset[i]));
  }
  return { points, faces: [], colors: [] };
}
