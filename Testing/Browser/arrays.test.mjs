// SPDX-License-Identifier: BSD-3-Clause
// Colours by an array of numbers, on a phone: which arrays there are, what they mean, and a link that keeps the choice.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { Server, Visit, buildStore, launchBrowser, portrait, sharpScreen, temporaryFolder, writePebble } from "./harness.mjs";
import { countPixels, difference } from "./pixels.mjs";

let server, browser;

// A hill of points, with its height as another array "height:", and another array that says which part it is.
function writeHill(file) {
  const side = 120;
  const points = [];
  for (let i = 0; i < side * side; ++i) {
    const x = i % side - side / 2, y = Math.floor(i / side) - side / 2;
    const z = 30 * Math.exp(-(x * x + y * y) / 900);
    points.push(`${x} ${y} ${z} ${z * 2} ${i === 0 ? 7 : x < -10 ? 2 : 6}`);
  }
  writeFileSync(file, `ply\nformat ascii 1.0\nelement vertex ${points.length}\nproperty float x\nproperty float y\n` +
    "property float z\nproperty float height%3a\nproperty uchar classification\nend_header\n" + points.join("\n") + "\n");
}

before(async () => {
  const folder = temporaryFolder();
  writeHill(join(folder, "hill.ply"));
  writePebble(join(folder, "pebble.ply"));
  for (const name of ["hill", "pebble"]) {
    buildStore(join(folder, `${name}.ply`), join(folder, `${name}.kds`), "--up", "0,0,1", "--view", "0,-1,1");
  }
  server = await Server.start(folder);
  browser = await launchBrowser();
});

after(async () => {
  await browser?.close();
  await server?.stop();
});

async function openModel(visit, model, more = "") {
  await visit.open(`${server.url}/#model=${model}${more}`);
  return visit.until("full screen", ({ mode, idle, shownLevel }) => mode === "full screen" && idle && shownLevel !== null);
}

const arraysOf = (visit) => visit.page.locator("select[aria-label='By array']");

test("a model without arrays offers none", async () => {
  const visit = await Visit.phone(browser);
  await openModel(visit, "pebble");
  assert.ok(!visit.requests.some((url) => url.includes("legend.")), "not before");
  await visit.page.locator("#menu-button").click();
  await visit.untilIdle();
  await arraysOf(visit).waitFor({ state: "attached" });
  assert.equal(await arraysOf(visit).isVisible(), false);
  await visit.close();
});

test("colours by an array, its range and its map, and a link to them", async () => {
  const visit = await Visit.phone(browser);
  await openModel(visit, "hill");
  const centre = await visit.centre();
  const own = await visit.around(centre, 300);
  await visit.page.locator("#menu-button").click();
  await arraysOf(visit).waitFor();
  const names = await arraysOf(visit).locator("option").allInnerTexts();
  assert.deepEqual(names, ["By array", "height:", "classification"]);
  await arraysOf(visit).selectOption("height:");
  await visit.page.locator("#legend svg[role=img]").waitFor();
  await visit.untilIdle();
  const figures = await visit.page.locator("#legend text").allTextContents();
  assert.equal(figures.length, 3);
  assert.ok(Number(figures[0]) < 1 && Number(figures[2]) > 40 && Number(figures[2]) < 60, figures.join());
  await visit.picture("arrays-1-menu");
  await visit.page.locator("input[aria-label=To]").fill("10");
  await visit.page.locator("input[aria-label=To]").blur();
  await visit.page.locator("select[aria-label='Colour map']").selectOption("diverging");
  await visit.page.locator("#menu-button").click();
  await visit.untilIdle();
  assert.equal((await visit.page.locator("#legend text").allTextContents())[2], "10");
  await visit.picture("arrays-2-measure");
  const seen = await visit.around(centre, 300);
  assert.ok(difference(own, seen) > 0.2, "other colours");
  await visit.page.locator("#tools-button").click();
  await visit.untilIdle();
  const link = await visit.copied("#copy-link");
  assert.match(link, /&colours=by:height%3A:diverging:[\d.e-]+:10$/);
  visit.assertClean(server.url);
  await visit.close();

  const theirs = await Visit.phone(browser);
  await theirs.open(link);
  await theirs.until("the view", ({ mode, idle, shownLevel }) => mode === "full screen" && idle && shownLevel !== null);
  await theirs.page.locator("#legend svg[role=img]").waitFor();
  assert.ok(difference(seen, await theirs.around(centre, 300)) < 0.01, "the same picture");
  await theirs.close();
});

test("classes have colours and names of their own; the list shows the model as it is", async () => {
  const visit = await Visit.phone(browser);
  await openModel(visit, "hill", "&colours=by:classification");
  await visit.page.locator("#legend li").nth(2).waitFor();
  const legend = await visit.page.locator("#legend li").allInnerTexts();
  assert.deepEqual(legend.map((each) => each.trim()), ["2 ground", "6 building", "7 low point (noise)"]);
  await visit.picture("arrays-3-classes");
  await visit.back();
  assert.equal(await visit.page.locator("#legend").isVisible(), false);
  await visit.close();
});

test("a saved picture tells what its colours mean", async () => {
  for (const colours of ["by:classification", "by:height%3A", "resolution"]) {
    const visit = await Visit.phone(browser, portrait, sharpScreen);
    await openModel(visit, "hill", `&colours=${colours}`);
    await visit.page.locator("#legend li").first().waitFor();
    const legend = await visit.page.locator("#legend rect").evaluateAll((all) => all.map((rect) => rect.getAttribute("fill")));
    const { height } = await visit.page.locator("#view").boundingBox();
    await visit.page.locator("#tools-button").click();
    const [download] = await Promise.all([visit.page.waitForEvent("download"), visit.page.locator("#save-picture").click()]);
    await download.saveAs(`${process.env.KDSTREAM_PICTURES}/arrays-4-saved-${colours.replace(/\W/g, "-")}.png`);
    const saved = readFileSync(await download.path());
    for (const color of [legend.at(0), legend.at(-1)]) {
      const channels = [1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16));
      assert.ok(countPixels(saved, channels, Math.ceil(sharpScreen.deviceScaleFactor * height)) > 100, `${colours}: ${color} below the picture`);
    }
    visit.assertClean(server.url);
    await visit.close();
  }
});

test("what a link says of arrays that are not there, or are none, does no harm", async () => {
  for (const colours of ["by:nothing", "by:%zz", "by:", "by:classification:red:1:0:7", "by:height%3a:cividis:NaN:1e999"]) {
    const visit = await Visit.phone(browser);
    await openModel(visit, "hill", `&colours=${colours}`);
    if (colours === "by:nothing") {
      await visit.untilSaid(/an invalid value for colours/);
    }
    await visit.page.locator("#menu-button").click();
    await arraysOf(visit).waitFor();
    visit.assertClean(server.url);
    await visit.close();
  }
});
