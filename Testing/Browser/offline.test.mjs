// SPDX-License-Identifier: BSD-3-Clause
// Without a network: models that were viewed open again, a model that the user has stored opens with its original, and
// versions of the page's own files never mix. Storage that is denied, full, or cleared does no harm.

import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { cpSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, afterEach, before, beforeEach, test } from "node:test";
import { Server, Visit, eventually, launchBrowser, makeModels, pause, temporaryFolder } from "./harness.mjs";
import { difference } from "./pixels.mjs";
import { Proxy } from "./proxy.mjs";

let models, browser, server, visit;

before(async () => {
  models = makeModels({ dragon: false });
  browser = await launchBrowser();
});

after(() => browser?.close());

beforeEach(async () => {
  server = await Server.start(models);
  visit = await Visit.phone(browser);
});

afterEach(async () => {
  await visit.close();
  await server.stop();
});

const workerIsActive = () => eventually("the service worker", () => visit.page.evaluate(
  async () => (await navigator.serviceWorker.getRegistration())?.active?.state === "activated"));

// The paths of the stored blobs, and the recorded sum of their bytes together with the true one.
const stored = (page = visit.page) => page.evaluate(() => new Promise((resolve) => {
  const request = indexedDB.open("kdstream", 1);
  request.onupgradeneeded = () => request.transaction.abort(); // do not create the database here
  request.onerror = () => resolve({ paths: [], entries: 0, sum: 0, bytes: 0 });
  request.onsuccess = () => {
    const transaction = request.result.transaction(["blobs", "entries", "texts"]);
    const [paths, all, entries, bytes] = [transaction.objectStore("blobs").getAllKeys(), transaction.objectStore("blobs").getAll(),
      transaction.objectStore("entries").getAll(), transaction.objectStore("texts").get("bytes")];
    transaction.oncomplete = () => {
      request.result.close();
      resolve({ paths: paths.result, entries: entries.result.length, sum: bytes.result ?? 0,
        bytes: all.result.reduce((sum, blob) => sum + blob.byteLength, 0) });
    };
  };
}));

// Waits until all blobs that have arrived are stored.
async function untilStored() {
  let before_ = -1;
  await eventually("what is kept rests", async () => {
    const { paths } = await stored();
    const rests = paths.length > 0 && paths.length === before_;
    before_ = paths.length;
    await pause(500);
    return rests;
  });
  return stored();
}

async function openFullScreen(model) {
  await visit.choose(model);
  await visit.tap(await visit.centre());
  return visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
}

test("it can be installed", async () => {
  await visit.open(server.url);
  const address = await visit.page.evaluate(() => document.querySelector("link[rel=manifest]").href);
  const answer = await fetch(address);
  assert.equal(answer.headers.get("content-type"), "application/manifest+json");
  const { icons, start_url: start, display } = await answer.json();
  assert.equal(display, "standalone");
  assert.equal((await fetch(new URL(start, address))).status, 200);
  for (const { src, type } of icons) {
    assert.equal((await fetch(new URL(src, address))).headers.get("content-type"), type);
  }
  const touched = await visit.page.evaluate(() => document.querySelector("link[rel=apple-touch-icon]").href);
  assert.equal((await fetch(touched)).headers.get("content-type"), "image/png", "for telephones that take no other");
  await visit.untilIdle();
  await workerIsActive();
  const session = await visit.page.context().newCDPSession(visit.page);
  const { errors } = await session.send("Page.getAppManifest");
  assert.deepEqual(errors, []);
  visit.assertClean(server.url);
});

