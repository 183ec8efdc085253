// SPDX-License-Identifier: BSD-3-Clause
// The page's memory on a phone is never more than its budget, whatever the view. A phone may take memory from a page,
// or put it to sleep: the view continues afterwards.
//
// The test is small by default: a relief of 400,000 triangles, with a budget of 32 MB. If KDSTREAM_BIG_STORE names a
// folder with a store big.kds, that store is used instead, with the budget of phones.

import assert from "node:assert/strict";
import { join } from "node:path";
import { after, afterEach, before, beforeEach, test } from "node:test";
import { setFlagsFromString } from "node:v8";
import { runInNewContext } from "node:vm";
import { Server, Visit, buildStore, eventually, launchBrowser, makeModels, pause, runProgram, temporaryFolder } from "./harness.mjs";
import { difference } from "./pixels.mjs";

const megabyte = 1e6;
const small = 32; // MB
const bigFolder = process.env.KDSTREAM_BIG_STORE;

let models, server, browser, visit, session;

before(async () => {
  models = makeModels({ dragon: false });
  const meshes = temporaryFolder();
  runProgram("kdstream-generate", "relief", join(meshes, "relief.ply"), "--vertices", "200000", "--quiet");
  buildStore(join(meshes, "relief.ply"), join(models, "relief.kds"), "--title", "A relief");
  browser = await launchBrowser();
});

after(() => browser?.close());

beforeEach(async () => {
  server = await Server.start(models);
  visit = await Visit.phone(browser);
  session = await visit.page.context().newCDPSession(visit.page);
});

afterEach(async () => {
  await visit.close();
  await server.stop();
});

// Random numbers between 0 and 1 that are the same in each run.
function seeded(seed) {
  let state = seed;
  return () => (state = (state * 1103515245 + 12345) % 2 ** 31) / 2 ** 31;
}

async function openFullScreen(url, model) {
  await visit.open(url);
  await visit.choose(model);
  await visit.tap(await visit.centre());
  await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
}

// Zooms, turns or taps.
async function lookAround(random) {
  const centre = await visit.centre();
  const place = { x: centre.x + 160 * (random() - 0.5), y: centre.y + 240 * (random() - 0.5) };
  const action = random();
  if (action < 0.35) {
    await visit.pinch(place, 60, 60 + 140 * random());
  } else if (action < 0.55) {
    await visit.pinch(place, 180, 80 + 60 * random());
  } else if (action < 0.75) {
    await visit.drag(place, 200 * (random() - 0.5), 200 * (random() - 0.5));
  } else {
    await visit.doubleTap(place);
  }
}

async function memory() {
  const { memory: taken } = await visit.status();
  assert.ok(taken.pieces > 0 && taken.graphics > 0, "something is there");
  assert.ok(taken.pieces < taken.used && taken.used < taken.heap, "parts of parts");
  return taken;
}

// Zooms and taps. Every third time it does not wait for the previous step.
async function viewManyTimes(url, model, megabytes, views) {
  await openFullScreen(url, model);
  const random = seeded(1);
  const heaps = [];
  let most = 0;
  let cut = 0; // steps at which the budget forces a much coarser view
  for (let step = 0; step < views; ++step) {
    await lookAround(random);
    if (step % 3) {
      const { errorLeft } = await visit.untilIdle();
      cut += errorLeft > 2;
    }
    const { budget, heap, graphics } = await memory();
    assert.equal(budget, megabytes * megabyte);
    assert.ok(heap + graphics <= budget, `step ${step}: ${heap} + ${graphics} bytes`);
    heaps.push(heap);
    most = Math.max(most, heap + graphics);
  }
  const { error, triangles } = await visit.untilIdle();
  assert.equal(error, "");
  assert.ok(triangles > 10_000, "and there is something to see");
  // How much arrives in the meantime depends on the machine's speed.
  assert.ok(heaps.at(-1) <= 1.1 * heaps[views / 2], `the heap is flat: ${heaps[views / 2]} bytes, then ${heaps.at(-1)}`);
  return { most, cut };
}

test("many zooms and taps stay within a small budget", async (t) => {
  const { most, cut } = await viewManyTimes(`${server.url}/?memory=${small}`, "relief", small, 50);
  t.diagnostic(`${(most / megabyte).toFixed(1)} MB at most, ${cut} times much coarser than the finest`);
  assert.ok(cut > 0, "it was small enough");
  await visit.picture("memory-small");
  visit.assertClean(server.url);
});

