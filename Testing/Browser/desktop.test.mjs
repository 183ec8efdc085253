// The same page on a desktop: mouse, wheel, double click and keys stand in for fingers.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { Pixels, Server, Visit, launchBrowser, makeModels } from "./harness.mjs";

let server, browser, pixels;

before(async () => {
  server = await Server.start(makeModels());
  browser = await launchBrowser();
  pixels = await Pixels.make(browser);
});

after(async () => {
  await browser?.close();
  await server?.stop();
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
    assert.ok(await pixels.difference(before_, await visit.around(middle)) > 0.05, `a drag with the ${button} button`);
  };
  await drag(80, 0, "left");
  await drag(-80, 0, "left");
  await drag(0, 60, "right");
  await drag(0, -60, "right");

  let status = full;
  for (let i = 0; i < 20 && status.shownLevel < full.shownLevel + 2; ++i) {
    await page.mouse.wheel(0, -100);
    status = await visit.untilIdle();
  }
  assert.equal(status.shownLevel, full.shownLevel + 2, "the wheel zooms in, level by level");
  await visit.picture("desktop-2-wheel");

  await page.mouse.dblclick(middle.x, middle.y);
  const { region } = await visit.until("the whole region",
    ({ region: it, idle }) => idle && it !== null && it.partitions > 0 && it.shown === it.partitions);
  await visit.picture("desktop-3-region");
  await page.mouse.dblclick(middle.x + 100, middle.y - 60);
  await visit.until("another region",
    ({ region: it, idle }) => idle && it !== null && it.cell !== region.cell && it.shown === it.partitions);

  for (let i = 0; i < 40 && status.shownLevel > full.shownLevel; ++i) {
    await page.mouse.wheel(0, 100);
    status = await visit.untilIdle();
  }
  assert.equal(status.shownLevel, full.shownLevel, "and out again");
  await page.keyboard.press("Escape");
  await visit.until("back to the list", ({ mode }) => mode === "browsing");
  assert.deepEqual(await visit.messages(), []);
  visit.assertClean(server.url);
  await visit.close();
});
