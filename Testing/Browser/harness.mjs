// SPDX-License-Identifier: BSD-3-Clause
// Shared by all browser tests: the programs under test as processes, Chromium as a phone or a desktop, and fingers.
// visit.mjs reads the page's state and waits for it.
//
// The environment says where all files are; ctest sets it:
//   KDSTREAM_PROGRAMS  folder of kdstream-build and kdstream-serve
//   KDSTREAM_PAGE      folder of the page
//   KDSTREAM_DRAGON    dragon.ply
//   KDSTREAM_PICTURES  folder for a screenshot of each stage
//   KDSTREAM_CHROMIUM  the browser (/usr/bin/chromium)
//   KDSTREAM_FIREFOX   the second browser, for its own test (/usr/bin/firefox-esr)
//   KDSTREAM_WEBKIT    WebKit's MiniBrowser, for its own test
//   KDSTREAM_NGINX     nginx, for the test of exports (nginx)
//   KDSTREAM_LONGEST_WAIT  seconds until the test gives up waiting (180)

import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import { once } from "node:events";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { after, before } from "node:test";
import { chromium } from "playwright-core";
import { PageVisit, longest, place, rememberMessages } from "./visit.mjs";

export { longest } from "./visit.mjs";

process.setMaxListeners(100); // one for each folder and server

// A run that is ended from outside removes its files and ends its processes, too.
for (const signal of ["SIGINT", "SIGTERM"]) {
  process.on(signal, () => process.exit(1));
}

// ---- models

// A folder that is removed when the process ends.
export function temporaryFolder() {
  const folder = mkdtempSync(join(tmpdir(), "kdstream-browser-"));
  process.on("exit", () => rmSync(folder, { recursive: true, force: true }));
  return folder;
}

// Writes a sphere with bumps, of `around` times `across` quads and a height of 2 `size`. It is closed, so that every
// picture shows a surface in its middle.
export function writePebble(file, around = 96, across = 48, size = 1) {
  const vertices = [`0 0 ${size}`];
  for (let j = 1; j < across; ++j) {
    const tilt = Math.PI * j / across;
    for (let i = 0; i < around; ++i) {
      const turn = 2 * Math.PI * i / around;
      const radius = size * (1 + 0.1 * Math.sin(5 * turn) * Math.sin(tilt) ** 2);
      vertices.push([Math.sin(tilt) * Math.cos(turn), Math.sin(tilt) * Math.sin(turn), Math.cos(tilt)]
        .map((value) => radius * value).join(" "));
    }
  }
  vertices.push(`0 0 ${-size}`);
  const at = (j, i) => (j === 0 ? 0 : j === across ? vertices.length - 1 : 1 + (j - 1) * around + i % around);
  const triangles = [];
  for (let i = 0; i < around; ++i) {
    for (let j = 0; j < across; ++j) {
      const [a, b, c, d] = [at(j, i), at(j + 1, i), at(j + 1, i + 1), at(j, i + 1)];
      if (b !== c) {
        triangles.push(`3 ${a} ${b} ${c}`);
      }
      if (a !== d) {
        triangles.push(`3 ${a} ${c} ${d}`);
      }
    }
  }
  writeFileSync(file, ["ply", "format ascii 1.0", `element vertex ${vertices.length}`,
    "property float x", "property float y", "property float z",
    `element face ${triangles.length}`, "property list uchar int vertex_indices", "end_header",
    ...vertices, ...triangles, ""].join("\n"));
}

function program(name) {
  return join(place("KDSTREAM_PROGRAMS"), name);
}

export function runProgram(name, ...options) {
  const { status, stderr, error } = spawnSync(program(name), options, { encoding: "utf8" });
  assert.equal(status, 0, `${name} ${options.join(" ")}: ${error ?? stderr}`);
}

export function buildStore(mesh, store, ...options) {
  runProgram("kdstream-build", mesh, "-o", store, "--quiet", ...options);
}

// Makes a folder of stores: pebble.kds; dragon.kds or a small shell.kds; and, if requested, a coloured vase.kds. The
// dragon has 65,591 triangles, like level 15 of the scan, because the processor draws it; with `whole` it has all
// 871,414.
export function makeModels({ dragon = true, whole = false, vase = false } = {}) {
  const folder = temporaryFolder();
  const meshes = temporaryFolder();
  const build = (name, title, vertices, ...size) => {
    writePebble(join(meshes, `${name}.ply`), ...size);
    buildStore(join(meshes, `${name}.ply`), join(folder, `${name}.kds`), "--title", title, "--vertices-per-partition", vertices);
  };
  build("pebble", "A pebble", "200");
  if (dragon) {
    const store = join(folder, "dragon.kds");
    const about = ["--title", "A dragon", "--credit", "Stanford Computer Graphics Laboratory"];
    buildStore(place("KDSTREAM_DRAGON"), store, ...about);
    if (!whole) {
      const mesh = join(meshes, "dragon.ply");
      runProgram("kdstream-store", "extract", store, "--level", "15", "-o", mesh);
      rmSync(store);
      buildStore(mesh, store, ...about);
    }
  } else {
    build("shell", "A shell", "50", 24, 12);
  }
  if (vase) {
    runProgram("kdstream-generate", "vase", join(meshes, "vase.ply"), "--vertices", "60000");
    buildStore(join(meshes, "vase.ply"), join(folder, "vase.kds"), "--title", "A painted vase");
  }
  return folder;
}