test("a hundred zooms and taps at a huge model stay within the standard budget", { skip: !bigFolder }, async (t) => {
  const big = await Server.start(bigFolder);
  try {
    const { most } = await viewManyTimes(big.url, "big", 150, 100);
    t.diagnostic(`${(most / megabyte).toFixed(1)} MB at most`);
    await visit.picture("memory-big");
  } finally {
    await big.stop();
  }
});

for (const [asked, budget] of [["", 150], ["?memory=much", 150], ["?memory=-3", 150], ["?memory=0", 150], ["?memory=1", 32], ["?memory=64.5", 64.5], ["?memory=1e9", 400]]) {
  test(`the budget of an address that ends in "${asked}" is ${budget} MB`, async () => {
    await visit.open(`${server.url}/${asked}`);
    await visit.untilIdle();
    assert.equal((await memory()).budget, budget * megabyte);
  });
}

test("a context that is lost while one zooms, again and again", async () => {
  await openFullScreen(`${server.url}/?memory=${small}`, "relief");
  const centre = await visit.centre();
  await visit.page.evaluate(() => {
    window.losing = document.getElementById("view").getContext("webgl2").getExtension("WEBGL_lose_context");
  });
  for (let round = 0; round < 6; ++round) {
    await visit.pinch(centre, 60, 100);
    await visit.page.evaluate(() => window.losing.loseContext());
    await visit.untilSaid(/^The device has stopped the 3D drawing\./);
    assert.equal((await visit.status()).memory.graphics, 0);
    await visit.pinch(centre, 60, 90); // is nevertheless taken into account
    const { frames } = await visit.status();
    await visit.page.evaluate(() => window.losing.restoreContext());
    await visit.until("a picture again", (status) => status.frames > frames && status.idle);
    await visit.untilQuiet();
  }
  const { heap, graphics } = await memory();
  assert.ok(heap + graphics <= small * megabyte);
  const { triangles, error } = await visit.status();
  assert.equal(error, "");
  assert.ok(triangles > 10_000);
  await assertRightPicture();
});

// Checks that the picture is the same as that of a new page with the same view.
async function assertRightPicture() {
  await visit.untilIdle();
  const link = await linkToView();
  const seen = await visit.around(await visit.centre());
  const other = await Visit.phone(browser);
  try {
    await other.open(`${server.url}/?memory=${small}${link}`);
    await other.until("the same view", ({ mode, idle, shownLevel }) => mode === "full screen" && idle && shownLevel !== null);
    const fresh = await other.around(await other.centre());
    assert.ok(difference(seen, fresh) < 0.05, "the picture is that of a fresh page");
  } finally {
    await other.close();
  }
}

async function linkToView() {
  await visit.page.evaluate(() => {
    Object.defineProperty(navigator, "clipboard", { configurable: true, value: { writeText: async (text) => (window.copied = text) } });
  });
  await visit.page.locator("#tools-button").click();
  await visit.page.locator("#copy-link").click();
  const link = await visit.page.evaluate(() => window.copied);
  await visit.page.locator("#tools-button").click();
  return new URL(link).hash;
}

// Does what a browser does to a hidden tab: sends the event, and runs no frames.
async function hide(hidden) {
  await visit.page.evaluate(async (hides) => {
    Object.defineProperty(document, "hidden", { configurable: true, get: () => hides });
    if (hides) {
      window.askForFrame = window.requestAnimationFrame;
      window.framesPutOff = [];
      window.requestAnimationFrame = (draw) => window.framesPutOff.push(draw);
      await new Promise((drawn) => window.askForFrame(drawn)); // wait for the frame that was requested before
    } else {
      window.requestAnimationFrame = window.askForFrame;
      window.framesPutOff.forEach((draw) => requestAnimationFrame(draw));
    }
    document.dispatchEvent(new Event("visibilitychange"));
  }, hidden);
}

// Waits without frames, because a hidden page has none. (The functions of Visit need frames.)
async function untilUnseen(what, condition) {
  return eventually(what, () => visit.status(), condition);
}

test("a tab in the background: what comes meanwhile is kept, and drawn when it is seen again", async () => {
  await openFullScreen(`${server.url}/?memory=${small}`, "relief");
  const before_ = await visit.status();
  await visit.pinch(await visit.centre(), 60, 150);
  await hide(true);
  const { frames } = await visit.status();
  await untilUnseen("nothing is on its way", ({ blobsWanted }) => blobsWanted === 0);
  const { heap, graphics } = await memory();
  assert.ok(heap + graphics <= small * megabyte);
  assert.equal((await visit.status()).frames, frames, "nothing is drawn");
  await hide(false);
  await visit.pinch(await visit.centre(), 60, 100);
  const shown = await visit.until("a newer picture", (status) => status.idle && status.frames > frames);
  assert.ok(shown.surface > before_.surface, "what is nearer is finer");
  assert.equal(shown.error, "");
  await assertRightPicture();
});

