// SPDX-License-Identifier: BSD-3-Clause
// The third engine: Debian's WebKitGTK in its small browser, as a substitute for Safari. No library drives it (its
// WebDriver crashes if Mesa draws on the processor). Instead, a server between the browser and kdstream-serve adds a
// script to the page, before the page's own scripts. The script asks the test for code to run, and returns the result.
// Mouse and keys come from the X server, and pictures from its memory.

import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import { once } from "node:events";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { PNG } from "pngjs";
import { pause, temporaryFolder } from "./harness.mjs";
import { Proxy } from "./proxy.mjs";
import { startScreen, stopScreen } from "./screen.mjs";
import { PageVisit, longest, rememberMessages } from "./visit.mjs";

const screen = { width: 1280, height: 960 };
const paths = "/-test/"; // addresses of the script's requests to the test

// Runs in the page, before its own scripts.
function agent(asked) {
  const errors = []; // what a developer would see in red in the console
  const events = {}; // the number of events of each kind
  let offset = null; // of the window's content on the screen
  addEventListener("error", (event) => errors.push(String(event.message ?? event.target?.src)), true);
  addEventListener("unhandledrejection", ({ reason }) => errors.push(String(reason)));
  const { error } = console;
  console.error = (...texts) => {
    errors.push(texts.join(" "));
    error.apply(console, texts);
  };
  for (const name of ["pointerdown", "pointermove", "pointerup", "wheel", "keydown", "keyup"]) {
    addEventListener(name, (event) => {
      events[name] = (events[name] ?? 0) + 1;
      offset = event.screenX === undefined ? offset : { x: event.screenX - event.clientX, y: event.screenY - event.clientY };
    }, { capture: true, passive: true });
  }
  window.agent = { errors, events, offset: () => offset };
  (async () => {
    for (;;) {
      const { code } = await (await fetch(`${asked}next`, { cache: "no-store" })).json();
      const answer = {};
      try {
        answer.result = await (0, eval)(`(${code})`);
      } catch (failure) {
        answer.error = String(failure);
      }
      await fetch(`${asked}done`, { method: "POST", body: JSON.stringify(answer) });
    }
  })();
}

// Adds the script to a page, and changes the page's policy, which would forbid it.
function putAgentInto(_, body, fields) {
  if (!fields["content-type"]?.startsWith("text/html")) {
    return body;
  }
  delete fields["content-security-policy"];
  return Buffer.from(body.toString().replace("<head>",
    () => `<head><script>(${rememberMessages})(); (${agent})(${JSON.stringify(paths)});</script>`));
}

// The browser, its screen, and the server that serves its pages.
export class WebKit {
  #screen;
  #browser = null;
  #proxy;
  #memory = temporaryFolder(); // a file with the screen's memory
  #poll = null; // the request of the page that waits for a task
  #task = null; // { code, resolve, reject }: a task that the page is to run, or runs now

  // target: the port of kdstream-serve.
  static async start(target) {
    const webkit = new WebKit();
    webkit.#proxy = await Proxy.start(target);
    webkit.#proxy.intercept = (asked, answer) => webkit.#answer(asked, answer);
    webkit.#proxy.alterFile = putAgentInto;
    webkit.#screen = await startScreen(screen, "-fbdir", webkit.#memory, "-nocursor");
    return webkit;
  }

