// SPDX-License-Identifier: BSD-3-Clause
// Holds the decoder in JavaScript against the encoder in C++: PieceDecoder.test.mjs PIECE_SAMPLES FILE
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { decodePiece } from "./PieceDecoder.mjs";

const [program, file] = process.argv.slice(2);
execFileSync(program, [file]);
const doubles = (hex) => {
  const bytes = Buffer.from(hex, "hex");
  return Array.from({ length: bytes.length / 8 }, (_, i) => bytes.readDoubleBE(8 * i));
};
let samples = 0, damaged = 0;
for (const line of readFileSync(file, "utf8").split("\n").filter(Boolean)) {
  const sample = JSON.parse(line);
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
  assert.deepEqual(piece.reachEnds, sample.reachBegin.slice(1), where);
  assert.deepEqual(piece.reachNodes, sample.reachNodes, where);
  assert.deepEqual(piece.attributes.map((attribute) => Buffer.from(attribute.values).toString("hex")), sample.attributes, where);
  // A blob that is cut anywhere is refused.
  const cut = new Uint8Array(blob.length - 1 - (samples % (blob.length - 12)));
  cut.set(blob.subarray(0, cut.length));
  assert.throws(() => decodePiece(cut, model, sample.level, sample.node), where);
  ++damaged;
  ++samples;
}
assert.ok(samples > 600, "too few samples");
console.log(`${samples} pieces are the same, ${damaged} that were cut are refused`);
