// SPDX-License-Identifier: BSD-3-Clause
// Compares the page on a phone's screen with three.js and vtk.js, which show the same mesh from a file (./dev bench
// phone):
//   node phone.mjs OUT [--rounds N] [--sizes 100000,300000,1000000] [--lines loopback,mobile]
// Each viewer opens in a browser of its own, one after the other, on the same processors, so compare ratios. Graphics
// are software (SwiftShader), which they are not on a phone. Needs the environment of Testing/Browser/harness.mjs, and
// npm ci in both folders.
//
// 1. Meshes: kdstream-generate relief, as a store, a PLY and a GLB.
// 2. For each round, line, size and viewer: measure (contestants.mjs), over a line (line.mjs).
// 3. Medians of the rounds, as Markdown and CSV, into OUT (tables.mjs).

import { spawnSync } from "node:child_process";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { Server, buildStore, runProgram, temporaryFolder } from "../../Browser/harness.mjs";
import { contestants, measure } from "./contestants.mjs";
import { FileServer, makeGlb, pageOf, readRelief } from "./files.mjs";
import { Line } from "./line.mjs";
import { median, quantile, summarize, toCsv, toMarkdown } from "./tables.mjs";

const lines = {
  loopback: { name: "Loopback", shape: {} },
  mobile: { name: "10 Mbit/s, 30 ms", shape: { rate: 10e6 / 8, roundTrip: 30 } },
};

function fail(message) {
  console.error(`phone: error: ${message}`);
  process.exit(2);
}

function readOptions([out, ...rest]) {
  const options = { out, rounds: 3, sizes: [100_000, 300_000, 1_000_000], lines: Object.keys(lines) };
  for (let i = 0; i < rest.length; i += 2) {
    const value = rest[i + 1] ?? fail(`${rest[i]}: a value is needed`);
    const readers = {
      "--rounds": () => (options.rounds = Number(value)),
      "--sizes": () => (options.sizes = value.split(",").map(Number)),
      "--lines": () => (options.lines = value.split(",")),
    };
    (readers[rest[i]] ?? (() => fail(`${rest[i]}: no such option`)))();
  }
  const whole = [options.rounds, ...options.sizes].every((value) => Number.isInteger(value) && value > 0);
  if (!out || !whole || !options.lines.every((name) => name in lines)) {
    fail("usage: phone.mjs OUT [--rounds N] [--sizes N,...] [--lines loopback,mobile]");
  }
  return options;
}

const nameOf = (triangles) => (triangles < 1e6 ? `${triangles / 1e3}k` : `${triangles / 1e6}M`);

// Makes the folder of stores, and the server with the other viewers' files.
async function makeModels(sizes) {
  const [stores, meshes] = [temporaryFolder(), temporaryFolder()];
  const files = await FileServer.start();
  for (const size of sizes) {
    const name = nameOf(size);
    const mesh = join(meshes, `${name}.ply`);
    runProgram("kdstream-generate", "relief", mesh, "--vertices", String(size / 2), "--quiet");
    buildStore(mesh, join(stores, `${name}.kds`), "--up", "0,1,0", "--view", "0,0,1");
    const relief = readRelief(mesh);
    files.add(`/${name}.ply`, relief.bytes);
    files.add(`/${name}.glb`, makeGlb(relief));
  }
  for (const name of ["three", "vtk"]) {
    const script = join(meshes, `${name}.js`);
    const source = fileURLToPath(new URL(`pages/${name}.js`, import.meta.url));
    const { status, stderr, error } = spawnSync("esbuild", [source, "--bundle", "--minify", "--format=esm", "--target=es2022",
      "--log-level=warning", `--outfile=${script}`], { encoding: "utf8" });
    if (status !== 0) {
      fail(`esbuild: ${error ?? stderr}`);
    }
    files.add(`/${name}.js`, readFileSync(script));
    files.add(`/${name}.html`, pageOf(`${name}.js`));
  }
  return { stores, files };
}

// Replaces the frames of turning by two figures.
function condense({ frames, moreFrames, ...figures }) {
  return { ...figures, ...(frames && { frame: median(frames), frame95: quantile(frames, 0.95) }),
    ...(moreFrames && { moreFrame: median(moreFrames), moreFrame95: quantile(moreFrames, 0.95) }) };
}

// Each round begins with another viewer, so that other work on the machine does not always affect the same one.
const rotated = (all, by) => [...all.slice(by % all.length), ...all.slice(0, by % all.length)];

const { out, rounds, sizes, lines: chosen } = readOptions(process.argv.slice(2));
mkdirSync(out, { recursive: true });
const { stores, files } = await makeModels(sizes);
const server = await Server.start(stores);
const runs = [];
for (let round = 0; round < rounds; ++round) {
  for (const size of sizes.map(nameOf)) {
    for (const where of chosen) {
      for (const contestant of rotated(contestants, round)) {
        const line = await Line.start(contestant.ours ? server.port : files.port, lines[where].shape);
        const picture = `phone-${size}-${contestant.name.replace(/\W+/g, "-")}`;
        const figures = condense(await measure(contestant, size, line, { turns: where === "loopback", picture }));
        await line.stop();
        runs.push({ line: lines[where].name, size, name: contestant.name, ...figures });
        console.error(`round ${round + 1}: ${lines[where].name}, ${size}, ${contestant.name}: first picture ${Math.round(figures.first)} ms`);
      }
    }
  }
  // Written after each round, so that nobody has to wait for the last one.
  writeFileSync(join(out, "phone.md"), toMarkdown(summarize(runs)));
  writeFileSync(join(out, "phone.csv"), toCsv(summarize(runs)));
}
await server.stop();
await files.stop();
console.log(toMarkdown(summarize(runs)));