test("what was seen opens without the server, and the rest says that it is not there", async () => {
  await visit.open(server.url);
  await visit.untilIdle(); // the first model, the pebble, is opened
  const online = await visit.around(await visit.centre());
  await untilStored();
  await workerIsActive();
  await server.stop();
  await visit.page.reload();
  assert.equal((await visit.untilIdle()).model, "pebble");
  assert.ok(difference(online, await visit.around(await visit.centre())) < 0.01, "the same picture");
  await visit.untilSaid(/^The server cannot be reached\. Stored data is shown\.$/);
  const marks = () => visit.page.locator("#models .kept").filter({ visible: true }).count();
  await eventually("a mark in the list", marks, (count) => count >= 1);
  await visit.picture("offline-1-list");

  // Full screen needs blobs that were never fetched. That they are missing is not an error.
  await visit.tap(await visit.centre());
  await visit.until("full screen", ({ mode, shownLevel }) => mode === "full screen" && shownLevel !== null);
  await visit.picture("offline-2-full-screen");

  // The server comes back.
  server = await Server.start(models, { port: server.port });
  await visit.tryNow();
  await visit.until("the original", ({ idle, original }) => idle && original);
  await visit.untilQuiet();
});

test("what is kept is not fetched again while the server is there, but what is kept damaged is", async () => {
  await visit.page.addInitScript(() => Object.defineProperty(Navigator.prototype, "connection", { get: () => ({ saveData: true }) }));
  let frames = [];
  visit.page.on("websocket", (socket) => socket.on("framereceived", ({ payload }) => frames.push(payload)));
  const blobs = () => frames.filter((payload) => typeof payload !== "string").length;
  const look = async () => {
    await visit.open(`${server.url}#model=pebble`);
    await visit.until("full screen", ({ mode, idle, shownLevel }) => mode === "full screen" && idle && shownLevel !== null);
    await visit.doubleTap(await visit.centre());
    await visit.until("the region", ({ region, idle }) => idle && region?.partitions > 0 && region.shown === region.partitions);
    return visit.around(await visit.centre(), 300);
  };
  const first = await look();
  const fetched = blobs();
  assert.ok(fetched > 3, `${fetched} blobs`);
  await untilStored();

  frames = [];
  await visit.page.goto("about:blank");
  const again = await look();
  assert.equal((await visit.status()).connection, "streaming");
  assert.equal(blobs(), 0, "all of it was here");
  assert.ok(difference(first, again, 0) < 0.001, "the same picture");

  await visit.page.evaluate(() => new Promise((resolve) => {
    const request = indexedDB.open("kdstream", 1);
    request.onsuccess = () => {
      const transaction = request.result.transaction("blobs", "readwrite");
      const store = transaction.objectStore("blobs");
      store.openCursor(IDBKeyRange.lowerBound("/api/")).onsuccess = ({ target }) => {
        if (target.result) {
          const bytes = new Uint8Array(target.result.value);
          bytes[bytes.length >> 1] ^= 1;
          target.result.update(bytes.buffer);
          target.result.continue();
        }
      };
      transaction.oncomplete = () => {
        request.result.close();
        resolve();
      };
    };
  }));
  frames = [];
  await visit.page.goto("about:blank");
  const repaired = await look();
  assert.equal(blobs(), fetched, "each was fetched");
  assert.ok(difference(first, repaired, 0) < 0.001, "the same picture");
  assert.deepEqual(await visit.messages(), []);
});

test("it opens in its language without the server, too", async () => {
  const german = await launchBrowser("--lang=de", "--accept-lang=de-CH,de"); // workers do not get Playwright's locale
  const before_ = visit;
  visit = await Visit.phone(german);
  await visit.open(server.url);
  await visit.untilIdle();
  await untilStored();
  await workerIsActive();
  const kept = await visit.page.evaluate(async () => {
    const [name] = await caches.keys();
    return (await (await caches.open(name)).keys()).map(({ url }) => new URL(url).pathname).filter((path) => path.startsWith("/words/"));
  });
  assert.deepEqual(kept, ["/words/de.js"], "no other language");
  await server.stop();
  await visit.page.reload();
  await visit.untilIdle();
  assert.equal(await visit.page.getAttribute("#open", "aria-label"), "Ganzer Bildschirm");
  await german.close();
  visit = before_;
});

