// SPDX-License-Identifier: BSD-3-Clause
// Tilesets by kdstream-store export --format 3dtiles, in parts:
//
//   write     seconds and memory compared with the build; tiles and bytes of each level; whether tiles are valid and right
//   peers     the tiles' bytes compared with gltfpack's
//   pictures  in 3d-tiles-renderer, compared with kdstream-view's
//   bytes     of a view in 3d-tiles-renderer, compared with our viewer's (BenchView); and whether there are cracks
//   flight    the memory of a browser that flies over the last model
//
//   node tiles.mjs PROGRAMS FOLDER [--only PART,...] MESH...    FOLDER: for stores and tilesets, which are removed again,
//                                                               and pictures, which stay
//
// Exit code 1 if a tile is wrong or a limit is missed.
import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, readdirSync, rmSync, statSync } from "node:fs";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { checkTileset, flyOver, measureBytes, measureEmptyPages, showClients, turns } from "../Browser/tile-clients.mjs";

const parts = ["write", "peers", "pictures", "bytes", "flight"];
const [programs, folder, ...words] = process.argv.slice(2);
const chosen = words[0] === "--only" ? words.splice(0, 2)[1]?.split(",") ?? [] : parts;
const meshes = words;
if (meshes.length === 0 || chosen.length === 0 || !chosen.every((part) => parts.includes(part))) {
  console.error(`usage: tiles.mjs PROGRAMS FOLDER [--only PART,...] MESH...; parts: ${parts.join(", ")}`);
  process.exit(2);
}
const here = path.dirname(fileURLToPath(import.meta.url));
const mostValidated = 300; // tiles of each tileset
const mostPacked = 60;
// What doc/3dtiles.md recommends where memory is short.
const sparing = { cache: 60, partition: 8000 }; // MB; vertices

// The seconds of processors of all child processes that have ended.
function secondsOfChildren() {
  const fields = readFileSync("/proc/self/stat", "utf8").replace(/.*\) /, "").split(" ");
  return (Number(fields[13]) + Number(fields[14])) / 100;
}

// Runs a program. Returns its seconds of processors, elapsed ones, and its peak memory in MB, as the system counts them.
function measure(program, ...options) {
  const begin = process.hrtime.bigint(), before = secondsOfChildren();
  const child = spawn(path.join(programs, program), options, { stdio: ["ignore", "ignore", "inherit"] });
  let peak = 0;
  const look = () => {
    try {
      peak = Math.max(peak, Number(/VmHWM:\s*(\d+)/.exec(readFileSync(`/proc/${child.pid}/status`, "utf8"))?.[1] ?? 0));
    } catch {
      // the process has ended
    }
  };
  const timer = setInterval(look, 20);
  return new Promise((done, fail) => child.on("error", fail).on("exit", (code) => {
    clearInterval(timer);
    const elapsed = Number(process.hrtime.bigint() - begin) / 1e9;
    code === 0 ? done({ seconds: secondsOfChildren() - before, elapsed, megabytes: peak / 1000 }) : fail(new Error(`${program} ${options.join(" ")}: ${code}`));
  }));
}

const bytesIn = (folder) => readdirSync(folder, { recursive: true }).map((name) => statSync(path.join(folder, name)))
  .reduce((sum, stat) => sum + (stat.isFile() ? stat.size : 0), 0);

function print(title, columns, rows) {
  const widths = columns.map((column, i) => Math.max(...[column, ...rows.map((row) => row[i])].map((cell) => cell.length)));
  console.log(`\n${title}\n`);
  for (const row of [columns, ...rows]) {
    console.log(row.map((cell, i) => cell.padEnd(widths[i])).join("  ").trimEnd());
  }
}

const kilobytes = (bytes) => (bytes / 1e3).toFixed(0);
const megabytes = (bytes) => (bytes / 1e6).toFixed(1);

