// SPDX-License-Identifier: BSD-3-Clause
// A server whose models require a token: the token comes with the page's link, and is stored nowhere else.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { Server, Visit, eventually, launchBrowser, makeModels, makeToken, pause, temporaryFolder } from "./harness.mjs";
import { Proxy } from "./proxy.mjs";

const keys = join(temporaryFolder(), "tokens.json");
const log = join(temporaryFolder(), "access.log");
const secret = "0123456789abcdef0123456789abcdef";

let server, browser;

before(async () => {
  writeFileSync(keys, JSON.stringify({ secret }), { mode: 0o600 });
  server = await Server.start(makeModels({ dragon: false }), { more: ["--tokens", keys, "--access-log", log] });
  browser = await launchBrowser();
});

after(async () => {
  await browser?.close();
  await server?.stop();
});

const tokenFor = (models, detail) => makeToken(keys, "--models", models, "--detail", detail);

async function openFullScreen(visit) {
  await visit.untilIdle();
  await visit.tap(await visit.centre());
  await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
}

test("a link with a token shows the models that it is for, and is forgotten", async () => {
  const token = tokenFor("pebble", "regions");
  const visit = await Visit.phone(browser);
  await visit.open(`${server.url}/#token=${token}`);
  await openFullScreen(visit);
  assert.equal(new URL(visit.page.url()).hash, "");
  assert.deepEqual(await visit.page.evaluate(() => [...document.querySelectorAll("#models [data-model]")].map((entry) => entry.dataset.model)),
    ["pebble"]);
  assert.equal((await visit.status()).connection, "streaming");
  await visit.doubleTap(await visit.centre());
  await visit.until("a region", ({ idle, region }) => idle && region !== null && region.shown === region.partitions);

  await visit.page.reload();
  await visit.untilIdle();
  assert.equal(new URL(visit.page.url()).hash, "", "this tab knows it still");
  assert.ok(visit.requests.every((address) => !address.includes(token)), "in no address");
  assert.deepEqual(visit.errors, []);
  await visit.close();
  await server.stop();
  assert.ok(readFileSync(log, "utf8").includes("GET /api/models.json"));
  assert.ok(!readFileSync(log, "utf8").includes(token.slice(0, 20)), "nor in the log");
  server = await Server.start(makeModels({ dragon: false }), { more: ["--tokens", keys] });
});

test("without a link, and with one that has expired, the page says what is wrong", async () => {
  const without = await Visit.phone(browser);
  await without.open(server.url);
  await without.untilSaid(/requires a token: open the link that you were given/);
  // Opens the link in the same tab.
  const reloaded = without.page.waitForEvent("load");
  await without.open(`${server.url}/#token=${tokenFor("*", "levels")}`);
  await reloaded;
  await without.untilIdle();
  await without.close();

  const late = await Visit.phone(browser);
  await late.open(`${server.url}/#token=${tokenFor("*", "levels")}A`);
  await late.untilSaid(/requires a token: your link has expired/);
  await late.close();
});

test("without a token the page says whose it is, and waits for one", async () => {
  const guarded = await Server.start(makeModels({ dragon: false }),
    { more: ["--tokens", keys, "--contact", "The museum of <b>stones</b>: ann@example.org sends links."] });
  const visit = await Visit.phone(browser);
  try {
    await visit.open(guarded.url);
    await visit.untilSaid(/^The server requires a token: open the link that you were given\. The museum of <b>stones<\/b>: ann@example\.org sends links\.$/);
    assert.equal(await visit.page.locator("#message b").count(), 0);
    await visit.picture("token-2-contact");
    const asked = () => visit.requests.filter((url) => url.includes("/api/")).length;
    await pause(3000);
    const before = asked();
    await pause(9000);
    assert.equal(asked(), before, "nobody gets a token by asking again");
    await visit.page.click("#message-action");
    await visit.page.fill("#token", tokenFor("*", "levels"));
    await visit.page.keyboard.press("Enter");
    await visit.untilIdle();
    await visit.untilQuiet();
  } finally {
    await visit.close();
    await guarded.stop();
  }
});

test("a token and a view come in one link, in either order", async () => {
  const token = tokenFor("pebble", "regions");
  for (const [fragment, left] of [
    [`token=${token}&model=pebble`, "#model=pebble"],
    [`model=pebble&token=${token}`, "#model=pebble"],
    [`model=pebble&token=${token}&detail=level`, "#model=pebble&detail=level"],
  ]) {
    const visit = await Visit.phone(browser);
    await visit.open(`${server.url}/#${fragment}`);
    await visit.until(fragment, ({ mode, model, idle, shownLevel }) =>
      mode === "full screen" && model === "pebble" && idle && shownLevel !== null);
    assert.equal(new URL(visit.page.url()).hash, left, "the token has left the address");
    assert.deepEqual(await visit.messages(), []);
    await visit.close();
  }
});

