// SPDX-License-Identifier: BSD-3-Clause
// Tokens are remembered only if the user wants this, and a server's refusals are explained in plain words.

import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { Server, Visit, eventually, launchBrowser, makeModels, makeToken, temporaryFolder } from "./harness.mjs";

const folder = temporaryFolder();
const keys = join(folder, "tokens.json");

let models, browser;

before(async () => {
  writeFileSync(keys, JSON.stringify({ secret: "0123456789abcdef0123456789abcdef" }), { mode: 0o600 });
  models = makeModels({ dragon: false });
  browser = await launchBrowser();
});

after(() => browser?.close());

const tokenFor = (detail) => makeToken(keys, "--models", "*", "--detail", detail);

async function withServer(more, act) {
  const server = await Server.start(models, { more });
  const visit = await Visit.phone(browser);
  try {
    await act(visit, server);
  } finally {
    await visit.page.context().close();
    await server.stop();
  }
}

const kept = (page) => page.evaluate(() => [Object.values(localStorage), Object.values(sessionStorage)]
  .map((values) => values.some((value) => value.split(".").length === 3)));

async function enter(visit, token, remembers) {
  await visit.page.click("#message-action");
  await visit.page.fill("#token", token);
  if (remembers) {
    await visit.page.getByLabel("Remember it in this browser").check();
  }
  await visit.page.getByRole("button", { name: "Enter", exact: true }).click();
  await visit.untilIdle();
}

test("a token is remembered by the tab alone", () => withServer(["--tokens", keys], async (visit, server) => {
  await visit.open(server.url);
  await visit.untilSaid(/open the link that you were given/);
  await enter(visit, tokenFor("levels"), false);
  assert.deepEqual(await kept(visit.page), [false, true]);
  const other = await visit.page.context().newPage();
  await other.goto(server.url);
  await eventually("a message in another tab", () => other.locator("#message-text").textContent(), (text) => /requires a token/.test(text));
}));

test("or by the browser, where the person wants it, until it is forgotten", () => withServer(["--tokens", keys], async (visit, server) => {
  await visit.open(server.url);
  await visit.untilSaid(/open the link that you were given/);
  await enter(visit, tokenFor("levels"), true);
  assert.deepEqual(await kept(visit.page), [true, true]);
  await visit.page.close();

  visit.page = await visit.page.context().newPage();
  const { page } = visit;
  await page.goto(server.url);
  await eventually("the list", () => page.evaluate(() => window.kdstream?.status().idle && window.kdstream.status().shownLevel !== null));
  await page.locator("#open").click();
  await page.locator("#menu-button").click();
  const box = page.getByLabel("Remember it in this browser");
  assert.ok(await box.isChecked());
  await page.screenshot({ path: join(process.env.KDSTREAM_PICTURES, "access-1-options.png") });
  await box.uncheck();
  assert.deepEqual(await kept(page), [false, false], "this tab has it still, in its memory");
  await box.check();
  assert.deepEqual(await kept(page), [true, false]);
  await page.getByRole("button", { name: "Forget it now" }).click();
  await eventually("the question", () => page.locator("#message-text").textContent(), (text) => /requires a token: open the link/.test(text));
  assert.deepEqual(await kept(page), [false, false]);
}));

test("a link's token can be remembered later; who cancels is asked again", () => withServer(["--tokens", keys], async (visit, server) => {
  await visit.open(`${server.url}/#token=${tokenFor("levels")}`);
  await visit.untilIdle();
  assert.deepEqual(await kept(visit.page), [false, true]);
  await visit.page.locator("#open").click();
  await visit.page.locator("#menu-button").click();
  await visit.page.getByLabel("Remember it in this browser").check();
  assert.deepEqual(await kept(visit.page), [true, true]);
  await visit.page.getByRole("button", { name: "Forget it now" }).click();
  await eventually("the question", () => visit.page.locator("#message-text").textContent().catch(() => ""), (text) => /open the link/.test(text));
  await visit.page.click("#message-action");
  await visit.page.getByRole("button", { name: "Cancel", exact: true }).click();
  await eventually("no dialog", () => visit.page.locator("dialog").count(), (count) => count === 0);
  assert.match(await visit.messageShown(), /requires a token/);
  await visit.page.click("#message-action");
  await visit.page.locator("#access-dialog").waitFor();
  await visit.page.keyboard.press("Escape");
  await eventually("no dialog", () => visit.page.locator("dialog").count(), (count) => count === 0);
}));

