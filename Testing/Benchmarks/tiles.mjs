// SPDX-License-Identifier: BSD-3-Clause
// What kdstream-store export --format 3dtiles costs: seconds and memory beside the build, tiles and bytes of each level, and the bytes
// of a level beside gltfpack's.
//
//   node tiles.mjs PROGRAMS FOLDER MESH...    FOLDER: for stores and tilesets, which are removed again
import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, readdirSync, rmSync, statSync } from "node:fs";
import path from "node:path";
import { fileURLToPath } from "node:url";

const [programs, folder, ...meshes] = process.argv.slice(2);
const here = path.dirname(fileURLToPath(import.meta.url));

// Its seconds and its peak in MB, as the system counts it.
function measure(program, ...words) {
  const begin = process.hrtime.bigint();
  const child = spawn(path.join(programs, program), words, { stdio: ["ignore", "ignore", "inherit"] });
  let peak = 0;
  const look = () => {
    try {
      peak = Math.max(peak, Number(/VmHWM:\s*(\d+)/.exec(readFileSync(`/proc/${child.pid}/status`, "utf8"))?.[1] ?? 0));
    } catch {
      // it has ended
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

function findGltfpack() {
  return [path.join(here, "Phone/node_modules/.bin/gltfpack")].find(existsSync);
}

mkdirSync(folder, { recursive: true });
const costs = [], levels = [], peers = [];
const gltfpack = findGltfpack();
for (const mesh of meshes) {
  const name = path.parse(mesh).name;
  const store = path.join(folder, `${name}.kds`);
  const built = await measure("kdstream-build", mesh, "-o", store, "--quiet");
  costs.push([`${name}, build`, built.seconds.toFixed(1), "1.00", built.megabytes.toFixed(0), "-", (statSync(store).size / 1e6).toFixed(1)]);
  for (const compression of ["meshopt", "draco", "none"]) {
    const tiles = path.join(folder, `${name}-${compression}`);
    const cost = await measure("kdstream-store", "export", store, tiles, "--format", "3dtiles", "--compression", compression, "--quiet");
    const files = readdirSync(tiles, { recursive: true }).filter((file) => file.endsWith(".glb"));
    costs.push([`${name}, ${compression}`, cost.seconds.toFixed(1), (cost.seconds / built.seconds).toFixed(2), cost.megabytes.toFixed(0),
      String(files.length), (bytesIn(tiles) / 1e6).toFixed(1)]);
    if (compression === "meshopt") {
      const folders = readdirSync(tiles, { withFileTypes: true }).filter((entry) => entry.isDirectory()).map((entry) => entry.name);
      for (const level of folders.sort((a, b) => (Number(a) || Infinity) - (Number(b) || Infinity))) {
        const own = readdirSync(path.join(tiles, level)).filter((file) => file.endsWith(".glb"));
        const sizes = own.map((file) => statSync(path.join(tiles, level, file)).size);
        levels.push([`${name} ${level}`, String(own.length), (sizes.reduce((sum, size) => sum + size, 0) / 1000).toFixed(0),
          (Math.max(...sizes) / 1000).toFixed(0)]);
      }
      const middle = folders.filter(Number).map(Number).sort((a, b) => a - b).at(-1); // the finest level
      const files = {};
      for (const kind of ["meshopt", "draco", "none"]) {
        files[kind] = path.join(folder, `${name}-${kind}.glb`);
        await measure("kdstream-store", "export", store, files[kind], "--format", "glb", "--level", String(middle), "--compression", kind, "--quiet");
      }
      const kilobytes = (file) => (statSync(file).size / 1000).toFixed(0);
      if (gltfpack) {
        // as many bits a coordinate
        const packed = path.join(folder, `${name}-packed.glb`);
        const { status } = spawnSync(gltfpack, ["-i", files.none, "-o", packed, "-c", "-vp", "16"], { stdio: "ignore" });
        peers.push([`${name} ${middle}`, kilobytes(files.meshopt), kilobytes(files.draco), status === 0 ? kilobytes(packed) : "-", kilobytes(files.none)]);
      } else {
        peers.push([`${name} ${middle}`, kilobytes(files.meshopt), kilobytes(files.draco), "-", kilobytes(files.none)]);
      }
      Object.values(files).forEach((file) => rmSync(file));
    }
    rmSync(tiles, { recursive: true });
  }
  rmSync(store);
}
print("Writing a tileset beside the build (bar: at most 2 times its seconds)", ["model, what", "seconds", "of the build", "peak MB", "tiles", "MB"], costs);
print("Tiles of each level, by meshopt", ["model and level", "tiles", "kB", "largest kB"], levels);
print(`The finest level as one file, kB${gltfpack ? "" : " (gltfpack is not installed)"}`, ["model and level", "meshopt", "draco", "gltfpack -c", "floats"], peers);
