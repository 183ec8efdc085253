// SPDX-License-Identifier: BSD-3-Clause
// The address of a model, m/ID: in a browser, without scripts, with a token, and offline; and the address of a model
// that was removed.

import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { Server, Visit, makeModels, makeToken, startForTests, temporaryFolder } from "./harness.mjs";

let server, browser;
startForTests(() => makeModels({ dragon: false }), (started) => ({ server, browser } = started));

const path = (visit) => new URL(visit.page.url()).pathname;
const isOpen = (wanted) => ({ mode, model, idle, shownLevel }) =>
  mode === "full screen" && model === wanted && idle && shownLevel !== null;

test("the address of a model opens it, and a model that is opened has it", async () => {
  const visit = await Visit.phone(browser);
  await visit.open(`${server.url}/m/pebble`);
  await visit.until("the pebble", isOpen("pebble"));
  assert.equal(await visit.page.title(), "A pebble – KdStream");
  assert.deepEqual(await visit.messages(), []);
  await visit.picture("pages-1-address");
  await visit.page.click("#back");
  await visit.until("the list", ({ mode }) => mode === "browsing");
  await visit.choose("shell");
  await visit.tap(await visit.centre());
  await visit.until("the shell", isOpen("shell"));
  assert.equal(path(visit), "/m/shell");
  await visit.page.reload();
  await visit.until("the shell again", isOpen("shell"));
  assert.equal(path(visit), "/m/shell");
  visit.assertClean(server.url);
  await visit.close();
});

test("a link that is copied has it, and older links open the same", async () => {
  const visit = await Visit.desktop(browser);
  await visit.open(`${server.url}/#model=pebble`);
  await visit.until("the pebble", isOpen("pebble"));
  await visit.page.evaluate(() => {
    Object.defineProperty(navigator, "clipboard", { value: { writeText: async (text) => (window.copied = text) } });
  });
  await visit.page.click("#tools-button");
  await visit.showTool("Copy link");
  await visit.page.getByRole("button", { name: "Copy link" }).click();
  const link = await visit.page.evaluate(() => window.copied);
  assert.match(link, /^http:\/\/127\.0\.0\.1:\d+\/m\/pebble#model=pebble&digest=[0-9a-f]{8}&view=[\w-]{47}$/);
  const other = await Visit.desktop(browser);
  await other.open(link);
  await other.until("the pebble", isOpen("pebble"));
  assert.deepEqual(await other.messages(), []);
  await other.close();
  await visit.close();
});

test("without scripts there are texts and a picture", async () => {
  const context = await browser.newContext({ javaScriptEnabled: false, viewport: { width: 412, height: 915 } });
  const page = await context.newPage();
  const pictures = [];
  page.on("response", (response) => response.url().endsWith("picture.jpg") && pictures.push(response));
  const answer = await page.goto(`${server.url}/m/pebble`, { waitUntil: "networkidle" });
  assert.equal(answer.status(), 200);
  assert.equal(await page.locator("#no-script h1").innerText(), "A pebble");
  assert.match(await page.locator("#no-script").innerText(), /9,024 triangles/);
  assert.equal(pictures.length, 1);
  assert.equal(pictures[0].status(), 200);
  assert.equal(pictures[0].headers()["content-type"], "image/jpeg");
  if (process.env.KDSTREAM_PICTURES) {
    await page.screenshot({ path: join(process.env.KDSTREAM_PICTURES, "pages-2-no-script.png") });
    writeFileSync(join(process.env.KDSTREAM_PICTURES, "pages-2-picture.jpg"), await pictures[0].body());
  }
  await page.locator("#no-script a").click();
  assert.deepEqual(await page.locator("#no-script li").allInnerTexts(), ["A pebble", "A shell"]);
  assert.deepEqual(await page.locator("#no-script li").evaluateAll((all) => all.map((each) => getComputedStyle(each).listStylePosition)),
    ["inside", "inside"], "bullets stand beside their titles");
  await page.goto(server.url); // a page made of files
  await page.locator("#no-script a").click();
  await page.locator("#no-script li a").last().click(); // a locator by text does not search in here
  assert.equal(await page.locator("#no-script h1").innerText(), "A shell");
  await context.close();
});

test("a model that is gone is 404, and the page shows the others", async () => {
  const visit = await Visit.phone(browser);
  const answer = await visit.page.goto(`${server.url}/m/nowhere`);
  assert.equal(answer.status(), 404);
  await visit.untilSaid(/nowhere/);
  await visit.until("the list", ({ mode }) => mode === "browsing");
  assert.equal(await visit.page.locator("#models [data-model]").count(), 2);
  await visit.picture("pages-3-gone");
  await visit.close();
});

test("with tokens the page is 401 until there is one", async () => {
  const keys = join(temporaryFolder(), "keys.json");
  writeFileSync(keys, JSON.stringify({ secret: "0123456789abcdef0123456789abcdef" }), { mode: 0o600 });
  const guarded = await Server.start(makeModels({ dragon: false }), { more: ["--tokens", keys, "--contact", "Ask Ann."] });
  try {
    const visit = await Visit.phone(browser);
    const answer = await visit.page.goto(`${guarded.url}/m/pebble`);
    assert.equal(answer.status(), 401);
    assert.doesNotMatch(await answer.text(), /A pebble/);
    await visit.untilSaid(/Ask Ann\./);
    await visit.picture("pages-4-token");
    const token = makeToken(keys, "--models", "pebble", "--detail", "levels");
    await visit.page.goto("about:blank");
    await visit.open(`${guarded.url}/m/pebble#token=${token}`);
    await visit.until("the pebble", isOpen("pebble"));
    assert.equal(visit.page.url(), `${guarded.url}/m/pebble`, "the token has left the address");
    await visit.close();
  } finally {
    await guarded.stop();
  }
});

test("it opens offline, where the model is kept", async () => {
  const own = await Server.start(makeModels({ dragon: false }));
  const visit = await Visit.phone(browser);
  await visit.open(`${own.url}/m/pebble`);
  await visit.until("the pebble", isOpen("pebble"));
  await visit.page.evaluate(() => navigator.serviceWorker.ready);
  await visit.page.reload(); // now by the service worker, which gives the same page
  await visit.until("the pebble", isOpen("pebble"));
  await visit.page.waitForTimeout(1000); // arrived data is stored in bundles
  await own.stop();
  await visit.page.reload();
  await visit.until("the pebble", isOpen("pebble"));
  assert.equal(path(visit), "/m/pebble");
  await visit.close();
});
