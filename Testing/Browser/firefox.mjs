// SPDX-License-Identifier: BSD-3-Clause
// The second browser: Debian's Firefox, driven by Puppeteer and WebDriver BiDi. It runs on an X server of its own,
// where it has WebGL 2 by llvmpipe; without a screen (headless) it has no WebGL 2.

import assert from "node:assert/strict";
import puppeteer from "puppeteer-core";
import { temporaryFolder } from "./harness.mjs";
import { startScreen, stopScreen } from "./screen.mjs";
import { PageVisit, longest, rememberMessages } from "./visit.mjs";

const screen = { width: 1280, height: 960 }; // including a window's frame and bars
const desktop = { width: 1100, height: 760 };

// Firefox and its screen.
export class Firefox {
  #browser;
  #screen;
  downloads = temporaryFolder(); // for files that it saves

  static async start() {
    const firefox = new Firefox();
    firefox.#screen = await startScreen(screen);
    firefox.#browser = await puppeteer.launch({
      browser: "firefox",
      executablePath: process.env.KDSTREAM_FIREFOX ?? "/usr/bin/firefox-esr",
      headless: false,
      protocolTimeout: longest,
      args: [`--width=${screen.width}`, `--height=${screen.height}`],
      env: { ...process.env, DISPLAY: firefox.#screen.display, MOZ_ENABLE_WAYLAND: "0", LIBGL_ALWAYS_SOFTWARE: "1" },
      extraPrefsFirefox: {
        "ui.prefersReducedMotion": 1, // nothing moves by itself: the same gestures give the same picture
        "browser.download.folderList": 2,
        "browser.download.dir": firefox.downloads,
        "browser.download.always_ask_before_handling_new_types": false,
        "browser.download.alwaysOpenPanel": false,
      },
    });
    return firefox;
  }

  async stop() {
    await this.#browser?.close();
    await stopScreen(this.#screen);
  }

  // Opens a page with a storage of its own. home: the list's address.
  async visit(home) {
    const context = await this.#browser.createBrowserContext();
    const visit = await FirefoxVisit.make(await context.newPage());
    visit.home = home;
    return visit;
  }
}

class FirefoxVisit extends PageVisit {
  home;

  static async make(page) {
    const visit = new FirefoxVisit();
    visit.page = page;
    await page.setViewport(desktop);
    page.on("request", (request) => visit.requests.push(request.url()));
    page.on("console", (message) => message.type() === "error" && visit.errors.push(message.text()));
    page.on("pageerror", (error) => visit.errors.push(String(error)));
    await page.evaluateOnNewDocument(rememberMessages);
    await page.bringToFront(); // otherwise it draws only once a second
    return visit;
  }

  async close() {
    await this.page.browserContext().close();
  }

  // Presses the visible button with this name.
  async press(name) {
    await this.showTool(name);
    const button = await this.page.evaluateHandle((wanted) => [...document.querySelectorAll("button")].find(
      (one) => one.checkVisibility() && (one.ariaLabel ?? one.textContent.trim()) === wanted), name);
    assert.ok(button.asElement(), `no button ${name}`);
    await button.asElement().click();
  }

  // Turns the wheel by one step at a place: towards the model, or away from it.
  async wheel({ x, y }, deltaY) {
    await this.page.mouse.move(x, y);
    await this.page.mouse.wheel({ deltaY });
  }

  async drag({ x, y }, dx, dy) {
    await this.page.mouse.move(x, y);
    await this.page.mouse.down();
    await this.page.mouse.move(x + dx, y + dy, { steps: 4 });
    await this.page.mouse.up();
  }
}
