// SPDX-License-Identifier: BSD-3-Clause
// The connection to the server: it fails and comes back; there is no stream; there are only files.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { Server, Visit, launchBrowser, makeModels } from "./harness.mjs";
import { Proxy } from "./proxy.mjs";

let models, server, browser;

before(async () => {
  models = makeModels({ whole: true });
  server = await Server.start(models);
  browser = await launchBrowser();
});

after(async () => {
  await browser?.close();
  await server?.stop();
});

const whole = ({ region, idle }) => idle && region !== null && region.partitions > 0 && region.shown === region.partitions;

async function openFullScreen(visit, url) {
  await visit.open(url);
  await visit.untilIdle();
  await visit.tap(await visit.centre());
  await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
}

test("the server goes away and comes back: the page says so and goes on by itself", async () => {
  const visit = await Visit.phone(browser);
  await openFullScreen(visit, server.url);
  const { port } = server;
  await server.stop();
  await visit.untilSaid(/(lost|does not answer|closed|going away).*Trying again/);
  const lost = await visit.until("lost", ({ connection }) => connection === "lost");
  assert.notEqual(lost.trouble, "");
  assert.equal(lost.shownLevel !== null && lost.triangles > 0, true, "what is there stays");
  await visit.picture("line-1-lost");

  // Actions that need no server work meanwhile.
  const frames = lost.frames;
  await visit.drag(await visit.centre(), 40, 0);
  await visit.until("it turns", (status) => status.frames > frames);
  // An action that needs the server is remembered.
  await visit.doubleTap(await visit.centre());

  server = await Server.start(models, { port });
  await visit.until("streaming", ({ connection }) => connection === "streaming");
  await visit.untilSaid(/^Connected again\.$/);
  await visit.picture("line-2-again");
  const here = await visit.until("the region tapped while the server was away", whole);
  await visit.until("nothing more to say", ({ trouble }) => trouble === "");
  await visit.picture("line-3-region");

  await visit.doubleTap({ x: (await visit.centre()).x + 50, y: (await visit.centre()).y - 40 });
  await visit.until("another region", (status) => whole(status) && status.region.cell !== here.region.cell);
  await visit.close();
});

// Gets the region around a double tap in the middle. Returns it, and the connection by which it came.
async function regionBy(url) {
  const visit = await Visit.phone(browser);
  await openFullScreen(visit, url);
  await visit.doubleTap(await visit.centre());
  const { region, shownLevel, vertices, triangles, connection } = await visit.until("the whole region", whole);
  const gets = visit.requests.filter((address) => /\/partitions\/\d+$/.test(address)).length;
  await visit.picture(`line-4-${connection}`);
  assert.deepEqual(await visit.messages(), []);
  await visit.close();
  return { shown: { region, shownLevel, vertices, triangles }, connection, gets };
}

test("without a stream the same comes by GET", async (t) => {
  const proxy = await Proxy.start(server.port);
  t.after(() => proxy.stop());
  proxy.streams = false;
  const streamed = await regionBy(server.url);
  const got = await regionBy(proxy.url);
  assert.equal(streamed.connection, "streaming");
  assert.equal(streamed.gets, 0);
  assert.equal(got.connection, "getting");
  assert.equal(got.gets, got.shown.region.partitions, "each partition once");
  assert.deepEqual(got.shown, streamed.shown);
});

test("of a stream that was there and is cut it is not said that the server has none", async (t) => {
  const proxy = await Proxy.start(server.port);
  t.after(() => proxy.stop());
  const visit = await Visit.phone(browser);
  await openFullScreen(visit, proxy.url);
  proxy.streams = false;
  proxy.cut();
  await visit.doubleTap(await visit.centre());
  await visit.untilSaid(/^The connection to the server was lost: it was closed\. Trying again/);
  proxy.streams = true;
  await visit.until("the whole region", whole);
  await visit.close();
});

test("without a stream too, a server that goes away is taken up again by the page itself", async () => {
  const visit = await Visit.phone(browser);
  await visit.page.addInitScript(() => {
    window.WebSocket = class {
      constructor() {
        throw new Error("there is none");
      }
    };
    const now = performance.now.bind(performance);
    window.skipped = 0; // ms
    performance.now = () => now() + window.skipped;
  });
  await openFullScreen(visit, server.url);
  await visit.until("getting", ({ connection }) => connection === "getting");
  const { port } = server;
  await server.stop();
  // It tries to open a stream again, and no server answers.
  await visit.page.evaluate(() => (window.skipped += 300_000));
  await visit.untilSaid(/server (cannot be reached|does not answer)/); // the second message if it was still fetching
  server = await Server.start(models, { port });
  await visit.untilQuiet();
  await visit.doubleTap(await visit.centre());
  const { connection } = await visit.until("the whole region", whole);
  assert.equal(connection, "getting");
  await visit.close();
});
