// SPDX-License-Identifier: BSD-3-Clause
// Tools for viewing, on a phone: views from six sides, automatic turning, distances, links to views, and pictures.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { Server, Visit, eventually, landscape, makeModels, portrait, runProgram, sharpScreen, startForTests } from "./harness.mjs";
import { difference, partOf } from "./pixels.mjs";

let server, browser;

startForTests(() => makeModels({ dragon: false }), async (started) => {
  ({ server, browser } = started);
});

async function openPebble(visit, url = server.url) {
  await visit.open(url);
  await visit.choose("pebble");
  await visit.tap(await visit.centre());
  return visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
}

// Opens the panel, or closes it.
async function turnPanel(visit) {
  await visit.page.locator("#tools-button").click();
  await visit.untilIdle();
}

const press = async (visit, name) => {
  await visit.showTool(name);
  await visit.page.getByRole("button", { name, exact: true }).click();
};

test("the tools come only when they are used", async () => {
  const visit = await Visit.phone(browser);
  await openPebble(visit);
  assert.ok(!visit.requests.some((url) => url.includes("tools.")), "not before");
  await turnPanel(visit);
  assert.ok(visit.requests.some((url) => url.endsWith("tools.js")));
  await visit.picture("tools-1-panel");
  await visit.page.keyboard.press("Escape");
  assert.equal(await visit.page.locator("#tools").isVisible(), false);
  visit.assertClean(server.url);
  await visit.close();
});

// Whether the middle of the element can be seen.
const isSeen = (visit, selector) => visit.page.locator(selector).evaluate((element) => {
  const { left, right, top, bottom } = element.getBoundingClientRect();
  const [x, y] = [(left + right) / 2, (top + bottom) / 2];
  return document.elementsFromPoint(x, y).some((each) => element.contains(each)) && top >= 0 && bottom <= innerHeight;
});

test("a notice of what was done is where one sees it", async () => {
  const visit = await Visit.phone(browser);
  await openPebble(visit);
  await turnPanel(visit);
  await visit.copied("#copy-link");
  const said = () => visit.page.locator("#notice").textContent();
  await eventually("it is copied", said, (text) => text === "Link copied.");
  await visit.page.locator("#notice").evaluate((element) => (element.style.pointerEvents = "auto"));
  assert.ok(await isSeen(visit, "#notice"));
  await visit.picture("tools-10-copied");
  await Promise.all([visit.page.waitForEvent("download"), press(visit, "Save picture")]);
  await eventually("it is saved", said, (text) => text === "Picture saved.");
  await eventually("it goes", said, (text) => text === "");
  visit.assertClean(server.url);
  await visit.close();
});

// Moves a slider to this share of its length, as a finger does.
async function slide(visit, id, share) {
  await visit.page.locator(id).scrollIntoViewIfNeeded();
  const box = await visit.page.locator(id).boundingBox();
  const thumb = 16; // approximately
  await visit.page.touchscreen.tap(box.x + thumb / 2 + (box.width - thumb) * share, box.y + box.height / 2);
  return visit.untilIdle();
}

test("a section is put through, moved by a slider and a finger, filled, and drawn", async () => {
  const visit = await Visit.phone(browser);
  await openPebble(visit);
  await turnPanel(visit);
  const where = await visit.centre();
  const whole = await visit.around(where, 300);
  const cuts = [];
  for (const from of ["From the front", "From the side", "From above"]) {
    await press(visit, from);
    await visit.until("it is cut", ({ depth, idle }) => Math.abs(depth - 0.5) < 0.01 && idle);
    cuts.push(await visit.around(where, 300));
  }
  assert.ok(difference(cuts[0], cuts[1]) > 0.1 && difference(cuts[1], cuts[2]) > 0.1, "each cuts another half");
  await press(visit, "Facing me");
  await visit.until("it is cut", ({ depth, idle }) => depth !== null && idle);
  assert.ok(difference(whole, await visit.around(where, 300)) > 0.2, "the cut face is seen");
  const half = await visit.around(where, 1100); // large enough to include its outline
  const { depth } = await slide(visit, "#section-depth", 0.75);
  assert.ok(depth > 0.65 && depth < 0.85, `${depth}`);
  assert.ok(difference(half, await visit.around(where, 1100)) > 0.02);
  await visit.picture("tools-5-section");
  const [drawing] = await Promise.all([visit.page.waitForEvent("download"), press(visit, "Save outline")]);
  assert.equal(drawing.suggestedFilename(), "pebble-section.svg");
  const svg = readFileSync(await drawing.path(), "utf8");
  assert.match(svg, /^<\?xml .*<svg [^>]*viewBox="[^"]+">.*<path .* d="\s*M[^"]*Z\s*"\/>\s*<\/svg>\s*$/s);
  await press(visit, "Move it by finger");
  await visit.until("the tool is in hand", ({ tool }) => tool === 2);
  await turnPanel(visit);
  const before = (await visit.status()).depth;
  await visit.drag(where, 0, -60);
  const after = (await visit.untilIdle()).depth;
  assert.ok(Math.abs(after - before) > 0.02, `${before} ${after}`);
  const link = await (await turnPanel(visit), visit.copied("#copy-link"));
  assert.match(link, /&section=[\w-]{19}/);
  await press(visit, "None");
  await visit.until("it is whole", (status) => status.depth === null);
  visit.assertClean(server.url);
  await visit.close();
});

