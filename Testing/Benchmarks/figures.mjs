// SPDX-License-Identifier: BSD-3-Clause
// Figures of benchmarks, in one JSON file for each run of a benchmark, and the page that is made from them.
//
//   node figures.mjs page            writes doc/benchmarks.md and its plots from Testing/Benchmarks/Figures/*.json
//   node figures.mjs check           checks whether they are up to date; if not, prints their names, with exit code 1
//   node figures.mjs record NAME     converts a benchmark's output (out/bench/NAME.txt) to out/bench/NAME.json
//
// A run: {"section","date","machine","command","commit","tables","remarks"}. A table:
// {"title","columns","rows","plot"}. plot is a list of columns whose first numbers become bars, or
// {"unit","bars":[[label,number],...]}. "show" lists the columns that the page shows, "showRows" its rows; without them
// it shows all, and with no columns only the plot. If tables in a section have the same title, the newest is shown, and
// the older ones are bars in its plot. Remarks are kept, but not shown.
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import os from "node:os";
import path from "node:path";
import { fileURLToPath } from "node:url";

const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), "../..");
const folder = path.join(root, "Testing/Benchmarks/Figures");

// For each section: the beginning of its files' names, its heading, and what its benchmark measures.
const sections = [
  ["large-build", "Large builds", "With `--memory 256M` the digest is the same, the peak 276 MB."],
  ["speed", "Building in memory and out of core", "The floor (`BenchFloor.cxx`) reads, builds a k-d tree, puts triangles into partitions and writes one file."],
  ["table2", "Partitions (Table 2)", "The paper's Table 2: compactness and seconds of k-d tree, octree and k-means."],
  ["fig5", "Partitions (Fig. 5)", "Sizes of partitions by k-d tree, octree and k-means."],
  ["table3", "Partitions out of core (Table 3)", "The paper's Table 3: medians of meshes that do not fit the memory."],
  ["fig12", "Clusters (Fig. 12)", "Simplification by k-d cells beside an octree's, as in the paper's Figure 12."],
  ["levels", "Levels", "Levels by collapse and by clusters beside VTK's and meshoptimizer's, and triangles that face the wrong way."],
  ["soup", "Triangle soup", "Building triangles that share no vertices beside a scan of as many vertices."],
  ["readers", "Readers", "Our readers beside VTK's, and beside reading the bytes only."],
  ["trees", "Trees", "An update of `vtkKdTreePartition` beside `vtkKdTree::BuildLocatorFromPoints`."],
  ["codec", "The codec", "Our codec ([why](decisions/0010-codec.md)) beside Draco at speed 5 and plain arrays under zstd -19."],
  ["floors", "Floors and peers", "What a step costs at least, and what other programs take for the same mesh."],
  ["view", "Views", "View-dependent refinement ([how](viewing.md)) from 12 directions, 800 x 480, over simulated lines of 1, 10 and 100 Mbit/s: bytes and seconds until at most 1 % of the object's pixels are wrong (a channel off by more than 8 of 255). The oracle fetches only the final cut.\n\n![Wrong pixels of the dragon over bytes, at zooms of 1, 4 and 16](pictures/view-dragon.png)"],
  ["tiles", "Tilesets", "What `kdstream-store export --format 3dtiles` costs (bar: twice the build's time), its bytes beside gltfpack's, pictures and bytes of views in 3d-tiles-renderer (npm) beside ours ([why they differ](decisions/0042-3d-tiles.md)), and the memory of a page in flight (bar: 300 MB of its own, which is what Chromium's task manager shows, with the [settings that spare memory](3dtiles.md#memory-of-a-browser))."],
  ["paint", "Colours", "Levels of a mesh with vertex colours beside levels by shape only; pictures without light from 24 cameras."],
  ["textures", "Textures", "What tiles of texture cost a build (bar: 2 times the build without)."],
  ["tables456", "Levels and regions over a line", "The paper's Tables 4 to 6 and Figures 10, 11 and 19, over a proxy. The paper measured a phone of 2013 on Wi-Fi.\n\n![Bytes of the partitions of one region, by k-d tree and by octree](pictures/fig10-dragon.png)"],
  ["arrival", "Arrivals", "What one arriving piece costs while 250,000 triangles and more are shown."],
  ["phone", "The page beside three.js and vtk.js", "Balls with relief in Chromium, 412 x 915 points of 3 x 3 pixels: ours streamed, theirs as files, all gzipped."],
  ["serve", "Crowds at a server", "Viewers over loopback open the dragon and act every ten seconds; of thirty two read slowly, one stalls, three vanish. Bars: no failure, nobody else dropped, no descriptor left, at most 16 MiB of growth."],
  ["card", "On a graphics card", "The demo's session drawn by a graphics card and by Mesa's software renderer."],
];

const number = (cell) => {
  const found = /\d{1,3}(?:,\d{3})+(?:\.\d+)?|\d+(?:\.\d+)?/.exec(cell);
  return found ? Number(found[0].replaceAll(",", "")) : null;
};

