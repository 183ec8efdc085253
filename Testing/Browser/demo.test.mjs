// SPDX-License-Identifier: BSD-3-Clause
// The site's demo: three models and the page as plain files in one folder of a site, on a host that only serves files.
// The page lists the models, opens each, and sends no request to any other host. A client of another kind reads them,
// too.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { readFileSync, readdirSync, statSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { Visit, launchBrowser, makeModels, runProgram, temporaryFolder } from "./harness.mjs";

const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm",
  ".json": "application/json", ".webmanifest": "application/manifest+json", ".svg": "image/svg+xml", ".png": "image/png" };

let host, url, browser;

before(async () => {
  const models = makeModels({ dragon: false, vase: true });
  const root = temporaryFolder();
  for (const store of readdirSync(models)) {
    runProgram("kdstream-store", "export", join(models, store), join(root, "demo"), "--quiet", "--page", process.env.KDSTREAM_PAGE);
  }
  host = createServer((request, response) => {
    const path = new URL(request.url, "http://host").pathname;
    const file = join(root, path.endsWith("/") ? `${path}index.html` : path);
    if (!statSync(file, { throwIfNoEntry: false })?.isFile()) {
      response.writeHead(404).end();
      return;
    }
    response.writeHead(200, { "Content-Type": types[extname(file)] ?? "application/octet-stream" }).end(readFileSync(file));
  }).listen(0, "127.0.0.1");
  await once(host, "listening");
  url = `http://127.0.0.1:${host.address().port}/demo/`;
  browser = await launchBrowser();
});

after(async () => {
  await browser?.close();
  host?.close();
});

test("three models lie beside the page, and nothing comes from elsewhere", async () => {
  const visit = await Visit.phone(browser);
  const elsewhere = [];
  visit.page.on("request", (request) => {
    if (!request.url().startsWith(url) && !/^(data|blob):/.test(request.url())) {
      elsewhere.push(request.url());
    }
  });
  await visit.open(url);
  await visit.untilIdle();
  const names = await visit.page.evaluate(() => [...document.querySelectorAll("#models [data-model]")].map((entry) => entry.dataset.model));
  assert.deepEqual(names.sort(), ["pebble", "shell", "vase"]);
  await visit.tap(await visit.centre());
  await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
  assert.ok((await visit.status()).triangles > 0);
  assert.deepEqual(elsewhere, []);
  await visit.close();
});

test("the client in 60 lines reads them", async () => {
  const client = fileURLToPath(new URL("../../Examples/Client/client.mjs", import.meta.url));
  const run = async (...words) => {
    const child = spawn(process.execPath, [client, url.slice(0, -1), ...words], { stdio: ["ignore", "pipe", "inherit"] });
    let said = "";
    child.stdout.on("data", (text) => (said += text));
    const [code] = await once(child, "close");
    assert.equal(code, 0);
    return said;
  };
  assert.match(await run(), /^pebble: A pebble, \d+ triangles\n/);
  const { models } = await (await fetch(`${url}api/models.json`)).json();
  const shell = models.find(({ id }) => id === "shell");
  const { partitions } = await (await fetch(`${url}api/models/shell/model.json`)).json();
  const out = join(temporaryFolder(), "out.obj");
  await run("shell", out);
  assert.match(readFileSync(out, "utf8"), /^v .*\n/);
  await run("shell", out, ...Array.from({ length: partitions }, (_, p) => String(p)));
  const faces = readFileSync(out, "utf8").split("\n").filter((line) => line.startsWith("f ")).map((line) => line.split(" ").slice(1).map(Number));
  const places = readFileSync(out, "utf8").split("\n").filter((line) => line.startsWith("v "));
  const whole = new Set(faces.map((face) => {
    const corners = face.map((v) => places[v - 1]);
    const first = corners.indexOf([...corners].sort()[0]);
    return [0, 1, 2].map((i) => corners[(first + i) % 3]).join();
  }));
  assert.equal(whole.size, shell.triangles, "each triangle of the original, of two partitions once");
});
