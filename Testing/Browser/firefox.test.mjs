// SPDX-License-Identifier: BSD-3-Clause
// The walk and the tools in a second engine, Firefox; also links, saved files, and stored data.

import assert from "node:assert/strict";
import { existsSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { fullScreen, openPebble, turnPanel, useTools, walk } from "./engines.mjs";
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

test("the list, a model, the wheel to the original, a double click for a region, and back", async () => {
  const visit = await firefox.visit(server.url);
  await walk("firefox", visit);
  await visit.close();
});

test("sides, a distance, a section, light", async () => {
  const visit = await firefox.visit(server.url);
  await useTools("firefox", visit);
  await visit.close();
});

// The element that has the focus, and the frame around it.
const focus = ({ page }) => page.evaluate(() => [document.activeElement.id, getComputedStyle(document.activeElement).outlineStyle]);

async function tab({ page }, way) {
  if (way === "back") {
    await page.keyboard.down("Shift");
  }
  await page.keyboard.press("Tab");
  await page.keyboard.up("Shift");
}

test("a link shows the same", async () => {
  const mine = await firefox.visit(server.url);
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

  // Another link in the same tab: the focus goes to the picture, which shows no frame until the keyboard is used.
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
  const visit = await firefox.visit(server.url);
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
