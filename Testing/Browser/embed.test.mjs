// SPDX-License-Identifier: BSD-3-Clause
// <kdstream-viewer> on a page of another origin, under a strict policy.

import assert from "node:assert/strict";
import { createServer } from "node:http";
import { readFileSync, writeFileSync } from "node:fs";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { Server, Visit, eventually, launchBrowser, makeModels, makeToken, temporaryFolder } from "./harness.mjs";

let server, browser, host;

// A museum's own site: it gives the page that is set last.
class Host {
  body = "";
  #server = createServer((request, response) => {
    response.setHeader("Content-Type", "text/html; charset=utf-8");
    const policy = request.url === "/example" ? "" : "Content-Security-Policy"; // the example has its script in the page
    policy && response.setHeader(policy,
      `default-src 'none'; script-src ${server.url}; frame-src ${server.url}; style-src 'nonce-a'; img-src 'self' data:`);
    response.end(["/", "/example"].includes(request.url) ? this.body : "");
  });
  url;

  async start() {
    await new Promise((started) => this.#server.listen(0, "127.0.0.1", started));
    this.url = `http://localhost:${this.#server.address().port}/`; // another origin by its name, too
  }
  stop() {
    this.#server.closeAllConnections();
    return new Promise((stopped) => this.#server.close(stopped));
  }
}

before(async () => {
  server = await Server.start(makeModels({ dragon: false }));
  browser = await launchBrowser();
  host = new Host();
  await host.start();
});

after(async () => {
  await browser?.close();
  await host?.stop();
  await server?.stop();
});

async function openHost(elements) {
  host.body = `<!doctype html><title>A museum</title><link rel="icon" href="data:,">
    <style nonce="a">kdstream-viewer { width: 320px; height: 240px; } .far { margin-top: 3000px; }</style>
    <script src="${server.url}/embed.js"></script>${elements}`;
  const visit = await Visit.desktop(browser);
  await visit.page.addInitScript(() => {
    window.told = [];
    for (const name of ["ready", "viewchange", "error", "sleep"]) {
      addEventListener(name, (event) => event.target.localName === "kdstream-viewer"
        && window.told.push([name, event.target.id, event.detail ?? ""]), true);
    }
  });
  await visit.open(host.url);
  return visit;
}

const untilTold = (visit, what, name, id, detail = () => true) =>
  eventually(what, () => visit.page.evaluate(() => window.told),
    (told) => told.some((each) => each[0] === name && each[1] === id && detail(each[2])));

const ask = (visit, id, deed, ...values) => visit.page.evaluate(([element, name, given]) =>
  document.getElementById(element)[name](...given), [id, deed, values]);

test("three lines show a model, and a page may ask and tell", async () => {
  const visit = await openHost('<kdstream-viewer id="a" model="pebble"></kdstream-viewer>');
  await untilTold(visit, "a picture", "ready", "a");
  await untilTold(visit, "a view", "viewchange", "a", (link) => link.startsWith("model=pebble&digest="));
  const status = await ask(visit, "a", "status");
  assert.equal(status.mode, "full screen");
  assert.equal(status.model, "pebble");
  const [frame] = visit.page.frames().slice(1);
  assert.deepEqual(await frame.evaluate(() => {
    const title = document.getElementById("title");
    const { left, right, top, bottom } = title.getBoundingClientRect();
    return [title.textContent, left >= 0 && right <= innerWidth && top >= 0 && bottom <= innerHeight, title.scrollWidth <= title.clientWidth,
      document.elementsFromPoint((left + right) / 2, (top + bottom) / 2).includes(document.getElementById("stage"))];
  }), ["A pebble", true, true, true], "what it is called can be read");
  const front = await ask(visit, "a", "link");
  await ask(visit, "a", "lookFrom", "top");
  await eventually("another view", () => ask(visit, "a", "link"), (link) => link !== front);
  const top = await ask(visit, "a", "link");
  await ask(visit, "a", "home");
  await eventually("the first view", () => ask(visit, "a", "link"), (link) => link !== top);
  await ask(visit, "a", "follow", `${server.url}/#${top}`);
  await eventually("what was seen from above", () => ask(visit, "a", "link"), (link) => link === top);
  const bytes = await visit.page.evaluate(async () => (await document.getElementById("a").picture()).size);
  assert.ok(bytes > 2000, `a picture of ${bytes} bytes`);
  await visit.page.evaluate(() => document.getElementById("a").setAttribute("model", "shell"));
  await untilTold(visit, "the other model", "viewchange", "a", (link) => link.startsWith("model=shell&"));
  assert.equal(await frame.locator("#back").isVisible(), false, "there is no list to go back to");
  assert.equal(await frame.locator("#browser").isVisible(), false);
  await frame.locator("#home").click();
  await visit.page.evaluate(() => document.getElementById("a").setAttribute("model", "nothing"));
  await untilTold(visit, "what is wrong", "error", "a", (text) => /nothing/.test(text));
  await assert.rejects(visit.page.evaluate(() => document.createElement("kdstream-viewer").home()), /not ready/);
  assert.deepEqual(visit.errors, [], "no policy is broken");
  await visit.picture("embed-1");
  await visit.close();
});

test("what is not seen sleeps, and comes back where it was", async () => {
  const more = [1, 2, 3, 4, 5].map((i) => `<kdstream-viewer id="v${i}" class="far" model="pebble"></kdstream-viewer>`).join("");
  const visit = await openHost(`<kdstream-viewer id="a" model="shell"></kdstream-viewer>${more}`);
  await untilTold(visit, "a picture", "ready", "a");
  assert.equal(visit.page.frames().length, 2, "what is far below has no frame");
  await ask(visit, "a", "lookFrom", "left");
  const left = await eventually("a view", () => ask(visit, "a", "link"));
  await untilTold(visit, "that it was seen", "viewchange", "a", (link) => link === left);
  for (const i of [1, 2, 3, 4, 5]) {
    await visit.page.evaluate((id) => document.getElementById(id).scrollIntoView(), `v${i}`);
    await untilTold(visit, `picture ${i}`, "ready", `v${i}`);
    assert.ok(visit.page.frames().length <= 5, "the page and four frames");
  }
  await untilTold(visit, "that it sleeps", "sleep", "a");
  assert.equal(await visit.page.evaluate(() => document.getElementById("a").asleep), true);
  await visit.page.evaluate(() => {
    window.told = [];
    document.getElementById("a").scrollIntoView();
  });
  await untilTold(visit, "its picture again", "ready", "a");
  assert.equal(await eventually("its view again", () => ask(visit, "a", "link"), (link) => link === left), left);
  assert.deepEqual(visit.errors, []);
  await visit.close();
});

test("a model that is named later is shown then", async () => {
  const visit = await openHost('<kdstream-viewer id="a"></kdstream-viewer>');
  assert.equal(await visit.page.evaluate(() => new Promise((seen) => {
    const viewer = document.getElementById("a");
    new IntersectionObserver(() => seen(viewer.asleep)).observe(viewer); // after its own
  })), true);
  await visit.page.evaluate(() => document.getElementById("a").setAttribute("model", "pebble"));
  await untilTold(visit, "a picture", "ready", "a");
  await visit.close();
});

test("nothing is told to strangers of what a token guards", async () => {
  const folder = makeModels({ dragon: false });
  const keys = `${temporaryFolder()}/keys.json`;
  writeFileSync(keys, JSON.stringify({ secret: "0123456789abcdef0123456789abcdef" }), { mode: 0o600 });
  const token = makeToken(keys, "--models", "*", "--detail", "regions");
  const guarded = await Server.start(folder, { more: ["--tokens", keys] });
  const open = server;
  server = guarded; // the host's page is about this one
  try {
    const visit = await openHost('<kdstream-viewer id="a" model="pebble"></kdstream-viewer>');
    const frame = await eventually("a frame of the server", () => visit.page.frames().find((each) => each.url().startsWith(guarded.url)));
    await frame.locator("#message-action").click();
    await frame.locator("#token").fill(token);
    await frame.locator("#token").press("Enter");
    await untilTold(visit, "a picture", "ready", "a");
    for (const deed of ["link", "picture", "status"]) {
      await assert.rejects(ask(visit, "a", deed), /need a token/, deed);
    }
    assert.deepEqual((await visit.page.evaluate(() => window.told)).filter(([name]) => name === "viewchange"), []);
    await visit.close();
  } finally {
    server = open;
    await guarded.stop();
  }
});

test("the example of the documentation works", async () => {
  const example = readFileSync(fileURLToPath(new URL("../../Examples/Embedding/index.html", import.meta.url)), "utf8");
  host.body = example.replaceAll("http://127.0.0.1:8700", server.url).replaceAll("dragon", "pebble");
  const visit = await Visit.desktop(browser);
  await visit.open(`${host.url}example`);
  await eventually("the view in words", () => visit.page.locator("output").textContent(), (text) => text.includes("model=pebble"));
  await visit.page.getByRole("button", { name: "From above" }).click();
  await visit.page.getByRole("button", { name: "First view" }).click();
  assert.deepEqual(visit.errors, []);
  await visit.close();
});
