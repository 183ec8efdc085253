// SPDX-License-Identifier: BSD-3-Clause
// Files as users have them: each is built to a store, and extracted again. The result is compared with what our own
// small readers find in the file (readers.mjs), and with known values.
//   node strangers.test.mjs      KDSTREAM_PROGRAMS: folder of kdstream-build and kdstream-store
//                                KDSTREAM_CASES: a folder of further cases, each a folder with a file a.*, if any

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { after, test } from "node:test";
import { cases } from "./cases.mjs";
import { differenceOf, measure } from "./measures.mjs";
import { readMesh } from "./readers.mjs";

const folder = mkdtempSync(join(tmpdir(), "kdstream-strangers-"));
after(() => rmSync(folder, { recursive: true, force: true }));

const run = (name, ...options) => spawnSync(join(process.env.KDSTREAM_PROGRAMS, name), options, { encoding: "utf8" });

// What our programs make of a file: { mesh, said }, or { error }.
function throughTheStore(file, name) {
  const store = join(folder, `${name}.kds`);
  const built = run("kdstream-build", file, "-o", store);
  if (built.status !== 0) {
    assert.ok(built.status > 0, `kdstream-build ended by a signal: ${built.signal}`);
    return { error: built.stderr };
  }
  return { mesh: extracted(store, ".ply"), said: built.stderr, store };
}

function extracted(store, ending) {
  const out = store.replace(/\.kds$/, ending);
  const done = run("kdstream-store", "extract", store, "--all", "-o", out, "--quiet");
  assert.equal(done.status, 0, done.stderr);
  return readMesh(out);
}

// Places may differ by the grid's step, and by the precision that floats far from the origin have lost.
const stepOf = ({ low, high }) => 1e-4 * Math.max(1e-9, ...high.map((value, i) => value - low[i]));

function check(file, name, { right = {}, says, silent, refused, colors, comesBack, isRead = true, mustRefuse = false }) {
  const { mesh, said, store, error } = throughTheStore(file, name);
  if (refused && error !== undefined) {
    assert.match(error, refused);
    return;
  }
  assert.ok(!mustRefuse, said);
  assert.equal(error, undefined, error);
  const found = measure(mesh);
  const step = stepOf(found.box);
  if (isRead) {
    assert.equal(differenceOf(found, measure(readMesh(file)), step), "", said);
  }
  const known = { ...found, ...right };
  assert.equal(differenceOf(found, known, step), "", said);
  says && assert.match(said, says);
  silent && assert.doesNotMatch(said, silent);
  comesBack && assert.equal(differenceOf(measure(extracted(store, comesBack)), known, step), "");
  if (colors) {
    assert.deepEqual([...new Set(mesh.colors.map(String))].sort(), colors.map(String).sort());
  }
}

for (const [number, each] of cases.entries()) {
  test(each.name, () => {
    const home = join(folder, String(number));
    mkdirSync(home);
    for (const [name, bytes] of Object.entries(each.files)) {
      mkdirSync(dirname(join(home, name)), { recursive: true });
      writeFileSync(join(home, name), bytes);
    }
    check(join(home, each.file), `own-${number}`, each);
  });
}

// ---- cases from elsewhere: known values in addition to those that the small reader finds

const others = process.env.KDSTREAM_CASES ?? "";
const known = {
  "gltf-meshopt-fallback": { refused: /meshopt/, right: { volume: 8 } },
  "ply-utm-stray": { right: { unused: 1 } },
  "las-count0": { mustRefuse: true, refused: /counts no points.*300/ },
  "las-count-less": { says: /200 points .* header does not count them/ },
  "las-8bit-one-bright": { colors: [[200, 100, 50], [255, 100, 50]] },
  "gltf-specgloss": { silent: /SpecularGlossiness/, colors: [[255, 0, 0]] },
  "gltf-far": { comesBack: ".glb" },
  "mtl-bom": { colors: [[255, 0, 0]] },
  // Mixed in linear light.
  "mtl-hash": { colors: [[137, 0, 225], [170, 0, 203], [188, 0, 188], [203, 0, 170], [225, 0, 137], [231, 0, 124]] },
  "obj-f2": { says: /1 face has fewer than three corners/ },
  "obj-index0": { says: /2 faces name texture coordinates/ },
  "pcd-padded": { says: /496 zeros after the end/ },
  "ply-float-color": { colors: [[255, 0, 0]] },
  "ply-nan-mesh": { says: /1 point is not finite/ },
  "stl-trailing": { says: /2 bytes after the end/ },
  "tex-case": { says: /original keeps the pictures/, silent: /is not there/ },
  "tex-quoted": { says: /original keeps the pictures/, silent: /is not there/ },
  "wrl-tetra-facecolor": { colors: [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 0]] },
  "xyz-cc-order": { says: /could be "x y z intensity r g b" too/, colors: [[255, 0, 0]] },
  "xyz-decimalcomma": { says: /decimal commas/ },
};
for (const name of others && existsSync(others) ? readdirSync(others).sort() : []) {
  const file = name.includes(".") ? undefined : readdirSync(join(others, name)).find((each) => /^a\.(?!mtl$)/.test(each));
  file && test(name, () => check(join(others, name, file), name, known[name] ?? {}));
}
