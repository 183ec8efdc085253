// SPDX-License-Identifier: BSD-3-Clause
// The page of figures is what its runs give, and tables that benchmarks print become columns and rows.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { pageFiles, parseTables } from "./figures.mjs";

test("doc/benchmarks.md and its plots are up to date", () => {
  const checked = spawnSync(process.execPath, [fileURLToPath(new URL("figures.mjs", import.meta.url)), "check"], { encoding: "utf8" });
  assert.equal(checked.status, 0, checked.stderr);
});

test("of two runs of a table the page has the newer one, and its plot has both", () => {
  const runOf = (date, seconds) => [`trees-${date}.json`, { date, machine: "m", command: "c", tables: [
    { title: "the same", columns: ["mesh", "seconds", "more"], show: [0, 1], showRows: [0, 2], plot: [1],
      rows: [["dragon", seconds, "x"], ["left out", "5", "x"], ["relief", "7", "x"]] },
    { title: `only of ${date}`, columns: ["mesh", "seconds"], show: [], rows: [["vase", "8"]], plot: [1] }] }];
  const files = pageFiles([runOf("2026-01-01", "3"), runOf("2026-02-01", "2")]);
  const page = files.get("doc/benchmarks.md").split("\n");
  assert.deepEqual(page.filter((line) => line.startsWith("|")), ["| mesh | seconds |", "|---|---|", "| dragon | 2 |", "| relief | 7 |"]);
  assert.deepEqual(page.filter((line) => line.endsWith(":") && !line.startsWith("**")), ["The same:", "Only of 2026-02-01:", "Only of 2026-01-01:"]);
  assert.deepEqual([...files.keys()], ["doc/pictures/benchmarks/trees-2026-02-01-1.svg", "doc/pictures/benchmarks/trees-2026-02-01-2.svg",
    "doc/pictures/benchmarks/trees-2026-01-01-2.svg", "doc/benchmarks.md"]);
  const numbers = [...files.get("doc/pictures/benchmarks/trees-2026-02-01-1.svg").matchAll(/>(2026-01-01|[\d.]+)<\/text>/g)].map((found) => found[1]);
  assert.deepEqual(numbers, ["2026-01-01", "2", "3", "5", "5", "7", "7"]);
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