test("a tab in the background whose server goes away and comes back", async () => {
  await openFullScreen(`${server.url}/?memory=${small}`, "relief");
  const { port } = server;
  await hide(true);
  await server.stop();
  await untilUnseen("lost", ({ connection }) => connection === "lost");
  server = await Server.start(models, { port });
  await hide(false);
  await visit.pinch(await visit.centre(), 60, 150);
  await visit.until("streaming", ({ connection, idle }) => connection === "streaming" && idle);
  await visit.untilQuiet();
  await assertRightPicture();
});

test("a phone that sleeps, and whose connection is cut meanwhile", async () => {
  await openFullScreen(`${server.url}/?memory=${small}`, "relief");
  const { port } = server;
  await visit.pinch(await visit.centre(), 60, 120);
  await session.send("Page.setWebLifecycleState", { state: "frozen" });
  await server.stop();
  server = await Server.start(models, { port });
  await session.send("Page.setWebLifecycleState", { state: "active" });
  await visit.pinch(await visit.centre(), 60, 120);
  await visit.until("streaming", ({ connection, idle, blobsWanted }) => connection === "streaming" && idle && blobsWanted === 0);
  await visit.untilQuiet();
  const { error, triangles } = await visit.status();
  assert.equal(error, "");
  assert.ok(triangles > 10_000);
  await assertRightPicture();
});

// An hour of use, shortened: one model after the other, from the list and back to it.
test("the memory of long use is flat", async (t) => {
  await visit.open(`${server.url}/?memory=${small}`);
  await visit.untilIdle();
  const random = seeded(2);
  const names = ["relief", "pebble", "relief", "shell"];
  const rounds = 16, warm = 8;
  let first = null, last = null;
  for (let round = 0; round < rounds; ++round) {
    await visit.choose(names[round % names.length]);
    await visit.tap(await visit.centre());
    await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
    for (let step = 0; step < 4; ++step) {
      await lookAround(random);
    }
    await visit.untilIdle();
    await visit.back();
    if (round % names.length === names.length - 1) {
      await visit.untilIdle();
      await session.send("HeapProfiler.collectGarbage");
      const { usedSize } = await session.send("Runtime.getHeapUsage");
      last = { ...await memory(), scripts: usedSize };
      first ??= round >= warm - 1 ? last : null;
      t.diagnostic(`${round + 1}: ${JSON.stringify(last)}`);
    }
  }
  const grown = (key) => last[key] / first[key];
  // The heap grows in steps of a tenth and never shrinks. One step may come late, depending on what is in use at the
  // moment.
  assert.ok(grown("heap") <= 1.15, `the heap has grown by the factor ${grown("heap")}`);
  assert.ok(grown("used") <= 1.02, `what is used of it, by ${grown("used")}`);
  assert.ok(grown("scripts") <= 1.2, `what scripts hold, by ${grown("scripts")}`);
  assert.ok(last.heap + last.graphics <= small * megabyte);
});

test("what a lost context had goes with it", async () => {
  const { forgetObjects, gainCanvas, imports, useContext, useMemory } = await import("../../viewer/mobile/web/gl.js");
  setFlagsFromString("--expose-gc");
  const collectGarbage = runInNewContext("gc");
  const made = [];
  const make = () => {
    const thing = {};
    made.push(new WeakRef(thing));
    return thing;
  };
  const context = { createBuffer: make, createProgram: make, getUniformLocation: make };
  useMemory({ buffer: new ArrayBuffer(64) });
  assert.equal(gainCanvas({ getContext: () => context }), context);
  useContext(context);
  const { glCreateProgram, glGenBuffers, glGetUniformLocation } = imports.env;
  glGenBuffers(2, 0);
  const place = glGetUniformLocation(glCreateProgram(), 32);
  await pause(0);
  collectGarbage();
  assert.equal(made.filter((each) => each.deref()).length, 4, "they are kept while they may be used");
  forgetObjects(context);
  useContext(context);
  await pause(0); // a WeakRef that was read stays alive until its turn of the event loop ends
  collectGarbage();
  assert.equal(made.filter((each) => each.deref()).length, 0);
  assert.notEqual(glGetUniformLocation(glCreateProgram(), 32), place, "no number means two things");
});