const escape = (text) => String(text).replaceAll("`", "").replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll('"', "&quot;");

// The bars of a table: series, each with a name and its numbers by row. Rows with the same name are distinguished by
// their order.
function seriesOf(table) {
  const count = new Map();
  const keyOf = (label) => {
    count.set(label, (count.get(label) ?? 0) + 1);
    return `${count.get(label)} ${label}`;
  };
  if (!Array.isArray(table.plot)) {
    return [{ name: table.plot.unit, values: new Map(table.plot.bars.map(([label, value]) => [keyOf(label), value])) }];
  }
  const keys = table.rows.map((row) => keyOf(row[0]));
  return table.plot.map((column) => ({
    name: table.plot.length > 1 ? table.columns[column] : `${table.title}: ${table.columns[column]}`,
    values: new Map(keys.map((key, i) => [key, number(table.rows[i][column] ?? "")])),
  }));
}

// Groups of bars: [label, [number, ...]], with a name for each series. older: [date, table] of tables with the same
// title.
function groupsOf(table, older) {
  const own = seriesOf(table);
  const series = [...own, ...older.map(([date, each]) => ({ name: date, values: seriesOf(each)[0].values }))];
  return {
    names: series.map((each) => each.name),
    groups: [...own[0].values.keys()]
      .map((key) => [key.slice(key.indexOf(" ") + 1), series.map((each) => each.values.get(key) ?? null)])
      .filter(([, values]) => values.some((value) => value !== null)),
  };
}

// Draws horizontal bars. The scale is logarithmic if the numbers span more than two orders of magnitude.
function plotOf(table, older) {
  const { names, groups } = groupsOf(table, older);
  const all = groups.flatMap(([, values]) => values).filter((value) => value > 0);
  const most = Math.max(...all);
  const least = Math.min(...all);
  const logarithmic = most > 100 * least;
  const low = logarithmic ? Math.log10(least) - 0.5 : 0;
  const high = logarithmic ? Math.log10(most) : most;
  const widthOf = (value) => Math.max(1, (430 * ((logarithmic ? Math.log10(value) : value) - low)) / (high - low));
  const colors = ["#2b6cb0", "#c05621", "#2f7d4f", "#805ad5"];
  const colorOf = (i) => colors[i % colors.length];
  const lines = [];
  let y = 8;
  names.forEach((name, i) => {
    lines.push(`<rect x="8" y="${y}" width="10" height="10" fill="${colorOf(i)}"/><text x="24" y="${y + 9}">${escape(name)}${logarithmic ? " (logarithmic)" : ""}</text>`);
    y += 18;
  });
  for (const [label, values] of groups) {
    y += 6;
    lines.push(`<text x="242" y="${y + 7 * values.length + 3}" text-anchor="end">${escape(label.length > 38 ? `${label.slice(0, 37)}…` : label)}</text>`);
    values.forEach((value, i) => {
      if (value !== null && value > 0) {
        const width = widthOf(value).toFixed(1);
        lines.push(`<rect x="250" y="${y}" width="${width}" height="11" fill="${colorOf(i)}"/><text x="${(255 + Number(width)).toFixed(1)}" y="${y + 9}">${value.toLocaleString("en")}</text>`);
      }
      y += 14;
    });
  }
  y += 8;
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 760 ${y}" width="760" height="${y}" font-family="sans-serif" font-size="11" fill="#222"><title>${escape(table.title)}</title><rect width="760" height="${y}" fill="#fff"/>\n${lines.join("\n")}\n</svg>\n`;
}

function tableOf(table) {
  const line = (cells) => `| ${cells.join(" | ")} |`;
  const shown = (cells) => (table.show ?? [...table.columns.keys()]).map((column) => cells[column] ?? "");
  const rows = (table.showRows ?? [...table.rows.keys()]).map((row) => table.rows[row]);
  return [line(shown(table.columns)), `|${"---|".repeat(shown(table.columns).length)}`, ...rows.map((cells) => line(shown(cells)))].join("\n");
}

// The runs in the folder: [name of the file, run].
function keptRuns() {
  return readdirSync(folder)
    .filter((name) => name.endsWith(".json"))
    .map((name) => [name, JSON.parse(readFileSync(path.join(folder, name), "utf8"))]);
}

