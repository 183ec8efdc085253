// SPDX-License-Identifier: BSD-3-Clause
// What the page says to people who have never seen it: help, a finger that shows the gestures, figures only in the
// details, and lengths in readable units and digits.

import assert from "node:assert/strict";
import { join } from "node:path";
import { test } from "node:test";
import { Visit, eventually, makeModels, pause, portrait, runProgram, startForTests } from "./harness.mjs";
import { describeLengths, formatError, formatLength } from "../../viewer/mobile/web/lengths.js";

globalThis.document = { documentElement: { dir: "ltr" } }; // needed for lengths

let server, browser;
const long = "The museum of a town with a very long name ".repeat(4).trim();

startForTests(() => {
  const models = makeModels({ dragon: false });
  runProgram("kdstream-store", "edit", join(models, "pebble.kds"), "--quiet", "--credit", long, "--license", "All rights reserved", "--unit", "m");
  return models;
}, async (started) => {
  ({ server, browser } = started);
});

async function openPebble(visit, more = "") {
  await visit.open(`${server.url}/${more}#model=pebble`);
  return visit.until("full screen", ({ mode, idle, shownLevel }) => mode === "full screen" && idle && shownLevel !== null);
}

test("lengths have the unit and the digits that one reads", () => {
  const plain = (text) => text.replaceAll("\u00a0", " ");
  for (const [value, error, unit, text, bound] of [
    [0.1254921, 4e-4, "m", "12.55 cm", "0.04 cm"],
    [0.1254921, 4e-8, "m", "12.549 cm", ""],
    [0.1254921, 0, "m", "12.549 cm", ""],
    [5.296e-4, 1e-9, "m", "529.60 µm", ""],
    [0.004, 1.2e-5, "metre", "4.00 mm", "0.02 mm"],
    [3.2e-5, 0, "m", "32 µm", ""],
    [1234567, 3, "mm", "1.2346 km", ""],
    [1234567, 3000, "mm", "1.235 km", "0.003 km"],
    [2, 0.25, "cubits", "2.0 cubits", "0.3 cubits"],
    [0, 0.1, "mm", "0 mm", "0.1 mm"],
    [7, 0, "", "7", ""],
  ]) {
    assert.equal(plain(formatLength(value, error, unit)), text, `${value} ± ${error} ${unit}`);
    assert.equal(plain(formatError(error, unit, value)), bound, `the bound of ${value} ${unit}`);
  }
  assert.equal(plain(formatLength(0.02, 1e-3, "m", 0.5)), "2.0 cm", "as the length that it belongs to");
  assert.equal(plain(describeLengths([0.3, 0.2, 0.1], "m")), "30 × 20 × 10 cm");
});

test("levels and triangles are shown only in the details", async () => {
  const visit = await Visit.phone(browser);
  await openPebble(visit);
  assert.match(await visit.page.locator("#status").textContent(), /^(Original)?$/);
  assert.doesNotMatch(await visit.page.locator("#stage").innerText(), /triangles|Level/);
  await visit.page.click("#about-button");
  await visit.page.locator("#about summary").click();
  assert.match(await visit.page.locator("#details").textContent(), /^(Up to|Level) .+ · [\d,]+ triangles$/);
  await visit.picture("people-1-details");
  await visit.page.keyboard.press("Escape");
  await visit.doubleTap(await visit.centre());
  await visit.until("a region", ({ idle, region }) => idle && region?.partitions > 0 && region.shown === region.partitions);
  assert.equal(await visit.page.locator("#status").textContent(), "Original");
  visit.assertClean(server.url);
  await visit.close();
});

test("the picture has the whole screen, and what is written over it is read whole", async () => {
  for (const viewport of [portrait, { width: 1280, height: 800 }]) {
    const visit = await Visit.phone(browser, viewport);
    await openPebble(visit);
    const view = await visit.page.locator("#view").boundingBox();
    assert.deepEqual(view, { x: 0, y: 0, ...viewport });
    const cut = await visit.page.evaluate(() => [...document.querySelectorAll("#title, #credit > *")].filter((each) => each.checkVisibility()
      && (each.scrollWidth > each.clientWidth || each.scrollHeight > each.clientHeight + 1)).map(({ textContent }) => textContent));
    assert.deepEqual(cut, []);
    await visit.picture(`people-2-full-${viewport.width}`);
    await visit.close();
  }
});

test("beside the list the credit breaks, too", async () => {
  const visit = await Visit.phone(browser);
  await visit.open(server.url);
  await visit.until("the preview of the first", ({ mode, model, idle }) => mode === "browsing" && model === "pebble" && idle);
  const lines = await visit.page.locator("#credit > :first-child").evaluate((each) => each.clientHeight / parseFloat(getComputedStyle(each).fontSize));
  assert.ok(lines > 2, `${lines} times its letters' height`);
  await visit.picture("people-5-beside-the-list");
  await visit.close();
});

test("help by its button and by ?", async () => {
  for (const [make, what] of [[Visit.phone, "One finger"], [Visit.desktop, "Drag"]]) {
    const visit = await make(browser);
    await openPebble(visit);
    await visit.page.click("#help-button");
    await eventually("help", () => visit.page.locator("#help dt").allTextContents(), (all) => all[0] === what);
    await visit.picture(`people-3-help-${what.replace(" ", "-")}`);
    await visit.page.keyboard.press("Escape");
    assert.equal(await visit.page.locator("#help").isVisible(), false);
    assert.equal(await visit.page.evaluate(() => document.activeElement.id), "help-button");
    await visit.page.keyboard.press("?");
    await visit.page.locator("#help dt").first().waitFor();
    await visit.page.getByRole("button", { name: "Close", exact: true }).click();
    assert.equal(await visit.page.locator("#help").isVisible(), false);
    visit.assertClean(server.url);
    await visit.close();
  }
});

test("a finger shows once how one turns a model, and nobody who wants nothing to move", async () => {
  const visit = await Visit.phone(browser, portrait, { reducedMotion: "no-preference" });
  await openPebble(visit);
  await visit.page.locator("#finger").waitFor();
  await visit.picture("people-4-finger");
  await visit.tap({ x: 30, y: 300 });
  await visit.page.locator("#finger").waitFor({ state: "detached" });
  await visit.page.reload();
  await visit.untilIdle();
  await pause(1000);
  assert.equal(await visit.page.locator("#finger").count(), 0);
  await visit.close();
  const still = await Visit.phone(browser);
  await openPebble(still);
  assert.ok(still.requests.every((url) => !url.endsWith("/help.js")));
  await still.close();
});
