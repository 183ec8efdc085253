// SPDX-License-Identifier: BSD-3-Clause
// The viewers that are compared: how each is opened, and when it has settled. All are measured in the same way.

import { readFileSync } from "node:fs";
import { Visit, launchBrowser } from "../../Browser/harness.mjs";
import { turn, watch, watchTap } from "./watch.mjs";

// Ours comes first: ratios are ours divided by theirs.
export const contestants = [
  { name: "KdStream", ours: true },
  { name: "three.js, PLY", page: "three.html", ending: "ply" },
  { name: "three.js, GLB", page: "three.html", ending: "glb" },
  { name: "vtk.js, PLY", page: "vtk.html", ending: "ply" },
];

const steps = 93; // frames while turning; the first three do not count
const points = 8; // how far a finger moves in each
const mostSeconds = 15; // of turning, if frames take long

const addressOf = ({ ours, page, ending }, size, url) => (ours ? `${url}/#model=${size}` : `${url}/${page}?mesh=${size}.${ending}`);

// Measures one viewer in a browser of its own, over `line`. turns: whether it is turned, too. Times are in ms, memory
// in bytes.
export async function measure(contestant, size, line, { turns, picture }) {
  const browser = await launchBrowser("--enable-precise-memory-info");
  try {
    const visit = await Visit.phone(browser);
    await visit.page.addInitScript(watch);
    await visit.open(addressOf(contestant, size, line.url));
    const figures = await settle(contestant, visit);
    figures.bytes = line.bytes;
    Object.assign(figures, await memoryOf(browser, visit));
    await visit.picture(picture);
    if (turns) {
      figures.frames = await visit.page.evaluate(turn, { steps, points, mostSeconds });
    }
    if (contestant.ours) {
      await tap(visit, figures);
      if (turns) {
        await turnMore(visit, figures);
      }
    }
    if (visit.errors.length) {
      throw new Error(`${contestant.name}, ${size}: ${visit.errors.join("; ")}`);
    }
    return figures;
  } finally {
    await browser.close();
  }
}

async function settle({ ours }, { page, ...visit }, patience = 180_000) {
  const end = Date.now() + patience;
  for (;;) {
    const found = await page.evaluate(() => new Promise((resolve) => {
      requestAnimationFrame(() => {
        const status = window.kdstream?.status() ?? {};
        const settled = window.peer || (status.mode === "full screen" && status.idle && status.shownLevel !== null);
        resolve(settled && { now: performance.now(), first: window.watched.first, triangles: status.triangles ?? window.watched.drawn,
          level: status.original ? `${status.shownLevel} and original` : status.shownLevel, finest: status.finestLevel,
          pixels: document.querySelector("canvas").width * document.querySelector("canvas").height });
      });
    }));
    if (found && found.first !== null) {
      // The other viewers have settled with their first picture.
      return { first: found.first, settled: ours ? found.now : found.first, triangles: found.triangles, pixels: found.pixels,
        ...(ours && { level: `${found.level} of ${found.finest}` }) };
    }
    if (Date.now() > end) {
      throw new Error(`nothing is shown: ${JSON.stringify(found)} ${visit.errors}`);
    }
  }
}

// The memory of JavaScript after a garbage collection, of WebAssembly, and of the processes that draw: the page's, and
// that of graphics, which are software.
async function memoryOf(browser, { page }) {
  const session = await page.context().newCDPSession(page);
  await session.send("HeapProfiler.collectGarbage");
  const { script, wasm } = await page.evaluate(() => ({ script: performance.memory.usedJSHeapSize,
    wasm: window.watched.memories.reduce((sum, { buffer }) => sum + buffer.byteLength, 0) }));
  const all = await browser.newBrowserCDPSession();
  const { processInfo } = await all.send("SystemInfo.getProcessInfo");
  const kilobytes = processInfo.filter(({ type }) => type === "renderer" || type === "GPU")
    .map(({ id }) => Number(/^Pss:\s+(\d+) kB$/m.exec(readFileSync(`/proc/${id}/smaps_rollup`, "utf8"))[1]));
  return { script, wasm, processes: 1024 * kilobytes.reduce((sum, each) => sum + each, 0) };
}

async function tap(visit, figures) {
  await visit.untilIdle();
  await visit.page.evaluate(watchTap);
  await visit.doubleTap(await visit.centre());
  await visit.until("the whole region", ({ region, idle }) => idle && region !== null && region.shown === region.partitions);
  const { first, whole } = await visit.page.evaluate(() => new Promise((resolve) => {
    const look = () => (window.tap.whole === null ? requestAnimationFrame(look) : resolve(window.tap));
    look();
  }));
  Object.assign(figures, { tapFirst: first, tapWhole: whole });
}

// Turns with the widest region of the original, which shows more triangles than the screen needs.
async function turnMore(visit, figures) {
  await visit.page.evaluate(() => {
    const choice = document.querySelector("[name=rings][value='3']");
    choice.checked = true;
    choice.dispatchEvent(new Event("change", { bubbles: true }));
  });
  await visit.doubleTap(await visit.centre());
  const { triangles } = await visit.until("the widest region",
    ({ region, idle }) => idle && region?.rings === 3 && region.shown === region.partitions);
  figures.moreTriangles = triangles;
  figures.moreFrames = await visit.page.evaluate(turn, { steps, points, mostSeconds });
}