// The files of the page that is made from these runs: path from the root → text.
export function pageFiles(runs) {
  const stemOf = (name) => name.replace(/-\d{4}-\d\d-\d\d\.json$/, "");
  for (const [name] of runs) {
    if (!sections.some(([stem]) => stem === stemOf(name))) {
      throw new Error(`${name}: no section of that name; files are called NAME-YYYY-MM-DD.json`);
    }
  }
  const files = new Map();
  const text = [
    "# Figures of benchmarks",
    "",
    "`node Testing/Benchmarks/figures.mjs page` makes this page from the runs in `Testing/Benchmarks/Figures` ([how to add one](../CONTRIBUTING.md)),",
    "which have more figures. Seconds are of one machine: compare ratios within a run. A *bar* is what the benchmark demands of itself.",
    "",
  ];
  for (const [stem, heading, about] of sections) {
    const own = runs.filter(([name]) => stemOf(name) === stem).sort(([a], [b]) => (a < b ? 1 : -1));
    if (own.length === 0) {
      continue;
    }
    text.push(`## ${heading}`, "", about, "");
    const seen = new Set();
    for (const [index, [name, run]] of own.entries()) {
      const newest = [...run.tables.entries()].filter(([, table]) => !seen.has(table.title));
      newest.forEach(([, table]) => seen.add(table.title));
      if (newest.length > 0) {
        text.push(`**${run.date}**, \`${run.command}\`, ${run.machine}.`, "");
      }
      for (const [i, table] of newest.filter(([, each]) => each.plot || each.show?.length !== 0)) {
        const title = table.title.startsWith("vtk") ? table.title : table.title[0].toUpperCase() + table.title.slice(1);
        text.push(`${title}:`, "");
        if (table.plot) {
          const picture = `pictures/benchmarks/${name.replace(".json", `-${i + 1}.svg`)}`;
          const older = own
            .slice(index + 1)
            .flatMap(([, each]) => each.tables.map((other) => [each.date, other]))
            .filter(([, other]) => other.title === table.title && other.plot);
          files.set(`doc/${picture}`, plotOf(table, older));
          text.push(`![plot](${picture})`, "");
        }
        if (table.show?.length !== 0) {
          text.push(tableOf(table), "");
        }
      }
    }
  }
  files.set("doc/benchmarks.md", `${text.join("\n").trimEnd()}\n`);
  return files;
}

// Finds tables in a benchmark's output: lines with columns that are separated by two or more blanks, or by "|", under a
// heading with as many columns.
export function parseTables(text) {
  const cellsOf = (line) => line.trim().replaceAll(" | ", "  ").split(/\s{2,}/);
  const tables = [];
  let title = "";
  let header = null;
  let table = null;
  for (const line of text.split("\n")) {
    const cells = cellsOf(line);
    const numbers = cells.slice(1).filter((cell) => /^[-\d.]/.test(cell)).length;
    if (cells.length < 2) {
      title = line.trim() || title;
      header = table = null;
    } else if (numbers === 0) {
      header = cells;
      table = null;
    } else if (header && (cells.length === header.length || cells.length === header.length + 1)) {
      if (!table) {
        table = { title, columns: cells.length > header.length ? ["", ...header] : header, rows: [] };
        tables.push(table);
      }
      table.rows.push(cells);
    }
  }
  for (const each of tables) { // the first column of numbers becomes bars
    each.plot = [each.columns.findIndex((_, i) => i > 0 && each.rows.every((cells) => number(cells[i]) !== null))].filter((i) => i > 0);
  }
  return tables.map(({ plot, ...each }) => (plot.length > 0 ? { ...each, plot } : each));
}

function record(name) {
  const text = readFileSync(path.join(root, "out/bench", `${name}.txt`), "utf8");
  const cpu = os.cpus();
  const git = (...words) => execFileSync("git", ["-C", root, ...words], { encoding: "utf8" }).trim();
  const section = sections.find(([stem]) => stem === name);
  const run = {
    section: section ? section[1] : name,
    date: new Date().toISOString().slice(0, 10),
    machine: `${cpu.length} x ${cpu[0]?.model ?? "processor"}, ${Math.round(os.totalmem() / 2 ** 30)} GiB, load ${os.loadavg()[0].toFixed(1)}`,
    command: `./dev bench ${name}`,
    commit: git("rev-parse", "HEAD") + (git("status", "--porcelain", "--untracked-files=no") ? " and changes" : ""),
    tables: parseTables(text),
    remarks: text.split("\n").filter((line) => line.trim()),
  };
  writeFileSync(path.join(root, "out/bench", `${name}.json`), `${JSON.stringify(run, null, 1)}\n`);
}

function main([command, name]) {
  if (command === "record" && name) {
    record(name);
    return 0;
  }
  if (command !== "page" && command !== "check") {
    console.error("usage: figures.mjs page|check|record NAME");
    return 2;
  }
  let stale = 0;
  for (const [file, text] of pageFiles(keptRuns())) {
    const target = path.join(root, file);
    if (command === "page") {
      mkdirSync(path.dirname(target), { recursive: true });
      writeFileSync(target, text);
      continue;
    }
    let present = null;
    try {
      present = readFileSync(target, "utf8");
    } catch {
      // the file is missing
    }
    if (present !== text) {
      console.error(`${file} is not what Testing/Benchmarks/Figures makes: run node Testing/Benchmarks/figures.mjs page`);
      stale = 1;
    }
  }
  return stale;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  process.exitCode = main(process.argv.slice(2));
}
