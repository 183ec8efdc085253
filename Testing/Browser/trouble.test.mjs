// SPDX-License-Identifier: BSD-3-Clause
// Errors, and what the user then reads: one sentence for each, and the page is still usable.

import assert from "node:assert/strict";
import { rmSync } from "node:fs";
import { join } from "node:path";
import { after, afterEach, before, beforeEach, test } from "node:test";
import { Server, Visit, eventually, launchBrowser, makeModels } from "./harness.mjs";
import { difference } from "./pixels.mjs";
import { Proxy } from "./proxy.mjs";

let models, server, browser, proxy, visit;

before(async () => {
  browser = await launchBrowser();
});

after(() => browser?.close());

beforeEach(async () => {
  models = makeModels({ dragon: false });
  server = await Server.start(models);
  proxy = await Proxy.start(server.port);
  visit = await Visit.phone(browser);
});

afterEach(async () => {
  await visit.close();
  await proxy.stop();
  await server.stop();
});

const flipLast = (bytes) => {
  bytes[bytes.length - 1] ^= 1;
  return bytes;
};
const setVersion = (bytes) => {
  bytes[3] = 9; // a version that does not exist yet
  return bytes;
};

// Shows one level for the whole model, so that partitions arrive only after a double tap.
async function openFullScreen(model) {
  await visit.presetDetail(1); // before choosing: that opens a model whose preview is already shown
  await visit.choose(model);
  await visit.tap(await visit.centre());
  return visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
}

// Checks that another model can be viewed, down to the original.
async function assertUsable(model = "shell") {
  if ((await visit.status()).mode === "full screen") {
    await visit.back();
  }
  await openFullScreen(model);
  await visit.doubleTap(await visit.centre());
  const { error } = await visit.until(`a region of ${model}`,
    ({ idle, region }) => idle && region !== null && region.partitions > 0 && region.shown === region.partitions);
  assert.equal(error, "");
  await visit.untilQuiet();
}

for (const way of ["streamed", "got"]) {
  test(`a partition with a wrong checksum, ${way}`, async () => {
    proxy.streams = way === "streamed";
    let damaged = null;
    proxy.alterBlob = (name, bytes) => {
      damaged ??= name.startsWith("partitions/") ? name : null;
      return name === damaged ? flipLast(bytes) : bytes;
    };
    await visit.open(proxy.url);
    await openFullScreen("pebble");
    await visit.doubleTap(await visit.centre());
    const status = await visit.until("all but one partition",
      ({ idle, region }) => idle && region !== null && region.shown === region.partitions - 1);
    assert.equal(proxy.altered, 1);
    await visit.untilSaid(/is missing/);
    assert.match(await visit.messageShown(),
      new RegExp(`^A part of “A pebble” is missing \\(${damaged}\\): .*its checksum is wrong\\.$`));
    assert.equal(status.connection, way === "streamed" ? "streaming" : "getting");
    await visit.picture(`trouble-checksum-${way}`);
    // The blob is correct again: the page gets it when the user asks it to try again.
    proxy.alterBlob = null;
    await visit.page.locator("#message-action").click();
    await visit.until("the whole region", ({ idle, region }) => idle && region !== null && region.shown === region.partitions);
    await visit.untilQuiet();
    await assertUsable();
  });

  test(`an unknown codec version, ${way}`, async () => {
    proxy.streams = way === "streamed";
    await visit.open(proxy.url);
    await visit.untilIdle();
    proxy.alterBlob = (name, bytes) => (name.startsWith("levels/") ? setVersion(bytes) : bytes);
    await visit.page.locator('[data-model="shell"]').click();
    await visit.untilSaid(/^There is a newer version of this viewer\.$/);
    assert.equal(await visit.page.locator("#message-action").textContent(), "Reload");
    assert.equal((await visit.status()).connection, way === "streamed" ? "streaming" : "getting");
    await visit.picture(`trouble-version-${way}`);
    proxy.alterBlob = null;
    await assertUsable("pebble");
  });

  test(`a blob cut short, ${way}`, async () => {
    proxy.streams = way === "streamed";
    await visit.open(proxy.url);
    await openFullScreen("pebble");
    proxy.alterBlob = (name, bytes) => (name.startsWith("partitions/") ? bytes.subarray(0, bytes.length - 9) : bytes);
    await visit.doubleTap(await visit.centre());
    await visit.untilSaid(way === "streamed" ? /connection to .* was lost: .*Trying again/ : /is missing .*its checksum is wrong/);
    await visit.picture(`trouble-short-${way}`);
    proxy.alterBlob = null;
    if (way === "streamed") {
      await visit.untilSaid(/^Connected again\.$/);
    }
    await assertUsable();
  });
}

