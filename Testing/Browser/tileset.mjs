// SPDX-License-Identifier: BSD-3-Clause
// Reads the output of kdstream-store export --format 3dtiles, as any other client would: tilesets, and tiles, decoded
// by npm's meshoptimizer or by the Draco decoder of three.js.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";
import { MeshoptDecoder } from "meshoptimizer";

// All tiles below a tileset's root, including those of external tilesets: { box, error, content, children }. content is
// relative to `folder`.
export function readTileset(folder, file = "tileset.json") {
  const { asset, root } = JSON.parse(readFileSync(join(folder, file), "utf8"));
  assert.equal(asset.version, "1.1");
  assert.equal(root.refine, "REPLACE");
  const read = ({ boundingVolume: { box }, geometricError: error, content, children = [], transform }) => {
    const uri = content && normalize(join(dirname(file), content.uri));
    if (uri?.endsWith(".json")) {
      assert.deepEqual(children, []);
      const inner = readTileset(folder, uri);
      assert.deepEqual({ box: inner.box, error: inner.error }, { box, error });
      return { ...inner, tileset: uri };
    }
    return { box, error, content: uri, children: children.map(read), transform };
  };
  return read(root);
}

export function allTiles(tile) {
  return [tile, ...tile.children.flatMap(allTiles)];
}

const arrays = { 5120: Int8Array, 5121: Uint8Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };
const sizes = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };

let draco;
async function loadDraco() {
  const file = fileURLToPath(new URL("node_modules/three/examples/jsm/libs/draco/draco_decoder.js", import.meta.url));
  // The file is a plain script, not a module.
  const script = new Function("require", "__dirname", `${readFileSync(file, "utf8")}; return DracoDecoderModule;`);
  draco ??= await script(createRequire(import.meta.url), dirname(file))();
}

// Decodes a primitive. Returns the values of each accessor, and the indices.
function unpackDraco(bytes, { attributes }, primitive, gltf) {
  const decoder = new draco.Decoder();
  const mesh = new draco.Mesh();
  const status = decoder.DecodeArrayToMesh(new Int8Array(bytes), bytes.length, mesh);
  assert.ok(status.ok(), status.error_msg());
  const unpacked = new Map();
  for (const [name, number] of Object.entries(attributes)) {
    const accessor = gltf.accessors[primitive.attributes[name]];
    assert.equal(accessor.bufferView, undefined);
    assert.equal(mesh.num_points(), accessor.count);
    const values = new draco.DracoFloat32Array();
    decoder.GetAttributeFloatForAllPoints(mesh, decoder.GetAttributeByUniqueId(mesh, number), values);
    const size = sizes[accessor.type];
    const scale = accessor.normalized ? 65535 : 1; // normalized values come as fractions
    unpacked.set(primitive.attributes[name], Array.from({ length: accessor.count }, (_, i) =>
      Array.from({ length: size }, (_, k) => scale * values.GetValue(i * size + k))));
  }
  assert.equal(3 * mesh.num_faces(), gltf.accessors[primitive.indices].count);
  const face = new draco.DracoInt32Array();
  unpacked.set(primitive.indices, Array.from({ length: mesh.num_faces() }, (_, f) => {
    decoder.GetFaceFromMesh(mesh, f, face);
    return [0, 1, 2].map((k) => [face.GetValue(k)]);
  }).flat());
  [face, mesh, decoder].forEach((object) => draco.destroy(object));
  return unpacked;
}