test("light comes from the finger, until one tap brings back the standard light", async () => {
  const visit = await Visit.phone(browser);
  await openPebble(visit);
  const where = await visit.centre();
  const standard = await visit.around(where, 300);
  await turnPanel(visit);
  await press(visit, "Light from the finger");
  await turnPanel(visit);
  await visit.drag(where, -120, 20);
  await visit.until("there is a lamp", ({ lamp: light, idle }) => light !== undefined && idle);
  const low = await visit.around(where, 300);
  assert.ok(difference(standard, low) > 0.1);
  await turnPanel(visit);
  await slide(visit, "#relief", 1);
  assert.ok((await visit.status()).relief > 0.9);
  assert.ok(difference(low, await visit.around(where, 300)) > 0.01, "ridges are lighter");
  await visit.picture("tools-6-light");
  await press(visit, "Standard light");
  await visit.until("as before", ({ lamp: light, idle }) => light === undefined && idle);
  await press(visit, "Light from the finger"); // puts the tool away
  await visit.until("no tool", ({ tool }) => tool === 0);
  await turnPanel(visit);
  assert.ok(difference(standard, await visit.around(where, 300)) < 0.005);
  visit.assertClean(server.url);
  await visit.close();
});

test("six sides, and turning by itself until it is touched", async () => {
  const visit = await Visit.phone(browser);
  await openPebble(visit);
  await turnPanel(visit);
  const seen = [];
  for (const side of ["Front", "Right", "Top"]) {
    await press(visit, side);
    const { canUndo } = await visit.untilIdle();
    assert.ok(canUndo || side === "Front");
    seen.push(await visit.around(await visit.centre(), 300));
  }
  assert.ok(difference(seen[0], seen[1]) > 0.02);
  assert.ok(difference(seen[1], seen[2]) > 0.02);
  await press(visit, "Turn automatically");
  await visit.until("it turns", ({ spinning }) => spinning);
  const frames = (await visit.status()).frames;
  await visit.until("frames", (status) => status.frames > frames + 5);
  await visit.tap({ x: 30, y: 300 });
  await visit.until("it rests", ({ spinning, turnsOn }) => !spinning && !turnsOn);
  visit.assertClean(server.url);
  await visit.close();
});

// Measures a distance across the middle of the pebble; the panel is closed.
async function measurePebble(visit) {
  await openPebble(visit);
  await turnPanel(visit);
  await press(visit, "Measure");
  await turnPanel(visit);
  const middle = await visit.centre();
  await visit.tap({ x: middle.x - 60, y: middle.y });
  await visit.tap({ x: middle.x + 60, y: middle.y + 20 });
  await visit.untilIdle();
}

test("two taps measure, on the original", async () => {
  const visit = await Visit.phone(browser);
  await measurePebble(visit);
  await turnPanel(visit);
  const text = await visit.page.locator("#measurements li span").textContent();
  const [, distance, height] = text.match(/^([\d.]+)(?: ± \S+)?, height (-?[\d.]+), across [\d.]+$/) ?? assert.fail(text);
  assert.ok(Number(distance) > 0.1 && Number(distance) < 2.2 && distance.length > 4 && Math.abs(Number(height)) < Number(distance), text);
  assert.equal(await visit.page.locator("#overlay line").count(), 1);
  await visit.page.locator("#measurements input").fill("the width");
  await visit.page.locator("#measurements input").press("Tab");
  await visit.picture("tools-2-distance");
  assert.equal(await visit.copied("#copy-measurements"), `the width: ${text}`);
  await press(visit, "Remove");
  await visit.page.locator("#measurements li").waitFor({ state: "detached" });
  assert.equal(await visit.page.locator("#overlay line").count(), 0);
  visit.assertClean(server.url);
  await visit.close();
});

