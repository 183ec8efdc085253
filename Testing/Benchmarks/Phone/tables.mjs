// SPDX-License-Identifier: BSD-3-Clause
// Writes medians of rounds: for readers as tables of values and of ratios, and as CSV.

export function quantile(values, share) {
  const sorted = [...values].sort((a, b) => a - b);
  const at = share * (sorted.length - 1);
  const below = Math.floor(at);
  return sorted[below] + (sorted[Math.min(below + 1, sorted.length - 1)] - sorted[below]) * (at - below);
}

export const median = (values) => quantile(values, 0.5);

const inMegabytes = (bytes) => (bytes / 1e6).toFixed(bytes < 1e7 ? 2 : 1);
const inMilliseconds = (ms) => ms.toFixed(ms < 10 ? 1 : 0);
const inThousands = (count) => Math.round(count / 1000).toLocaleString("en");

// The values in a cell: { key, title, text(value) }. If a viewer lacks a key, the cell is empty.
const columns = [
  { key: "first", title: "first picture, ms", text: inMilliseconds },
  { key: "settled", title: "settled, ms", text: inMilliseconds },
  { key: "bytes", title: "MB", text: inMegabytes },
  { key: "triangles", title: "1000 triangles", text: inThousands },
  { key: "frame", title: "frame, ms", text: inMilliseconds },
  { key: "frame95", title: "its p95", text: inMilliseconds },
  { key: "script", title: "JS, MB", text: inMegabytes },
  { key: "wasm", title: "wasm, MB", text: inMegabytes },
  { key: "processes", title: "processes, MB", text: inMegabytes },
];
const ownColumns = [
  { key: "tapFirst", title: "tap to first partition, ms", text: inMilliseconds },
  { key: "tapWhole", title: "to the whole region, ms", text: inMilliseconds },
  { key: "moreTriangles", title: "widest region, 1000 triangles", text: inThousands },
  { key: "moreFrame", title: "its frame, ms", text: inMilliseconds },
  { key: "moreFrame95", title: "its p95", text: inMilliseconds },
];
const allColumns = [...columns, ...ownColumns];

// runs: [{ line, size, name, ...figures }], one for each round. Returns a row of medians for each line, size and name.
export function summarize(runs) {
  const rows = new Map();
  for (const run of runs) {
    const key = [run.line, run.size, run.name].join("|");
    rows.set(key, [...rows.get(key) ?? [], run]);
  }
  return [...rows.values()].map((rounds) => {
    const { line, size, name, level } = rounds[0];
    const row = { line, size, name, level, rounds: rounds.length };
    for (const { key } of allColumns) {
      const values = rounds.map((round) => round[key]).filter((value) => value !== undefined);
      if (values.length) {
        row[key] = median(values);
      }
    }
    return row;
  });
}

const cell = (value, text) => (value === undefined ? "" : text(value));

function table(heads, lines) {
  return [heads, heads.map(() => "---"), ...lines].map((cells) => `| ${cells.join(" | ")} |`).join("\n");
}

const ratio = (one, other) => (one === undefined || !other ? "" : (one / other).toFixed(2));

export function toMarkdown(rows) {
  const parts = [];
  for (const line of new Set(rows.map((row) => row.line))) {
    const here = rows.filter((row) => row.line === line);
    const shown = columns.filter(({ key }) => here.some((row) => row[key] !== undefined));
    parts.push(`## ${line}`, table(["mesh", "viewer", ...shown.map(({ title }) => title)],
      here.map((row) => [row.size, row.name, ...shown.map(({ key, text }) => cell(row[key], text))])));
    const own = here.filter(({ level }) => level !== undefined);
    const ownShown = ownColumns.filter(({ key }) => own.some((row) => row[key] !== undefined));
    parts.push(table(["mesh", "level when settled", ...ownShown.map(({ title }) => title)],
      own.map((row) => [row.size, row.level, ...ownShown.map(({ key, text }) => cell(row[key], text))])));
    const compared = shown.filter(({ key }) => key !== "script" && key !== "wasm");
    const turned = own.some(({ moreFrame }) => moreFrame !== undefined);
    const heads = compared.map(({ title }) => title.replace(/, .*/, ""));
    parts.push("Ours / theirs:", table(["mesh", "beside", ...heads, ...(turned ? ["frame with the widest region"] : [])],
      here.filter(({ level }) => level === undefined).map((row) => {
        const ours = own.find(({ size }) => size === row.size);
        const more = turned ? [ratio(ours.moreFrame, row.frame)] : [];
        return [row.size, row.name, ...compared.map(({ key }) => ratio(ours[key], row[key])), ...more];
      })));
  }
  return parts.join("\n\n") + "\n";
}

export function toCsv(rows) {
  const keys = ["line", "size", "name", "rounds", "level", ...allColumns.map(({ key }) => key)];
  return [keys, ...rows.map((row) => keys.map((key) => (typeof row[key] === "string" ? `"${row[key]}"` : row[key] ?? "")))]
    .map((values) => values.join(",")).join("\n") + "\n";
}
