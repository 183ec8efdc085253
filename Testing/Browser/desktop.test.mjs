// SPDX-License-Identifier: BSD-3-Clause
// The same page on a desktop: mouse, wheel, double click and keys stand in for fingers.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Visit, makeModels, startForTests } from "./harness.mjs";
import { difference } from "./pixels.mjs";

let server, browser;

startForTests(() => makeModels({ vase: true }), async (started) => {
  ({ server, browser } = started);
});

test("mouse, wheel, double click and keys", async () => {
  const visit = await Visit.desktop(browser);
  const { page } = visit;
  await visit.open(server.url);
  await visit.untilIdle();
  await visit.picture("desktop-1-list");
  let middle = await visit.centre();
  await page.mouse.click(middle.x, middle.y);
  const full = await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
  middle = await visit.centre();

  const drag = async (dx, dy, button) => {
    const before_ = await visit.around(middle);
    await page.mouse.move(middle.x, middle.y);
    await page.mouse.down({ button });
    await page.mouse.move(middle.x + dx, middle.y + dy, { steps: 4 });
    await page.mouse.up({ button });
    await visit.untilIdle();
    assert.ok(difference(before_, await visit.around(middle)) > 0.05, `a drag with the ${button} button`);
  };
  await drag(80, 0, "left");
  await drag(-80, 0, "left");
  await drag(0, 60, "right");
  await drag(0, -60, "right");

  let status = full;
  for (let i = 0; i < 20 && !status.original; ++i) {
    await page.mouse.wheel(0, -100);
    status = await visit.untilIdle();
  }
  assert.ok(status.original, "the wheel zooms in, to the original");
  await visit.picture("desktop-2-wheel");

  await page.mouse.dblclick(middle.x, middle.y);
  const { region } = await visit.until("the whole region",
    ({ region: it, idle }) => idle && it !== null && it.partitions > 0 && it.shown === it.partitions);
  await visit.picture("desktop-3-region");
  await page.mouse.dblclick(middle.x + 100, middle.y - 60);
  await visit.until("another region",
    ({ region: it, idle }) => idle && it !== null && it.cell !== region.cell && it.shown === it.partitions);

  for (let i = 0; i < 40 && status.targetLevel > 11; ++i) {
    await page.mouse.wheel(0, 100);
    status = await visit.untilIdle();
  }
  assert.equal(status.targetLevel, 11, "and out again, where the preview does");
  await page.keyboard.press("Escape");
  await visit.until("back to the list", ({ mode }) => mode === "browsing");
  assert.deepEqual(await visit.messages(), []);
  visit.assertClean(server.url);
  await visit.close();
});

// Chromium does not send these events; what the page does with Safari's events can be tested with simulated ones.
test("a pinch on Safari's trackpad zooms", async () => {
  const visit = await Visit.desktop(browser);
  const { page } = visit;
  await visit.open(server.url);
  await visit.untilIdle();
  await page.mouse.click(...Object.values(await visit.centre()));
  await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
  const middle = await visit.centre();
  const seen = async () => {
    await visit.untilIdle();
    return visit.around(middle, 400);
  };
  // Sends gesture events with these scales (relative to the start) to the canvas. Returns whether the browser may still
  // do its default action.
  const pinch = (...scales) => page.evaluate(([{ x, y }, all]) => ["gesturestart", ...all].map((scale, at) => {
    const event = new Event(at ? "gesturechange" : scale, { bubbles: true, cancelable: true });
    Object.assign(event, { scale: at ? scale : 1, clientX: x, clientY: y });
    return document.getElementById("view").dispatchEvent(event);
  }), [middle, scales]);

  const far = await seen();
  await page.mouse.move(middle.x, middle.y);
  await page.mouse.wheel(0, -100);
  const near = await seen();
  assert.ok(difference(far, near) > 0.05, "the wheel zooms in");
  await page.keyboard.press("h");
  assert.ok(difference(far, await seen()) < 0.01);
  assert.deepEqual(await pinch(1.2, 0.9, Math.exp(0.2)), [false, false, false, false], "the browser does not zoom the page");
  assert.ok(difference(near, await seen()) < 0.01, "a pinch of the same factor shows the same");
  await pinch(Math.exp(-0.2));
  assert.ok(difference(far, await seen()) < 0.01, "the next one begins anew");
  await page.mouse.down(); // on a phone, gesture events come together with pointer events
  await pinch(1.5);
  await page.mouse.up();
  assert.ok(difference(far, await seen()) < 0.01, "what fingers do is not done twice");
  visit.assertClean(server.url);
  await visit.close();
});

