// SPDX-License-Identifier: BSD-3-Clause
// No false alarms: what the page shows on a slow network before there is a picture, and texts that fit the device.

import assert from "node:assert/strict";
import { afterEach, beforeEach, test } from "node:test";
import { Visit, landscape, longest, makeModels, portrait, startForTests } from "./harness.mjs";
import { Proxy } from "./proxy.mjs";

let server, browser, proxy, visit;

startForTests(() => makeModels({ dragon: false }), (started) => ({ server, browser } = started));

beforeEach(async () => {
  proxy = await Proxy.start(server.port);
});

afterEach(async () => {
  await visit.close();
  await proxy.stop();
});

const loading = () => visit.page.evaluate(() => {
  const box = document.getElementById("loading");
  return box?.checkVisibility() ? document.getElementById("loading-text").textContent : "";
});

const settled = (seconds) => new Promise((resolve) => setTimeout(resolve, 1000 * seconds));

async function untilLoading(pattern) {
  for (const end = Date.now() + longest; !pattern.test(await loading()); await settled(0.05)) {
    assert.ok(Date.now() < end, `never came: ${pattern}; instead “${await loading()}”`);
  }
}

test("at 10 kB/s it tells how much has come, and raises no alarm", async () => {
  proxy.bytesPerSecond = 10_000;
  visit = await Visit.phone(browser);
  await visit.page.goto(proxy.url, { waitUntil: "commit" });
  await untilLoading(/Loading the viewer/);
  while (!(await visit.page.evaluate(() => document.styleSheets.length))) {
    await settled(0.05); // until the style sheet has arrived, the browser shows nothing
  }
  const begin = Date.now();
  const texts = new Set();
  while (!(await visit.page.evaluate(() => window.kdstream))) {
    texts.add(await loading());
    assert.equal(await visit.messageShown(), "", "no alarm while it loads");
    if (texts.size === 30) {
      await visit.picture("slow-1-loading");
    }
    await settled(0.1);
  }
  assert.ok(Date.now() - begin > 8000, "it took long");
  const parts = [...texts].map((text) => Number(/(\d+)\u00a0%/.exec(text)?.[1])).filter((part) => part >= 0);
  assert.ok(parts.length > 20 && parts.every((part, i) => !i || part > parts[i - 1]), `it grows: ${parts}`);
  await visit.untilIdle();
  assert.equal(await loading(), "");
  assert.deepEqual(await visit.messages(), []);
  await visit.picture("slow-2-loaded");
});

test("where nothing comes for long, it says so, and goes on with what comes then", async () => {
  proxy.bytesPerSecond = 200_000;
  proxy.stallsAt = 60_000;
  visit = await Visit.phone(browser);
  await visit.page.goto(proxy.url);
  await visit.untilSaid(/^The server has sent nothing for a while\. Still waiting …$/);
  await visit.picture("slow-3-silent");
  proxy.goOn();
  await visit.untilIdle();
  await visit.untilQuiet();
});

test("a viewer that is not there is reported at once", async () => {
  visit = await Visit.phone(browser);
  await visit.page.route("**/kdstream.wasm", (route) => route.fulfill({ status: 404, body: "" }));
  await visit.page.goto(proxy.url);
  await visit.untilSaid(/^The viewer could not be loaded from the server\.$/);
  assert.equal(await loading(), "");
});

async function openFullScreen(model) {
  await visit.choose(model);
  await visit.tap(await visit.centre());
  return visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
}

// The number of lines of an element's text.
const lines = (id) => visit.page.evaluate((name) => {
  const element = document.getElementById(name);
  const range = document.createRange();
  range.selectNodeContents(element);
  return new Set([...range.getClientRects()].map(({ top }) => Math.round(top))).size;
}, id);

const box = (id) => visit.page.locator(`#${id}`).boundingBox();

for (const [name, viewport] of [["portrait", portrait], ["landscape", landscape]]) {
  test(`the picture fills the screen, and captions lie over its edges: ${name}`, async () => {
    visit = await Visit.phone(browser, viewport);
    await visit.open(server.url);
    await openFullScreen("pebble");
    assert.deepEqual(await box("view"), { x: 0, y: 0, ...viewport });
    const foot = await visit.page.locator("#hint").textContent() ? "hint" : "status";
    assert.equal(await lines(foot), 1);
    assert.ok((await box(foot)).y > 0.85 * viewport.height, "at its foot");
    await visit.page.evaluate(() => {
      document.getElementById("title").firstChild.data = "A very long title ".repeat(20);
    });
    const { x, y, width, height } = await box("title");
    assert.ok(y + height < viewport.height / 2, "at its head");
    assert.ok(name === "portrait" || x + width < viewport.width / 2, "a long title leaves room");
    await visit.picture(`slow-4-captions-${name}`);
  });
}

test("a legend of the colours of detail, which the list does not keep", async () => {
  visit = await Visit.phone(browser);
  await visit.open(server.url);
  await openFullScreen("pebble");
  assert.equal(await visit.page.locator("#legend").isVisible(), false);
  await visit.page.locator("#menu-button").click();
  assert.match(await visit.page.locator("#menu").innerText(), /around a double tap/);
  await visit.page.locator("[name=coloring][value='resolution']").check({ force: true });
  await visit.page.locator("#menu-button").click();
  await visit.untilIdle();
  await visit.page.locator("#legend li").first().waitFor();
  const legend = await visit.page.locator("#legend li").allInnerTexts();
  const { shownLevel, original } = await visit.status();
  assert.equal(legend[0].trim(), original ? "Original" : `Level\u00a0${shownLevel}`);
  const colours = await visit.page.locator("#legend rect").evaluateAll((all) => all.map((one) => getComputedStyle(one).fill));
  assert.equal(new Set(colours).size, legend.length, "a colour each");
  await visit.picture("slow-5-legend");
  await visit.back();
  assert.equal(await visit.page.locator("#legend").isVisible(), false);
  await visit.untilIdle();
  await visit.picture("slow-6-list");
  assert.equal(await visit.page.evaluate(() => document.getElementById("menu").elements.coloring.value), "own");
});

test("on a desktop: double click, and no frame around the picture after a key", async () => {
  visit = await Visit.desktop(browser);
  await visit.open(server.url);
  await visit.choose("pebble");
  const { x, y } = await visit.centre();
  await visit.page.mouse.click(x, y);
  await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
  await visit.page.keyboard.press("ArrowLeft");
  const frame = () => visit.page.evaluate(() => getComputedStyle(document.getElementById("view")).outlineStyle);
  assert.equal(await visit.page.evaluate(() => document.activeElement.id), "view");
  assert.equal(await frame(), "none");
  await visit.page.locator("#menu-button").click();
  assert.match(await visit.page.locator("#menu").innerText(), /around a double click/);
  await visit.picture("slow-7-desktop");
  await visit.page.keyboard.press("Escape");
  await visit.page.locator("#home").focus();
  for (let i = 0; i < 20 && await visit.page.evaluate(() => document.activeElement.id !== "view"); ++i) {
    await visit.page.keyboard.press("Shift+Tab");
  }
  assert.equal(await frame(), "solid", "who comes by keyboard sees where he is");
});
