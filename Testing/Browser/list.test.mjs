// SPDX-License-Identifier: BSD-3-Clause
// The list of models: pictures, sorted titles, search, texts of the site and of its models, and texts written by
// strangers.

import assert from "node:assert/strict";
import { cpSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { Server, Visit, buildStore, eventually, launchBrowser, makeModels, pause, runProgram, temporaryFolder, writePebble } from "./harness.mjs";

let browser, models;

before(async () => {
  models = makeModels({ dragon: false });
  browser = await launchBrowser();
});

after(() => browser?.close());

async function withServer(folder, act, more = []) {
  const server = await Server.start(folder, { more });
  const visit = await Visit.phone(browser);
  try {
    await act(visit, server);
    visit.assertClean(server.url);
  } finally {
    await visit.close();
    await server.stop();
  }
}

const edit = (folder, id, ...texts) => runProgram("kdstream-store", "edit", join(folder, `${id}.kds`), "--quiet", ...texts);

const namesShown = (visit) => visit.page.locator("#models li:not([hidden]) .name").allTextContents();

// The pictures that are shown, by model.
const pictures = (visit) => visit.page.evaluate(() => Object.fromEntries([...document.querySelectorAll("#models [data-model]")]
  .map((entry) => [entry.dataset.model, entry.querySelector("img").hidden ? "" : entry.querySelector("img").src])));

const untilPictures = (visit, count) => eventually(`${count} pictures`, () => pictures(visit),
  (all) => Object.values(all).filter((src) => src.startsWith("data:image/")).length === count);

// The requests for previews, over either connection.
const previewsGot = (visit) => visit.requests.filter((url) => /\/levels\/\d+\/1$/.test(url));

test("each model has a picture, which is made once, and of what is fetched once", () => withServer(models, async (visit, server) => {
  const frames = [];
  visit.page.on("websocket", (socket) => socket.on("framesent", ({ payload }) => frames.push(String(payload))));
  await visit.open(server.url);
  await visit.untilIdle();
  const all = await untilPictures(visit, 2);
  assert.notEqual(all.pebble, all.shell);
  await visit.picture("list-1-pictures");
  const asked = () => frames.filter((text) => /"levels\/\d+\/1"/.test(text)).length;
  assert.equal(asked(), 1, "the chosen model's preview came over the stream");
  assert.deepEqual(previewsGot(visit).map((url) => url.match(/models\/(\w+)/)[1]), ["shell"], "the other's for its picture");
  const { model } = await visit.status();
  assert.equal(model, "pebble", "what is chosen stays so");

  await visit.choose("shell");
  assert.equal(asked(), 1, "the preview that was there is not fetched again");
  assert.equal(previewsGot(visit).length, 1);
  assert.equal((await visit.status()).error, "");

  await eventually("pictures are kept", () => visit.page.evaluate(() => new Promise((resolve) => {
    const request = indexedDB.open("kdstream", 1);
    request.onsuccess = () => {
      const keys = request.result.transaction("blobs").objectStore("blobs").getAllKeys();
      keys.onsuccess = () => resolve(keys.result.filter((path) => path.startsWith("picture/")).length);
    };
  })), (count) => count === 2);
  visit.requests.length = 0;
  await visit.page.reload();
  await visit.untilIdle();
  assert.deepEqual(await untilPictures(visit, 2), all, "the same pictures");
  assert.deepEqual(previewsGot(visit), [], "of what was kept");
  for (let i = 0; i < 8; ++i) {
    visit.requests.push(server.url); // assertClean expects some requests
  }
}));

for (const [what, harm] of [
  ["denied", () => (IDBFactory.prototype.open = () => { throw new DOMException("no", "UnknownError"); })],
  ["full", () => (IDBObjectStore.prototype.put = () => { throw new DOMException("full", "QuotaExceededError"); })],
]) {
  test(`where storage is ${what}, pictures are made anew`, () => withServer(models, async (visit, server) => {
    await visit.page.addInitScript(harm);
    await visit.open(server.url);
    await untilPictures(visit, 2);
    await visit.page.reload();
    await untilPictures(visit, 2);
    assert.deepEqual(await visit.messages(), []);
  }));
}

test("two tabs make their pictures beside each other", () => withServer(models, async (visit, server) => {
  const page = await visit.page.context().newPage();
  const other = { page };
  await Promise.all([visit.open(server.url), page.goto(server.url)]);
  await untilPictures(visit, 2); // a tab in the background waits
  await page.bringToFront();
  await untilPictures(other, 2);
  assert.deepEqual(await pictures(other), await pictures(visit));
}));

test("who saves data gets no pictures that are not kept", () => withServer(models, async (visit, server) => {
  const thrifty = await Visit.phone(browser);
  await thrifty.page.addInitScript(() => Object.defineProperty(Navigator.prototype, "connection", { get: () => ({ saveData: true }) }));
  await thrifty.open(server.url);
  await thrifty.untilIdle();
  await visit.open(server.url);
  await untilPictures(visit, 2); // this page was opened later
  assert.deepEqual(await pictures(thrifty), { pebble: "", shell: "" });
  await thrifty.close();
}));

test("what the site says of itself, titles in order, and a mark of what is kept", () => {
  const folder = temporaryFolder();
  cpSync(models, folder, { recursive: true });
  edit(folder, "pebble", "--title", "Émile 10");
  edit(folder, "shell", "--title", "Emile 9", "--description", "A shell of the sea");
  return withServer(folder, async (visit, server) => {
    await visit.open(server.url);
    await visit.untilIdle();
    assert.equal(await visit.page.locator("#site").textContent(), "Museum <b>");
    assert.equal(await visit.page.locator("#introduction").textContent(), "Bones & stones");
    assert.match(await visit.page.title(), /^Emile 9 – Museum <b>$/);
    assert.deepEqual(await namesShown(visit), ["Emile 9", "Émile 10"], "as a reader of the language orders them");
    assert.equal(await visit.page.locator("[data-model=shell] .facts").textContent(), "A shell of the sea");
    assert.equal(await visit.page.locator("#search").isVisible(), false, "for so few");
    assert.doesNotMatch(await visit.page.locator("#models").innerText(), /triangle/);
    await untilPictures(visit, 2);
    await visit.choose("pebble");
    await visit.page.locator("#open").click();
    await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
    await pause(800); // until it is stored
    await visit.back();
    await eventually("a mark", () => visit.page.locator("[data-model=pebble] .kept").isVisible());
    assert.equal(await visit.page.locator("[data-model=pebble] .kept").textContent(), "available offline");
    await visit.picture("list-2-site");
  }, ["--site-title", "Museum <b>", "--site-text", "Bones & stones"]);
});

test("many models are searched by title and description", () => {
  const folder = temporaryFolder();
  const titles = ["Amphora", "Bust of a man", "Crâne", "Dagger", "Eagle", "Figurine", "Goblet", "Helmet", "Idol", "Jug", "Kettle", "Lamp", "Mask"];
  titles.forEach((title, i) => {
    cpSync(join(models, "shell.kds"), join(folder, `m${i}.kds`));
    edit(folder, `m${i}`, "--title", title, ...(title === "Jug" ? ["--description", "A vessel, and Roman"] : []));
  });
  return withServer(folder, async (visit, server) => {
    const { page } = visit;
    await visit.open(server.url);
    await visit.untilIdle();
    const search = page.locator("#search");
    assert.ok(await search.isVisible(), "more than a dozen");
    await page.keyboard.press("/");
    assert.equal(await page.evaluate(() => document.activeElement.id), "search");
    await page.keyboard.type("CRANE");
    assert.deepEqual(await namesShown(visit), ["Crâne"]);
    assert.equal(await page.locator("#empty").textContent(), "1 model found");
    await visit.picture("list-3-search");
    await search.fill("roman ves");
    assert.deepEqual(await namesShown(visit), ["Jug"], "by its description");
    await search.fill("a");
    assert.ok((await namesShown(visit)).length > 5);
    await search.fill("zzz");
    assert.deepEqual(await namesShown(visit), []);
    assert.equal(await page.locator("#empty").textContent(), "No model matches.");
    await search.fill("");
    assert.equal((await namesShown(visit)).length, 13);
    assert.equal(await page.locator("#empty").isVisible(), false);
    // Only pictures that are visible are fetched, and one picture serves all models with the same digest.
    await eventually("pictures", () => pictures(visit), (all) => Object.values(all).filter(Boolean).length > 2);
    assert.ok(previewsGot(visit).length <= 1, `${previewsGot(visit)}`);
  });
});

// Chooses the model, unless it is chosen already: choosing it again would open it.
async function choose(visit, model) {
  if ((await visit.status()).model !== model) {
    await visit.choose(model);
  }
}

async function openAbout(visit, model) {
  await choose(visit, model);
  await visit.page.locator("#about-button").click();
  await visit.page.locator("#about summary").waitFor();
  return visit.page.locator("#about");
}

const factsOf = (about) => about.evaluate((element) => Object.fromEntries(
  [...element.querySelectorAll("dt")].map((name) => [name.textContent, name.nextElementSibling.textContent])));

test("all that is known of a model, with links that lead to http alone", () => {
  const folder = temporaryFolder();
  cpSync(models, folder, { recursive: true });
  const licence = `https://example.org/${"licence".repeat(40)}`;
  edit(folder, "pebble", "--description", "See https://example.org/pebble. <img src=x onerror=alert(1)>", "--unit", "mm",
    "--credit", "javascript:alert(1)", "--license", licence);
  return withServer(folder, async (visit, server) => {
    await visit.open(server.url);
    await visit.untilIdle();
    const about = await openAbout(visit, "pebble");
    const facts = await factsOf(about);
    assert.equal(facts.Licence, licence, "all of it");
    assert.equal(facts.By, "javascript:alert(1)");
    const figures = about.locator("details p").first();
    assert.match(await figures.textContent(), /^The original: 9,0\d\d triangles · 4,5\d\d vertices$/);
    assert.equal(await figures.isVisible(), false, "only for those who ask for details");
    const links = await about.locator("a").evaluateAll((all) => all.map((each) => [each.href, each.rel, each.target]));
    assert.deepEqual(links.map(([href]) => href), ["https://example.org/pebble", licence]);
    assert.ok(links.every(([, rel, target]) => rel.includes("noopener") && target === "_blank"));
    assert.equal(await about.locator("img").count(), 0, "texts are no HTML");
    const [sheet, link] = [await about.boundingBox(), await about.locator("a").last().boundingBox()];
    assert.ok(link.x >= sheet.x && link.x + link.width <= sheet.x + sheet.width, "it breaks into lines");
    assert.ok(await about.locator("a").last().evaluate((each) => each.getClientRects().length > 3));
    await visit.picture("list-4-about");
    await visit.page.getByRole("button", { name: "Close", exact: true }).click();
    assert.equal(await about.isVisible(), false);
    assert.equal(await visit.page.evaluate(() => document.activeElement.id), "about-button");
  });
});

test("below a title the licence is read whole, and is a link where it is an address", () => {
  const folder = temporaryFolder();
  cpSync(models, folder, { recursive: true });
  const licences = {
    "https://creativecommons.org/licenses/by-nc-sa/4.0/deed.de": "CC BY-NC-SA 4.0",
    "http://www.creativecommons.org/publicdomain/zero/1.0/": "CC0 1.0",
    "https://creativecommons.org/publicdomain/mark/1.0/": "Public Domain Mark 1.0",
    [`https://www.example.org/${"terms".repeat(40)}`]: "example.org",
    "https://creativecommons.org/choose": "creativecommons.org",
    "All rights reserved": "All rights reserved",
    "javascript:alert(1)": "javascript:alert(1)",
    "<img src=x onerror=alert(1)>": "<img src=x onerror=alert(1)>",
  };
  return withServer(folder, async (visit, server) => {
    for (const [licence, shown] of Object.entries(licences)) {
      edit(folder, "pebble", "--credit", "The museum of a town with a very long name ".repeat(4).trim(), "--license", licence);
      server.rereadModels();
      const last = visit.page.locator("#credit > :last-child");
      await eventually(`"${shown}" below the title`, async () => {
        await visit.open(`${server.url}/?${Math.random()}#model=pebble`);
        await visit.untilIdle();
        return last.textContent();
      }, (text) => text === shown);
      const missing = await last.evaluate((each) => {
        const words = document.createRange();
        words.selectNodeContents(each);
        return words.getBoundingClientRect().width - each.getBoundingClientRect().width;
      });
      assert.ok(missing < 0.01, `${shown} lacks ${missing} points`);
      const isAddress = licence.startsWith("http");
      assert.equal(await last.evaluate((each) => each.href ?? ""), isAddress ? licence : "");
      assert.equal(await visit.page.locator("#credit > :first-child").evaluate((each) => each.getClientRects().length > 0
        && each.scrollWidth <= each.clientWidth && each.scrollHeight <= each.clientHeight + 1), true, "and the credit too");
      assert.equal(await visit.page.locator("#credit img").count(), 0);
    }
    await visit.picture("list-7-licence");
  });
});

test("sizes have sensible digits and units", () => {
  const folder = temporaryFolder();
  const meshes = temporaryFolder();
  const build = (name, size, unit) => {
    writePebble(join(meshes, `${name}.ply`), 24, 12, size);
    buildStore(join(meshes, `${name}.ply`), join(folder, `${name}.kds`), "--unit", unit);
  };
  build("atom", 1e-10, "m");
  build("hill", 1234567 / 2, "mm");
  build("coin", 10, "mm");
  build("odd", 1e12, "cubits");
  build("plain", 0.7, "m");
  return withServer(folder, async (visit, server) => {
    await visit.open(server.url);
    await visit.untilIdle();
    const seen = {};
    for (const name of ["atom", "hill", "coin", "odd", "plain"]) {
      seen[name] = (await factsOf(await openAbout(visit, name))).Size.replaceAll("\u00a0", " ");
      await visit.page.keyboard.press("Escape");
    }
    assert.match(seen.atom, /^2\d\d × 2\d\d × 200 pm$/);
    assert.match(seen.hill, /^1\.\d\d × 1\.\d\d × 1\.23 km$/);
    assert.match(seen.coin, /^2\d\.\d × 2\d(\.\d)? × 20 mm$/);
    assert.match(seen.odd, /^2\.\d\dE12 × 2(\.\d+)?E12 × 2E12 cubits$/);
    assert.match(seen.plain, /^1\.\d\d × 1\.\d+ × 1\.4 m$/);
  });
});

test("titles with markup, very long, from right to left, and none", () => {
  const folder = temporaryFolder();
  for (const id of ["markup", "long", "rtl", "none"]) {
    cpSync(join(models, "shell.kds"), join(folder, `${id}.kds`));
  }
  edit(folder, "markup", "--title", "<img src=x onerror=\"document.title='hacked'\"> & \"quotes\"");
  edit(folder, "long", "--title", "W".repeat(4096));
  edit(folder, "rtl", "--title", "\u202eقناع من الذهب");
  edit(folder, "none", "--title", "");
  return withServer(folder, async (visit, server) => {
    await visit.open(server.url);
    await visit.untilIdle();
    assert.equal(await visit.page.locator("#models img[src=x]").count(), 0);
    assert.deepEqual((await namesShown(visit)).map((name) => name.slice(0, 4)).sort(), ["<img", "WWWW", "none", "قناع"].sort());
    for (const { width, height } of await visit.page.locator("#models button").evaluateAll((all) => all.map((each) => each.getBoundingClientRect()))) {
      assert.ok(width <= 412 && height < 130, `${width} x ${height}`);
    }
    for (const id of ["markup", "long", "rtl", "none"]) {
      await choose(visit, id);
      const { x, width, y, height } = await visit.page.locator("#title").boundingBox();
      assert.ok(x >= 0 && x + width <= 412 && height < 48 && y + height <= (await visit.page.locator("#view").boundingBox()).y, id);
    }
    await choose(visit, "rtl");
    assert.equal(await visit.page.title(), "قناع من الذهب – KdStream", "it turns nothing round behind it");
    await choose(visit, "long");
    await visit.picture("list-5-titles");
    const about = await openAbout(visit, "long");
    assert.equal((await about.locator("h2").textContent()).length, 4096, "all of it is to be read there");
    assert.ok(await about.evaluate((each) => each.scrollWidth <= each.clientWidth), "within the sheet");
    assert.match(await visit.page.title(), /^W+ – KdStream$/);
  });
});

test("a list with a title of 10,000 characters is reported, and the models there stay usable", () => withServer(models, async (visit, server) => {
  await visit.open(server.url);
  await visit.untilIdle();
  await visit.page.route("**/api/models.json", async (route) => {
    const list = await (await route.fetch()).json();
    list.models[0].title = "x".repeat(10000);
    await route.fulfill({ json: list });
  });
  await visit.page.locator("#open").click();
  await visit.until("full screen", ({ mode }) => mode === "full screen");
  await visit.back();
  await visit.untilSaid(/^The list of models cannot be loaded: .*title.* Trying again …$/);
  assert.deepEqual(await namesShown(visit), ["A pebble", "A shell"]);
  await visit.page.unroute("**/api/models.json");
  await visit.tryNow();
  await visit.untilQuiet();
}));

test("an old server's list, without site and descriptions, and one with members of other types", () => withServer(models, async (visit, server) => {
  await visit.page.route("**/api/models.json", async (route) => {
    const list = await (await route.fetch()).json();
    await route.fulfill({ json: { ...list, site: { title: 7, text: ["x"] }, later: {} } });
  });
  await visit.open(server.url);
  await visit.untilIdle();
  assert.equal(await visit.page.locator("#site").textContent(), "Models");
  assert.equal(await visit.page.locator("#introduction").isVisible(), false);
}));

test("previews that are asked for: nothing is drawn and fetched before, and a window over the list shows one", () => withServer(models, async (visit, server) => {
  const { page } = visit;
  await visit.open(server.url);
  await visit.untilIdle();
  await page.locator("#open").click();
  await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
  await page.locator("#menu-button").click();
  await page.locator("[name=previews][value=asked]").check({ force: true });
  await page.locator("#menu-button").click();
  await visit.back();
  assert.equal(await page.locator("#stage").isVisible(), false, "the list has the screen");
  await page.evaluate(() => indexedDB.deleteDatabase("kdstream"));

  await page.goto("about:blank");
  await visit.open(server.url);
  await untilPictures(visit, 2);
  const { mode, triangles, frames } = await visit.status();
  assert.equal(mode, "no model", "it is remembered");
  assert.equal(triangles, 0, "nothing is drawn");
  await pause(700);
  assert.equal((await visit.status()).frames, frames, "again and again");
  await page.locator("[data-model=shell]").click();
  await visit.until("a preview", ({ model, idle, shownLevel }) => model === "shell" && idle && shownLevel !== null);
  await page.locator("#stage").waitFor();
  await visit.picture("list-6-pop-up");
  const [window_, list] = [await page.locator("#stage").boundingBox(), await page.locator("#browser").boundingBox()];
  assert.ok(window_.y > list.y + 100 && window_.y + window_.height < list.y + list.height, "a window over the list");

  await page.keyboard.press("Escape");
  assert.equal(await page.locator("#stage").isVisible(), false);
  assert.equal(await page.evaluate(() => document.activeElement.dataset.model), "shell");
  await page.keyboard.press("Enter");
  await page.locator("#stage").waitFor();
  assert.equal((await visit.status()).mode, "browsing", "its preview, not the whole screen");
  await page.locator("#back").click();
  assert.equal(await page.locator("#stage").isVisible(), false);
  await page.locator("[data-model=pebble]").click();
  await visit.until("the other", ({ model, idle }) => model === "pebble" && idle);
  await page.locator("[data-model=pebble]").click();
  await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
  await visit.back();
  assert.equal(await page.locator("#stage").isVisible(), false);
}));