// The first view, by button, by key, and by a double click beside the model; and back to the previous view.
test("home and back", async () => {
  const visit = await Visit.desktop(browser);
  const { page } = visit;
  await visit.open(server.url);
  await visit.untilIdle();
  await page.mouse.click(...Object.values(await visit.centre()));
  await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
  const middle = await visit.centre();
  const seen = async () => {
    await visit.untilIdle();
    await visit.untilQuiet();
    return visit.around(middle, 400);
  };
  const same = (one, other) => difference(one, other) < 0.01;
  const first = await seen();
  assert.ok(await page.locator("#undo").isDisabled(), "there is nothing to take back");

  await page.focus("#view");
  for (const key of ["ArrowLeft", "ArrowUp", "ArrowUp", "+", "+"]) {
    await page.keyboard.press(key);
  }
  const moved = await seen();
  assert.ok(!await same(first, moved));
  await visit.picture("desktop-6-moved");
  const beside = { x: middle.x - 440, y: middle.y + 220 };
  const ways = {
    button: [() => page.click("#home"), () => page.click("#undo")],
    key: [() => page.keyboard.press("h"), () => page.keyboard.press("u")],
    "other key": [() => page.keyboard.press("Home"), () => page.keyboard.press("Backspace")],
    "double click": [() => page.mouse.dblclick(beside.x, beside.y), () => page.click("#undo")],
  };
  for (const [name, [home, undo]] of Object.entries(ways)) {
    if (name.endsWith("key")) {
      await page.focus("#view");
    }
    await home();
    assert.ok(await same(first, await seen()), `home by ${name}`);
    assert.ok((await visit.status()).canUndo);
    await undo();
    assert.ok(await same(moved, await seen()), `and back, after ${name}`);
    assert.ok(await page.locator("#undo").isDisabled());
  }
  await page.click("#home");
  await visit.picture("desktop-7-home");
  assert.deepEqual(await visit.messages(), []);
  visit.assertClean(server.url);
  await visit.close();
});

// After a drag ends, the model turns on and comes to rest; if the system asks for reduced motion, it does not.
test("turning on", async () => {
  for (const motion of ["no-preference", "reduce"]) {
    // A small window, so that frames are quick.
    const visit = await Visit.desktop(browser, { reducedMotion: motion, viewport: { width: 360, height: 300 } });
    await visit.open(server.url);
    await visit.untilIdle();
    const framesTurning = await visit.countFrames("turnsOn");
    await visit.throwMouse(await visit.centre(), 80, 0);
    await visit.page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
    await visit.until("rest", (status) => status.idle && !status.turnsOn);
    assert.equal(await framesTurning() > 0, motion === "no-preference", "whether it was seen to turn on");
    visit.assertClean(server.url);
    await visit.close();
  }
});

// Free turning, chosen in the menu, tilts the horizon; "upright" levels it again.
test("turning freely", async () => {
  const visit = await Visit.desktop(browser);
  const { page } = visit;
  await visit.open(server.url);
  await visit.untilIdle();
  await page.mouse.click(...Object.values(await visit.centre()));
  await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
  const choose = async (label) => {
    await page.click("#menu-button");
    await page.getByText(label, { exact: true }).filter({ visible: true }).click();
    await page.keyboard.press("Escape");
    await visit.untilIdle();
    await visit.untilQuiet();
  };
  const middle = await visit.centre();
  const level = await visit.around(middle, 400);
  // Moves along the edge of the ball, which rolls the model if turning is free.
  const aroundTheEdge = async () => {
    await page.mouse.move(middle.x + 350, middle.y);
    await page.mouse.down();
    for (let i = 1; i <= 8; ++i) {
      await page.mouse.move(middle.x + 350 * Math.cos(0.1 * i), middle.y + 350 * Math.sin(0.1 * i));
    }
    await page.mouse.up();
    await visit.untilIdle();
  };
  await choose("Free");
  await aroundTheEdge();
  await visit.picture("desktop-8-free");
  const leaning = await visit.around(middle, 400);
  assert.ok(difference(level, leaning) > 0.05);
  await choose("Upright");
  await visit.picture("desktop-9-upright");
  assert.ok(difference(leaning, await visit.around(middle, 400)) > 0.05, "it is level again");
  visit.assertClean(server.url);
  await visit.close();
});

// The model's own colours, stone, and colours of partitions: the menu offers those that are available.
test("a coloured model", async () => {
  const visit = await Visit.desktop(browser);
  const { page } = visit;
  await visit.open(server.url);
  const plain = await visit.untilIdle();
  assert.equal(plain.colored, false);
  await visit.choose("vase");
  await visit.choose("vase");
  await visit.until("the vase", ({ model, mode, idle }) => model === "vase" && mode === "full screen" && idle);
  assert.equal((await visit.status()).colored, true);
  await visit.picture("desktop-4-colours");
  const middle = await visit.centre();
  const coloured = await visit.around(middle);

  const show = async (label) => {
    await page.click("#menu-button");
    const shown = await page.locator("#menu label:has([name=coloring])").filter({ visible: true }).allInnerTexts();
    await page.getByText(label, { exact: true }).filter({ visible: true }).click();
    await page.keyboard.press("Escape");
    await visit.untilQuiet();
    return shown;
  };
  assert.deepEqual(await show("Stone"), ["Colours", "Stone", "Pieces", "Detail"]);
  const stone = await visit.around(middle);
  assert.ok(difference(coloured, stone) > 0.3, "stone is not the colours");
  await visit.picture("desktop-5-stone");
  await show("Colours");
  assert.ok(difference(coloured, await visit.around(middle)) < 0.01, "and back");

  await visit.back();
  await visit.choose("pebble");
  await visit.choose("pebble");
  await visit.until("the pebble", ({ model, mode, idle }) => model === "pebble" && mode === "full screen" && idle);
  assert.deepEqual(await show("Stone"), ["Stone", "Pieces", "Detail"]);
  assert.deepEqual(await visit.messages(), []);
  visit.assertClean(server.url);
  await visit.close();
});
