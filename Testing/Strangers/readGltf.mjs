// SPDX-License-Identifier: BSD-3-Clause
// Reads glTF 2.0, .gltf and .glb: the nodes of a scene, in doubles; sparse and quantised accessors, strips, fans,
// instances, CESIUM_RTC, hidden nodes. Does not read compressed files.

const sizes = { 5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4 };
const reads = { 5120: "readInt8", 5121: "readUInt8", 5122: "readInt16LE", 5123: "readUInt16LE", 5125: "readUInt32LE", 5126: "readFloatLE" };
const steps = { 5120: 127, 5121: 255, 5122: 32767, 5123: 65535 };
const widths = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };

const multiply = (a, b) => Array.from({ length: 16 }, (_, i) => // matrices are stored by columns
  [0, 1, 2, 3].reduce((sum, k) => sum + a[i % 4 + 4 * k] * b[4 * Math.floor(i / 4) + k], 0));

function matrixOf({ matrix, translation: t = [0, 0, 0], rotation: [x, y, z, w] = [0, 0, 0, 1], scale: s = [1, 1, 1] }) {
  return matrix ?? [
    (1 - 2 * (y * y + z * z)) * s[0], 2 * (x * y + z * w) * s[0], 2 * (x * z - y * w) * s[0], 0,
    2 * (x * y - z * w) * s[1], (1 - 2 * (x * x + z * z)) * s[1], 2 * (y * z + x * w) * s[1], 0,
    2 * (x * z + y * w) * s[2], 2 * (y * z - x * w) * s[2], (1 - 2 * (x * x + y * y)) * s[2], 0, t[0], t[1], t[2], 1];
}

const isMirror = (m) => m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) + m[8] * (m[1] * m[6] - m[2] * m[5]) < 0;

export function readGltf(bytes, readFile) {
  let json = bytes, body = null;
  if (bytes.toString("latin1", 0, 4) === "glTF") {
    const length = bytes.readUInt32LE(12);
    json = bytes.subarray(20, 20 + length);
    body = bytes.subarray(28 + length);
  }
  const gltf = JSON.parse(json.toString("utf8"));
  const buffers = (gltf.buffers ?? []).map(({ uri }) => (!uri ? body
    : uri.startsWith("data:") ? Buffer.from(uri.slice(uri.indexOf(",") + 1), "base64") : readFile(decodeURIComponent(uri))));

  const rowsOf = (view, offset, type, width, count) => {
    const { buffer, byteOffset = 0, byteStride } = gltf.bufferViews[view];
    const stride = byteStride ?? width * sizes[type];
    return Array.from({ length: count }, (_, row) => Array.from({ length: width }, (_, i) =>
      buffers[buffer][reads[type]](byteOffset + offset + row * stride + i * sizes[type])));
  };
  const accessor = (index) => {
    const { bufferView, byteOffset = 0, componentType: type, type: shape, count, sparse, normalized } = gltf.accessors[index];
    const width = widths[shape];
    const rows = bufferView === undefined ? Array.from({ length: count }, () => new Array(width).fill(0))
      : rowsOf(bufferView, byteOffset, type, width, count);
    if (sparse) {
      const at = rowsOf(sparse.indices.bufferView, sparse.indices.byteOffset ?? 0, sparse.indices.componentType, 1, sparse.count);
      rowsOf(sparse.values.bufferView, sparse.values.byteOffset ?? 0, type, width, sparse.count)
        .forEach((row, i) => (rows[at[i][0]] = row));
    }
    return normalized ? rows.map((row) => row.map((value) => Math.max(value / steps[type], -1))) : rows;
  };

  const points = [], faces = [];
  const addMesh = (mesh, matrix) => {
    for (const { attributes, indices, mode = 4 } of gltf.meshes[mesh].primitives) {
      const first = points.length;
      const places = accessor(attributes.POSITION);
      for (const [x, y, z] of places) {
        points.push([0, 1, 2].map((i) => matrix[i] * x + matrix[4 + i] * y + matrix[8 + i] * z + matrix[12 + i]));
      }
      const order = indices === undefined ? places.map((_, i) => i) : accessor(indices).map(([index]) => index);
      const add = (...corners) => faces.push((isMirror(matrix) ? corners.reverse() : corners).map((i) => first + order[i]));
      for (let i = 0; i + 2 < order.length; i += mode === 4 ? 3 : 1) {
        mode === 6 ? add(0, i + 1, i + 2) : mode === 5 && i % 2 ? add(i + 1, i, i + 2) : mode >= 4 && add(i, i + 1, i + 2);
      }
    }
  };
  const walk = (index, parent) => {
    const node = gltf.nodes[index];
    if (node.extensions?.KHR_node_visibility?.visible === false) {
      return;
    }
    const matrix = multiply(parent, matrixOf(node));
    const instances = node.extensions?.EXT_mesh_gpu_instancing?.attributes;
    if (instances) {
      const [t, r, s] = ["TRANSLATION", "ROTATION", "SCALE"].map((name) => instances[name] !== undefined && accessor(instances[name]));
      (t || r || s).forEach((_, i) => addMesh(node.mesh,
        multiply(matrix, matrixOf({ translation: t ? t[i] : undefined, rotation: r ? r[i] : undefined, scale: s ? s[i] : undefined }))));
    } else if (node.mesh !== undefined) {
      addMesh(node.mesh, matrix);
    }
    node.children?.forEach((child) => walk(child, matrix));
  };
  gltf.scenes[gltf.scene ?? 0].nodes.forEach((node) => walk(node, matrixOf({ translation: gltf.extensions?.CESIUM_RTC?.center })));
  return { points, faces, colors: [] };
}
