// SPDX-License-Identifier: BSD-3-Clause
// Serves the other viewers' content as a good static host would: their page, one script, and the mesh as a binary PLY
// or GLB. Everything is compressed by gzip, and served from memory.

import { once } from "node:events";
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { gzipSync } from "node:zlib";

const types = { html: "text/html; charset=utf-8", js: "text/javascript", ply: "application/octet-stream", glb: "model/gltf-binary" };

export class FileServer {
  #server;
  #files = new Map(); // by path: { type, bytes }
  port;

  static async start() {
    const files = new FileServer();
    files.#server = createServer(({ url }, answer) => files.#answer(url.replace(/[?#].*/, ""), answer));
    files.#server.listen(0, "127.0.0.1");
    await once(files.#server, "listening");
    files.port = files.#server.address().port;
    return files;
  }

  async stop() {
    this.#server.closeAllConnections();
    this.#server.close();
    await once(this.#server, "close");
  }

  add(path, content) {
    this.#files.set(path, { type: types[path.split(".").pop()], bytes: gzipSync(content) });
  }

  #answer(path, answer) {
    const file = this.#files.get(path);
    if (!file) {
      answer.writeHead(404).end();
      return;
    }
    answer.writeHead(200, { "content-type": file.type, "content-encoding": "gzip", "content-length": file.bytes.length });
    answer.end(file.bytes);
  }
}

export function pageOf(script) {
  return `<!doctype html><html><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,"><style>html, body { margin: 0; height: 100%; overflow: hidden; background: #303236 }
#view { width: 100%; height: 743px }</style></head><body><div id="view"></div><script type="module" src="${script}"></script></body></html>`;
}

// Reads a mesh of kdstream-generate relief: vertices of three floats, faces of a byte and three indices.
export function readRelief(file) {
  const bytes = readFileSync(file);
  const begin = bytes.indexOf("end_header\n") + 11;
  const header = bytes.subarray(0, begin).toString();
  const count = (name) => Number(new RegExp(`^element ${name} (\\d+)$`, "m").exec(header)[1]);
  const [vertices, triangles] = [count("vertex"), count("face")];
  const positions = new Float32Array(bytes.buffer.slice(bytes.byteOffset + begin, bytes.byteOffset + begin + 12 * vertices));
  const indices = new Uint32Array(3 * triangles);
  let at = begin + 12 * vertices;
  if (bytes.length !== at + 13 * triangles) {
    throw new Error(`${file}: not as kdstream-generate writes a relief`);
  }
  for (let i = 0; i < indices.length; i += 3, at += 13) {
    for (let k = 0; k < 3; ++k) {
      indices[i + k] = bytes.readUInt32LE(at + 1 + 4 * k);
    }
  }
  return { bytes, positions, indices, triangles };
}

// Writes the mesh as a binary glTF: positions and indices.
export function makeGlb({ positions, indices }) {
  const least = [Infinity, Infinity, Infinity], most = [-Infinity, -Infinity, -Infinity];
  positions.forEach((value, i) => {
    least[i % 3] = Math.min(least[i % 3], value);
    most[i % 3] = Math.max(most[i % 3], value);
  });
  const [floats, unsigned, arrays, elements] = [5126, 5125, 34962, 34963]; // OpenGL's numbers for these
  const text = JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    accessors: [{ bufferView: 0, componentType: floats, count: positions.length / 3, type: "VEC3", min: least, max: most },
      { bufferView: 1, componentType: unsigned, count: indices.length, type: "SCALAR" }],
    bufferViews: [{ buffer: 0, byteOffset: 0, byteLength: positions.byteLength, target: arrays },
      { buffer: 0, byteOffset: positions.byteLength, byteLength: indices.byteLength, target: elements }],
    buffers: [{ byteLength: positions.byteLength + indices.byteLength }],
  });
  const json = Buffer.from(text.padEnd(4 * Math.ceil(text.length / 4)));
  const binary = Buffer.concat([Buffer.from(positions.buffer), Buffer.from(indices.buffer)]);
  const words = (...values) => Buffer.from(new Uint32Array(values).buffer);
  const whole = 12 + 8 + json.length + 8 + binary.length;
  return Buffer.concat([words(0x46546c67, 2, whole), words(json.length, 0x4e4f534a), json, words(binary.length, 0x004e4942), binary]);
}