// ---- the server

// The token that kdstream-serve prints for these options; the subject is ann unless the options name one.
export function makeToken(keys, ...options) {
  const whose = options.includes("--sub") ? [] : ["--sub", "ann"];
  const { status, stdout, stderr } = spawnSync(program("kdstream-serve"), ["token", "--tokens", keys, ...whose, ...options],
    { encoding: "utf8" });
  assert.equal(status, 0, stderr);
  return stdout.trim();
}

export class Server {
  #process;
  url;
  port;

  // Starts kdstream-serve. port 0: any free port; more: further options.
  static async start(models, { port = 0, web = place("KDSTREAM_PAGE"), more = [] } = {}) {
    const server = new Server();
    server.#process = spawn(program("kdstream-serve"), [models, "--port", String(port), "--web", web, ...more],
      { stdio: ["ignore", "pipe", "inherit"] });
    process.on("exit", () => server.#process.kill("SIGKILL"));
    const lines = createInterface({ input: server.#process.stdout });
    const [line] = await Promise.race([once(lines, "line"), once(server.#process, "exit").then(() => [""])]);
    assert.match(line, /^listening on http:/, "kdstream-serve did not start");
    server.url = line.replace("listening on ", "");
    server.port = Number(new URL(server.url).port);
    return server;
  }

  // Ends the server as an administrator would.
  async stop() {
    if (this.#process.exitCode === null) {
      const ended = once(this.#process, "exit");
      this.#process.kill("SIGTERM");
      const [code] = await ended;
      assert.equal(code, 0, "kdstream-serve ends with 0");
    }
  }

  rereadModels() {
    this.#process.kill("SIGHUP");
  }

  // Waits until the server has noticed that the model was removed.
  async untilGone(model) {
    const end = Date.now() + longest;
    for (let there = true; there;) {
      assert.ok(Date.now() < end, `${model} is still there`);
      const { models } = await (await fetch(`${this.url}/api/models.json`)).json();
      there = models.some(({ id }) => id === model);
    }
  }
}

// ---- waiting

export const pause = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

// Asks repeatedly until the answer is good, and returns it.
export async function eventually(what, ask, good = Boolean) {
  for (const end = Date.now() + longest; ; await pause(50)) {
    const answer = await ask();
    if (good(answer)) {
      return answer;
    }
    assert.ok(Date.now() < end, `never came: ${what}; instead ${JSON.stringify(answer)}`);
  }
}

// ---- the browser

export const portrait = { width: 412, height: 915 };
export const landscape = { width: 915, height: 412 };
// In tests the processor draws; with one pixel for each point, this takes four fifths of the tests' time. So a test
// that is not about pixels has one pixel for two points. A test that is has a screen as sharp as that of many phones.
const coarseScreen = { deviceScaleFactor: 0.5 };
export const sharpScreen = { deviceScaleFactor: 2 };

export function launchBrowser(...options) {
  return chromium.launch({
    executablePath: process.env.KDSTREAM_CHROMIUM ?? "/usr/bin/chromium",
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run",
      "--disable-background-networking", "--disable-component-update", "--disable-sync", ...options],
  });
}

// Before the tests of a file, starts a server of the folder that `make` returns, and a browser, and passes both to
// `take`. Ends both after the tests.
export function startForTests(make, take) {
  let server, browser;
  before(async () => {
    server = await Server.start(make());
    browser = await launchBrowser();
    await take({ server, browser });
  });
  after(async () => {
    await browser?.close();
    await server?.stop();
  });
}

// A page as a phone shows it, or as a desktop does.
export class Visit extends PageVisit {
  #session;
  #clock = 0; // s: the time of the last touch

  // Nothing moves by itself, so that the same gestures give the same picture.
  static async phone(browser, viewport = portrait, options = {}) {
    return Visit.#make(await browser.newContext(
      { viewport, ...coarseScreen, isMobile: true, hasTouch: true, reducedMotion: "reduce", ...options }));
  }

  static async desktop(browser, options = {}) {
    return Visit.#make(await browser.newContext(
      { viewport: { width: 960, height: 600 }, ...coarseScreen, reducedMotion: "reduce", ...options }));
  }

  static async #make(context) {
    const visit = new Visit();
    visit.page = await context.newPage();
    visit.page.setDefaultTimeout(longest);
    visit.page.on("request", (request) => visit.requests.push(request.url()));
    visit.page.on("websocket", (socket) => visit.requests.push(socket.url()));
    visit.page.on("console", (message) => message.type() === "error" && visit.errors.push(message.text()));
    visit.page.on("pageerror", (error) => visit.errors.push(String(error)));
    await visit.page.addInitScript(rememberMessages);
    visit.#session = await context.newCDPSession(visit.page);
    return visit;
  }

