// SPDX-License-Identifier: BSD-3-Clause
// Notes on a model: a visitor steps through them, an author writes some, and the server reads them from a file beside
// the store.

import assert from "node:assert/strict";
import { readFileSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { Server, Visit, eventually, launchBrowser, makeModels, makeToken, pause, temporaryFolder } from "./harness.mjs";

let server, browser, models, goodView;

const file = (model = "pebble") => join(models, `${model}.notes.json`);

const notesOf = (...notes) => JSON.stringify({
  type: "AnnotationPage",
  items: notes.map(([title, text, link]) => ({
    type: "Annotation", label: { en: [title] }, body: { type: "TextualBody", value: text, language: "en" },
    target: { type: "SpecificResource", source: "model.json", selector: { type: "FragmentSelector", value: link } },
  })),
});

// Waits until the list of models reports this number of notes.
const untilListed = (number, model = "pebble") => eventually(`${number} notes on ${model}`, async () => {
  const list = await (await fetch(`${server.url}/api/models.json`)).json();
  return list.models.find(({ id }) => id === model).notes ?? 0;
}, (count) => count === number);

before(async () => {
  models = makeModels({ dragon: false });
  server = await Server.start(models);
  browser = await launchBrowser();
});

after(async () => {
  await browser?.close();
  await server?.stop();
});

async function openPebble(visit, more = "") {
  await visit.open(`${server.url}${more}#model=pebble`);
  return visit.until("full screen", ({ mode, idle, shownLevel }) => mode === "full screen" && idle && shownLevel !== null);
}

const press = async (visit, name) => {
  await visit.showTool(name);
  await visit.page.getByRole("button", { name, exact: true }).click();
};
const textOf = (visit, id) => visit.page.locator(id).textContent();

test("an author adds notes, moves and edits them, and saves a file that is then served", async () => {
  const visit = await Visit.phone(browser);
  await openPebble(visit);
  assert.ok(!visit.requests.some((url) => /notes\.(js|json)/.test(url)), "nothing of notes where there are none");
  const middle = await visit.centre();
  await visit.drag(middle, 90, 40);
  await visit.untilIdle();
  await visit.page.locator("#tools-button").click();
  await press(visit, "Write notes");
  for (const [title, text] of [["Second", "<b>bold</b>"], ["First", "Ü"]]) {
    await press(visit, "Add a note here");
    await visit.page.locator("#note-title").fill(title);
    await visit.page.locator("#note-text").fill(text);
    await press(visit, "Keep this note");
  }
  await visit.page.locator("#notes-written li").nth(1).getByRole("button", { name: "Up" }).click();
  await visit.page.locator("#notes-written li").nth(0).getByRole("button", { name: "Edit" }).click();
  await visit.page.locator("#note-title").fill("The first");
  await press(visit, "Keep this note");
  assert.deepEqual(await visit.page.locator("#notes-written span").allTextContents(), ["The first", "Second"]);
  await visit.picture("notes-1-writing");
  const [saved] = await Promise.all([visit.page.waitForEvent("download"), press(visit, "Save notes")]);
  assert.equal(saved.suggestedFilename(), "pebble.notes.json");
  assert.match(await textOf(visit, "#notes-remark"), /^Copy pebble\.notes\.json to the folder of pebble\.kds on the server/);
  const text = readFileSync(await saved.path(), "utf8");
  const { items } = JSON.parse(text);
  assert.deepEqual(items.map(({ label, body }) => [label.en[0], body.value]), [["The first", "Ü"], ["Second", "<b>bold</b>"]]);
  goodView = items[0].target.selector.value;
  assert.match(goodView, /^model=pebble&digest=[0-9a-f]{8}&view=/);
  await saved.saveAs(file());
  await untilListed(2);
  const answer = await fetch(`${server.url}/api/models/pebble/notes.json`);
  assert.equal(answer.status, 200);
  assert.equal(await answer.text(), text, "as it is");
  visit.assertClean(server.url);
  await visit.close();
});

test("a visitor steps through them by keyboard, and hears what they say", async () => {
  writeFileSync(file(), notesOf(["A crack", "From 1687.", goodView], ["Markup", "<img src=x onerror=alert(1)><b>&amp;</b>", "model=pebble"],
    ["Nowhere", "Its view is nonsense.", "model=pebble&view=%3Cscript%3E"], ["Elsewhere", "It names another model.", goodView.replace("pebble", "shell")]));
  await untilListed(4);
  const visit = await Visit.phone(browser);
  await openPebble(visit);
  const { canUndo } = await visit.status();
  assert.equal(canUndo, false);
  await visit.page.locator("#notes-open").click();
  assert.deepEqual(await visit.page.locator("#notes-list button").allTextContents(), ["A crack", "Markup", "Nowhere", "Elsewhere"]);
  assert.equal(await visit.page.evaluate(() => document.activeElement.textContent), "A crack");
  const before = await visit.around(await visit.centre(), 300);
  await visit.page.keyboard.press("Enter");
  await visit.untilIdle();
  assert.notDeepEqual(await visit.around(await visit.centre(), 300), before, "another view");
  assert.equal(await visit.page.locator("#note").getAttribute("aria-live"), "polite");
  assert.equal(await textOf(visit, "#note"), "A crackFrom 1687.");
  assert.equal(await textOf(visit, "#note-place"), "1 of 4");
  await visit.picture("notes-2-note");
  assert.equal(await visit.page.evaluate(() => document.activeElement.id), "note-next");
  await visit.page.keyboard.press("Enter");
  assert.equal(await textOf(visit, "#note p"), "<img src=x onerror=alert(1)><b>&amp;</b>");
  assert.equal(await visit.page.locator("#note img, #note b").count(), 0, "markup is text");
  await visit.page.keyboard.press("Enter");
  await visit.until("a sentence", ({ error }) => /link to a view/.test(error));
  assert.equal(await textOf(visit, "#note h3"), "Nowhere");
  await press(visit, "Next note");
  await visit.until("it goes on", ({ idle, error, model }) => idle && model === "pebble" && !error);
  assert.equal(await textOf(visit, "#note h3"), "Elsewhere");
  assert.equal(await visit.page.locator("#note-next").isDisabled(), true);
  await visit.page.keyboard.press("Escape");
  assert.equal(await visit.page.locator("#notes").isVisible(), false);
  assert.equal((await visit.status()).mode, "full screen", "Escape closes the notes alone");
  assert.equal(await visit.page.evaluate(() => document.activeElement.id), "notes-open");
  visit.assertClean(server.url);
  await visit.close();
});

test("a note's number stands on the object, hidden behind it, and opens it", async () => {
  writeFileSync(file(), notesOf(["<b>One</b>", "From 1687.", goodView], ["Two", "No view.", "model=pebble"]));
  await untilListed(2);
  const visit = await Visit.phone(browser);
  const { page } = visit;
  await openPebble(visit);
  const mark = page.locator(".note-mark").first();
  await page.locator("#notes-open").click();
  await page.locator("#notes-list button").first().click();
  await visit.untilIdle();
  await mark.waitFor();
  assert.equal(await mark.textContent(), "1");
  assert.equal(await mark.getAttribute("aria-label"), "1: <b>One</b>");
  assert.equal(await page.locator(".note-mark").nth(1).isVisible(), false, "the first view looks at no place");
  const [middle, box] = [await visit.centre(), await mark.boundingBox()];
  assert.ok(Math.hypot(box.x + box.width / 2 - middle.x, box.y + box.height / 2 - middle.y) < 3, "where its view looks");
  await visit.picture("notes-3-marks");
  await press(visit, "Close");
  await visit.drag({ x: middle.x - 180, y: middle.y + 120 }, 360, 0, 12); // half a turn
  await visit.untilIdle();
  await eventually("behind it", () => mark.isVisible(), (seen) => !seen);
  await visit.drag({ x: middle.x + 180, y: middle.y + 120 }, -340, 0, 12);
  await visit.untilIdle();
  await mark.waitFor();
  await mark.click();
  await eventually("its note", () => textOf(visit, "#note h3"), (text) => text === "<b>One</b>");
  assert.equal(await page.locator("#note b").count(), 0);
  await page.keyboard.press("Escape");
  await page.locator("#tools-button").click();
  await page.locator("#tabs").waitFor();
  await press(visit, "Measure");
  await eventually("taps are for the tool in hand", () => mark.isVisible(), (seen) => !seen);
  visit.assertClean(server.url);
  await visit.close();
});

test("a note's number is there where its file comes after the last frame", async () => {
  const visit = await Visit.phone(browser);
  const { page } = visit;
  let send;
  const wanted = new Promise((resolve) => (send = resolve));
  await page.route("**/notes.json", async (route) => {
    await wanted;
    await route.continue();
  });
  await openPebble(visit);
  await eventually("it is asked for", () => visit.requests.some((url) => url.endsWith("/notes.json")));
  await pause(500);
  const { frames } = await visit.status();
  send();
  await page.locator(".note-mark").first().waitFor();
  assert.equal((await visit.status()).frames, frames, "nothing was drawn for it");
  await visit.close();
});

test("a tour plays by itself, until somebody takes over", async () => {
  const visit = await Visit.phone(browser);
  const { page } = visit;
  await page.addInitScript(() => {
    const wait = window.setTimeout; // each note is shown for seconds
    window.setTimeout = (act, time, ...more) => wait(act, time > 3999 && time < 31000 ? 400 : time, ...more);
  });
  await openPebble(visit);
  await page.locator("#notes-open").click();
  await page.locator("#notes-list button").first().click();
  await press(visit, "Play the tour");
  assert.equal(await textOf(visit, "#note h3"), "Two");
  await eventually("it ends with the last", () => textOf(visit, "#note-play"), (text) => text === "Play the tour");
  await press(visit, "Play the tour");
  assert.equal(await textOf(visit, "#note h3"), "<b>One</b>");
  assert.equal(await textOf(visit, "#note-play"), "Pause");
  await eventually("the next", () => textOf(visit, "#note h3"), (text) => text === "Two");
  await press(visit, "Previous note");
  assert.equal(await textOf(visit, "#note-play"), "Play the tour");
  await pause(1500);
  assert.equal(await textOf(visit, "#note h3"), "<b>One</b>", "who takes over has it");
  await visit.close();
  rmSync(file());
  await untilListed(0);
});

test("notes that are too long, or no notes, are not served", async () => {
  for (const wrong of [" ".repeat(262145), notesOf(["a".repeat(201), "", "model=pebble"]), "{}"]) {
    writeFileSync(file(), wrong);
    await untilListed(0);
    const answer = await fetch(`${server.url}/api/models/pebble/notes.json`);
    assert.equal(answer.status, 404);
    assert.equal((await answer.json()).error, "there are no notes on pebble");
    writeFileSync(file(), notesOf(["One", "", "model=pebble"]));
    await untilListed(1);
  }
  assert.equal((await fetch(`${server.url}/api/models/pebble/notes.json`, { method: "PUT" })).status, 405);
  rmSync(file());
  await untilListed(0);
});

test("a note that was begun outlasts Escape, and what is to be done with notes is seen", async () => {
  const visit = await Visit.phone(browser);
  const { page } = visit;
  const written = () => page.locator("#notes-written span").allTextContents();
  await openPebble(visit);
  await page.locator("#tools-button").click();
  await press(visit, "Write notes");
  await press(visit, "Add a note here");
  await page.locator("#note-title").fill("Begun");
  await page.locator("#note-text").fill("and not ended");
  await page.keyboard.press("Escape");
  assert.equal(await page.locator("#tools").isVisible(), false);
  await page.locator("#tools-button").click();
  await press(visit, "Add a note here");
  assert.equal(await page.locator("#note-title").inputValue(), "Begun");
  assert.equal(await page.locator("#note-text").inputValue(), "and not ended");
  await press(visit, "Keep this note");
  await press(visit, "Add a note here");
  await page.locator("#note-text").fill("without a title");
  await press(visit, "Edit");
  assert.match(await textOf(visit, "#notes-remark"), /needs a title/);
  await page.locator("#note-title").fill("Another");
  await press(visit, "Edit");
  assert.deepEqual(await written(), ["Begun", "Another"], "it is kept before the other is edited");
  assert.equal(await page.locator("#note-title").inputValue(), "Begun");
  await Promise.all([page.waitForEvent("download"), press(visit, "Save notes")]);
  assert.ok(await page.locator("#notes-remark").evaluate((element) => {
    const [{ top, bottom }, sheet] = [element.getBoundingClientRect(), document.getElementById("tools").getBoundingClientRect()];
    return top >= sheet.top && bottom <= sheet.bottom;
  }), "where to put the file");
  await visit.close();
});

test("notes that are not saved are not lost without a question", async () => {
  const visit = await Visit.phone(browser);
  await openPebble(visit);
  await visit.page.locator("#tools-button").click();
  await press(visit, "Write notes");
  await press(visit, "Add a note here");
  await visit.page.locator("#note-title").fill("One");
  await press(visit, "Keep this note");
  const leave = async () => {
    let asked = 0;
    const answer = (dialog) => {
      asked += dialog.type() === "beforeunload";
      return dialog.dismiss();
    };
    visit.page.on("dialog", answer);
    await visit.page.goto("about:blank").catch(() => {}); // is cancelled if the answer is no
    visit.page.off("dialog", answer);
    return asked;
  };
  assert.equal(await leave(), 1);
  assert.deepEqual(await visit.page.locator("#notes-written span").allTextContents(), ["One"], "the page stays");
  await Promise.all([visit.page.waitForEvent("download"), press(visit, "Save notes")]);
  assert.equal(await leave(), 0);
  assert.equal(visit.page.url(), "about:blank");
  await visit.close();
});

test("notes that were seen are there without the server", async () => {
  writeFileSync(file(), notesOf(["A crack", "From 1687.", goodView]));
  await untilListed(1);
  const other = await Server.start(models);
  const visit = await Visit.phone(browser);
  await visit.open(`${other.url}#model=pebble`);
  await visit.page.locator("#notes-open").waitFor();
  await eventually("the worker", () => visit.page.evaluate(
    async () => (await navigator.serviceWorker.getRegistration())?.active?.state === "activated"));
  await pause(1000); // until the last data is stored
  await other.stop();
  await visit.page.reload();
  await visit.page.locator("#notes-open").click();
  await visit.page.locator("#notes-list button").click();
  assert.equal(await textOf(visit, "#note"), "A crackFrom 1687.");
  await visit.close();
  rmSync(file());
  await untilListed(0);
});

test("whoever may have any of the model may have its notes, and nobody else", async () => {
  writeFileSync(file(), notesOf(["A crack", "From 1687.", "model=pebble"]));
  const keys = join(temporaryFolder(), "tokens.json");
  writeFileSync(keys, JSON.stringify({ secret: "0123456789abcdef0123456789abcdef" }), { mode: 0o600 });
  const guarded = await Server.start(models, { more: ["--tokens", keys] });
  const ask = async (token) => (await fetch(`${guarded.url}/api/models/pebble/notes.json`,
    token ? { headers: { Authorization: `Bearer ${token}` } } : {})).status;
  const tokenFor = (which, detail) => makeToken(keys, "--models", which, "--detail", detail);
  assert.equal(await ask(), 401);
  assert.equal(await ask(tokenFor("shell", "regions")), 403);
  assert.equal(await ask(tokenFor("pebble", "preview")), 200);
  const visit = await Visit.phone(browser);
  await visit.open(`${guarded.url}/#token=${tokenFor("pebble", "preview")}`);
  await visit.untilIdle();
  await visit.page.locator("#open").click();
  await visit.page.locator("#notes-open").click();
  assert.deepEqual(await visit.page.locator("#notes-list button").allTextContents(), ["A crack"]);
  const keptTexts = await visit.page.evaluate(async () => (await indexedDB.databases()).length);
  assert.equal(keptTexts, 0, "nothing is kept");
  await visit.close();
  await guarded.stop();
  rmSync(file());
  await untilListed(0);
});

test("what stands in the fields waits for its model, and is not lost without a question", async () => {
  const visit = await Visit.phone(browser);
  await openPebble(visit);
  await visit.page.locator("#tools-button").click();
  await press(visit, "Write notes");
  await press(visit, "Add a note here");
  await visit.page.locator("#note-title").fill("Of the pebble");
  await visit.page.locator("#note-text").fill("A draft");
  await visit.page.locator("#tools-button").click();
  await visit.back();
  await visit.choose("shell");
  await visit.page.locator("#open").click();
  await visit.until("the other model", ({ mode, idle, model }) => mode === "full screen" && idle && model === "shell");
  await visit.page.locator("#tools-button").click();
  assert.equal(await visit.page.locator("#note-title").isVisible(), false, "nothing of another model's");
  await press(visit, "Add a note here");
  assert.equal(await visit.page.locator("#note-title").inputValue(), "");
  await visit.page.locator("#tools-button").click();
  await visit.back();
  await visit.choose("pebble");
  await visit.page.locator("#open").click();
  await visit.until("the first again", ({ mode, idle, model }) => mode === "full screen" && idle && model === "pebble");
  await visit.page.locator("#tools-button").click();
  assert.equal(await visit.page.locator("#note-title").inputValue(), "Of the pebble");
  assert.equal(await visit.page.locator("#note-text").inputValue(), "A draft");
  let asked = 0;
  visit.page.on("dialog", (dialog) => {
    asked += dialog.type() === "beforeunload";
    return dialog.dismiss();
  });
  await visit.page.goto("about:blank").catch(() => {});
  assert.equal(asked, 1);
  await press(visit, "Keep this note");
  assert.deepEqual(await visit.page.locator("#notes-written span").allTextContents(), ["Of the pebble"]);
  visit.page.removeAllListeners("dialog");
  await visit.close();
});