// Compares tiles of a tileset with the same tiles packed by gltfpack; returns the bytes of all compared ones. Both have
// positions of 16 bits in a tile's box, so that errors are equal, normals of 8 bits, colours and texture coordinates of 16.
function comparePacked(packed, plain) {
  const gltfpack = path.join(here, "Phone/node_modules/.bin/gltfpack");
  const files = readdirSync(plain, { recursive: true }).filter((file) => file.endsWith(".glb")).sort();
  const every = Math.ceil(files.length / mostPacked);
  const sums = { tiles: 0, ours: 0, plain: 0, tight: 0, floats: 0 };
  const out = path.join(folder, "packed.glb");
  const pack = (file, how) => {
    const options = ["-i", path.join(plain, file), "-o", out, how, "-vp", "16", "-vt", "16", "-vc", "16"];
    const { status, stderr, error } = spawnSync(gltfpack, options, { stdio: ["ignore", "ignore", "pipe"], encoding: "utf8" });
    if (status !== 0) {
      throw new Error(`gltfpack ${options.join(" ")}: ${error ?? stderr}`);
    }
    return statSync(out).size;
  };
  for (const file of files.filter((_, i) => i % every === 0)) {
    sums.tiles += 1;
    sums.ours += statSync(path.join(packed, file)).size;
    sums.plain += pack(file, "-c");
    sums.tight += pack(file, "-cc");
    sums.floats += statSync(path.join(plain, file)).size;
  }
  rmSync(out, { force: true });
  return sums;
}

// The bytes that our viewer fetches from the same directions, by zoom; the larger ones.
function ownBytes(stores, name) {
  const bench = path.join(programs, "BenchView");
  const { status, stderr, error } = spawnSync(bench, [stores, folder, "--directions", turns.join(), name], { encoding: "utf8" });
  if (status !== 0) {
    throw new Error(`BenchView ${name}: ${error ?? stderr}`);
  }
  const looks = new Map(); // samples of a zoom and direction
  for (const line of readFileSync(path.join(folder, `view-${name}.tsv`), "utf8").trim().split("\n").slice(1)) {
    const [direction, zoom, detail, , bytes, , wrong] = line.split("\t");
    if (detail === "view") {
      const key = `${zoom} ${direction}`;
      looks.set(key, [...(looks.get(key) ?? []), { bytes: Number(bytes), wrong: Number(wrong) }]);
    }
  }
  return (zoom) => {
    const most = { first: 0, few: 0, settled: 0, bytes: 0 };
    for (const samples of [...looks].filter(([key]) => key.startsWith(`${zoom} `)).map(([, list]) => list)) {
      const few = samples[samples.findLastIndex(({ wrong }) => wrong > 0.05) + 1]?.bytes ?? Infinity;
      const look = { first: samples[0].bytes, few, settled: samples.at(-1).wrong, bytes: samples.at(-1).bytes };
      Object.keys(most).forEach((key) => (most[key] = Math.max(most[key], look[key])));
    }
    return most;
  };
}

let misses = 0;
function bar(what, value, most) {
  misses += value <= most ? 0 : 1;
  console.log(`${what}: ${value.toFixed(2)} of ${most}${value <= most ? "" : ", MISSED"}`);
}

const stores = path.join(folder, "stores");
mkdirSync(stores, { recursive: true });
const tables = { costs: [], levels: [], peers: [], pictures: [], bytes: [] }, bars = [];

// A mesh with its store, and its tilesets by compression, which are made when they are needed.
class Model {
  tilesets = new Map();
  constructor(mesh) {
    this.name = path.parse(mesh).name;
    this.store = path.join(stores, `${this.name}.kds`);
    this.mesh = mesh;
  }
  async build(...options) {
    this.built = await measure("kdstream-build", this.mesh, "-o", this.store, "--quiet", ...options);
  }
  async tileset(compression) {
    if (!this.tilesets.has(compression)) {
      const tiles = path.join(folder, `${this.name}-${compression}`);
      const cost = await measure("kdstream-store", "export", this.store, tiles, "--format", "3dtiles", "--compression", compression, "--quiet");
      const count = readdirSync(tiles, { recursive: true }).filter((file) => file.endsWith(".glb")).length;
      this.tilesets.set(compression, { tiles, cost, count });
    }
    return this.tilesets.get(compression);
  }
  remove() {
    this.tilesets.forEach(({ tiles }) => rmSync(tiles, { recursive: true }));
    this.tilesets.clear();
    rmSync(this.store);
  }
}

