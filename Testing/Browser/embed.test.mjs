// SPDX-License-Identifier: BSD-3-Clause
// <kdstream-viewer> on a page of another origin, under a strict policy.

import assert from "node:assert/strict";
import { createServer } from "node:http";
import { readFileSync, writeFileSync } from "node:fs";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { PNG } from "pngjs";
import { Server, Visit, eventually, launchBrowser, makeModels, makeToken, pause, temporaryFolder } from "./harness.mjs";

let server, browser, host;

// A museum's own site. It serves the page that was set last.
class Host {
  body = "";
  scripts = ""; // further sources of scripts that its policy allows
  #server = createServer((request, response) => {
    response.setHeader("Content-Type", "text/html; charset=utf-8");
    // The example's script is in the page itself.
    const policy = request.url === "/example" ? "" : "Content-Security-Policy";
    policy && response.setHeader(policy,
      `default-src 'none'; script-src ${server.url}${this.scripts}; frame-src ${server.url}; style-src 'nonce-a'; img-src 'self' data:`);
    response.end(["/", "/example"].includes(request.url) ? this.body : "");
  });
  url;

  async start() {
    await new Promise((started) => this.#server.listen(0, "127.0.0.1", started));
    this.url = `http://localhost:${this.#server.address().port}/`; // by its name it is another origin, too
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

async function openHost(elements, isPhone = false, script = `<script src="${server.url}/embed.js"></script>`, options = {}) {
  host.body = `<!doctype html><title>A museum</title><link rel="icon" href="data:,"><meta name="viewport" content="width=device-width">
    <style nonce="a">kdstream-viewer { width: 320px; height: 240px; } .far { margin-top: 3000px; } .tall { height: 1500px; }</style>
    ${script}${elements}`;
  const visit = await (isPhone ? Visit.phone(browser, undefined, options) : Visit.desktop(browser, options));
  await visit.page.addInitScript(() => {
    window.events = [];
    for (const name of ["ready", "viewchange", "error", "sleep"]) {
      addEventListener(name, (event) => event.target.localName === "kdstream-viewer"
        && window.events.push([name, event.target.id, event.detail ?? ""]), true);
    }
  });
  await visit.open(host.url);
  return visit;
}

const untilEvent = (visit, what, name, id, detail = () => true) =>
  eventually(what, () => visit.page.evaluate(() => window.events),
    (events) => events.some((each) => each[0] === name && each[1] === id && detail(each[2])));

const ask = (visit, id, command, ...values) => visit.page.evaluate(([element, name, given]) =>
  document.getElementById(element)[name](...given), [id, command, values]);

test("three lines show a model, and a page may ask and tell", async () => {
  const visit = await openHost('<kdstream-viewer id="a" model="pebble"></kdstream-viewer>');
  await untilEvent(visit, "a picture", "ready", "a");
  await untilEvent(visit, "a view", "viewchange", "a", (link) => link.startsWith("model=pebble&digest="));
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
  await untilEvent(visit, "the other model", "viewchange", "a", (link) => link.startsWith("model=shell&"));
  assert.equal(await frame.locator("#back").isVisible(), false, "there is no list to go back to");
  assert.equal(await frame.locator("#browser").isVisible(), false);
  await frame.locator("#home").click();
  await visit.page.evaluate(() => document.getElementById("a").setAttribute("model", "nothing"));
  await untilEvent(visit, "what is wrong", "error", "a", (text) => /nothing/.test(text));
  await assert.rejects(visit.page.evaluate(() => document.createElement("kdstream-viewer").home()), /not ready/);
  assert.deepEqual(visit.errors, [], "no policy is broken");
  await visit.picture("embed-1");
  await visit.close();
});

test("as a module of another origin, and imported by one", async () => {
  for (const [script, from] of [[`<script type="module" src="${server.url}/embed.js"></script>`, ""],
    [`<script type="module" src="data:text/javascript,import '${server.url}/embed.js'"></script>`, " data:"]]) {
    host.scripts = from;
    const visit = await openHost('<kdstream-viewer id="a" model="pebble"></kdstream-viewer>', false, script);
    await untilEvent(visit, "a picture", "ready", "a");
    assert.deepEqual(visit.errors, []);
    await visit.close();
  }
  host.scripts = "";
});

const dot = (color) => `data:image/svg+xml,${encodeURIComponent(`<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"><rect width="9" height="9" fill="${color}"/></svg>`)}`;

test("a poster waits to be pressed, and a logo stays", async () => {
  const visit = await openHost(`<kdstream-viewer id="a" model="pebble" title="A pebble" poster='${dot("red")}' logo='${dot("lime")}' autoplay="false">
    </kdstream-viewer>`);
  const poster = visit.page.locator("#a button");
  await poster.waitFor();
  await pause(500);
  assert.equal(visit.page.frames().length, 1, "nothing is loaded");
  assert.equal(await poster.getAttribute("aria-label"), "A pebble");
  await visit.picture("embed-5-poster");
  await poster.click();
  await untilEvent(visit, "a picture", "ready", "a");
  assert.equal(await poster.count(), 0);
  const logo = await visit.page.locator("#a [part=logo]").boundingBox();
  const viewer = await visit.page.locator("#a").boundingBox();
  const below = viewer.y + viewer.height - logo.y - logo.height;
  assert.ok(logo.width > 0 && below > 90, `hints have room below it: ${below}`);
  assert.deepEqual(visit.errors, [], "no policy is broken");
  await visit.close();
});

test("it turns by itself, on a light ground, and fingers turn it at once", async () => {
  const visit = await openHost('<kdstream-viewer id="a" model="pebble" turn theme="light" scroll="off"></kdstream-viewer>', true, undefined,
    { reducedMotion: "no-preference" });
  await untilEvent(visit, "a picture", "ready", "a");
  await eventually("it turns", () => ask(visit, "a", "status"), ({ spinning }) => spinning);
  const frame = visit.page.frames()[1];
  assert.equal(await frame.evaluate(() => document.body.hasAttribute("data-entered")), true);
  const light = (selector) => frame.evaluate((wanted) => getComputedStyle(document.querySelector(wanted)).color, selector);
  await eventually("dark writing", () => light("#title"), (color) => color === "rgb(29, 28, 25)");
  await visit.picture("embed-6-light");
  const { x, y } = await visit.page.locator("#a").boundingBox();
  const { data } = PNG.sync.read(await visit.page.screenshot({ clip: { x: x + 6, y: y + 120, width: 8, height: 8 } }));
  assert.ok(data.every((channel) => channel > 200), "a light ground");
  const [caption, logo] = await frame.evaluate(() => [document.getElementById("caption").getBoundingClientRect().right, innerWidth * 0.75 - 8]);
  assert.ok(caption < logo, "a logo would hide no title");
  await visit.page.evaluate(() => document.getElementById("a").removeAttribute("turn"));
  await eventually("it rests", () => ask(visit, "a", "status"), ({ spinning }) => !spinning);
  assert.deepEqual(visit.errors, []);
  await visit.close();
});

test("it is light, and has no list, before there is a picture", async () => {
  const visit = await openHost("");
  let send;
  const wanted = new Promise((resolve) => (send = resolve));
  await visit.page.route("**/kdstream.wasm", async (route) => {
    await wanted;
    await route.continue();
  });
  await visit.page.evaluate(() => {
    document.body.innerHTML = '<kdstream-viewer id="a" model="pebble" theme="light"></kdstream-viewer>';
  });
  const frame = await eventually("a frame", () => visit.page.frames()[1]);
  const ground = () => frame.evaluate(() => getComputedStyle(document.getElementById("stage")).backgroundImage);
  await eventually("a light ground", ground, (image) => image.includes("rgb(244, 242, 238)"));
  assert.equal(await frame.locator("#browser").isVisible(), false);
  await visit.picture("embed-7-early");
  send();
  await untilEvent(visit, "a picture", "ready", "a");
  await visit.open(`${server.url}/?theme=light`);
  await visit.untilIdle();
  assert.equal(await visit.page.evaluate(() => getComputedStyle(document.body).backgroundColor), "rgb(244, 242, 238)", "the whole page, too");
  await visit.picture("embed-8-light-page");
  await visit.close();
});

test("what is not seen sleeps, and comes back where it was", async () => {
  const more = [1, 2, 3, 4, 5].map((i) => `<kdstream-viewer id="v${i}" class="far" model="pebble"></kdstream-viewer>`).join("");
  const visit = await openHost(`<kdstream-viewer id="a" model="shell"></kdstream-viewer>${more}`);
  await untilEvent(visit, "a picture", "ready", "a");
  assert.equal(visit.page.frames().length, 2, "what is far below has no frame");
  await ask(visit, "a", "lookFrom", "left");
  const left = await eventually("a view", () => ask(visit, "a", "link"));
  await untilEvent(visit, "that it was seen", "viewchange", "a", (link) => link === left);
  for (const i of [1, 2, 3, 4, 5]) {
    await visit.page.evaluate((id) => document.getElementById(id).scrollIntoView(), `v${i}`);
    await untilEvent(visit, `picture ${i}`, "ready", `v${i}`);
    assert.ok(visit.page.frames().length <= 5, "the page and four frames");
  }
  await untilEvent(visit, "that it sleeps", "sleep", "a");
  assert.equal(await visit.page.evaluate(() => document.getElementById("a").asleep), true);
  await visit.page.evaluate(() => {
    window.events = [];
    document.getElementById("a").scrollIntoView();
  });
  await untilEvent(visit, "its picture again", "ready", "a");
  assert.equal(await eventually("its view again", () => ask(visit, "a", "link"), (link) => link === left), left);
  assert.deepEqual(visit.errors, []);
  await visit.close();
});

test("a model that is named later is shown then", async () => {
  const visit = await openHost('<kdstream-viewer id="a"></kdstream-viewer>');
  assert.equal(await visit.page.evaluate(() => new Promise((seen) => {
    const viewer = document.getElementById("a");
    new IntersectionObserver(() => seen(viewer.asleep)).observe(viewer); // called after the viewer's own observer
  })), true);
  await visit.page.evaluate(() => document.getElementById("a").setAttribute("model", "pebble"));
  await untilEvent(visit, "a picture", "ready", "a");
  await visit.close();
});

// Opens a viewer between paragraphs, on a phone. Returns functions for what a visitor does there, and for what has
// happened.
async function openArticle() {
  const visit = await openHost(`<p class="tall">before</p><kdstream-viewer id="a" model="pebble"></kdstream-viewer>
    <p class="tall">after</p><p class="far">the end</p>`, true);
  await visit.page.evaluate(() => document.getElementById("a").scrollIntoView({ block: "center" }));
  await untilEvent(visit, "a picture", "ready", "a");
  const frame = visit.page.frames()[1];
  const middle = async () => {
    const { x, y, width, height } = await visit.page.locator("#a").boundingBox();
    return { x: x + width / 2, y: y + height / 2 };
  };
  // Waits until scrolling has ended; returns the position.
  const scrolled = () => visit.page.evaluate(async () => {
    const frames = (n) => new Promise((seen) => (n ? requestAnimationFrame(() => frames(n - 1).then(seen)) : seen()));
    for (let before = NaN; before !== scrollY; await frames(8)) {
      before = scrollY;
    }
    return scrollY;
  });
  const link = async () => {
    await eventually("rest", () => ask(visit, "a", "status"), ({ idle }) => idle);
    return ask(visit, "a", "link");
  };
  const isEntered = () => frame.evaluate(() => document.body.hasAttribute("data-entered"));
  // Drags one finger. Returns whether this has turned the model, and whether it has scrolled the page.
  const drag = async (dx, dy) => {
    const [seen, top] = [await link(), await scrolled()];
    await visit.dragSlowly(await middle(), dx, dy);
    const turns = await link() !== seen;
    await pause(400); // the page scrolls only after it and the frame have handled the events
    return { scrolls: Math.abs(await scrolled() - top) > 20, turns };
  };
  return { visit, frame, middle, scrolled, link, isEntered, drag };
}

test("one finger scrolls the page around a viewer, until one has entered that", async () => {
  const { visit, frame, middle, scrolled, link, isEntered, drag } = await openArticle();
  assert.match(await frame.locator("#hint").textContent(), /^Tap to turn the model$/);
  assert.deepEqual(await drag(0, -100), { turns: false, scrolls: true });
  assert.deepEqual(await drag(0, 100), { turns: false, scrolls: true });
  assert.equal((await drag(60, 0)).turns, false, "nor across");
  assert.equal(await isEntered(), false, "a finger that scrolls is no tap");

  const seen = await link();
  await visit.tap(await middle());
  await eventually("entered by a tap", isEntered);
  assert.equal(await link(), seen, "which does nothing else");
  assert.deepEqual(await drag(0, -100), { turns: true, scrolls: false });
  assert.deepEqual(await drag(50, 40), { turns: true, scrolls: false });

  await visit.tap({ x: 200, y: (await visit.page.locator("#a").boundingBox()).y - 20 }); // a tap beside the viewer
  await eventually("left", isEntered, (entered) => !entered);
  assert.deepEqual(await drag(0, 100), { turns: false, scrolls: true });

  const [before_, top] = [await link(), await scrolled()];
  await visit.pinch(await middle(), 60, 120, 6);
  await eventually("entered by two fingers", isEntered);
  await eventually("pinched", link, (now) => now !== before_);
  assert.ok(Math.abs(await scrolled() - top) < 20, "which do not scroll");
  assert.deepEqual(await drag(0, -100), { turns: true, scrolls: false });

  await visit.page.evaluate(() => scrollTo(0, 5000));
  await eventually("left", isEntered, (entered) => !entered);
  await visit.page.evaluate(() => document.getElementById("a").scrollIntoView({ block: "center" }));
  assert.deepEqual(await drag(0, 100), { turns: false, scrolls: true });
  await visit.picture("embed-2-outside"); // the next finger may get lost after a screenshot
  await eventually("entered", async () => {
    await visit.tap(await middle());
    return isEntered();
  });
  await visit.picture("embed-3-entered");
  assert.deepEqual(visit.errors, []);
  await visit.close();
});

test("a mouse turns an embedded model at once", async () => {
  const visit = await openHost('<kdstream-viewer id="a" model="pebble"></kdstream-viewer>');
  await untilEvent(visit, "a view", "viewchange", "a");
  const seen = await ask(visit, "a", "link");
  const { x, y, width, height } = await visit.page.locator("#a").boundingBox();
  await visit.page.mouse.move(x + width / 2, y + height / 2);
  await visit.page.mouse.down();
  await visit.page.mouse.move(x + width / 2 + 60, y + height / 2 + 10, { steps: 5 });
  await visit.page.mouse.up();
  await eventually("turned", () => ask(visit, "a", "link"), (link) => link !== seen);
  await visit.close();
});

test("an embedded viewer fills the screen, and comes back", async () => {
  const { visit, frame, isEntered, drag } = await openArticle();
  const fills = () => frame.evaluate(() => document.fullscreenElement === document.documentElement);
  const button = frame.locator("#open");
  assert.equal(await button.getAttribute("aria-label"), "Full screen");
  await button.tap();
  await eventually("the whole screen", fills);
  await eventually("the whole screen", () => frame.evaluate(() => innerHeight), (height) => height > 600);
  await eventually("one finger turns there", isEntered);
  await visit.picture("embed-4-full-screen");
  await button.tap();
  await eventually("the page again", fills, (filling) => !filling);
  await eventually("left", isEntered, (entered) => !entered);
  assert.equal((await drag(0, -100)).turns, false);
  assert.deepEqual(visit.errors, []);
  await visit.close();
});

test("where no frame may fill the screen, the viewer has a tab of its own", async () => {
  const { visit, frame, link } = await openArticle();
  await frame.evaluate(() => (Element.prototype.requestFullscreen = undefined));
  const seen = await link();
  const [tab] = await Promise.all([visit.page.context().waitForEvent("page"), frame.locator("#open").tap()]);
  await tab.waitForLoadState();
  assert.equal(tab.url(), `${server.url}/#${seen}`);
  await eventually("the same view", () => tab.evaluate(() => window.kdstream?.status()),
    (status) => status?.mode === "full screen" && status.model === "pebble" && status.shownLevel !== null);
  await visit.close();
});

test("strangers get no details of what a token guards", async () => {
  const folder = makeModels({ dragon: false });
  const keys = `${temporaryFolder()}/keys.json`;
  writeFileSync(keys, JSON.stringify({ secret: "0123456789abcdef0123456789abcdef" }), { mode: 0o600 });
  const token = makeToken(keys, "--models", "*", "--detail", "regions");
  const guarded = await Server.start(folder, { more: ["--tokens", keys] });
  const open = server;
  server = guarded; // the host's page embeds from this server
  try {
    const visit = await openHost('<kdstream-viewer id="a" model="pebble"></kdstream-viewer>');
    const frame = await eventually("a frame of the server", () => visit.page.frames().find((each) => each.url().startsWith(guarded.url)));
    await frame.locator("#message-action").click();
    await frame.locator("#token").fill(token);
    await frame.locator("#token").press("Enter");
    await untilEvent(visit, "a picture", "ready", "a");
    for (const command of ["link", "picture", "status"]) {
      await assert.rejects(ask(visit, "a", command), /need a token/, command);
    }
    assert.deepEqual((await visit.page.evaluate(() => window.events)).filter(([name]) => name === "viewchange"), []);
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