// A tile's JSON and the content of its primitives: positions in the tileset's coordinates (z up), as [x, y, z], and
// indices.
export async function readTile(file) {
  await MeshoptDecoder.ready;
  const bytes = readFileSync(file);
  assert.equal(bytes.toString("latin1", 0, 4), "glTF");
  assert.equal(bytes.readUInt32LE(8), bytes.length);
  const jsonLength = bytes.readUInt32LE(12);
  const gltf = JSON.parse(bytes.toString("utf8", 20, 20 + jsonLength));
  const binary = bytes.subarray(20 + jsonLength + 8);
  const views = gltf.bufferViews.map((view) => {
    const packed = view.extensions?.EXT_meshopt_compression;
    if (!packed) {
      return binary.subarray(view.byteOffset ?? 0, (view.byteOffset ?? 0) + view.byteLength);
    }
    const { count, byteStride, byteOffset, byteLength, mode, filter } = packed;
    const out = new Uint8Array(count * byteStride);
    MeshoptDecoder.decodeGltfBuffer(out, count, byteStride, binary.subarray(byteOffset, byteOffset + byteLength), mode, filter);
    return out;
  });
  const unpacked = new Map();
  for (const primitive of gltf.meshes[0].primitives) {
    const packed = primitive.extensions?.KHR_draco_mesh_compression;
    if (packed) {
      await loadDraco();
      unpackDraco(views[packed.bufferView], packed, primitive, gltf).forEach((values, index) => unpacked.set(index, values));
    }
  }
  const read = (index) => {
    if (unpacked.has(index)) {
      return unpacked.get(index);
    }
    const { bufferView, componentType, count, type } = gltf.accessors[index];
    const array = arrays[componentType], size = sizes[type];
    const stride = gltf.bufferViews[bufferView].byteStride ?? size * array.BYTES_PER_ELEMENT;
    const values = [];
    for (let i = 0; i < count; ++i) {
      const part = views[bufferView].slice(i * stride, i * stride + size * array.BYTES_PER_ELEMENT);
      values.push([...new array(part.buffer, part.byteOffset, size)]);
    }
    return values;
  };
  const m = gltf.nodes[0].matrix;
  const primitives = gltf.meshes[0].primitives.map((primitive) => {
    const positions = read(primitive.attributes.POSITION).map(([a, b, c]) => {
      const [x, y, z] = [0, 1, 2].map((k) => m[k] * a + m[4 + k] * b + m[8 + k] * c + m[12 + k]);
      return [x, -z, y];
    });
    const indices = primitive.indices === undefined ? null : read(primitive.indices).map(([index]) => index);
    const others = Object.entries(primitive.attributes).filter(([name]) => name !== "POSITION");
    return { positions, indices, isSkirt: primitive.extras?.skirt === true, attributes: Object.fromEntries(others.map(([name, i]) => [name, read(i)])) };
  });
  return { gltf, primitives };
}

// Reads the points and triangles of an OBJ.
export function readObj(file) {
  const points = [], triangles = [];
  for (const line of readFileSync(file, "utf8").split("\n")) {
    const words = line.split(" ");
    if (words[0] === "v") {
      points.push(words.slice(1, 4).map(Number));
    } else if (words[0] === "f") {
      triangles.push(words.slice(1, 4).map((word) => Number.parseInt(word) - 1));
    }
  }
  return { points, triangles };
}

// Finds the point of a list that is nearest to a place, and no farther away than `reach`.
export class PointFinder {
  #cells = new Map();
  #points;
  #reach;

  constructor(points, reach) {
    this.#points = points;
    this.#reach = reach;
    points.forEach((point, i) => {
      const key = this.#cell(point).join();
      this.#cells.set(key, [...(this.#cells.get(key) ?? []), i]);
    });
  }
  #cell(point) {
    return point.map((x) => Math.floor(x / (4 * this.#reach)));
  }
  // All points within reach.
  near(place) {
    const found = [];
    const cell = this.#cell(place);
    for (let code = 0; code < 27; ++code) {
      const key = cell.map((x, k) => x + (Math.floor(code / 3 ** k) % 3) - 1).join();
      for (const i of this.#cells.get(key) ?? []) {
        if (Math.hypot(...place.map((x, k) => x - this.#points[i][k])) <= this.#reach) {
          found.push(i);
        }
      }
    }
    return found;
  }
}
