// SPDX-License-Identifier: BSD-3-Clause
// The walk and the tools in engines other than Chromium: a short try of what is tested thoroughly in Chromium. A visit
// is a PageVisit that also has `home`, the address of the list, and drag, wheel and press (firefox.mjs, webkit.mjs).

import assert from "node:assert/strict";
import { difference } from "./pixels.mjs";

export const fullScreen = (visit) => visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);

export async function openPebble(visit) {
  await visit.open(visit.home);
  await visit.untilIdle();
  await visit.choose("pebble");
  const { x, y } = await visit.centre();
  await visit.page.mouse.click(x, y);
  return fullScreen(visit);
}

// Opens the panel of tools, or closes it.
export async function turnPanel(visit) {
  await visit.page.click("#tools-button");
  await visit.untilIdle();
}

// The list, a model, turning the wheel until the original is shown, a double click for a region, and back.
export async function walk(name, visit) {
  await visit.open(visit.home);
  const { model } = await visit.untilIdle();
  assert.equal(model, "pebble");
  await visit.picture(`${name}-1-list`);
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
  await visit.picture(`${name}-2-full-screen`);
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
  await visit.picture(`${name}-3-wheel`);
  await visit.page.mouse.click(middle.x, middle.y, { count: 2 });
  await visit.until("the whole region", ({ region, idle }) => idle && region?.partitions > 0 && region.shown === region.partitions);
  await visit.picture(`${name}-4-region`);
  assert.match(await visit.page.evaluate(() => document.getElementById("status").textContent), /^Original$/);
  await visit.page.keyboard.press("Escape");
  await visit.until("back to the list", ({ mode }) => mode === "browsing");
  assert.deepEqual(await visit.messages(), []);
  await visit.assertClean(visit.home);
}

// The tools: views from the sides, a distance, a section, light.
export async function useTools(name, visit) {
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
  const text = await visit.page.evaluate(() => document.querySelector("#measurements li span").textContent);
  const [, distance] = text.match(/^([\d.]+)(?: ± \S+)?, height -?[\d.]+, across [\d.]+$/) ?? assert.fail(text);
  assert.ok(Number(distance) > 0.05 && Number(distance) < 2.2, text);
  await visit.picture(`${name}-5-distance`);
  await visit.press("Remove");

  const whole = await visit.around(middle, 200);
  await visit.press("Facing me");
  const { depth } = await visit.until("it is cut", (status) => status.depth !== null && status.idle);
  assert.ok(depth > 0 && depth < 1);
  assert.ok(difference(whole, await visit.around(middle, 200)) > 0.2, "the cut face is seen");
  await visit.picture(`${name}-6-section`);
  await visit.press("None");
  await visit.until("it is whole", (status) => status.depth === null && status.idle);

  await visit.press("Light from the finger");
  await turnPanel(visit);
  const standard = await visit.around(middle, 300);
  await visit.drag(middle, -120, 20);
  await visit.until("there is a lamp", ({ lamp: light, idle }) => light !== undefined && idle);
  assert.ok(difference(standard, await visit.around(middle, 300)) > 0.1, "light from the side");
  await visit.picture(`${name}-7-light`);
  assert.deepEqual(await visit.messages(), []);
  await visit.assertClean(visit.home);
}
