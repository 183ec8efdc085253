// SPDX-License-Identifier: BSD-3-Clause
// The page for everyone: with only the keyboard; for screen readers (axe-core finds nothing); in other languages, and
// from right to left; at usual screen sizes; and with the contrast and the reduced motion that a system asks for.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { Server, Visit, buildStore, eventually, landscape, launchBrowser, makeModels, portrait, runProgram, temporaryFolder, writePebble } from "./harness.mjs";
import { difference } from "./pixels.mjs";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

let server, browser;

before(async () => {
  const models = makeModels({ dragon: false });
  const mesh = join(temporaryFolder(), "fine.ply"); // so fine that the first view is not the original
  writePebble(mesh, 320, 160);
  buildStore(mesh, join(models, "pebble.kds"), "--title", "A pebble", "--vertices-per-partition", "1000");
  runProgram("kdstream-store", "edit", join(models, "pebble.kds"), "--quiet", "--credit", "Somebody", "--license", "https://example.org/",
    "--description", "A pebble with bumps", "--unit", "mm");
  writeFileSync(join(models, "pebble.notes.json"), JSON.stringify({ type: "AnnotationPage", items: [{
    type: "Annotation", label: { de: ["Ein Riss"] }, body: { type: "TextualBody", language: "de", value: "Von 1687. ".repeat(120) },
    target: { type: "SpecificResource", source: "model.json", selector: { type: "FragmentSelector", value: "model=pebble" } } }] }));
  server = await Server.start(models, { more: ["--site-title", "Stones"] });
  browser = await launchBrowser();
});

after(async () => {
  await browser?.close();
  await server?.stop();
});

const fullScreen = (visit) => visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);

// Whether the text below the picture says how to see the original ("hint") or what is shown ("status").
const footOf = async ({ page }) => (await page.locator("#hint").textContent() ? "hint" : "status");

