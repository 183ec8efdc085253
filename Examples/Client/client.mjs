// SPDX-License-Identifier: BSD-3-Clause
// A client of the protocol in 60 lines. It lists a server's models, or writes the preview of one model, or some
// partitions of its original, as OBJ. It reads models from kdstream-serve, or from a host of plain files
// (kdstream-store export).
//   node client.mjs http://HOST:PORT [MODEL OUT.obj [PARTITION...]]
// If the server needs a token, set KDSTREAM_TOKEN.
import { writeFileSync } from "node:fs";
import { decodePiece } from "../../Testing/Decoder/PieceDecoder.mjs"; // written from doc/formats.md

const [server, id, out, ...partitions] = process.argv.slice(2);
const token = process.env.KDSTREAM_TOKEN;

// Sends a GET. If it is refused for the moment (429, 503), asks again after the pause that the server names.
async function get(path) {
  for (let wait = 1; ; wait = Math.min(60, 2 * wait)) {
    const answer = await fetch(`${server}/api${path}`, { headers: token ? { Authorization: `Bearer ${token}` } : {} });
    if (answer.ok) return answer;
    if (![429, 502, 503, 504].includes(answer.status)) throw new Error(`${path}: ${answer.status} ${await answer.text()}`);
    const seconds = Number(answer.headers.get("Retry-After")) || wait;
    await new Promise((done) => setTimeout(done, 1000 * seconds));
  }
}

// A blob's address contains the model's digest, so the blob never changes: a cache may keep it.
async function piece(model, name, level, node) {
  const blob = new Uint8Array(await (await get(`/models/${id}/${model.digest}/${name}`)).arrayBuffer());
  const { bits, scalar_type, origin, step } = model.precision;
  const spacing = level === null ? 1 : model.levels[level].spacing;
  const grid = { bits: bits === "lossless" ? 0 : bits, scalarType: scalar_type === "float64" ? 1 : 0, origin, step, spacing };
  const depths = { partition: model.partition_depth, stitch: model.stitch_depth, preview: Math.min(model.finest_depth, 11) };
  return decodePiece(blob, { ...depths, grid }, level, node);
}

// The vertices of a piece are first its own, then ghosts. A triangle on a boundary is in each piece that owns one of
// its corners.
function obj(pieces) {
  const lines = [];
  let first = 1;
  for (const { positions, triangles } of pieces) {
    lines.push(...positions.map((p) => `v ${p.join(" ")}`), ...triangles.map((t) => `f ${t.map((v) => first + v).join(" ")}`));
    first += positions.length;
  }
  return `${lines.join("\n")}\n`;
}

if (!id) {
  for (const model of (await (await get("/models.json")).json()).models) {
    console.log(`${model.id}: ${model.title || "no title"}, ${model.triangles} triangles`);
  }
} else {
  const model = await (await get(`/models/${id}/model.json`)).json();
  const preview = Math.min(model.finest_depth, 11);
  const wanted = partitions.length > 0
    ? partitions.map((p) => [`partitions/${p}`, null, 2 ** model.partition_depth + Number(p)])
    : [[`levels/${preview}/1`, preview, 1]];
  const pieces = [];
  for (const each of wanted) pieces.push(await piece(model, ...each));
  writeFileSync(out, obj(pieces));
  console.log(`${out}: ${pieces.reduce((sum, { triangles }) => sum + triangles.length, 0)} triangles`);
}
