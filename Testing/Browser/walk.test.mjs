// SPDX-License-Identifier: BSD-3-Clause
// A user's walk on a phone: the list and its live preview, full screen, zooming in and out, two taps on interesting
// places, and back. In portrait the detail depends on the view; in landscape there is one level for the whole model.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Visit, landscape, makeModels, portrait, startForTests } from "./harness.mjs";
import { difference } from "./pixels.mjs";

let server, browser;

startForTests(() => makeModels({ whole: true }), async (started) => {
  ({ server, browser } = started);
});

// Pinches until level `goal` is shown. Returns the last status.
async function pinchTo(visit, goal) {
  const first = (await visit.untilIdle()).shownLevel;
  const direction = Math.sign(goal - first);
  let last = first;
  for (let pinches = 0; last !== goal; ++pinches) {
    assert.ok(pinches < 25, `${pinches} pinches lead from level ${first} to ${last}, not to ${goal}`);
    // Pinches in small steps near the goal, because neighbouring levels may be nearly equally close to the original.
    const wide = Math.abs(goal - last) > 1 ? 140 : 120;
    const [from, to] = direction > 0 ? [100, wide] : [wide, 100];
    await visit.pinch(await visit.centre(), from, to);
    const { shownLevel, targetLevel } = await visit.untilIdle();
    assert.equal(shownLevel, targetLevel, "what is asked for is shown");
    assert.ok((shownLevel - last) * direction >= 0, `level ${shownLevel} comes after ${last}`);
    last = shownLevel;
  }
  return visit.status();
}

// Pinches nearer until the original is shown, and back. Returns the status before.
async function pinchToTheOriginal(visit, name) {
  const start = await visit.untilIdle();
  let near = start;
  for (let pinches = 0; !near.original; ++pinches) {
    assert.ok(pinches < 25, "pinching leads to the original");
    await visit.pinch(await visit.centre(), 100, 140);
    near = await visit.untilIdle();
    assert.ok(near.triangles < 400_000, `${near.triangles} triangles are within a phone's budget`);
  }
  await visit.picture(`${name}-5-pinched`);
  for (let pinches = 0; near.original; ++pinches) {
    assert.ok(pinches < 25, "pinching leads away from the original");
    await visit.pinch(await visit.centre(), 140, 100);
    near = await visit.untilIdle();
  }
  await visit.picture(`${name}-5-away`);
  return near;
}

// Pinches through three levels, and back.
async function pinchThroughLevels(visit, name, finest) {
  const start = await pinchTo(visit, finest - 3);
  await visit.picture(`${name}-4-before-pinch`);
  const near = await pinchTo(visit, finest);
  await visit.picture(`${name}-5-pinched`);
  const far = await pinchTo(visit, finest - 3);
  assert.ok(far.triangles === start.triangles && far.triangles < near.triangles / 6);
  await pinchTo(visit, finest - 2);
  return visit.status();
}

async function walk(name, viewport, elsewhere, detail) {
  const visit = await Visit.phone(browser, viewport);
  await visit.open(server.url);
  const byView = detail === 0;

  // The list, and the first model's preview in the strip below it.
  const preview = await visit.untilIdle();
  assert.equal(preview.mode, "browsing");
  assert.equal(preview.model, "dragon");
  assert.equal(preview.shownLevel, 11, "a preview is level 11");
  assert.deepEqual(await visit.page.locator("#models [data-model]").evaluateAll((all) => all.map((one) => one.dataset.model)),
    ["dragon", "pebble"]);
  await visit.picture(`${name}-1-list`);

  // The preview is live: it can show another model, and it turns under a finger.
  const dragon = await visit.around(await visit.centre());
  await visit.choose("pebble");
  await visit.picture(`${name}-2-other`);
  const pebble = await visit.around(await visit.centre());
  assert.ok(difference(dragon, pebble) > 0.1, "another model is another picture");
  await visit.choose("dragon");
  const unturned = await visit.around(await visit.centre());
  assert.ok(difference(dragon, unturned) < 0.01, "the same model is the same picture");
  await visit.drag(await visit.centre(), 60, 0);
  await visit.untilIdle();
  assert.ok(difference(unturned, await visit.around(await visit.centre())) > 0.05, "one finger turns");
  assert.equal((await visit.status()).mode, "browsing", "turning is no tap");
  await visit.drag(await visit.centre(), -60, 0);

  // A tap opens the full screen, at a suitable level.
  await visit.tap(await visit.centre());
  await visit.until("full screen", ({ mode }) => mode === "full screen");
  await visit.setDetail(detail);
  const full = await visit.untilIdle();
  assert.ok(full.shownLevel > preview.shownLevel, "more room, no less detail");
  assert.equal(full.region, null);
  await visit.picture(`${name}-3-full-screen`);
  const fullPicture = await visit.around(await visit.centre());
  await visit.dragTwo(await visit.centre(), 0, 40);
  await visit.untilIdle();
  assert.ok(difference(fullPicture, await visit.around(await visit.centre())) > 0.05, "two fingers pan");
  await visit.dragTwo(await visit.centre(), 0, -40);

  const level = byView ? await pinchToTheOriginal(visit, name) : await pinchThroughLevels(visit, name, full.finestLevel);

  // A double tap shows the original of the region around it.
  const middle = await visit.centre();
  const before_ = await visit.around(middle);
  await visit.doubleTap(middle);
  const first = await visit.until("the whole region",
    ({ region, idle }) => idle && region !== null && region.shown === region.partitions);
  assert.ok(first.region.partitions > 0);
  assert.ok(first.triangles > level.triangles);
  assert.equal(first.shownLevel, byView ? level.finestLevel : level.shownLevel, "around it all stays as it was");
  await visit.picture(`${name}-6-region`);
  const finer = difference(before_, await visit.around(middle), 8);
  assert.ok(finer > (byView ? 0.01 : 0.05), `the region looks finer: ${finer}`);
  assert.match(await visit.page.locator("#status").textContent(), /^Original$/);

  // A double tap elsewhere moves the region there.
  await visit.doubleTap({ x: middle.x + elsewhere.x, y: middle.y + elsewhere.y });
  const second = await visit.until("another region",
    ({ region, idle }) => idle && region !== null && region.cell !== first.region.cell && region.shown === region.partitions);
  assert.ok(second.region.partitions > 0);
  await visit.picture(`${name}-7-elsewhere`);

  // And back to the list.
  const back = await visit.back();
  assert.equal(back.region, null);
  const again = await visit.untilIdle();
  assert.equal(again.shownLevel, 11);
  await visit.picture(`${name}-8-back`);
  assert.ok(difference(dragon, await visit.around(await visit.centre())) < 0.01, "the preview is as it was");
  assert.deepEqual(await visit.messages(), [], "nothing had to be said");
  visit.assertClean(server.url);
  await visit.close();
}

test("portrait", () => walk("portrait", portrait, { x: 60, y: -60 }, 0));
test("landscape", () => walk("landscape", landscape, { x: 110, y: -40 }, 1));

test("the page comes compressed", async () => {
  const visit = await Visit.phone(browser);
  const [answer] = await Promise.all([
    visit.page.waitForResponse((response) => response.url().endsWith("kdstream.wasm")),
    visit.open(server.url),
  ]);
  assert.equal(answer.headers()["content-encoding"], "gzip");
  assert.equal(answer.headers()["content-type"], "application/wasm");
  await visit.close();
});