test("a frame without its head", async () => {
  await visit.open(proxy.url);
  await openFullScreen("pebble");
  proxy.alterFrame = (message) => message.subarray(0, 10);
  await visit.doubleTap(await visit.centre());
  await visit.untilSaid(/connection to .* was lost: .*Trying again/);
  await visit.picture("trouble-frame");
  proxy.alterFrame = null;
  await visit.untilSaid(/^Connected again\.$/);
  // The blobs that were requested before then arrive without another action.
  await visit.until("the whole region",
    ({ idle, region }) => idle && region !== null && region.partitions > 0 && region.shown === region.partitions);
  await assertUsable();
});

test("a model that is removed from the server", async () => {
  await visit.open(server.url);
  await openFullScreen("pebble");
  rmSync(join(models, "pebble.kds"));
  server.rereadModels();
  await server.untilGone("pebble");
  await visit.back();
  await visit.untilSaid(/^“A pebble” is no longer on the server\./);
  assert.deepEqual(await visit.page.locator("#models [data-model]").evaluateAll((all) => all.map((one) => one.dataset.model)),
    ["shell"]);
  await visit.picture("trouble-removed");
  await assertUsable();
});

test("a model that is removed before it is opened", async () => {
  await visit.open(server.url);
  await visit.choose("shell");
  rmSync(join(models, "pebble.kds"));
  server.rereadModels();
  await server.untilGone("pebble");
  await visit.page.locator('[data-model="pebble"]').click();
  await visit.untilSaid(/^Pebble cannot be opened: there is no model pebble\.$/);
  await visit.picture("trouble-removed-before");
  await assertUsable();
});

test("a lost WebGL context", async () => {
  await visit.open(server.url);
  await openFullScreen("pebble");
  const before_ = await visit.around(await visit.centre());
  await visit.page.evaluate(() => {
    window.losing = document.getElementById("view").getContext("webgl2").getExtension("WEBGL_lose_context");
    window.losing.loseContext();
  });
  await visit.untilSaid(/^The device has stopped the 3D drawing\./);
  await visit.picture("trouble-context");
  const { frames } = await visit.status();
  await visit.page.evaluate(() => window.losing.restoreContext());
  await visit.until("a picture again", (status) => status.frames > frames && status.idle);
  await visit.untilQuiet();
  assert.ok(difference(before_, await visit.around(await visit.centre())) < 0.01, "the picture is as it was");
  await assertUsable();
});

test("no WebGL 2: a sentence, not a blank page", async () => {
  const without = await launchBrowser("--disable-3d-apis");
  try {
    const other = await Visit.phone(without);
    await other.open(server.url);
    await other.untilSaid(/^This browser cannot draw in 3D: it has no WebGL 2/);
    assert.match(await other.messageShown(), /WebGL 2/);
    await other.picture("trouble-no-webgl");
  } finally {
    await without.close();
  }
});

// Waits until the list shows a picture of each model.
const untilPictures = () => eventually("the list's pictures", () => visit.page.evaluate(() =>
  [...document.querySelectorAll("#models img")].every((image) => !image.hidden && image.naturalWidth > 0)));