test("a browser that keeps nothing does what it can", () => withServer(["--tokens", keys], async (visit, server) => {
  await visit.page.addInitScript(() => {
    for (const name of ["localStorage", "sessionStorage", "indexedDB"]) {
      Object.defineProperty(window, name, { get() { throw new DOMException("no", "SecurityError"); } });
    }
  });
  await visit.open(`${server.url}/#token=${tokenFor("levels")}`);
  await visit.untilIdle();
  await visit.page.locator("#open").click();
  await visit.page.locator("#menu-button").click();
  const box = visit.page.getByLabel("Remember it in this browser");
  await box.click();
  assert.equal(await box.isChecked(), false, "it does not pretend to");
  assert.deepEqual(visit.errors, []);
}));

for (const [what, answer, said] of [
  ["too many requests, with an end", { status: 429, headers: { "Retry-After": "42" } },
    /^The list of models cannot be loaded: too many requests; the server answers again in 42 seconds\. Trying again …$/],
  ["too many requests, for long", { status: 429, headers: { "Retry-After": "1200" } },
    /the server answers again at \d{1,2}:\d\d [AP]M\. Trying again …$/],
  ["too many requests", { status: 429 }, /: too many requests\. Trying again …$/],
  ["a busy server", { status: 503, headers: { "Retry-After": "1" } }, /: the server is busy; it answers again in 1 second\. Trying again …$/],
  ["a proxy without a server", { status: 502 }, /: the server is busy\. Trying again …$/],
  ["what is not allowed", { status: 403 }, /: your link does not allow this\. Trying again …$/],
  ["what is not there", { status: 404 }, /: the server does not have it\. Trying again …$/],
  ["what nobody knows", { status: 418 }, /: the server says 418\. Trying again …$/],
]) {
  test(`in words: ${what}`, () => withServer([], async (visit, server) => {
    await visit.page.route("**/api/models.json", (route) => route.fulfill({ body: "{}", contentType: "application/json", ...answer }));
    await visit.open(server.url);
    await visit.untilSaid(said);
    assert.equal(await visit.page.locator("#message-action").textContent(), "Try now");
    await visit.page.unroute("**/api/models.json");
    await visit.tryNow();
    await visit.untilIdle();
    await visit.untilQuiet();
  }));
}

test("a quota that is used up says until when, and in the person's language", () => {
  const quotas = join(folder, "quotas.sqlite");
  return withServer(["--tokens", keys, "--quota-file", quotas, "--quota-partitions", "10%", "--quota-window", "7200"], async (visit, server) => {
    await visit.open(`${server.url}/?lang=de#token=${tokenFor("regions")}`);
    await visit.untilIdle();
    await visit.page.locator("#open").click();
    await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
    await visit.doubleTap(await visit.centre());
    await visit.untilSaid(/^Ihr Kontingent für dieses Modell ist verbraucht; wieder um \d{1,2}:\d\d/);
    await visit.picture("access-2-quota");
    assert.ok((await visit.status()).triangles > 0, "what is there stays");
  });
});

test("a token for less than is asked for says so", () => withServer(["--tokens", keys], async (visit, server) => {
  await visit.open(`${server.url}/#token=${makeToken(keys, "--models", "shell", "--detail", "levels")}`);
  await visit.untilIdle();
  await visit.page.evaluate(() => {
    location.hash = "model=pebble";
  });
  await visit.untilSaid(/^The server has no model 'pebble'\.$/);
}));