async function write(model, compressions) {
  const { name, store, built } = model;
  const row = (what, { seconds, elapsed, megabytes: peak }, count, bytes) => tables.costs.push([`${name}, ${what}`, seconds.toFixed(1), (seconds / built.seconds).toFixed(2),
    elapsed.toFixed(1), peak.toFixed(0), count, megabytes(bytes)]);
  row("build", built, "-", statSync(store).size);
  for (const compression of compressions) {
    const { tiles, cost, count } = await model.tileset(compression);
    row(compression, cost, String(count), bytesIn(tiles));
    if (compression !== "none") {
      const checked = await checkTileset(programs, store, tiles, Math.ceil(count / mostValidated));
      bars.push([`${name}, ${compression}: wrong tiles (${checked.validated} of ${checked.tiles} validated and decoded)`, checked.wrong.length, 0]);
      checked.wrong.slice(0, 5).forEach((line) => console.error(line));
      if (compression === "meshopt") {
        bars.push([`${name}: seconds of the export over those of the build`, cost.seconds / built.seconds, 2]);
        const levels = [...checked.levels].sort(([a], [b]) => (a === "original") - (b === "original") || a - b);
        levels.forEach(([level, { tiles: each, triangles, bytes }]) => tables.levels.push([`${name} ${level}`, String(each), String(triangles), kilobytes(bytes)]));
        const grown = levels.slice(1).filter(([, { tiles: each }], i) => each <= levels[i][1].tiles);
        bars.push([`${name}: levels with no more tiles than the next coarser one`, grown.length, 0]);
      }
    }
  }
}

async function comparePeers(model) {
  const [packed, plain] = [await model.tileset("meshopt"), await model.tileset("none")];
  const sums = comparePacked(packed.tiles, plain.tiles);
  tables.peers.push([model.name, String(sums.tiles), kilobytes(sums.ours), kilobytes(sums.plain), kilobytes(sums.tight), kilobytes(sums.floats)]);
  bars.push([`${model.name}: bytes of tiles over gltfpack's`, sums.ours / sums.plain, 1]);
}

async function comparePictures({ name, store }, tiles) {
  for (const { turn, zoom, own, shown } of await showClients(programs, store, tiles, path.join(folder, "pictures"))) {
    const { triangles, mean, alone } = shown[0];
    tables.pictures.push([`${name}, direction ${turn}, zoom ${zoom}`, String(triangles), String(own.triangles), mean.toFixed(2), `${(100 * alone).toFixed(2)} %`]);
    bars.push([`${name}, zoom ${zoom}: mean difference from kdstream-view's picture, of 255`, mean, 10]);
  }
}

async function compareBytes({ name, store }, tiles) {
  const own = ownBytes(stores, name);
  const unlessNever = (bytes) => (bytes < Infinity ? kilobytes(bytes) : "- never");
  let holes = 0, count = 0;
  for (const view of await measureBytes(programs, store, tiles)) {
    const ours = own(view.zoom);
    tables.bytes.push([`${name}, zoom ${view.zoom}`, unlessNever(view.few), unlessNever(ours.few), kilobytes(view.first), kilobytes(ours.first),
      `${(100 * view.settled).toFixed(2)} %`, `${(100 * ours.settled).toFixed(2)} %`, kilobytes(view.bytes), kilobytes(ours.bytes), String(view.triangles)]);
    holes += view.holes;
    count += view.pictures;
  }
  bars.push([`${name}: pixels of background that shine through, in ${count} pictures or more while tiles arrive`, holes, 0]);
}