test("no message hides what is in the options for good", async () => {
  await visit.open(server.url);
  await visit.untilIdle();
  await openFullScreen("pebble");
  await untilStored();
  await workerIsActive();
  await server.stop();
  await visit.page.reload();
  await visit.untilSaid(/^The server cannot be reached/);
  await visit.page.locator("#menu-button").click();
  const last = visit.page.locator("#stored");
  await last.waitFor();
  await visit.page.evaluate(() => {
    const sheet = document.getElementById("menu");
    sheet.scrollTop = sheet.scrollHeight;
  });
  const [message, text] = [await visit.page.locator("#message").boundingBox(), await last.boundingBox()];
  assert.ok(text.y + text.height <= message.y, `${text.y + text.height} ${message.y}`);
});

test("a language that the address asks for is there without the server once it was used", async () => {
  const address = `${server.url}/?lang=de`;
  await visit.open(address);
  await visit.untilIdle();
  await workerIsActive();
  await visit.open(address);
  await visit.untilIdle();
  await untilStored();
  await server.stop();
  await visit.open(address);
  await visit.untilIdle();
  assert.equal(await visit.page.getAttribute("#open", "aria-label"), "Ganzer Bildschirm");
});

// Removes entries from the storage.
const forget = (store, ...keys) => visit.page.evaluate(([name, all]) => new Promise((resolve) => {
  const request = indexedDB.open("kdstream", 1);
  request.onsuccess = () => {
    const transaction = request.result.transaction(name, "readwrite");
    all.forEach((key) => transaction.objectStore(name).delete(key));
    transaction.oncomplete = () => resolve(request.result.close());
  };
}), [store, keys]);

const picturesShown = () => visit.page.evaluate(() =>
  [...document.querySelectorAll("#models img")].filter((image) => !image.hidden && image.naturalWidth > 0).length);

test("the list is quiet without a network: a model that is kept, the pictures of before, and no alarm", async () => {
  await visit.open(server.url);
  await visit.choose("shell");
  await eventually("pictures", picturesShown, (count) => count === 2);
  await untilStored();
  await workerIsActive();
  await forget("texts", "/api/models/pebble/model.json"); // the first of the list
  await server.stop();
  await visit.page.reload();
  const { model } = await visit.until("one that is kept", ({ idle, shownLevel }) => idle && shownLevel !== null);
  assert.equal(model, "shell");
  await eventually("pictures", picturesShown, (count) => count === 2);
  await visit.untilSaid(/^The server cannot be reached\. Stored data is shown\.$/);
  assert.equal(await visit.page.locator("#message").getAttribute("class"), "good", "it is no alarm");
  await visit.picture("offline-6-list");

  await forget("texts", "/api/models/shell/model.json");
  await visit.page.reload();
  await eventually("pictures", picturesShown, (count) => count === 2);
  const { mode, error } = await visit.status();
  assert.equal(mode, "no model", "none is kept");
  assert.equal(error, "");
  assert.equal(await visit.page.locator("#loading").isVisible(), false);
  assert.equal(await visit.page.locator("#message").getAttribute("class"), "good");
  await visit.picture("offline-7-list");
  await visit.page.locator('[data-model="pebble"]').click();
  await visit.untilSaid(/^“A pebble” is not stored on this device, and the server cannot be reached\.$/);
  assert.equal(await visit.page.locator("#message").getAttribute("class"), "");
  server = await Server.start(models, { port: server.port });
});

test("a model that was never seen says so", async () => {
  await visit.open(server.url);
  await visit.untilIdle();
  await untilStored();
  await workerIsActive();
  await forget("texts", "/api/models/shell/model.json");
  await server.stop();
  await visit.page.reload();
  await visit.page.locator('[data-model="shell"]').click();
  await visit.untilSaid(/^“A shell” is not stored on this device, and the server cannot be reached\.$/);
  server = await Server.start(models, { port: server.port });
});

// Parses "3 of 65 parts, 12 kB".
function figuresOf(text) {
  const [, done, all, bytes, unit] = text.match(/(\d+) of (\d+) parts, ([\d.]+)\u00a0([kM])B/);
  return { done: Number(done), all: Number(all), bytes: Number(bytes) * (unit === "M" ? 1000 : 1) };
}