  async close() {
    await this.page.context().close();
  }

  // Sets the detail as the menu would, in any state of the page, as soon as the page works.
  async presetDetail(detail) {
    await this.page.locator("#models [data-model]").first().waitFor({ state: "attached" });
    await this.page.evaluate((value) => {
      const choice = document.querySelector(`[name=detail][value="${value}"]`);
      choice.checked = true;
      choice.dispatchEvent(new Event("change", { bubbles: true }));
    }, detail);
  }

  // Uses the menu: 0 refines by the view; 1 shows one level for the whole model.
  async setDetail(detail) {
    await this.page.locator("#menu-button").click();
    await this.page.locator(`[name=detail][value="${detail}"]`).check({ force: true });
    await this.page.locator("#menu-button").click();
  }

  // ---- fingers; places in points of the window

  // Sends one frame of touches, `seconds` after the previous one, whatever the real time is: whether two taps are a
  // double tap must not depend on how busy the machine is.
  async #touch(type, touchPoints, seconds) {
    this.#clock = Math.max(this.#clock + seconds, this.#clock ? 0 : Date.now() / 1000);
    await this.#session.send("Input.dispatchTouchEvent", { type, touchPoints, timestamp: this.#clock });
  }

  async #tapOnce({ x, y }, pause) {
    await this.#touch("touchStart", [{ x, y, id: 1 }], pause);
    await this.#touch("touchEnd", [], 0.06);
  }

  async tap(point) {
    await this.#tapOnce(point, 1);
  }

  async doubleTap(point) {
    await this.#tapOnce(point, 1);
    await this.#tapOnce(point, 0.1);
  }

  // Drags one finger from `from` by (dx, dy).
  async drag(from, dx, dy, steps = 3) {
    await this.#fingers(steps, (part) => [{ x: from.x + part * dx, y: from.y + part * dy, id: 1 }]);
  }

  // Does the same in real time, which a browser needs for scrolling. The finger stands still before it is lifted, so
  // nothing moves on.
  async dragSlowly(from, dx, dy, steps = 10) {
    const send = (type, part) => this.#session.send("Input.dispatchTouchEvent",
      { type, touchPoints: type === "touchEnd" ? [] : [{ x: from.x + part * dx, y: from.y + part * dy, id: 1 }] });
    await send("touchStart", 0);
    for (let step = 1; step <= steps; ++step) {
      await pause(20);
      await send("touchMove", step / steps);
    }
    await pause(300);
    await send("touchEnd", 1);
    this.#clock = Math.max(this.#clock, Date.now() / 1000);
  }

  // Drags the mouse from `from` by (dx, dy) and releases it, in the time of eight frames, whatever the real time is.
  async throwMouse(from, dx, dy, steps = 8) {
    const send = async (type, part, buttons) => {
      this.#clock = Math.max(this.#clock + 0.016, this.#clock ? 0 : Date.now() / 1000);
      await this.#session.send("Input.dispatchMouseEvent",
        { type, x: from.x + part * dx, y: from.y + part * dy, button: "left", buttons, clickCount: 1, timestamp: this.#clock });
    };
    await send("mousePressed", 0, 1);
    for (let step = 1; step <= steps; ++step) {
      await send("mouseMoved", step / steps, 1);
    }
    await send("mouseReleased", 1, 0);
  }

  // Puts two fingers beside `middle`, and moves them together by (dx, dy).
  async dragTwo(middle, dx, dy, steps = 2) {
    await this.#fingers(steps, (part) => [-40, 40].map((side, id) => (
      { x: middle.x + side + part * dx, y: middle.y + part * dy, id: id + 1 })));
  }

  // Puts two fingers around `middle`, and changes their distance from `from` to `to` points.
  async pinch(middle, from, to, steps = 2) {
    await this.#fingers(steps, (part) => [-0.5, 0.5].map((side, id) => (
      { x: middle.x + side * (from + part * (to - from)), y: middle.y, id: id + 1 })));
  }

  async #fingers(steps, placesAt) {
    await this.#touch("touchStart", placesAt(0), 1);
    for (let step = 1; step <= steps; ++step) {
      await this.#touch("touchMove", placesAt(step / steps), 0.016);
    }
    await this.#touch("touchEnd", [], 0.016);
  }
}
