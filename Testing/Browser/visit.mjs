// SPDX-License-Identifier: BSD-3-Clause
// A page in a browser, whichever library drives it: reads the page's state (window.kdstream.status, see
// viewer/mobile/web/page.js), waits for it, and takes pictures. Chromium's fingers are in harness.mjs, Firefox is in
// firefox.mjs, WebKit in webkit.mjs.
//
// Nothing here waits for a fixed time: every wait is for a condition, and `longest` only ends a run that hangs.

import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { join } from "node:path";

export const longest = 1000 * Number(process.env.KDSTREAM_LONGEST_WAIT ?? 180); // ms, of a single wait

// Reads a variable of the environment: harness.mjs lists the names.
export function place(name) {
  const value = process.env[name];
  assert.ok(value, `${name} is not set: see Testing/Browser/harness.mjs`);
  return value;
}

const pictures = () => {
  const folder = place("KDSTREAM_PICTURES");
  mkdirSync(folder, { recursive: true });
  return folder;
};

// `page` is Playwright's or Puppeteer's. Only functions that both have are used (goto, evaluate, click, screenshot).
export class PageVisit {
  page;
  requests = []; // addresses of all requests and streams
  errors = []; // what a developer would see in red in the console

  async open(url) {
    await this.page.goto(url);
  }

  // Checks that no request went to another server, and that there was no error that a developer would see.
  assertClean(url) {
    const { host } = new URL(url);
    const elsewhere = this.requests.filter((address) => {
      const { protocol, host: asked } = new URL(address);
      return protocol !== "data:" && protocol !== "blob:" && asked !== host;
    });
    assert.deepEqual(elsewhere, [], "requests to other hosts");
    assert.ok(this.requests.length > 5, "requests are recorded");
    assert.deepEqual(this.errors, [], "errors on the console");
  }

  // ---- state and texts of the page

  status() {
    return this.page.evaluate(() => window.kdstream.status());
  }

  // Asks the page repeatedly, once in each of its frames, until `good` is true for the answer; returns the answer.
  // (Playwright's own waitForFunction needs eval, which the page's policy forbids.)
  async #askUntil(what, ask, good) {
    const end = Date.now() + longest;
    for (;;) {
      const answer = await this.page.evaluate(ask);
      if (good(answer)) {
        return answer;
      }
      if (Date.now() > end) {
        throw new Error(`never came: ${what}; instead ${JSON.stringify(answer)}`);
      }
    }
  }

  // Waits until `condition` is true for the status; returns that status.
  until(what, condition) {
    return this.#askUntil(what, () => new Promise((resolve) => {
      requestAnimationFrame(() => resolve({ ...window.kdstream?.status(), said: window.said }));
    }), (status) => status.mode && condition(status));
  }

  // From now on counts the frames in whose status this member is true. Returns a function for the count.
  async countFrames(member) {
    await this.page.evaluate((name) => {
      window.framesCounted = 0;
      const look = () => {
        window.framesCounted += window.kdstream.status()[name];
        requestAnimationFrame(look);
      };
      look();
    }, member);
    return () => this.page.evaluate(() => window.framesCounted);
  }

  // Waits until everything that the view needs has arrived and is drawn.
  untilIdle() {
    return this.until("idle", (status) => status.idle && status.shownLevel !== null);
  }

  // All texts that #message has shown so far.
  messages() {
    return this.page.evaluate(() => window.said);
  }

  // Waits until #message has shown a text that matches the pattern, since the page was opened.
  untilSaid(pattern) {
    return this.#askUntil(`a message like ${pattern}`, () => new Promise((resolve) => {
      requestAnimationFrame(() => resolve({ said: window.said, page: document.body.innerText }));
    }), ({ said }) => said.some((text) => pattern.test(text)));
  }

  // Presses the button of a message, if the page has not tried again by itself meanwhile and removed the message.
  tryNow() {
    return this.page.evaluate(() => document.getElementById("message-action").click());
  }

  // Waits until no message is on the screen.
  untilQuiet() {
    return this.#askUntil("no message", () => new Promise((resolve) => {
      requestAnimationFrame(() => resolve(document.getElementById("message").checkVisibility()
        && document.getElementById("message-text").textContent));
    }), (text) => !text);
  }

  // The message that is now on the screen, or "".
  messageShown() {
    return this.page.evaluate(() => {
      const message = document.getElementById("message");
      return message?.checkVisibility({ visibilityProperty: true }) ? document.getElementById("message-text").textContent : "";
    });
  }

  // Taps the model's entry in the list, and waits until its preview is shown.
  async choose(model) {
    await this.page.click(`[data-model="${model}"]`);
    return this.until(`the preview of ${model}`,
      (status) => status.model === model && status.idle && status.shownLevel !== null);
  }

  // Makes the tool with this name visible, if its group is closed.
  async showTool(name) {
    await this.#askUntil("tools in their sheet", () => {
      const sheet = document.getElementById("tools");
      return sheet.hidden || sheet.querySelector("#tabs") !== null;
    }, Boolean);
    await this.page.evaluate((wanted) => {
      const button = [...document.querySelectorAll("#tools fieldset button")].find(({ textContent }) => textContent === wanted);
      const group = button?.closest("fieldset");
      if (group && !button.checkVisibility()) {
        const place = [...document.querySelectorAll("#tools fieldset")].indexOf(group);
        document.querySelectorAll("#tabs button")[place].click();
      }
    }, name);
  }

  // The text that the page copies at a click, by the page's own method for browsers without a clipboard.
  async copied(selector) {
    await this.page.evaluate(() => {
      window.copied = "";
      document.addEventListener("copy", () => {
        window.copied = document.activeElement.value ?? "";
      });
      navigator.clipboard.writeText = (text) => {
        window.copied = text;
        return Promise.resolve();
      };
    });
    await this.page.click(selector);
    return this.page.evaluate(() => window.copied);
  }

  async back() {
    await this.page.click("#back");
    return this.until("back to the list", (status) => status.mode === "browsing");
  }

  // ---- pictures

  // Takes a picture of the screen, also saved as NAME.png for people to look at.
  async picture(name) {
    return Buffer.from(await this.page.screenshot({ path: join(pictures(), `${name}.png`) }));
  }

  // The part of the screen around a point, as PNG.
  async around({ x, y }, size = 160) {
    return Buffer.from(await this.page.screenshot({ clip: { x: x - size / 2, y: y - size / 2, width: size, height: size } }));
  }

  // The middle of the picture, in points of the window.
  centre() {
    return this.page.evaluate(() => {
      const { x, y, width, height } = document.getElementById("view").getBoundingClientRect();
      return { x: x + width / 2, y: y + height / 2 };
    });
  }
}

// Runs in the page before its own scripts: window.said gets every text that #message shows.
export function rememberMessages() {
  window.said = [];
  const remember = () => {
    const message = document.getElementById("message");
    const text = document.getElementById("message-text")?.textContent.replace(/\s+/g, " ").trim();
    if (message && !message.hidden && !message.classList.contains("starting") && window.said.at(-1) !== text) {
      window.said.push(text);
    }
  };
  new MutationObserver(remember).observe(document, { subtree: true, childList: true, characterData: true, attributes: true });
}