test("a tap beside the model says that there is nothing to measure", async () => {
  const visit = await Visit.phone(browser);
  await openPebble(visit);
  await turnPanel(visit);
  await press(visit, "Measure");
  await visit.until("it measures", ({ measuring }) => measuring);
  await visit.tap({ x: 20, y: 250 });
  await eventually("a notice", () => visit.page.locator("#notice").textContent(), (text) => /nothing to measure/.test(text));
  assert.equal(await visit.page.locator("#measurements li").count(), 0);
  assert.ok(await visit.page.locator("#tools").isVisible(), "the tools stay in sight");
  await visit.close();
});

test("on a phone the tools leave the model in sight, and begin with what is carried away", async () => {
  for (const [name, viewport] of [["portrait", portrait], ["landscape", landscape]]) {
    const visit = await Visit.phone(browser, viewport);
    await openPebble(visit);
    await turnPanel(visit);
    const { width, height } = await visit.page.locator("#tools").boundingBox();
    assert.ok(width * height < 0.37 * viewport.width * viewport.height, `${width} x ${height}`);
    assert.deepEqual(await visit.page.locator("#carry button").allTextContents(), ["Copy link", "Save picture"]);
    await visit.page.locator("#tabs button").first().click();
    assert.ok(await visit.page.getByRole("button", { name: "Front", exact: true }).isVisible());
    await visit.page.locator("#tabs button").nth(1).click();
    assert.equal(await visit.page.getByRole("button", { name: "Front", exact: true }).isVisible(), false, "one kind at a time");
    assert.ok(await visit.page.locator("#measure").isVisible());
    await visit.picture(`tools-11-${name}`);
    await visit.close();
  }
});

test("a link shows its distances at once", async () => {
  const mine = await Visit.phone(browser);
  await measurePebble(mine);
  const drawn = (visit) => visit.page.locator("#overlay text").allTextContents();
  const [distance] = await drawn(mine);
  await turnPanel(mine);
  const link = await mine.copied("#copy-link");
  assert.match(link, /&distances=[\w-]{40}$/);
  await mine.close();

  const theirs = await Visit.phone(browser);
  await theirs.open(link);
  await theirs.until("the view", ({ mode, idle, shownLevel }) => mode === "full screen" && idle && shownLevel !== null);
  await eventually("the distance", () => drawn(theirs), ([text]) => text === distance);
  assert.equal(await theirs.page.locator("#overlay line").count(), 1);
  assert.equal(await theirs.page.locator("#tools").isVisible(), false, "nobody has opened the tools");
  await theirs.picture("tools-7-distance");
  // Opens a link in the same tab.
  await theirs.page.evaluate(() => {
    location.hash = "model=pebble";
  });
  await eventually("no distance", () => drawn(theirs), ({ length }) => length === 0);
  theirs.assertClean(server.url);
  await theirs.close();
});