async function fly(model, tiles) {
  const rowOf = (what, { page, card }, ...more) => [what, megabytes(page.own), megabytes(page.shared), megabytes(page.files), megabytes(card.own), ...more];
  const { blank, scene } = await measureEmptyPages();
  const rows = [rowOf("an empty tab", blank, ...Array(5).fill("-")), rowOf("an empty scene of three.js", scene, ...Array(5).fill("-"))];
  const fliesOver = async (what, ...options) => {
    const most = await flyOver(...options);
    rows.push(rowOf(what, most, megabytes(most.kept), megabytes(most.heap), megabytes(most.buffers), String(most.triangles), megabytes(most.bytes)));
    return most.page.own / 1e6;
  };
  await fliesOver("default settings", tiles, 0, "plain");
  await fliesOver("settings that spare memory", tiles, sparing.cache, "sparing");
  model.remove();
  await model.build("--vertices-per-partition", String(sparing.partition));
  const large = await model.tileset("meshopt");
  const own = await fliesOver(`the same, ${sparing.partition} vertices a partition`, large.tiles, sparing.cache, "sparing");
  bars.push([`${model.name}: MB of the page's own memory in flight`, own, 300]);
  print(`A flight of 48 views over ${model.name} in 3d-tiles-renderer, an error of 1 pixel: largest MB`,
    ["", "the page's own", "shared", "files", "of the process that draws", "own without garbage", "heap", "buffers", "triangles", "fetched"], rows);
}

for (const mesh of meshes) {
  const isLast = mesh === meshes.at(-1);
  const last = { write: true, pictures: true, flight: isLast, bytes: !isLast || meshes.length === 1, peers: !isLast || meshes.length === 1 };
  const wants = (part) => chosen.includes(part) && last[part];
  if (!parts.some(wants)) {
    continue;
  }
  const model = new Model(mesh);
  console.error(`${model.name}: ${parts.filter(wants).join(", ")}`);
  await model.build();
  const { tiles } = await model.tileset("meshopt");
  if (wants("write")) {
    await write(model, isLast && meshes.length > 1 ? ["meshopt"] : ["meshopt", "draco", "none"]);
  }
  if (wants("peers")) {
    await comparePeers(model);
  }
  if (wants("pictures")) {
    await comparePictures(model, tiles);
  }
  if (wants("bytes")) {
    await compareBytes(model, tiles);
  }
  if (wants("flight")) {
    await fly(model, tiles);
  }
  model.remove();
}
rmSync(stores, { recursive: true });

const printIfAny = (title, columns, rows) => rows.length > 0 && print(title, columns, rows);
printIfAny("Writing a tileset beside the build (bar: at most 2 times its seconds of processors)",
  ["model, what", "seconds of processors", "of the build", "elapsed", "peak MB", "tiles", "MB"], tables.costs);
printIfAny("Tiles of each level, by meshopt; triangles without skirts", ["model and level", "tiles", "triangles", "kB"], tables.levels);
printIfAny("Tiles beside the same ones by gltfpack (npm) with -vp 16 -vt 16 -vc 16, kB", ["model", "tiles", "ours", "gltfpack -c", "gltfpack -cc", "floats"], tables.peers);
printIfAny("Pictures in 3d-tiles-renderer beside kdstream-view's of the same camera, an error of 1 pixel",
  ["", "triangles", "kdstream-view's", "mean difference, of 255", "pixels of one outline alone"], tables.pictures);
printIfAny("kB until at most 5 % of the pixels are wrong in 3d-tiles-renderer with our tileset, beside our viewer: an error of 1 pixel in both, the larger of 2 directions",
  ["", "until 5 % wrong", "our viewer", "first picture", "our viewer's first", "wrong in the end", "our viewer's wrong", "all kB", "our viewer's all", "triangles"], tables.bytes);
console.log("");
bars.forEach((each) => bar(...each));
process.exitCode = misses > 0 ? 1 : 0;
