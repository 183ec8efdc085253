// SPDX-License-Identifier: BSD-3-Clause
// Compares the decoder in JavaScript with the encoder in C++: PieceDecoder.test.mjs PIECE_SAMPLES FILE
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { decodePartitionBoxes, decodePiece, decodeTreePage } from "./PieceDecoder.mjs";
import { decodeTexture } from "./TextureDecoder.mjs";

const [program, file] = process.argv.slice(2);
execFileSync(program, [file]);
const doubles = (hex) => {
  const bytes = Buffer.from(hex, "hex");
  return Array.from({ length: bytes.length / 8 }, (_, i) => bytes.readDoubleBE(8 * i));
};
const flat = (boxes) => boxes.flatMap((box) => [...box.lo, ...box.hi]);
const same = (values, expected, where) => {
  assert.equal(values.length, expected.length, where);
  values.forEach((value, i) => assert.ok(Object.is(value, expected[i]), `${where}, value ${i}`));
};
let samples = 0, damaged = 0, pages = 0, textures = 0;

function checkTree(sample) {
  const blob = new Uint8Array(Buffer.from(sample.blob, "hex"));
  const where = `${sample.kind} ${sample.node}`;
  const decode = (bytes) => {
    if (sample.kind === "boxes") return { boxes: decodePartitionBoxes(bytes, sample, sample.node), facts: [] };
    const [lo, hi] = [doubles(sample.around).slice(0, 3), doubles(sample.around).slice(3)];
    const page = decodeTreePage(bytes, sample, sample.node, { lo, hi });
    return { boxes: page.boxes.slice(1), facts: page.facts };
  };
  const decoded = decode(blob);
  same(flat(decoded.boxes), doubles(sample.boxes), where);
  same(decoded.facts.flatMap((fact) => [fact.most99, fact.most, fact.bytes]), doubles(sample.facts), where);
  const cut = new Uint8Array(blob.length - 1 - (pages % (blob.length - 12)));
  cut.set(blob.subarray(0, cut.length));
  assert.throws(() => decode(cut), where);
  ++pages;
}

function checkTexture(sample) {
  const blob = new Uint8Array(Buffer.from(sample.blob, "hex"));
  const where = `texture ${textures}`;
  const decoded = decodeTexture(blob, sample.triangles, doubles(sample.positions));
  assert.deepEqual([decoded.width, decoded.height, decoded.format], [sample.width, sample.height, sample.format], where);
  assert.equal(Buffer.from(decoded.image).toString("hex"), sample.image, where);
  same(decoded.places, doubles(sample.places), where);
  same(decoded.given, doubles(sample.given), where);
  const cut = blob.slice(0, blob.length - 1 - (37 * textures % (blob.length - 12)));
  assert.throws(() => decodeTexture(cut, sample.triangles, doubles(sample.positions)), where);
  ++textures;
}

for (const line of readFileSync(file, "utf8").split("\n").filter(Boolean)) {
  const sample = JSON.parse(line);
  if (sample.kind === "texture") {
    checkTexture(sample);
    continue;
  }
  if (sample.kind) {
    checkTree(sample);
    continue;
  }
  const frame = doubles(sample.frame);
  const grid = { bits: sample.bits, scalarType: sample.scalarType, origin: frame.slice(0, 3), step: frame[3],
    spacing: sample.spacing };
  const model = { partition: sample.partition, stitch: sample.stitch, preview: sample.preview, grid };
  const blob = new Uint8Array(Buffer.from(sample.blob, "hex"));
  const piece = decodePiece(blob, model, sample.level, sample.node);
  const where = `sample ${samples}`;
  assert.equal(piece.own, sample.own, where);
  assert.deepEqual(piece.triangles, sample.triangles, where);
  assert.deepEqual(piece.keys, sample.keys, where);
  const positions = doubles(sample.positions);
  assert.equal(piece.positions.flat().length, positions.length, where);
  piece.positions.flat().forEach((value, i) => assert.ok(Object.is(value, positions[i]), `${where}, coordinate ${i}`));
  assert.deepEqual(piece.ancestors.flat(), sample.ancestors, where);
  assert.deepEqual(piece.childEnds, sample.reachBegin.slice(1), where);
  assert.deepEqual(piece.childNodes, sample.reachNodes, where);
  assert.deepEqual(piece.attributes.map((attribute) => Buffer.from(attribute.values).toString("hex")), sample.attributes, where);
  // A blob that is cut off anywhere is refused.
  const cut = new Uint8Array(blob.length - 1 - (samples % (blob.length - 12)));
  cut.set(blob.subarray(0, cut.length));
  assert.throws(() => decodePiece(cut, model, sample.level, sample.node), where);
  ++damaged;
  ++samples;
}
assert.ok(samples > 600, "too few samples");
assert.ok(textures > 30, "too few textures");
assert.ok(pages > 100, "too few pages and boxes");
console.log(`${pages} pages and boxes, ${textures} textures are the same; ${samples} pieces are the same, ${damaged} that were cut are refused`);