test("a link shows the same elsewhere", async () => {
  const mine = await Visit.phone(browser);
  await openPebble(mine);
  const middle = await mine.centre();
  await mine.pinch(middle, 80, 260);
  await mine.drag(middle, 70, 40);
  await mine.page.locator("#menu-button").click();
  await mine.page.locator("[name=coloring][value='partition']").check({ force: true });
  await mine.page.locator("#menu-button").click();
  await mine.untilIdle();
  const seen = await mine.around(middle, 380);
  await turnPanel(mine);
  const link = await mine.copied("#copy-link");
  assert.match(link, /^http:\/\/127\.0\.0\.1:\d+\/m\/pebble#model=pebble&digest=[0-9a-f]{8}&view=[\w-]{47}&colours=partition$/);
  await mine.close();

  const theirs = await Visit.phone(browser);
  await theirs.open(link);
  await theirs.until("the view", ({ mode, idle, model }) => mode === "full screen" && idle && model === "pebble");
  await theirs.picture("tools-3-link");
  assert.ok(difference(seen, await theirs.around(middle, 380)) < 0.01, "the same picture");
  // Opens another link in the same tab; then one without a view.
  await theirs.page.evaluate(() => {
    location.hash = "model=shell";
  });
  await theirs.until("the other model", ({ mode, idle, model }) => mode === "full screen" && idle && model === "shell");
  await theirs.page.evaluate(() => {
    location.hash = "model=shell&view=%3Cscript%3E";
  });
  await theirs.until("a sentence", ({ error }) => /link to a view/.test(error));
  await theirs.page.evaluate(() => {
    location.hash = "model=nowhere";
  });
  await theirs.until("a sentence", ({ error }) => /no model 'nowhere'/.test(error));
  theirs.assertClean(server.url);
  await theirs.close();
});

const pixelsPerPoint = sharpScreen.deviceScaleFactor;

test("a picture is saved with its words", async () => {
  const visit = await Visit.phone(browser, landscape, sharpScreen);
  await openPebble(visit);
  await turnPanel(visit);
  const downloading = visit.page.waitForEvent("download");
  await press(visit, "Save picture");
  const download = await downloading;
  assert.equal(download.suggestedFilename(), "pebble.png");
  const saved = readFileSync(await download.path());
  assert.equal(saved.subarray(1, 4).toString(), "PNG");
  const view = await visit.page.locator("#view").boundingBox();
  assert.deepEqual(await visit.page.locator("#overlay").boundingBox(), view, "lines lie over the picture");
  const [width, height] = [saved.readUInt32BE(16), saved.readUInt32BE(20)];
  assert.equal(width, pixelsPerPoint * landscape.width);
  assert.ok(height > pixelsPerPoint * view.height, "room for the words");
  await download.saveAs(`${process.env.KDSTREAM_PICTURES}/tools-4-saved.png`);
  visit.assertClean(server.url);
  await visit.close();
});

// Checks that the saved picture shows the same as the middle of the screen, and returns the picture.
async function assertSaved(visit, what) {
  await visit.untilIdle();
  const shown = await visit.around(await visit.centre(), 240);
  await turnPanel(visit);
  const [download] = await Promise.all([visit.page.waitForEvent("download"), press(visit, "Save picture")]);
  await turnPanel(visit);
  const { width, height } = await visit.page.locator("#view").boundingBox();
  const size = 240 * pixelsPerPoint;
  const middle = { x: (pixelsPerPoint * width - size) / 2, y: (pixelsPerPoint * height - size) / 2, width: size, height: size };
  const saved = partOf(readFileSync(await download.path()), middle);
  assert.ok(difference(shown, saved) < 0.01, `${what}: the picture is what is seen`);
  assert.ok(difference(shown, await visit.around(await visit.centre(), 240)) < 0.005, `${what}: and stays`);
  return shown;
}

test("a picture is what is seen, also of a model that was turned, and so is a phone that is turned and turned back", async () => {
  const visit = await Visit.phone(browser, portrait, sharpScreen);
  await openPebble(visit);
  const middle = await visit.centre();
  await visit.drag(middle, 90, 60);
  const upright = await assertSaved(visit, "turned");
  await visit.page.setViewportSize(landscape);
  await assertSaved(visit, "turned phone");
  await visit.picture("tools-9-turned-phone");
  await visit.page.setViewportSize(portrait);
  assert.ok(difference(upright, await assertSaved(visit, "turned back")) < 0.01, "as before");
  await visit.pinch(middle, 80, 200);
  await visit.dragTwo(middle, 30, 60);
  await assertSaved(visit, "pinched and panned");
  visit.assertClean(server.url);
  await visit.close();
});

test("a saved picture breaks a long title, and ends what is longer still", async () => {
  const models = makeModels({ dragon: false });
  const title = (text) => runProgram("kdstream-store", "edit", join(models, "pebble.kds"), "--quiet", "--title", text);
  const rowHeight = pixelsPerPoint * 18; // pixels
  for (const [text, rows] of [
    ["A pebble", 1],
    ["A pebble from the beach in front of the old lighthouse, with bumps", 2],
    ["A pebble from the beach in front of the old lighthouse, with bumps ".repeat(8), 3],
    ["Pebble".repeat(40), 1],
  ]) {
    title(text);
    const own = await Server.start(models);
    const visit = await Visit.phone(browser, portrait, sharpScreen);
    try {
      await visit.open(`${own.url}/#model=pebble`);
      await visit.until("the view", ({ mode, idle, shownLevel }) => mode === "full screen" && idle && shownLevel !== null);
      await turnPanel(visit);
      const [download] = await Promise.all([visit.page.waitForEvent("download"), press(visit, "Save picture")]);
      await download.saveAs(`${process.env.KDSTREAM_PICTURES}/tools-8-title-${text.length}.png`);
      const height = readFileSync(await download.path()).readUInt32BE(20);
      const pixelsHigh = await visit.page.locator("#view").evaluate((canvas) => canvas.height);
      assert.equal(height, Math.floor(pixelsHigh + (rows + 0.7) * rowHeight), text);
    } finally {
      await visit.close();
      await own.stop();
    }
  }
});
