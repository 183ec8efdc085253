// SPDX-License-Identifier: BSD-3-Clause
// The page of figures is what its runs make, and tables that benchmarks print become columns and rows.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { parseTables } from "./figures.mjs";

test("doc/benchmarks.md and its plots are up to date", () => {
  const checked = spawnSync(process.execPath, [fileURLToPath(new URL("figures.mjs", import.meta.url)), "check"], { encoding: "utf8" });
  assert.equal(checked.status, 0, checked.stderr);
});

test("a printed table becomes columns and rows", () => {
  const text = [
    "dragon: 437,645 vertices; distances in % of the diagonal",
    "method                            level  vertices     rms to",
    "rounds of collapse                   13      8268     0.0203",
    "vtkQuadricDecimation                 13      8301     0.0203",
    "",
    "mesh             points |        ms | port 1",
    "dragon           437645 |     120.5 |   0.60",
  ].join("\n");
  assert.deepEqual(parseTables(text), [
    { title: "dragon: 437,645 vertices; distances in % of the diagonal", columns: ["method", "level", "vertices", "rms to"],
      rows: [["rounds of collapse", "13", "8268", "0.0203"], ["vtkQuadricDecimation", "13", "8301", "0.0203"]], plot: [1] },
    { title: "dragon: 437,645 vertices; distances in % of the diagonal", columns: ["mesh", "points", "ms", "port 1"],
      rows: [["dragon", "437645", "120.5", "0.60"]], plot: [1] },
  ]);
});
