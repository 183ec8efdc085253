// SPDX-License-Identifier: BSD-3-Clause
// The walk and the tools in a second engine: Firefox. What is tested at length in Chromium is here tried once.

import assert from "node:assert/strict";
import { existsSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { Firefox } from "./firefox.mjs";
import { Server, eventually, makeModels } from "./harness.mjs";
import { difference } from "./pixels.mjs";

let server, firefox;

before(async () => {
  server = await Server.start(makeModels({ dragon: false }));
  firefox = await Firefox.start();
});

after(async () => {
  await firefox?.stop();
  await server?.stop();
});

const fullScreen = (visit) => visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);

async function openPebble(visit) {
  await visit.open(server.url);
  await visit.untilIdle();
  await visit.choose("pebble");
  const { x, y } = await visit.centre();
  await visit.page.mouse.click(x, y);
  return fullScreen(visit);
}

// Opens the panel of tools, or closes it.
async function turnPanel(visit) {
  await visit.page.click("#tools-button");
  await visit.untilIdle();
}

test("the list, a model, the wheel to the original, a double click for a region, and back", async () => {
  const visit = await firefox.visit();
  await visit.open(server.url);
  const { model } = await visit.untilIdle();
  assert.equal(model, "pebble");
  await visit.picture("firefox-1-list");
  const pebble = await visit.around(await visit.centre(), 300);
  await visit.choose("shell");
  assert.ok(difference(pebble, await visit.around(await visit.centre(), 300), 4) > 0.1, "another model is another picture");
  await visit.choose("pebble");
  assert.ok(difference(pebble, await visit.around(await visit.centre(), 300), 4) < 0.01, "the same model is the same picture");

  const listed = await visit.centre();
  await visit.page.mouse.click(listed.x, listed.y);
  await fullScreen(visit);
  const middle = await visit.centre();
  const first = await visit.around(middle, 500);
  await visit.picture("firefox-2-full-screen");
  await visit.drag(middle, 80, 0);
  await visit.untilIdle();
  assert.ok(difference(first, await visit.around(middle, 500)) > 0.02, "a drag turns");
  await visit.page.keyboard.press("h");
  await visit.untilIdle();
  assert.ok(difference(first, await visit.around(middle, 500)) < 0.01, "H leads home");

  for (let turn = 0; turn < 8; ++turn) {
    await visit.wheel(middle, -100);
  }
  assert.ok((await visit.untilIdle()).original, "the wheel leads to the original");
  assert.ok(difference(first, await visit.around(middle, 500)) > 0.1, "and nearer");
  await visit.picture("firefox-3-wheel");
  await visit.page.mouse.click(middle.x, middle.y, { count: 2 });
  await visit.until("the whole region", ({ region, idle }) => idle && region?.partitions > 0 && region.shown === region.partitions);
  await visit.picture("firefox-4-region");
  assert.match(await visit.page.evaluate(() => document.getElementById("status").textContent), /^Original$/);
  await visit.page.keyboard.press("Escape");
  await visit.until("back to the list", ({ mode }) => mode === "browsing");
  assert.deepEqual(await visit.messages(), []);
  visit.assertClean(server.url);
  await visit.close();
});

test("sides, a distance, a section, light", async () => {
  const visit = await firefox.visit();
  await openPebble(visit);
  const middle = await visit.centre();
  await turnPanel(visit);
  await visit.press("Front");
  await visit.untilIdle();
  const front = await visit.around(middle, 300);
  await visit.press("Top");
  await visit.untilIdle();
  assert.ok(difference(front, await visit.around(middle, 300)) > 0.02, "another side");

  await visit.press("Measure");
  await turnPanel(visit);
  for (const [dx, dy] of [[-60, 0], [60, 20]]) {
    await visit.page.mouse.click(middle.x + dx, middle.y + dy);
    await visit.untilIdle();
  }
  await turnPanel(visit);
  const told = await visit.page.evaluate(() => document.querySelector("#measurements li span").textContent);
  const [, distance] = told.match(/^([\d.]+)(?: ± \S+)?, height -?[\d.]+, across [\d.]+$/) ?? assert.fail(told);
  assert.ok(Number(distance) > 0.05 && Number(distance) < 2.2, told);
  await visit.picture("firefox-5-distance");
  await visit.press("Remove");

  const whole = await visit.around(middle, 200);
  await visit.press("Facing me");
  const { depth } = await visit.until("it is cut", (status) => status.depth !== null && status.idle);
  assert.ok(depth > 0 && depth < 1);
  assert.ok(difference(whole, await visit.around(middle, 200)) > 0.2, "the cut face is seen");
  await visit.picture("firefox-6-section");
  await visit.press("None");
  await visit.until("it is whole", (status) => status.depth === null && status.idle);

  await visit.press("Light from the finger");
  await turnPanel(visit);
  const standard = await visit.around(middle, 300);
  await visit.drag(middle, -120, 20);
  await visit.until("there is a lamp", ({ lamp, idle }) => lamp !== undefined && idle);
  assert.ok(difference(standard, await visit.around(middle, 300)) > 0.1, "light from the side");
  await visit.picture("firefox-7-light");
  assert.deepEqual(await visit.messages(), []);
  visit.assertClean(server.url);
  await visit.close();
});