// Empties the storage, as another tab would do.
const emptyStorage = () => visit.page.evaluate(() => new Promise((resolve) => {
  const request = indexedDB.open("kdstream", 1);
  request.onsuccess = () => {
    const names = [...request.result.objectStoreNames];
    const transaction = request.result.transaction(names, "readwrite");
    names.forEach((name) => transaction.objectStore(name).clear());
    transaction.oncomplete = () => resolve(request.result.close());
  };
}));

test("what is removed while a model is being kept is reported, and fetched again", async () => {
  const proxy = await Proxy.start(server.port);
  await visit.open(proxy.url);
  await openFullScreen("pebble");
  await visit.page.locator("#menu-button").click();
  await eventually("details to choose from", () => visit.page.locator("#keep-goal option").count(), (count) => count > 1);
  const button = visit.page.locator("#keep");
  const said = () => visit.page.locator("#keep-state").textContent();
  const begin = async () => {
    proxy.bytesPerSecond = 1000;
    await button.click();
    await eventually("progress", said, (text) => /^[1-9]\d* of \d+ parts, /.test(text) && figuresOf(text).bytes > 2);
  };
  await begin();
  await visit.page.locator("#empty-storage").click(); // empties it in this tab
  await eventually("a pause", said, (text) => text === "Paused: all stored data was removed.");
  assert.equal(await button.textContent(), "Keep offline");
  await pause(500);
  assert.deepEqual((await stored()).paths, [], "what was under way is not kept");

  const removed = (text) => text === "Paused: some stored data was removed.";
  await begin();
  await emptyStorage();
  proxy.bytesPerSecond = Infinity;
  await eventually("what has happened", said, removed);
  assert.equal(await button.textContent(), "Go on");
  await visit.page.locator("#stored").scrollIntoViewIfNeeded();
  await visit.picture("offline-8-removed");
  const some = (await stored()).paths.length;
  await button.click();
  await eventually("the end", said, (text) => text === "Stored: it opens offline.");
  const { paths, sum, bytes } = await stored();
  assert.ok(paths.length > some && paths.some((path) => path.endsWith("/tree/1")), `${paths.length} ${some}`);
  assert.equal(sum, bytes);

  await emptyStorage();
  await visit.page.locator("#menu-button").click();
  await visit.page.locator("#menu-button").click();
  await eventually("what has happened since", said, removed);
  await proxy.stop();
});

test("keep offline: progress, pause, going on, and the original without the server", async () => {
  const proxy = await Proxy.start(server.port);
  await visit.open(proxy.url);
  await openFullScreen("pebble");
  await workerIsActive();
  await visit.page.locator("#menu-button").click();
  await eventually("details to choose from", () => visit.page.locator("#keep-goal option").count(), (count) => count > 1);
  assert.match(await visit.page.locator("#keep-goal option").last().innerText(), /^Original, [\d.]+\u00a0[kM]B$/);
  proxy.bytesPerSecond = 1000;
  const button = visit.page.locator("#keep");
  const said = () => visit.page.locator("#keep-state").textContent();
  await button.click();
  await eventually("progress", said, (text) => /^[1-9]\d* of \d+ parts, /.test(text) && figuresOf(text).bytes > 4);
  assert.equal(await button.textContent(), "Pause");
  await button.click();
  const paused = figuresOf(await eventually("a pause", said, (text) => /^Paused after [1-9]/.test(text)));
  const { paths } = await stored();
  assert.equal(await button.textContent(), "Go on");
  await visit.page.locator("#stored").scrollIntoViewIfNeeded();
  await visit.picture("offline-3-keeping");
  await button.click();
  const next = figuresOf(await eventually("progress", said, (text) => /^\d+ of \d+ parts, /.test(text)));
  assert.ok(next.done >= paused.done && next.bytes >= paused.bytes, `it is counted on: ${JSON.stringify([paused, next])}`);
  proxy.bytesPerSecond = Infinity;
  await eventually("the end", said, (text) => text === "Stored: it opens offline.");
  const all = await stored();
  assert.ok(all.paths.length > paths.length);
  assert.equal(all.sum, all.bytes, "the sum is that of the blobs");
  assert.ok(all.paths.some((path) => path.includes("/partitions/")));

  await proxy.stop();
  await visit.page.evaluate(() => history.replaceState(null, "", new URL("/", location)));
  await visit.page.reload();
  await openFullScreen("pebble");
  for (let pinches = 0; !(await visit.status()).original; ++pinches) {
    assert.ok(pinches < 10, "the original is there");
    await visit.pinch(await visit.centre(), 100, 140);
    await visit.untilIdle();
  }
  await visit.doubleTap(await visit.centre());
  const { error } = await visit.until("a region", ({ idle, region }) => idle && region?.shown === region?.partitions && region !== null);
  assert.equal(error, "");
});