  // Opens a new browser, with empty storage, at this address.
  open(url) {
    const folder = temporaryFolder();
    // Nothing moves by itself, so the same gestures give the same picture.
    mkdirSync(join(folder, "gtk-3.0"));
    writeFileSync(join(folder, "gtk-3.0", "settings.ini"), "[Settings]\ngtk-enable-animations=0\n");
    const folders = Object.fromEntries(["HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME"].map((name) => [name, folder]));
    const browser = spawn(process.env.KDSTREAM_WEBKIT, ["--private", `--geometry=${screen.width}x${screen.height}`, url], {
      stdio: ["ignore", "ignore", "inherit"],
      detached: true, // a process group, with the processes that it starts
      env: { ...process.env, ...folders, DISPLAY: this.#screen.display, GDK_BACKEND: "x11", LIBGL_ALWAYS_SOFTWARE: "1",
        NO_AT_BRIDGE: "1", MESA_SHADER_CACHE_DISABLE: "true" },
    });
    process.on("exit", () => this.#browser === browser && process.kill(-browser.pid, "SIGKILL"));
    browser.once("exit", (code) => this.#task?.reject(new Error(`MiniBrowser ended with ${code}`)));
    this.#browser = browser;
  }

  async close() {
    const ended = once(this.#browser, "exit");
    process.kill(-this.#browser.pid, "SIGKILL");
    await ended;
    this.#browser = this.#poll = null;
  }

  async stop() {
    await this.#proxy.stop();
    await stopScreen(this.#screen);
  }

  get url() {
    return this.#proxy.url;
  }

  // ---- requests of the page

  #answer(asked, answer) {
    const { url: path } = asked;
    if (path === `${paths}next`) {
      this.#poll = answer;
      this.#hand();
    } else if (path === `${paths}done`) {
      this.#take(asked, answer);
    } else if (path === "/worker.js") {
      answer.writeHead(404).end(); // the worker would check the page's files, which are changed here
    } else {
      delete asked.headers["accept-encoding"]; // its HTML is changed here, so it must not be compressed
      return false;
    }
    return true;
  }

  #hand() {
    if (this.#poll && this.#task && !this.#task.isHanded) {
      this.#task.isHanded = true;
      this.#poll.writeHead(200, { "content-type": "application/json" }).end(JSON.stringify({ code: this.#task.code }));
      this.#poll = null;
    }
  }

  async #take(asked, answer) {
    let text = "";
    for await (const part of asked) {
      text += part;
    }
    answer.writeHead(204).end();
    const { result, error } = JSON.parse(text);
    const task = this.#task;
    this.#task = null;
    if (error) {
      task.reject(new Error(error));
    } else {
      task.resolve(result);
    }
  }

  // Runs a function in the page. Its argument and its result are JSON.
  run(action, argument) {
    assert.equal(this.#task, null, "one at a time");
    return new Promise((resolve, reject) => {
      const late = setTimeout(() => this.#task?.reject(new Error(`the page did not run ${action}`)), longest);
      const end = (finish) => (value) => {
        clearTimeout(late);
        this.#task = null;
        finish(value);
      };
      this.#task = { code: `(${action})(${JSON.stringify(argument)})`, resolve: end(resolve), reject: end(reject) };
      this.#hand();
    });
  }

  // ---- the screen

  // Runs xdotool with these arguments.
  input(...words) {
    const { status, stderr } = spawnSync("xdotool", words.map(String),
      { encoding: "utf8", env: { ...process.env, DISPLAY: this.#screen.display } });
    assert.equal(status, 0, stderr);
  }

  // Reads the X server's memory, an X window dump: a head of big-endian numbers, colours, then rows of blue, green, red
  // and an unused byte.
  #screenRows() {
    const dump = readFileSync(join(this.#memory, "Xvfb_screen0"));
    const [head, rowBytes, colors] = [0, 48, 76].map((at) => dump.readUInt32BE(at));
    return (x, y) => [2, 1, 0].map((part) => dump[head + 12 * colors + y * rowBytes + 4 * x + part]);
  }

  // Takes a part of the screen as PNG, as soon as the pixel at `mark` has this colour.
  async picture({ x, y, width, height }, mark, color) {
    let pixel = this.#screenRows();
    for (const end = Date.now() + longest; !color.every((value, part) => pixel(...mark)[part] === value); pixel = this.#screenRows()) {
      assert.ok(Date.now() < end, "the page is not drawn");
      await pause(30);
    }
    const png = new PNG({ width, height });
    for (let j = 0; j < height; ++j) {
      for (let i = 0; i < width; ++i) {
        png.data.set([...pixel(x + i, y + j), 255], 4 * (j * width + i));
      }
    }
    return PNG.sync.write(png);
  }

  // A page that is opened once, by itself; there is one page at a time.
  visit() {
    return new WebKitVisit(this);
  }
}

// The functions that PageVisit calls on a page.
class WebKitPage {
  #webkit;
  #offset = null; // of the content on the screen
  #pictures = 0;
  mouse;
  keyboard;

  constructor(webkit) {
    this.#webkit = webkit;
    this.mouse = { click: (x, y, options) => this.#click(x, y, options), move: (x, y) => this.move(x, y) };
    this.keyboard = { press: (key) => this.#press(key) };
  }

  evaluate(action, argument) {
    return this.#webkit.run(action, argument);
  }

  async goto(url) {
    this.#webkit.open(url);
    await this.evaluate(() => new Promise((resolve) => {
      if (document.readyState === "complete") {
        resolve();
      }
      addEventListener("load", () => resolve());
    }));
    this.#offset = await this.#findContent();
  }

  // Finds the content by moving the pointer: an event says where the pointer is in the content.
  async #findContent() {
    // Focus it, because there is no window manager.
    this.#webkit.input("search", "--onlyvisible", "--class", "MiniBrowser", "windowfocus");
    await this.#until("pointermove", () => this.#webkit.input("mousemove", 600, 500, "mousemove_relative", 1, 1));
    return this.evaluate(() => window.agent.offset());
  }

  // Does something, and waits until the page has received an event of this kind.
  async #until(name, act) {
    const count = () => this.evaluate((kind) => window.agent.events[kind] ?? 0, name);
    const before = await count();
    act();
    for (const end = Date.now() + longest; await count() === before;) {
      assert.ok(Date.now() < end, `no ${name} came`);
    }
  }

  #onScreen(x, y) {
    return [Math.round(x + this.#offset.x), Math.round(y + this.#offset.y)];
  }

  async move(x, y) {
    this.#webkit.input("mousemove", ...this.#onScreen(x, y));
  }

  async #click(x, y, { count = 1 } = {}) {
    await this.move(x, y);
    await this.#until("pointerup", () => this.#webkit.input("click", ...(count > 1 ? ["--repeat", count, "--delay", 60] : []), 1));
  }

  async drag(x, y, dx, dy) {
    const steps = [0.25, 0.5, 0.75, 1].flatMap(
      (part) => ["mousemove", ...this.#onScreen(x + part * dx, y + part * dy), "sleep", 0.03]);
    await this.move(x, y);
    await this.#until("pointerup", () => this.#webkit.input("mousedown", 1, ...steps, "sleep", 0.2, "mouseup", 1));
  }

  async wheel(x, y, deltaY) {
    await this.move(x, y);
    await this.#until("wheel", () => this.#webkit.input("click", deltaY < 0 ? 4 : 5));
  }

  async #press(key) {
    await this.#until("keyup", () => this.#webkit.input("key", key));
  }

  async click(selector) {
    const { x, y } = await this.evaluate((wanted) => {
      const element = document.querySelector(wanted);
      element.scrollIntoView({ block: "nearest" });
      const box = element.getBoundingClientRect();
      return { x: box.x + box.width / 2, y: box.y + box.height / 2 };
    }, selector);
    await this.#click(x, y);
  }

  // Takes a picture of a frame that is drawn after this call: the page's first pixel gets another colour each time.
  async screenshot({ path, clip }) {
    const color = [++this.#pictures % 250, 40, 200];
    const whole = await this.evaluate((rgb) => new Promise((resolve) => {
      requestAnimationFrame(() => requestAnimationFrame(() => {
        const mark = document.getElementById("mark") ?? document.createElement("i");
        mark.id = "mark";
        mark.style = `position: fixed; inset: 0 auto auto 0; width: 2px; height: 2px; z-index: 9999; background: rgb(${rgb})`;
        document.body.append(mark);
        resolve({ x: 0, y: 0, width: innerWidth, height: innerHeight });
      }));
    }), color);
    const { x: left, y: top, width, height } = clip ?? whole;
    const [x, y] = this.#onScreen(left, top);
    const png = await this.#webkit.picture({ x, y, width, height }, this.#onScreen(0, 0), color);
    if (path) {
      writeFileSync(path, png);
    }
    return png;
  }
}

class WebKitVisit extends PageVisit {
  #webkit;
  home;

  constructor(webkit) {
    super();
    this.#webkit = webkit;
    this.home = webkit.url;
    this.page = new WebKitPage(webkit);
  }

  async close() {
    await this.#webkit.close();
  }

  async assertClean(url) {
    this.errors = await this.page.evaluate(() => window.agent.errors);
    this.requests = await this.page.evaluate(() => performance.getEntriesByType("resource").map(({ name }) => name));
    super.assertClean(url);
  }

  // Presses the visible button with this name.
  async press(name) {
    await this.showTool(name);
    assert.ok(await this.page.evaluate((wanted) => {
      document.querySelector("[data-pressed]")?.removeAttribute("data-pressed");
      const button = [...document.querySelectorAll("button")].find(
        (one) => one.checkVisibility() && (one.ariaLabel ?? one.textContent.trim()) === wanted);
      button?.setAttribute("data-pressed", "");
      return Boolean(button);
    }, name), `no button ${name}`);
    await this.page.click("[data-pressed]");
  }

  async wheel({ x, y }, deltaY) {
    await this.page.wheel(x, y, deltaY);
  }

  async drag({ x, y }, dx, dy) {
    await this.page.drag(x, y, dx, dy);
  }
}
