// SPDX-License-Identifier: BSD-3-Clause
// The cost of kdstream-store export --format 3dtiles: seconds and memory compared with the build; tiles and bytes of
// each level; the tiles' bytes compared with gltfpack's; pictures in 3d-tiles-renderer compared with kdstream-view's;
// the bytes of a view compared with ours; and the memory of a browser that flies over the largest model.
//
//   node tiles.mjs PROGRAMS FOLDER MESH...    FOLDER: for stores and tilesets, which are removed again, and pictures,
//                                             which stay. Bytes are for views of the first mesh; the flight is over
//                                             the last one
//
// Exit code 1 if a tile is wrong or a limit is missed.
import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, readdirSync, rmSync, statSync } from "node:fs";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { checkTileset, flyOver, measureBytes, showClients } from "../Browser/tile-clients.mjs";

const [programs, folder, ...meshes] = process.argv.slice(2);
const here = path.dirname(fileURLToPath(import.meta.url));
const mostValidated = 300; // tiles of each tileset
const mostPacked = 60;
const cache = 100; // MB, for 3d-tiles-renderer in flight

// Runs a program. Returns its seconds (elapsed and processor time) and its peak memory in MB, as the system counts
// them.
function measure(program, ...words) {
  const begin = process.hrtime.bigint();
  const child = spawn(path.join(programs, program), words, { stdio: ["ignore", "ignore", "inherit"] });
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
    const seconds = Number(process.hrtime.bigint() - begin) / 1e9;
    code === 0 ? done({ seconds, megabytes: peak / 1000 }) : fail(new Error(`${program} ${words.join(" ")}: ${code}`));
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

// Compares tiles of a tileset with the same tiles packed by gltfpack; returns the kB of all compared ones. Both have
// positions of 16 bits in a tile's box, so that errors are equal, normals of 8 bits, and texture coordinates of 12 bits
// (gltfpack's default; ours have 16).
function comparePacked(packed, plain, gltfpack) {
  const files = readdirSync(plain, { recursive: true }).filter((file) => file.endsWith(".glb")).sort();
  const every = Math.ceil(files.length / mostPacked);
  const sums = { tiles: 0, ours: 0, theirs: 0, floats: 0 };
  const out = path.join(folder, "packed.glb");
  for (const file of files.filter((_, i) => i % every === 0)) {
    const { status } = spawnSync(gltfpack, ["-i", path.join(plain, file), "-o", out, "-c", "-vp", "16"], { stdio: "ignore" });
    if (status === 0) {
      sums.tiles += 1;
      sums.ours += statSync(path.join(packed, file)).size;
      sums.theirs += statSync(out).size;
      sums.floats += statSync(path.join(plain, file)).size;
    }
  }
  return sums;
}

// The bytes that our own viewer fetches of the dragon for the same cameras: recorded figures of ./dev bench view.
function ownViews() {
  const kept = path.join(here, "Figures");
  const tables = readdirSync(kept).filter((name) => name.startsWith("view-")).sort().reverse()
    .flatMap((name) => JSON.parse(readFileSync(path.join(kept, name), "utf8")).tables);
  const rows = tables.find(({ title }) => title.startsWith("the dragon ("))?.rows ?? [];
  return (zoom) => {
    const row = rows.find(([label]) => label === `zoom ${zoom}`) ?? [];
    return { few: row[2]?.split(",")[0] || "never", settled: row[4] ?? "-", bytes: row[6]?.split(",")[0] ?? "-" };
  };
}

let misses = 0;
function bar(what, value, most) {
  misses += value <= most ? 0 : 1;
  console.log(`${what}: ${value.toFixed(2)} of ${most}${value <= most ? "" : ", MISSED"}`);
}

mkdirSync(folder, { recursive: true });
const gltfpack = [path.join(here, "Phone/node_modules/.bin/gltfpack")].find(existsSync);
const costs = [], levels = [], peers = [], pictures = [], bars = [];
for (const mesh of meshes) {
  const name = path.parse(mesh).name;
  const store = path.join(folder, `${name}.kds`);
  const built = await measure("kdstream-build", mesh, "-o", store, "--quiet");
  costs.push([`${name}, build`, built.seconds.toFixed(1), "1.00", built.megabytes.toFixed(0), "-", megabytes(statSync(store).size)]);
  const tilesets = {};
  for (const compression of mesh === meshes.at(-1) ? ["meshopt"] : ["meshopt", "draco", "none"]) {
    const tiles = tilesets[compression] = path.join(folder, `${name}-${compression}`);
    const cost = await measure("kdstream-store", "export", store, tiles, "--format", "3dtiles", "--compression", compression, "--quiet");
    const files = readdirSync(tiles, { recursive: true }).filter((file) => file.endsWith(".glb"));
    costs.push([`${name}, ${compression}`, cost.seconds.toFixed(1), (cost.seconds / built.seconds).toFixed(2), cost.megabytes.toFixed(0),
      String(files.length), megabytes(bytesIn(tiles))]);
    if (compression === "meshopt") {
      bars.push([`${name}: seconds of the export over those of the build`, cost.seconds / built.seconds, 2]);
    }
    if (compression !== "none") {
      const checked = await checkTileset(programs, store, tiles, Math.ceil(files.length / mostValidated));
      bars.push([`${name}, ${compression}: wrong tiles (${checked.validated} of ${checked.tiles} validated and decoded)`, checked.wrong.length, 0]);
      checked.wrong.slice(0, 5).forEach((line) => console.error(line));
      for (const [level, { tiles: count, triangles, bytes }] of compression === "meshopt" ? checked.levels : []) {
        levels.push([`${name} ${level}`, String(count), String(triangles), kilobytes(bytes)]);
      }
    }
  }
  if (tilesets.none && gltfpack) {
    const { tiles, ours, theirs, floats } = comparePacked(tilesets.meshopt, tilesets.none, gltfpack);
    peers.push([name, String(tiles), kilobytes(ours), kilobytes(theirs), kilobytes(floats)]);
  }
  for (const { turn, zoom, own, shown } of await showClients(programs, store, tilesets.meshopt, path.join(folder, "pictures"))) {
    const { triangles, mean, alone } = shown[0];
    pictures.push([`${name}, direction ${turn}, zoom ${zoom}`, String(triangles), String(own.triangles), mean.toFixed(2), `${(100 * alone).toFixed(2)} %`]);
    bars.push([`${name}, zoom ${zoom}: mean difference from kdstream-view's picture, of 255`, mean, 10]);
  }
  if (mesh === meshes[0]) {
    const own = ownViews();
    const rows = (await measureBytes(programs, store, tilesets.meshopt)).map(({ zoom, first, few, settled, bytes, triangles }) =>
      [`zoom ${zoom}`, kilobytes(first), few < Infinity ? kilobytes(few) : "never", own(zoom).few, `${(100 * settled).toFixed(2)} %`, own(zoom).settled,
        kilobytes(bytes), own(zoom).bytes, String(triangles)]);
    print(`${name} in 3d-tiles-renderer, an error of 1 pixel: kB, the most of 2 directions; ours: kept medians of ./dev bench view`,
      ["", "first picture", "until 5 % wrong", "ours", "wrong in the end", "ours in the end", "all kB", "all of ours", "triangles"], rows);
  }
  if (mesh === meshes.at(-1)) {
    const most = await flyOver(tilesets.meshopt, cache);
    print(`A flight over ${name} in 3d-tiles-renderer with a cache of ${cache} MB: largest MB`,
      ["", "heap", "buffers", "heap and buffers", "the page's process", "cache", "triangles", "fetched"],
      [[name, megabytes(most.heap), megabytes(most.buffers), megabytes(most.both), megabytes(most.process), megabytes(most.cached), String(most.triangles), megabytes(most.bytes)]]);
    bars.push([`${name}: MB of JavaScript's heap and its buffers in flight`, most.both / 1e6, 300]);
  }
  Object.values(tilesets).forEach((tiles) => rmSync(tiles, { recursive: true }));
  rmSync(store);
}
print("Writing a tileset beside the build (bar: at most 2 times its seconds)", ["model, what", "seconds", "of the build", "peak MB", "tiles", "MB"], costs);
print("Tiles of each level, by meshopt; triangles without skirts", ["model and level", "tiles", "triangles", "kB"], levels);
if (gltfpack) {
  print("Tiles beside the same ones by gltfpack -c -vp 16 (npm), kB", ["model", "tiles", "meshopt", "gltfpack", "floats"], peers);
}
print(`Pictures in 3d-tiles-renderer beside kdstream-view's of the same camera, an error of 1 pixel (${path.join(folder, "pictures")})`,
  ["", "triangles", "kdstream-view's", "mean difference, of 255", "pixels of one outline alone"], pictures);
console.log("");
bars.forEach((each) => bar(...each));
process.exitCode = misses > 0 ? 1 : 0;