const saveData = () => Object.defineProperty(Navigator.prototype, "connection", { get: () => ({ saveData: true }) });

// Stores the whole model, or up to a level, with the options of an open page.
async function keepOffline(page = visit.page, goal = "original") {
  await page.locator("#menu-button").click();
  await eventually("details to choose from", () => page.locator("#keep-goal option").count(), (count) => count > 1);
  await page.locator("#keep-goal").selectOption(goal);
  await page.locator("#keep").click();
  await eventually("the end", () => page.locator("#keep-state").textContent(), (text) => text === "Stored: it opens offline.");
  await page.locator("#menu-button").click();
}

const untilLost = () => visit.until("the loss", ({ connection }) => connection === "lost");

async function pinchToTheOriginal() {
  for (let pinches = 0; !(await visit.status()).original; ++pinches) {
    assert.ok(pinches < 10, "the original is there");
    await visit.pinch(await visit.centre(), 100, 140);
    await visit.untilIdle();
  }
}

const untilRegion = () => visit.until("a region",
  ({ idle, region }) => idle && region !== null && region.partitions > 0 && region.shown === region.partitions);

// A model with more data than the first view needs.
let dragon = null;
async function serveTheDragon() {
  await server.stop();
  dragon ??= makeModels({ whole: true });
  server = await Server.start(dragon);
}

test("a model that is kept goes on where the server dies in mid view", async () => {
  await serveTheDragon();
  await visit.page.addInitScript(saveData);
  await visit.open(server.url);
  await openFullScreen("dragon");
  await keepOffline();
  assert.equal((await visit.status()).original, false, "there is more to see");
  await server.stop();
  await pinchToTheOriginal();
  await visit.picture("offline-9-died");
  await untilLost();
  await visit.doubleTap(await visit.centre());
  assert.equal((await untilRegion()).error, "");
  server = await Server.start(dragon, { port: server.port });
  await visit.tryNow();
  await visit.untilQuiet();
});

test("what the server owes as it dies comes from what another tab has kept meanwhile", async () => {
  await serveTheDragon();
  const proxy = await Proxy.start(server.port);
  await visit.page.addInitScript(saveData);
  await visit.open(proxy.url);
  await openFullScreen("dragon");
  const other = await visit.page.context().newPage();
  await other.goto(`${proxy.url}/#model=dragon`);
  await keepOffline(other);
  await other.close();
  proxy.holds = true;
  await visit.doubleTap(await visit.centre());
  await visit.until("waiting", ({ blobsWanted }) => blobsWanted > 0);
  await pause(300);
  assert.equal((await visit.status()).idle, false);
  await proxy.stop();
  await untilRegion();
  assert.equal((await visit.status()).connection, "lost");
});

test("what is not kept keeps nothing waiting without the server, and comes once that is back", async () => {
  await serveTheDragon();
  await visit.page.addInitScript(saveData);
  await visit.open(server.url);
  await openFullScreen("dragon");
  const { targetLevel, finestLevel } = await visit.status();
  await keepOffline(visit.page, String(finestLevel));
  assert.ok(finestLevel > targetLevel, "there is more to see");
  await server.stop();
  await visit.doubleTap(await visit.centre()); // which needs the original
  for (let pinches = 0; (await visit.status()).shownLevel < finestLevel; ++pinches) {
    assert.ok(pinches < 10, "the finest level is there");
    await visit.pinch(await visit.centre(), 100, 140);
    await visit.untilIdle();
  }
  await untilLost();
  assert.equal((await visit.status()).original, false);
  await visit.doubleTap(await visit.centre());
  await visit.untilIdle();
  assert.match(await visit.messageShown(), /^The connection to the server was lost: .* Trying again …$/);
  await visit.picture("offline-10-not-kept");
  server = await Server.start(dragon, { port: server.port });
  await visit.tryNow();
  await untilRegion();
  await visit.untilQuiet();
});