const isThere = ({ mode, model, idle, shownLevel }, wanted) =>
  mode === "full screen" && model === wanted && idle && shownLevel !== null;

test("a link with a wrong value is reported, and its model opens all the same", async () => {
  for (const [value, message] of [
    ["view=zzz", /^This link to a view has an invalid value for view\.$/],
    [`view=${"A".repeat(3000)}`, /^This link to a view is too long\.$/],
    ["region=1.9&colours=%zz", /value for region\.$/],
  ]) {
    await visit.open("about:blank");
    await visit.open(`${server.url}/#model=shell&${value}`);
    await visit.until(value, (status) => isThere(status, "shell"));
    await visit.untilSaid(message);
    await visit.page.click("#dismiss");
    assert.equal(await visit.page.locator("#loading").isVisible(), false, "nothing loads for ever");
  }
  await visit.picture("trouble-link");
  await visit.back();
  await untilPictures();
});

test("a link to a model that is not there is reported, and the list can be used", async () => {
  for (const model of ["nowhere", "", "%F0%9F%8F%BA"]) {
    await visit.open("about:blank");
    await visit.open(`${server.url}/#model=${model}`);
    await visit.until("the list", ({ mode, idle, shownLevel }) => mode === "browsing" && idle && shownLevel !== null);
    await visit.untilSaid(model === "nowhere" ? /^The server has no model .nowhere.\.$/ : /value for model\.$/);
    await visit.page.click("#dismiss");
    assert.equal(await visit.page.locator("#loading").isVisible(), false);
  }
  await untilPictures();
  await visit.choose("shell");
  await visit.untilQuiet();
});

// Random numbers from 0 to 1 that are the same in every run (mulberry32).
function numbersFrom(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let mixed = Math.imul(state ^ (state >>> 15), 1 | state);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), 61 | mixed)) ^ mixed;
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 2 ** 32;
  };
}

// Keys that exist and keys that do not, with valid and invalid values, in any order.
function anyFragment(number) {
  const pick = (all) => all[Math.floor(number() * all.length)];
  const letters = "AZaz09-_.:=&%#?/+~ \u00e9\u{1f3fa}";
  const noise = (most) => Array.from({ length: Math.floor(number() * most) }, () => pick([...letters])).join("");
  const value = () => pick([() => pick(["shell", "pebble"]), () => noise(60), () => "A".repeat(pick([19, 40, 47, 3000])),
    () => pick(["free", "level", "full", "1.1", "64.2", "by:x:y", "partition", "own", "%", "%00", "", "a.b.c"])])();
  const keys = ["model", "digest", "view", "turning", "detail", "region", "distances", "section", "lamps", "colours", "light", "notes", "x", ""];
  const entry = () => (number() < 0.1 ? noise(40) : `${pick(keys)}=${value()}`);
  return [...(number() < 0.6 ? [`model=${pick(["shell", "pebble"])}`] : []), ...Array.from({ length: Math.floor(number() * 5) }, entry)].join("&");
}

test("whatever follows the # there is a picture, and nothing loads for ever", async () => {
  const number = numbersFrom(18);
  const isOfUse = ({ mode, idle, shownLevel }) => mode !== "no model" && idle && shownLevel !== null;
  for (let i = 0; i < 30; ++i) {
    const fragment = anyFragment(number);
    if (i % 6 === 0) { // like a visitor who comes from another page
      await visit.open("about:blank");
      await visit.open(`${server.url}/#${fragment}`);
    } else {
      await visit.page.evaluate((hash) => {
        location.hash = hash;
      }, fragment);
    }
    await visit.until(`a picture for #${fragment}`, isOfUse);
    assert.equal(await visit.page.locator("#loading").isVisible(), false, fragment);
  }
  assert.deepEqual(visit.errors, []);
  assert.equal(await visit.page.locator("#models button").count(), 2);
});
