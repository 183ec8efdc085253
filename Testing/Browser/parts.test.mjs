// SPDX-License-Identifier: BSD-3-Clause
// The viewer's WebAssembly has two parts. There is a picture before the second part is loaded, code that needs it waits
// for it, and parts of different versions are never combined.

import assert from "node:assert/strict";
import { cpSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { afterEach, beforeEach, test } from "node:test";
import { Server, Visit, buildStore, eventually, makeModels, pause, startForTests, temporaryFolder, writePebble } from "./harness.mjs";
import { place } from "./visit.mjs";

let server, browser, visit;

startForTests(() => makeModels({ dragon: false }), (started) => ({ server, browser } = started));

beforeEach(async () => {
  visit = await Visit.phone(browser);
});

afterEach(async () => {
  await visit.close();
});

const bytesOf = (name) => readFileSync(join(place("KDSTREAM_PAGE"), name));

// Holds the second part back. Returns how often it was requested, and a function that releases it.
async function holdBack() {
  const held = { asked: 0, letGo: null };
  const gone = new Promise((resolve) => {
    held.letGo = resolve;
  });
  await visit.page.route("**/kdstream-more.wasm", async (route) => {
    if (++held.asked > 1) {
      await route.abort(); // requested by a stub, which would block the page
      return;
    }
    await gone;
    await route.continue().catch(() => {}); // the page may be closed
  });
  return held;
}

const loading = () => visit.page.evaluate(() => {
  const box = document.getElementById("loading");
  return box.checkVisibility() ? document.getElementById("loading-text").textContent : "";
});

const untilWaiting = () => eventually("it tells what it waits for", loading, (text) => text.startsWith("Loading the viewer"));

// Opens the model whose preview is shown first, in full screen.
async function openFullScreen(good = () => true) {
  await visit.untilIdle();
  await visit.tap(await visit.centre());
  return visit.until("full screen", (status) => status.mode === "full screen" && good(status));
}

test("a picture, and turning and enlarging it, do without the second part; what is finer waits for it", async () => {
  const held = await holdBack();
  await visit.open(server.url);
  const { shownLevel } = await visit.untilIdle();
  const middle = await visit.centre();
  await visit.drag(middle, 60, 20);
  await openFullScreen();
  const large = await visit.centre();
  await visit.drag(large, -80, 10);
  await visit.pinch(large, 80, 240);
  await visit.dragTwo(large, 20, 20);
  await visit.doubleTap(large);
  const waiting = await visit.until("it waits", ({ waits }) => waits);
  assert.deepEqual([waiting.shownLevel, waiting.region, waiting.idle], [shownLevel, null, false]);
  await visit.page.keyboard.press("u"); // back to the previous view
  assert.equal(held.asked, 1, "it was asked for, once");
  assert.deepEqual(await visit.messages(), []);
  held.letGo();
  await visit.until("the original is there", ({ region, idle }) => idle && region !== null && region.shown === region.partitions);
  assert.equal((await visit.status()).waits, false);
  visit.assertClean(server.url);
});

test("tools wait for it, and say so", async () => {
  const held = await holdBack();
  await visit.open(server.url);
  await openFullScreen();
  await visit.page.locator("#tools-button").click();
  await untilWaiting();
  await visit.picture("parts-1-waiting");
  assert.equal(await visit.page.locator("#tools").isVisible(), false);
  held.letGo();
  await visit.page.locator("#tabs").waitFor();
  await visit.showTool("Measure");
  await visit.page.locator("#measure").click();
  await visit.until("it measures", ({ measuring }) => measuring);
  assert.equal(await loading(), "");
  visit.assertClean(server.url);
});

test("a choice in the menu waits for it", async () => {
  const held = await holdBack();
  await visit.open(server.url);
  await openFullScreen();
  const { frames } = await visit.status();
  await visit.page.locator("#menu-button").click();
  await visit.page.locator("[name=coloring][value='partition']").check({ force: true });
  await untilWaiting();
  assert.equal((await visit.status()).frames, frames, "as it was");
  held.letGo();
  await visit.until("other colours", (status) => status.frames > frames && status.idle);
});

test("what opens over the picture waits for its style, and opens without it where that cannot be had", async () => {
  let send;
  const wanted = new Promise((resolve) => (send = resolve));
  let asked = 0;
  await visit.page.route("**/later.css", async (route) => {
    await wanted;
    return ++asked === 1 ? route.abort() : route.continue();
  });
  await visit.open(server.url);
  await openFullScreen();
  const menu = visit.page.locator("#menu");
  await visit.page.locator("#menu-button").click();
  assert.equal(await menu.isVisible(), false);
  send();
  await menu.waitFor();
  const isPlaced = () => menu.evaluate((element) => getComputedStyle(element).position === "absolute");
  assert.equal(await isPlaced(), false);
  await visit.page.keyboard.press("Escape");
  await visit.page.locator("#menu-button").click();
  await menu.waitFor();
  assert.equal(await isPlaced(), true, "it is asked for again");
});

test("pictures of a list that is searched, which is there before it, wait for it", async () => {
  const models = temporaryFolder();
  writePebble(join(models, "mesh.ply"));
  buildStore(join(models, "mesh.ply"), join(models, "m0.kds"));
  for (let i = 1; i < 14; ++i) {
    cpSync(join(models, "m0.kds"), join(models, `m${i}.kds`));
  }
  const many = await Server.start(models);
  try {
    const held = await holdBack();
    const pictures = () => visit.page.locator("#models img:not([hidden])").count();
    await visit.open(many.url);
    await visit.untilIdle();
    assert.ok(await visit.page.locator("#search").isVisible());
    await pause(2000); // long enough for pictures to be made
    assert.equal(await pictures(), 0);
    held.letGo();
    await eventually("pictures", pictures, (count) => count > 2);
    visit.assertClean(many.url);
  } finally {
    await many.stop();
  }
});

test("a link waits for it, and is followed then; the last of several", async () => {
  await visit.open(server.url);
  await openFullScreen(({ idle }) => idle);
  await visit.page.locator("#tools-button").click();
  await visit.page.locator("#tabs").waitFor();
  await visit.showTool("Facing me");
  await visit.page.getByRole("button", { name: "Facing me", exact: true }).click();
  await visit.until("it is cut", ({ depth, idle }) => depth !== null && idle);
  const link = await visit.copied("#copy-link");
  const { depth } = await visit.status();
  await visit.close();

  visit = await Visit.phone(browser);
  const held = await holdBack();
  await visit.open(`${server.url}/#model=shell`);
  await visit.until("the first part is there", ({ mode }) => mode === "no model");
  await untilWaiting();
  await visit.page.evaluate((hash) => (location.hash = hash), new URL(link).hash);
  held.letGo();
  const followed = await visit.until("the section", (status) => status.depth !== null && status.idle);
  assert.deepEqual([followed.model, followed.depth, followed.mode], ["pebble", depth, "full screen"]);
  visit.assertClean(server.url);
});

// Writes points on a sphere.
function writeCloud(file, points = 3000) {
  const places = Array.from({ length: points }, (_, i) => {
    const [z, turn] = [1 - 2 * (i + 0.5) / points, 2.4 * i];
    return [Math.sqrt(1 - z * z) * Math.cos(turn), Math.sqrt(1 - z * z) * Math.sin(turn), z].join(" ");
  });
  writeFileSync(file, ["ply", "format ascii 1.0", `element vertex ${points}`, "property float x", "property float y", "property float z",
    "end_header", ...places, ""].join("\n"));
}

for (const [what, write, ...options] of [["a cloud", writeCloud], ["a lossless model", writePebble, "--precision", "lossless"]]) {
  test(`${what} waits for it`, async (t) => {
    const models = temporaryFolder();
    write(join(models, "mesh.ply"));
    buildStore(join(models, "mesh.ply"), join(models, "model.kds"), ...options);
    const other = await Server.start(models);
    t.after(() => other.stop());
    const held = await holdBack();
    await visit.open(other.url);
    await untilWaiting();
    const waiting = await visit.until("it waits", ({ waits }) => waits);
    assert.deepEqual([waiting.model, waiting.shownLevel], ["model", null]);
    held.letGo();
    await visit.untilIdle();
    visit.assertClean(other.url);
  });
}

test("a server that has not got it is asked again", async () => {
  let refusals = 2;
  await visit.page.route("**/kdstream-more.wasm", (route) => (refusals-- > 0 ? route.fulfill({ status: 503, body: "" }) : route.continue()));
  await visit.open(server.url);
  await visit.untilSaid(/^A part of the viewer cannot be loaded from the server\. Trying again …$/);
  await visit.picture("parts-2-refused");
  await openFullScreen();
  await visit.page.locator("#tools-button").click();
  await visit.page.locator("#tabs").waitFor();
  await visit.untilQuiet();
  assert.ok(refusals < 0);
});

// The name by which one part imports from the other.
const importModulesOf = (name) => new Set(WebAssembly.Module.imports(new WebAssembly.Module(bytesOf(name)))
  .map(({ module }) => module).filter((module) => !/^(env|wasi_.*)$/.test(module)));

test("both parts are of one version, and the second has all from the first", () => {
  const [first, more] = ["kdstream.wasm", "kdstream-more.wasm"];
  assert.equal(importModulesOf(first).size, 1);
  assert.deepEqual(importModulesOf(first), importModulesOf(more));
  const exported = new Set(WebAssembly.Module.exports(new WebAssembly.Module(bytesOf(first))).map(({ name }) => name));
  const missing = WebAssembly.Module.imports(new WebAssembly.Module(bytesOf(more))).filter(({ name }) => !exported.has(name));
  assert.deepEqual(missing, []);
});

test("another version's second part is not taken", async () => {
  const [importModule] = importModulesOf("kdstream-more.wasm");
  const other = Buffer.from(bytesOf("kdstream-more.wasm").toString("latin1").replaceAll(importModule, "12345678"), "latin1");
  await visit.page.route("**/kdstream-more.wasm", (route) =>
    route.fulfill({ status: 200, contentType: "application/wasm", body: other }));
  await visit.open(server.url);
  await visit.untilSaid(/^There is a newer version of this viewer\.$/);
  const { shownLevel } = await openFullScreen();
  assert.notEqual(shownLevel, null);
});

// Calls a function of the second part before that part has arrived. Normally the page does not do this.
async function callEarly() {
  await visit.page.addInitScript(() => {
    const instantiate = WebAssembly.instantiate.bind(WebAssembly);
    WebAssembly.instantiate = async (...given) => {
      const made = await instantiate(...given);
      window.viewerParts = [...window.viewerParts ?? [], made.instance.exports];
      return made;
    };
  });
  await visit.open(server.url);
  await visit.untilIdle();
  return visit.page.evaluate(() => {
    const [first] = window.viewerParts;
    const viewer = first.ViewerMake();
    try {
      first.ViewerLink(viewer);
      return first.ViewerTextBytes(viewer);
    } catch (error) {
      return error.isPartMissing;
    }
  });
}

test("a function that is called early is fetched at once", async () => {
  let asked = 0;
  // The first request hangs.
  await visit.page.route("**/kdstream-more.wasm", (route) => (++asked > 1 ? route.continue() : undefined));
  const bytes = await callEarly();
  assert.equal(asked, 2);
  assert.ok(bytes > 0, "it gives what it gives");
});

test("where that cannot be had either, the viewer stops in words", async () => {
  await visit.page.route("**/kdstream-more.wasm", (route) => route.abort());
  assert.equal(await callEarly(), true);
});