test("it is shown what is kept, limited, and emptied", async () => {
  await visit.open(server.url);
  await openFullScreen("pebble");
  const { bytes, sum } = await untilStored();
  assert.ok(bytes > 0);
  assert.equal(sum, bytes);
  await visit.page.locator("#menu-button").click();
  await eventually("how much", () => visit.page.locator("#stored").textContent(),
    (text) => text === `${Math.ceil(bytes / 1000)}\u00a0kB of 200\u00a0MB are used.`);
  await visit.page.locator("#limit").selectOption("50000000");
  await eventually("the limit", () => visit.page.locator("#stored").textContent(), (text) => text.endsWith("of 50\u00a0MB are used."));
  await visit.page.locator("#empty-storage").click();
  await eventually("nothing", () => stored(), ({ paths, entries, sum }) => !paths.length && !entries && !sum);
  await eventually("the sum is shown", () => visit.page.locator("#stored").textContent(), (text) => text.startsWith("0\u00a0kB of"));
  visit.assertClean(server.url);
});

test("beyond the limit what was used longest ago goes, and what was asked for stays", async () => {
  await visit.open(server.url);
  await visit.untilIdle();
  await untilStored();
  await visit.page.evaluate(() => new Promise((resolve) => { // pretend that much is stored
    const request = indexedDB.open("kdstream", 1);
    request.onsuccess = () => {
      const transaction = request.result.transaction(["blobs", "entries", "texts"], "readwrite");
      const put = (path, used, pinned) => {
        transaction.objectStore("blobs").put(new ArrayBuffer(10), path);
        transaction.objectStore("entries").put({ path, size: 190e6, used, pinned });
      };
      put("old", 1, 0);
      put("asked for", 1, 1);
      transaction.objectStore("texts").put(380e6, "bytes");
      transaction.oncomplete = () => resolve(request.result.close());
    };
  }));
  await visit.choose("shell");
  await visit.choose("pebble");
  const { paths } = await eventually("room", () => stored(), ({ paths: left }) => !left.includes("old"));
  assert.ok(paths.includes("asked for"));
});

for (const [name, harm] of [
  ["denied", () => Object.defineProperty(window, "indexedDB", { get() { throw new DOMException("no", "SecurityError"); } })],
  ["refused", () => (IDBFactory.prototype.open = () => { throw new DOMException("no", "UnknownError"); })],
  ["full", () => (IDBObjectStore.prototype.put = () => { throw new DOMException("full", "QuotaExceededError"); })],
]) {
  test(`storage that is ${name} harms nothing, and is reported in the options`, async () => {
    await visit.page.addInitScript(harm);
    await visit.open(server.url);
    await openFullScreen("pebble");
    await pause(600); // until arrived data would be stored
    await visit.page.locator("#menu-button").click();
    await eventually("why", () => visit.page.locator("#stored").textContent(), (text) => /^Nothing more can be stored: /.test(text));
    await visit.picture(`offline-4-${name}`);
    assert.deepEqual(await visit.messages(), []);
    visit.assertClean(server.url);
  });
}