test("on a server without tokens one is passed over", async () => {
  const open = await Server.start(makeModels({ dragon: false }));
  try {
    const visit = await Visit.phone(browser);
    await visit.open(`${open.url}/#token=${tokenFor("*", "levels")}&model=pebble`);
    await visit.until("the model", ({ mode, model, idle, shownLevel }) =>
      mode === "full screen" && model === "pebble" && idle && shownLevel !== null);
    assert.equal(new URL(visit.page.url()).hash, "#model=pebble");
    assert.deepEqual(await visit.messages(), []);
    await visit.close();
  } finally {
    await open.stop();
  }
});

test("a token that is entered is in no address at all", async () => {
  const token = tokenFor("pebble", "levels");
  const visit = await Visit.phone(browser);
  await visit.open(server.url);
  await visit.untilSaid(/requires a token: open the link that you were given/);
  await visit.page.click("#message-action");
  await visit.page.fill("#token", "nonsense!");
  await visit.page.getByRole("button", { name: "Enter", exact: true }).click();
  assert.match(await visit.page.locator("#token-wrong").textContent(), /^This is not a token/);
  await visit.picture("token-1-dialog");
  await visit.page.fill("#token", `${server.url}/#token=${token}`);
  await visit.page.keyboard.press("Enter");
  await visit.untilIdle();
  assert.equal(await visit.page.locator("dialog").count(), 0);
  await visit.page.reload();
  await visit.untilIdle();
  assert.equal(visit.page.url(), `${server.url}/`);
  assert.ok(visit.requests.every((address) => !address.includes(token)));
  await visit.close();
});

test("levels without the original: nothing is missing until it is asked for", async () => {
  const visit = await Visit.phone(browser);
  await visit.open(`${server.url}/#token=${tokenFor("pebble", "levels")}`);
  await openFullScreen(visit);
  await visit.pinch(await visit.centre(), 40, 320);
  assert.equal(await visit.page.locator("#hint").textContent(), "", "nobody is invited to what is refused then");
  const near = await visit.until("the finest level", ({ idle, shownLevel, finestLevel }) => idle && shownLevel === finestLevel);
  assert.equal(near.error, "");
  assert.equal(near.original, false);
  await visit.doubleTap(await visit.centre());
  await visit.untilSaid(/^Your link does not allow the original\.$/);
  await visit.close();
});

test("a token that is revoked ends the stream, and the page says so", async () => {
  const visit = await Visit.phone(browser);
  await visit.open(`${server.url}/#token=${tokenFor("*", "regions")}`);
  await openFullScreen(visit);
  writeFileSync(keys, JSON.stringify({ secret, revoked_subjects: ["ann"] }));
  await visit.untilSaid(/requires a token: your link has expired/);
  assert.equal((await visit.status()).triangles > 0, true, "what is there stays");

  // Asks for another token; then everything continues where it was.
  assert.equal(await visit.page.locator("#message-action").textContent(), "Enter it");
  await visit.page.click("#message-action");
  await visit.page.fill("#token", `${server.url}/#model=pebble&token=${makeToken(keys, "--sub", "bob", "--models", "*", "--detail", "regions")}`);
  await visit.page.keyboard.press("Enter");
  await visit.untilSaid(/^Connected again\.$/);
  await visit.doubleTap(await visit.centre());
  const { mode, error } = await visit.until("a region", ({ idle, region }) => idle && region?.shown === region?.partitions && region !== null);
  assert.equal(mode, "full screen");
  assert.equal(error, "");
  await visit.close();
});

test("where nothing streams another token can be entered, too", async () => {
  const tokenOf = (name) => makeToken(keys, "--sub", name, "--models", "*", "--detail", "regions");
  const proxy = await Proxy.start(server.port);
  proxy.streams = false;
  const visit = await Visit.phone(browser);
  try {
    await visit.open(`${proxy.url}/#token=${tokenOf("eve")}`);
    await openFullScreen(visit);
    assert.equal((await visit.status()).connection, "getting");
    writeFileSync(keys, JSON.stringify({ secret, revoked_subjects: ["ann", "eve"] }));
    await eventually("it counts no more", async () =>
      (await fetch(`${server.url}/api/models.json`, { headers: { Authorization: `Bearer ${tokenOf("eve")}` } })).status,
    (status) => status === 401);
    await visit.doubleTap(await visit.centre());
    await visit.untilSaid(/^The token has been revoked\.$/);
    assert.equal(await visit.page.locator("#message-action").textContent(), "Enter it");
    await visit.page.click("#message-action");
    await visit.page.fill("#token", tokenOf("bob"));
    await visit.page.keyboard.press("Enter");
    await visit.untilQuiet();
    await visit.doubleTap(await visit.centre());
    const { mode, error } = await visit.until("a region", ({ idle, region }) => idle && region?.shown === region?.partitions && region !== null);
    assert.equal(mode, "full screen");
    assert.equal(error, "");
  } finally {
    await visit.close();
    await proxy.stop();
  }
});