// Where the focus is, and the frame around it.
const focus = ({ page }) => page.evaluate(() => [document.activeElement.id, getComputedStyle(document.activeElement).outlineStyle]);

async function tab({ page }, way) {
  if (way === "back") {
    await page.keyboard.down("Shift");
  }
  await page.keyboard.press("Tab");
  await page.keyboard.up("Shift");
}

test("a link shows the same", async () => {
  const mine = await firefox.visit();
  await openPebble(mine);
  const middle = await mine.centre();
  await mine.wheel(middle, -100);
  await mine.drag(middle, 70, 40);
  await mine.untilIdle();
  const seen = await mine.around(middle, 380);
  await turnPanel(mine);
  const link = await mine.copied("#copy-link");
  assert.match(link, /#model=pebble&digest=[0-9a-f]{8}&view=[\w-]{47}$/);
  await mine.close();

  const theirs = await firefox.visit();
  await theirs.open(link);
  await fullScreen(theirs);
  await theirs.picture("firefox-8-link");
  assert.ok(difference(seen, await theirs.around(middle, 380)) < 0.01, "the same picture");

  // Another link in the same tab: the focus goes to the picture, without a frame until somebody goes by keyboard.
  await theirs.open(server.url);
  await theirs.untilIdle();
  await theirs.page.evaluate(() => {
    location.hash = "model=shell";
  });
  await fullScreen(theirs);
  assert.deepEqual(await focus(theirs), ["view", "none"]);
  await theirs.page.keyboard.press("ArrowLeft");
  assert.deepEqual(await focus(theirs), ["view", "none"]);
  await tab(theirs);
  await tab(theirs, "back");
  assert.deepEqual(await focus(theirs), ["view", "solid"]);
  theirs.assertClean(server.url);
  await theirs.close();
});

test("a picture is saved", async () => {
  const visit = await firefox.visit();
  await openPebble(visit);
  await turnPanel(visit);
  await visit.press("Save picture");
  const file = join(firefox.downloads, "pebble.png");
  const saved = await eventually("the whole file", () => (existsSync(file) ? readFileSync(file) : Buffer.alloc(0)),
    (bytes) => bytes.subarray(-8, -4).toString() === "IEND");
  const canvas = await visit.page.evaluate(() => ({ ...document.getElementById("view").getBoundingClientRect().toJSON() }));
  assert.equal(saved.readUInt32BE(16), canvas.width);
  assert.ok(saved.readUInt32BE(20) > canvas.height, "room for the words");
  visit.assertClean(server.url);
  await visit.close();
});

test("what was seen opens without the server", async () => {
  const own = await Server.start(makeModels({ dragon: false }));
  const visit = await firefox.visit();
  await visit.open(own.url);
  await visit.untilIdle();
  const online = await visit.around(await visit.centre());
  await eventually("the service worker", () => visit.page.evaluate(
    async () => (await navigator.serviceWorker.getRegistration())?.active?.state === "activated"));
  await eventually("the list is kept", () => visit.page.evaluate(() => document.querySelectorAll("#models .kept").length > 0));
  await own.stop();
  await visit.page.reload();
  assert.equal((await visit.untilIdle()).model, "pebble");
  await visit.untilSaid(/^The server cannot be reached\. Stored data is shown\.$/);
  await visit.picture("firefox-9-offline");
  assert.ok(difference(online, await visit.around(await visit.centre())) < 0.01, "the same picture");
  await visit.close();
});