test("storage that is cleared in between, and two tabs", async () => {
  await visit.open(server.url);
  await visit.untilIdle();
  await untilStored();
  await visit.page.evaluate(() => new Promise((resolve) => {
    const request = indexedDB.deleteDatabase("kdstream");
    request.onsuccess = resolve;
  }));
  await visit.choose("shell");
  await untilStored();

  const other = await visit.page.context().newPage();
  await other.goto(server.url);
  await eventually("the other tab", () => other.evaluate(() => window.kdstream?.status().idle));
  await Promise.all([other.locator('[data-model="shell"]').click(), visit.choose("pebble")]);
  await eventually("the other tab", () => other.evaluate(() => window.kdstream.status().idle));
  const { sum, bytes } = await untilStored();
  assert.equal(sum, bytes, "two tabs keep one sum");
  assert.deepEqual(await visit.messages(), []);
});

test("nothing that takes a token is kept", async () => {
  await visit.page.addInitScript(() => sessionStorage.setItem("token", "a.b.c"));
  await visit.open(server.url);
  await visit.untilIdle();
  await pause(600);
  await visit.page.locator("#open").click();
  await visit.page.locator("#menu-button").click();
  await visit.page.locator("#access").waitFor(); // it is there when all options are there
  assert.equal(await visit.page.locator("#offline").isVisible(), false);
  assert.equal(await visit.page.evaluate(async () => (await indexedDB.databases()).length), 0);
});

// A page with another title, and a worker that knows its files; mixed: the worker still knows those of the earlier
// page.
function otherPage({ mixed = false } = {}) {
  const folder = temporaryFolder();
  cpSync(process.env.KDSTREAM_PAGE, folder, { recursive: true });
  readdirSync(folder).filter((name) => name.endsWith(".gz")).forEach((name) => rmSync(join(folder, name)));
  const change = (name, act) => writeFileSync(join(folder, name), act(readFileSync(join(folder, name), "utf8")));
  const digest = () => createHash("sha256").update(readFileSync(join(folder, "index.html"))).digest("hex");
  const before_ = digest();
  change("index.html", (text) => text.replace(">Models<", ">Newer models<"));
  const after_ = mixed ? "0".repeat(64) : digest();
  change("worker.js", (text) => text.replaceAll(before_, after_));
  const [, version] = readFileSync(join(folder, "worker.js"), "utf8").match(/"([0-9a-f]{16})"/);
  change("worker.js", (text) => text.replaceAll(version, "f".repeat(16)));
  return folder;
}

const heading = () => visit.page.locator("h1").textContent();
const caches_ = () => visit.page.evaluate(async () => (await caches.keys()).filter((name) => name.startsWith("kdstream page")));

test("a new page comes whole, when the person wants it", async () => {
  await visit.open(server.url);
  await visit.untilIdle();
  await workerIsActive();
  await visit.page.reload();
  await visit.untilIdle();
  await server.stop();
  server = await Server.start(models, { port: server.port, web: otherPage() });
  await visit.page.reload();
  assert.equal(await heading(), "Models", "the page of before, and all of it");
  await visit.untilSaid(/^There is a newer version of this viewer\.$/);
  await visit.picture("offline-5-update");
  await visit.page.locator("#message-action").click();
  await eventually("the new page", () => heading().catch(() => ""), (text) => text === "Newer models");
  await visit.untilIdle();
  assert.equal((await caches_()).length, 1, "the old files are gone");
  assert.match((await caches_())[0], /f{16}$/);
});

test("of a server that has files of two versions nothing is taken over", async () => {
  await visit.open(server.url);
  await visit.untilIdle();
  await workerIsActive();
  const [before_] = await caches_();
  await server.stop();
  server = await Server.start(models, { port: server.port, web: otherPage({ mixed: true }) });
  await visit.page.reload();
  await visit.untilIdle();
  assert.ok(await visit.page.evaluate(async () => {
    const registration = await navigator.serviceWorker.getRegistration();
    return registration.update().then(({ installing }) => Boolean(installing), () => true);
  }), "the server's worker is another one");
  await eventually("the other worker fails", () => visit.page.evaluate(async () => {
    const { installing, waiting } = await navigator.serviceWorker.getRegistration();
    return !installing && !waiting;
  }));
  await visit.page.reload();
  await visit.untilIdle();
  assert.equal(await heading(), "Models");
  assert.deepEqual(await caches_(), [before_]);
  assert.deepEqual(await visit.messages(), []);
});