// What axe-core finds wrong in the page's present state, as text.
async function findings({ page }, least = 15) {
  await page.evaluate(`${axe};0`);
  const { violations, passes } = await page.evaluate(() => window.axe.run(document,
    { runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"] }));
  assert.ok(passes.length > least, "it has looked");
  return violations.flatMap(({ id, nodes }) => nodes.map(({ html, failureSummary }) => `${id}: ${html.slice(0, 120)} ${failureSummary}`));
}

for (const lang of ["en", "de", "ar"]) {
  test(`axe-core finds nothing: ${lang}`, async () => {
    const visit = await Visit.phone(browser);
    const { page } = visit;
    await page.goto(`${server.url}/?lang=${lang}`);
    await visit.untilIdle();
    const stages = {
      list: () => {},
      about: async () => {
        await page.click("#about-button");
        await page.locator("#about dl").waitFor();
      },
      "full screen": async () => {
        await page.keyboard.press("Escape");
        await page.click("#open");
        await fullScreen(visit);
      },
      options: async () => {
        await page.click("#menu-button");
        await page.locator("#keep-goal option").first().waitFor({ state: "attached" });
      },
      tools: async () => {
        await page.click("#tools-button");
        await page.locator("#tabs button").nth(1).click();
        await page.locator("#measure").waitFor();
      },
      help: async () => {
        await page.click("#help-button");
        await page.locator("#help dl").waitFor();
      },
      notes: async () => {
        await page.keyboard.press("Escape");
        await page.locator("#notes-open").dispatchEvent("click");
        await page.locator("#notes-list button").first().click();
        await page.locator("#note h3").waitFor();
        await visit.untilIdle();
        const [box, { y }] = [await page.locator("#notes").boundingBox(), await visit.centre()];
        assert.ok(box.y > y + 16 || box.y + box.height < y - 16, "a long note leaves its marker in sight");
      },
      "notes in landscape": async () => {
        await page.setViewportSize(landscape);
        await visit.untilIdle();
        const [box, view] = [await page.locator("#notes").boundingBox(), page.viewportSize()];
        assert.ok(box.x >= 0 && box.x + box.width <= view.width && box.y >= 0 && box.y + box.height <= view.height, JSON.stringify(box));
        const [title, next] = [await page.locator("#note h3").boundingBox(), await page.locator("#note-next").boundingBox()];
        assert.ok(title.y >= box.y && next.y + next.height <= box.y + box.height, "a long note's title and buttons are seen");
        await visit.picture(`everyone-notes-${lang}`);
        await page.setViewportSize(portrait);
        await page.keyboard.press("Escape");
      },
      legend: async () => {
        await page.evaluate(() => document.querySelector("[name=coloring][value='resolution']").click());
        await page.locator("#legend li").first().waitFor();
      },
    };
    for (const [name, act] of Object.entries(stages)) {
      await act();
      assert.deepEqual(await findings(visit), [], name);
    }
    visit.assertClean(server.url);
    await visit.close();
  });
}

for (const theme of ["dark", "light"]) {
  test(`axe-core finds nothing in somebody's page: ${theme}`, async (t) => {
    const host = createServer((_, response) => response.setHeader("Content-Type", "text/html; charset=utf-8").end(`<!doctype html>
      <html lang="en"><title>A museum</title><link rel="icon" href="data:,"><main><h1>A museum</h1>
      <script src="${server.url}/embed.js"></script><kdstream-viewer model="pebble" theme="${theme}" title="A pebble" style="width: 700px; height: 620px"></kdstream-viewer></main>`));
    await new Promise((started) => host.listen(0, "127.0.0.1", started));
    t.after(() => host.close());
    const visit = await Visit.desktop(browser);
    await visit.page.goto(`http://127.0.0.1:${host.address().port}/`);
    const frame = await (await visit.page.waitForSelector("kdstream-viewer iframe")).contentFrame();
    const inFrame = { page: frame };
    await eventually("a picture", () => frame.evaluate(() => window.kdstream?.status()), (status) => status?.idle && status.shownLevel !== null);
    const open = async (button, what) => {
      await frame.click(button);
      await frame.locator(what).first().waitFor();
    };
    assert.deepEqual(await findings(visit, 5), [], "the page around it");
    for (const [name, act] of Object.entries({
      viewer: () => {},
      about: () => open("#about-button", "#about dl"),
      options: () => open("#menu-button", "#menu"),
      tools: () => open("#tools-button", "#measure"),
      "a tool in hand": () => open("#measure", "#measure[aria-pressed=true]"),
      "a note": async () => {
        await open("#notes-open", "#notes-list");
        await open("#notes-list button", "#note h3");
        const [box, view] = await frame.evaluate(() => ["notes", "view"].map((id) => document.getElementById(id).getBoundingClientRect().toJSON()));
        assert.ok(box.right < view.x + view.width / 2 - 16, "a long note leaves its marker in sight");
      },
    })) {
      await act();
      assert.deepEqual(await findings(inFrame), [], name);
      await visit.picture(`everyone-9-${theme}-${name.replaceAll(" ", "-")}`);
    }
    await visit.close();
  });
}

test("axe-core finds nothing where something is wrong", async (t) => {
  const gone = await Visit.phone(browser);
  await gone.open(`${server.url}/m/nowhere`);
  await gone.untilSaid(/nowhere/);
  assert.deepEqual(await findings(gone), [], "a model that is gone");
  await gone.close();

  const keys = join(temporaryFolder(), "keys.json");
  writeFileSync(keys, JSON.stringify({ secret: "0123456789abcdef0123456789abcdef" }), { mode: 0o600 });
  const guarded = await Server.start(makeModels({ dragon: false }), { more: ["--tokens", keys, "--contact", "Ask Ann."] });
  t.after(() => guarded.stop());
  const stranger = await Visit.phone(browser);
  await stranger.open(`${guarded.url}/m/pebble`);
  await stranger.untilSaid(/Ask Ann\./);
  assert.deepEqual(await findings(stranger), [], "without a token");
  await stranger.page.click("#message-action");
  await stranger.page.fill("#token", "?");
  await stranger.page.getByRole("button", { name: "Enter", exact: true }).click();
  await eventually("it is none", () => stranger.page.locator("#token-wrong").textContent(), Boolean);
  assert.deepEqual(await findings(stranger), [], "the dialog for a token");
  await stranger.picture("everyone-9-token");
  await stranger.close();

  const empty = await Server.start(temporaryFolder());
  t.after(() => empty.stop());
  const early = await Visit.phone(browser);
  await early.open(empty.url);
  await early.page.locator("#empty").waitFor();
  assert.deepEqual(await findings(early), [], "no models yet");
  await early.close();
});

// Presses Tab until the element with the id has the focus.
async function tabTo(page, id) {
  for (let i = 0; i < 40; ++i) {
    await page.keyboard.press("Tab");
    if (await page.evaluate((wanted) => document.activeElement.id === wanted || document.activeElement.dataset.model === wanted, id)) {
      return;
    }
  }
  assert.fail(`Tab never comes to ${id}`);
}

const focused = (page) => page.evaluate(() => document.activeElement.id || document.activeElement.dataset.model || document.activeElement.nodeName);
const outline = (page) => page.evaluate(() => getComputedStyle(document.activeElement).outlineStyle);

test("all of it by keyboard", async () => {
  const visit = await Visit.desktop(browser);
  const { page } = visit;
  await visit.open(server.url);
  await visit.untilIdle();
  assert.equal(await focused(page), "BODY", "the page takes no focus by itself");
  await tabTo(page, "shell");
  assert.equal(await outline(page), "solid", "where the focus is shows");
  await page.keyboard.press("Enter");
  await visit.until("the shell's preview", ({ model, idle }) => model === "shell" && idle);
  await eventually("it is announced", () => page.locator("#live").textContent(), (text) => text === "Preview of A shell");
  await page.keyboard.press("Shift+Tab");
  assert.equal(await focused(page), "pebble");
  await page.keyboard.press("Enter");
  await visit.until("the pebble's preview", ({ model, idle }) => model === "pebble" && idle);

  await tabTo(page, "about-button");
  await page.keyboard.press("Enter");
  await page.locator("#about dl").waitFor();
  assert.equal(await focused(page), "about");
  await page.keyboard.press("Tab");
  assert.equal(await focused(page), "A", "the licence's link");
  await page.keyboard.press("Escape");
  assert.equal(await focused(page), "about-button");
  await visit.until("the list", ({ mode }) => mode === "browsing");

  await tabTo(page, "open");
  await page.keyboard.press("Enter");
  await fullScreen(visit);
  assert.equal(await focused(page), "view", "the focus goes with what is shown");
  await eventually("it is announced", () => page.locator("#live").textContent(), (text) => text === "A pebble: full screen");
  assert.match(await page.locator("#keys").textContent(), /Arrow keys turn/);
  assert.equal(await page.getAttribute("#view", "aria-describedby"), "keys");

  const seen = async () => {
    await visit.untilIdle();
    return visit.around(await visit.centre(), 500);
  };
  let last = await seen();
  // A part of the picture that includes the model's outline, which does not move when the model turns.
  const { x, y } = await visit.centre();
  const here = await visit.around({ x, y }, 560);
  await page.keyboard.press("Shift+ArrowRight");
  await visit.untilIdle();
  assert.ok(difference(here, await visit.around({ x: x + 40, y }, 560)) < 0.03, "Shift moves");
  await page.keyboard.press("h");
  last = await seen();
  for (const key of ["ArrowLeft", "ArrowUp", "+", "-", "Shift+ArrowUp", "h", "u"]) {
    await page.keyboard.press(key);
    const next = await seen();
    assert.ok(difference(last, next) > 0.005, key);
    last = next;
  }
  await page.keyboard.press("h");
  await visit.untilIdle();
  await page.keyboard.press("Enter");
  await visit.until("the original in the middle", ({ region, idle }) => idle && region?.partitions > 0 && region.shown === region.partitions);
  await eventually("it is announced", () => page.locator("#live").textContent(), (text) => text === "A pebble: original detail is shown");

  await tabTo(page, "tools-button");
  await page.keyboard.press("Enter");
  await page.locator("#measure").waitFor();
  await eventually("the focus in the sheet", () => page.evaluate(() => document.activeElement.closest("#tools") !== null));
  await page.locator("#measure").focus();
  await page.keyboard.press("Enter");
  await visit.until("it measures", ({ measuring }) => measuring);
  await page.keyboard.press("Escape");
  assert.equal(await focused(page), "tools-button");
  await page.focus("#view");
  await page.keyboard.press("Enter"); // a tap at the middle
  await page.keyboard.press("ArrowLeft");
  await visit.untilIdle();
  await page.keyboard.press("Enter");
  await eventually("a distance", () => page.locator("#measurements li").count(), (count) => count === 1);
  await eventually("between two points", () => page.locator("#measurements li span").textContent(), (text) => /height/.test(text));

  await tabTo(page, "menu-button");
  await page.keyboard.press("Enter");
  assert.equal(await page.evaluate(() => document.activeElement.name), "detail");
  await page.keyboard.press("ArrowRight");
  assert.equal(await page.evaluate(() => document.querySelector("[name=detail]:checked").value), "1");
  await page.keyboard.press("Escape");
  await page.keyboard.press("Escape");
  await visit.until("the list", ({ mode }) => mode === "browsing");
  await eventually("the focus on what was chosen", () => focused(page), (id) => id === "pebble");
  assert.deepEqual(await visit.messages(), []);
  visit.assertClean(server.url);
  await visit.close();
});

test("no frame around the picture for who points, whatever is pressed", async () => {
  const visit = await Visit.desktop(browser);
  const { page } = visit;
  await visit.open(server.url);
  await visit.untilIdle();
  await page.mouse.click(...Object.values(await visit.centre()));
  await fullScreen(visit);
  for (const key of ["Shift", "a", "ArrowLeft", "h", "Control"]) {
    await page.keyboard.press(key);
    assert.equal(await page.evaluate(() => getComputedStyle(document.getElementById("view")).outlineStyle), "none", key);
  }
  await page.click("#home");
  await page.keyboard.press("a");
  assert.notEqual(await page.evaluate(() => getComputedStyle(document.getElementById("view")).outlineStyle), "solid");
  await visit.close();
});

test("no frame around the picture for who opens a link", async () => {
  const visit = await Visit.desktop(browser);
  const { page } = visit;
  await visit.open(server.url);
  await visit.untilIdle();
  await page.evaluate(() => {
    location.hash = "model=shell";
  });
  await fullScreen(visit);
  for (const key of ["Shift", "ArrowLeft"]) {
    assert.deepEqual([await focused(page), await outline(page)], ["view", "none"]);
    await page.keyboard.press(key);
  }
  await page.keyboard.press("Tab");
  await page.keyboard.press("Shift+Tab");
  assert.deepEqual([await focused(page), await outline(page)], ["view", "solid"], "who goes by keyboard sees it");
  await visit.close();
});

test("in the browser's language, or the address's", async () => {
  const german = await Visit.phone(browser, { width: 390, height: 844 }, { locale: "de-AT" });
  await german.open(server.url);
  await german.untilIdle();
  assert.equal(await german.page.evaluate(() => document.documentElement.lang), "de");
  assert.equal(await german.page.getAttribute("#open", "aria-label"), "Ganzer Bildschirm");
  assert.ok(german.requests.some((url) => url.endsWith("/words/de.js")));
  await german.page.locator("#open").click();
  await fullScreen(german);
  assert.match(await german.page.locator("#hint").textContent(), /^Doppelt antippen/);
  await german.page.locator("#menu-button").click();
  await eventually("figures", () => german.page.locator("#stored").textContent(), (text) => /kB von 200\u00a0MB sind belegt\.$/.test(text));
  assert.doesNotMatch(await german.page.locator("#menu").innerText(), /Detail|Show|Turning|Near|Keep/);
  await german.picture("everyone-1-german");
  german.assertClean(server.url);
  await german.close();

  const english = await Visit.phone(browser, undefined, { locale: "de-DE" });
  await english.open(`${server.url}/?lang=en`);
  await english.untilIdle();
  assert.equal(await english.page.getAttribute("#open", "aria-label"), "Full screen");
  assert.ok(!english.requests.some((url) => url.includes("/words/")), "English is there already");
  await english.close();

  // A language without a translation, one whose file does not arrive, and an invalid code.
  for (const [query, block] of [["?lang=de", true], ["?lang=xx", false], ["?lang=../../evil", false]]) {
    const other = await Visit.phone(browser);
    if (block) {
      await other.page.route("**/words/*", (route) => route.abort());
    }
    await other.open(`${server.url}/${query}`);
    await other.untilIdle();
    assert.equal(await other.page.getAttribute("#open", "aria-label"), "Full screen", query);
    await other.close();
  }
});

test("a language that comes late is spoken from then on", async () => {
  const visit = await Visit.phone(browser);
  const { page } = visit;
  let send;
  const wanted = new Promise((resolve) => (send = resolve));
  await page.route("**/words/de.js", async (route) => {
    await wanted;
    await route.continue();
  });
  await visit.open(`${server.url}/?lang=de`);
  await visit.untilIdle();
  assert.equal(await page.evaluate(() => document.documentElement.lang), "en", "nobody waits for it for ever");
  assert.match(await page.locator("#live").textContent(), /^Preview of/);
  send();
  await eventually("German", () => page.locator("#live").textContent(), (text) => /^Vorschau von/.test(text));
  assert.equal(await page.evaluate(() => document.documentElement.lang), "de");
  assert.equal(await page.locator("#menu-button").getAttribute("aria-label"), "Einstellungen");
  assert.deepEqual(visit.errors, []);
  await visit.close();
});

test("what session and server say is translated too", async () => {
  const visit = await Visit.phone(browser);
  await visit.open(`${server.url}/?lang=de#model=nowhere`);
  await visit.untilSaid(/^Der Server hat kein Modell „nowhere“\.$/);
  await visit.close();
});

test("from right to left", async () => {
  const visit = await Visit.phone(browser, undefined, { locale: "ar" });
  const { page } = visit;
  await visit.open(server.url);
  await visit.untilIdle();
  const { width } = page.viewportSize();
  const box = (selector) => page.locator(selector).boundingBox();
  const isRight = ({ x, width: own }) => x + own / 2 > width / 2;
  assert.equal(await page.evaluate(() => document.documentElement.dir), "rtl");
  assert.ok(isRight(await box("[data-model=pebble] .picture")), "entries begin at the right");
  assert.ok(!isRight(await box("#open")));
  await visit.picture("everyone-2-arabic-list");
  await page.click("#open");
  await fullScreen(visit);
  assert.ok(isRight(await box("#back")) && !isRight(await box("#menu-button")));
  assert.notEqual(await page.evaluate(() => getComputedStyle(document.querySelector("#back svg")).transform), "none", "the arrow points to where it leads");
  await page.click("#menu-button");
  const sheet = await box("#menu");
  assert.ok(sheet.x >= 0 && sheet.x < 30 && sheet.x + sheet.width <= width, "sheets open at the end of a line");
  await visit.picture("everyone-3-arabic-options");
  await page.click("#about-button");
  await page.locator("#about dl").waitFor();
  const [size] = await page.locator("#about dd").allTextContents();
  assert.match(size, /^\u2066[\d.]+ × [\d.]+ × [\d.]+\u00a0mm\u2069$/, "figures keep their order");
  assert.equal(await page.locator("#about dd").first().evaluate((each) => getComputedStyle(each).textAlign), "right", "they begin below their names");
  await visit.picture("everyone-4-arabic-about");
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width, "nothing sticks out");
  visit.assertClean(server.url);
  await visit.close();
});

test("a title in another direction begins where its credit does", async () => {
  for (const [lang, title, edge] of [["ar", "Nefertiti", "right"], ["en", "قناع من الذهب", "left"]]) {
    const visit = await Visit.phone(browser);
    await visit.open(`${server.url}/?lang=${lang}`);
    await visit.untilIdle();
    const edges = await visit.page.evaluate(([text, side]) => ["#title", "#credit", "#models .name", "#site"].map((selector) => {
      const element = document.querySelector(selector);
      element.textContent = text;
      const words = document.createRange();
      words.selectNodeContents(element);
      const line = element.id === "site" ? element : element.parentElement;
      return Math.abs(words.getBoundingClientRect()[side] - line.getBoundingClientRect()[side]);
    }), [title, edge]);
    assert.ok(edges.every((distance) => distance < 6), `${lang}: ${edges}`);
    await visit.close();
  }
});

test("hints are read whole at 240 points", async () => {
  const visit = await Visit.phone(browser, { width: 240, height: 420 });
  await visit.open(`${server.url}/?lang=de`);
  await visit.untilIdle();
  await visit.page.click("#open");
  await fullScreen(visit);
  const hint = visit.page.locator("#hint");
  await eventually("a hint", () => hint.textContent());
  assert.ok(await hint.evaluate((element) => {
    const { left, right } = element.getBoundingClientRect();
    return element.scrollWidth <= element.clientWidth && element.scrollHeight <= element.clientHeight && left >= 0 && right <= innerWidth;
  }));
  await visit.picture("everyone-9-narrow");
  await visit.close();
});

test("no hint at the original where it is shown", async () => {
  const visit = await Visit.phone(browser);
  await visit.open(server.url);
  await visit.untilIdle();
  await visit.page.click("#open");
  await fullScreen(visit);
  const hint = () => visit.page.locator("#hint").textContent();
  const pinchUntil = async (original, from, to) => {
    for (let pinches = 0; (await visit.untilIdle()).original !== original; ++pinches) {
      assert.ok(pinches < 25, "pinching leads there");
      await visit.pinch(await visit.centre(), from, to);
    }
  };
  await pinchUntil(false, 200, 100);
  assert.match(await hint(), /^Double-tap/);
  await pinchUntil(true, 100, 200);
  assert.equal(await hint(), "");
  assert.match(await visit.page.locator("#status").textContent(), /^Original$/);
  await pinchUntil(false, 200, 100);
  assert.match(await hint(), /^Double-tap/);
  await visit.close();
});

// Whether two boxes overlap.
const overlap = (a, b) => a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;

for (const [width, height] of [[390, 844], [844, 390], [320, 568], [1280, 800], [600, 1000], [412, 500], [915, 200]]) {
  test(`captions, buttons and picture beside each other at ${width}x${height}`, async () => {
    const visit = await Visit.phone(browser, { width, height });
    const { page } = visit;
    await visit.open(server.url);
    await visit.untilIdle();
    await page.evaluate(() => {
      document.querySelector("#models .name").textContent = "A very long title ".repeat(20);
    });
    const boxes = async (...ids) => Object.fromEntries(await Promise.all(ids.map(async (id) => [id, await page.locator(`#${id}`).boundingBox()])));
    const assertApart = (all) => {
      for (const [name, one] of Object.entries(all)) {
        for (const [other, two] of Object.entries(all)) {
          assert.ok(name >= other || !overlap(one, two), `${name} and ${other}: ${JSON.stringify([one, two])}`);
        }
        assert.ok(one.x >= 0 && one.y >= 0 && one.x + one.width <= width + 0.5 && one.y + one.height <= height + 0.5, `${name} is on the screen`);
      }
    };
    assertApart(await boxes("title", "about-button", "open", "view"));
    await visit.picture(`everyone-5-list-${width}x${height}`);
    await page.click("#open");
    await fullScreen(visit);
    await page.focus("#view");
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("h");
    await visit.untilIdle();
    assert.equal((await visit.status()).canUndo, true);
    await page.evaluate(() => {
      document.getElementById("title").firstChild.data = "A very long title ".repeat(20);
    });
    assertApart(await boxes("back", "title", "credit", "about-button", "help-button", "undo", "home", "tools-button", "menu-button", await footOf(visit)));
    assert.deepEqual((await boxes("view")).view, { x: 0, y: 0, width, height }, "the picture has all of the room");
    await visit.picture(`everyone-6-full-${width}x${height}`);
    visit.assertClean(server.url);
    await visit.close();
  });
}

test("a notch: nothing lies under it", async () => {
  const visit = await Visit.phone(browser, { width: 844, height: 390 });
  const { page } = visit;
  const session = await page.context().newCDPSession(page);
  await session.send("Emulation.setSafeAreaInsetsOverride", { insets: { top: 20, left: 47, right: 47, bottom: 21 } }).catch(() => {});
  await visit.open(server.url);
  await visit.untilIdle();
  if (await page.evaluate(() => getComputedStyle(document.documentElement).getPropertyValue("--left").trim()) !== "47px") {
    // The test's browser has no such margins, and cannot simulate them.
    await page.evaluate(() => {
      for (const [side, points] of Object.entries({ top: 20, left: 47, right: 47, bottom: 21 })) {
        document.documentElement.style.setProperty(`--${side}`, `${points}px`);
      }
    });
  }
  await page.click("#open");
  await fullScreen(visit);
  for (const id of ["back", "title", "menu-button", "help-button", await footOf(visit)]) {
    const { x, y, width, height } = await page.locator(`#${id}`).boundingBox();
    assert.ok(x >= 47 && x + width <= 844 - 47 && y >= 20 && y + height <= 390 - 21, id);
  }
  await visit.picture("everyone-7-notch");
  await visit.close();
});

test("more contrast, and a system's own colours", async () => {
  for (const [name, options] of [["contrast", { contrast: "more" }], ["forced", { forcedColors: "active" }]]) {
    const visit = await Visit.phone(browser, undefined, options);
    const { page } = visit;
    await visit.open(server.url);
    await visit.untilIdle();
    const edge = (selector) => page.evaluate((wanted) => {
      const { borderTopWidth, borderTopStyle, borderTopColor } = getComputedStyle(document.querySelector(wanted));
      return borderTopStyle !== "none" && parseFloat(borderTopWidth) > 0 && !/^rgba\(.*, 0\)$/.test(borderTopColor);
    }, selector);
    assert.ok(await edge("[data-model=shell]"), `${name}: entries have edges`);
    await page.click("#open");
    await fullScreen(visit);
    await page.click("#menu-button");
    assert.ok(await edge("#menu"), `${name}: sheets have edges`);
    await visit.picture(`everyone-8-${name}`);
    visit.assertClean(server.url);
    await visit.close();
  }
});
