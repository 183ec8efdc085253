// SPDX-License-Identifier: BSD-3-Clause
// The output of kdstream-store export, served by nginx, which knows nothing about models: the same page, the same
// surface.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { chmodSync, existsSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { createServer } from "node:net";
import { join } from "node:path";
import { after, before, test } from "node:test";
import validator from "gltf-validator";
import { Server, Visit, eventually, launchBrowser, longest, makeModels, runProgram, temporaryFolder } from "./harness.mjs";

// nginx serving a folder, with the configuration that the export has written.
class FileHost {
  #process;
  url;

  static async start(root) {
    const probe = createServer().listen(0, "127.0.0.1"); // finds a free port, because nginx cannot report its own
    await once(probe, "listening");
    const { port } = probe.address();
    probe.close();
    await once(probe, "close");

    const work = temporaryFolder();
    const temporary = ["client_body", "proxy", "fastcgi", "uwsgi", "scgi"].map((name) => `${name}_temp_path ${work}/${name};`);
    writeFileSync(join(work, "nginx.conf"), `daemon off; pid ${work}/pid; error_log ${work}/error.log;
      events {}
      http { include /etc/nginx/mime.types; access_log ${work}/access.log; ${temporary.join(" ")}
        server { listen 127.0.0.1:${port}; root ${root}; include ${root}/kdstream.nginx.conf; } }`);
    for (const folder of [work, root]) {
      chmodSync(folder, 0o755); // nginx's workers may run as another user
    }
    const host = new FileHost();
    host.#process = spawn(process.env.KDSTREAM_NGINX ?? "nginx", ["-e", join(work, "error.log"), "-c", join(work, "nginx.conf")], { stdio: "inherit" });
    process.on("exit", () => host.#process.kill("SIGTERM"));
    host.url = `http://127.0.0.1:${port}`;
    for (const end = Date.now() + longest; ;) {
      const answer = await fetch(host.url).catch(() => null);
      if (answer?.ok) {
        return host;
      }
      if (Date.now() > end || host.#process.exitCode !== null) {
        host.#process.kill("SIGTERM"); // else this process does not end
        assert.fail(`nginx: ${answer?.status} ${existsSync(join(work, "error.log")) ? readFileSync(join(work, "error.log")) : ""}`);
      }
    }
  }

  async stop() {
    const ended = once(this.#process, "exit");
    this.#process.kill("SIGTERM");
    await ended;
  }
}

let server, host, browser;

before(async () => {
  const models = makeModels({ dragon: false });
  const root = temporaryFolder();
  for (const store of readdirSync(models)) {
    runProgram("kdstream-store", "export", join(models, store), root, "--quiet", "--page", process.env.KDSTREAM_PAGE);
  }
  server = await Server.start(models);
  host = await FileHost.start(root);
  browser = await launchBrowser();
});

after(async () => {
  await browser?.close();
  await host?.stop();
  await server?.stop();
});

// Opens the first model, taps a region, and returns what is shown afterwards.
async function walk(url) {
  const visit = await Visit.phone(browser);
  await visit.open(url);
  await visit.untilIdle();
  await visit.tap(await visit.centre());
  await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
  await visit.doubleTap(await visit.centre());
  await visit.until("a region", ({ idle, region }) => idle && region !== null && region.shown === region.partitions);
  const { triangles, region } = await visit.status();
  const names = await visit.page.evaluate(() => [...document.querySelectorAll("#models [data-model]")].map((entry) => entry.dataset.model));
  await visit.close();
  return { triangles, region, names };
}

test("a host of files shows what our server shows", async () => {
  const here = await walk(host.url);
  assert.deepEqual(here, await walk(server.url));
  assert.deepEqual(here.names, ["pebble", "shell"]);
  assert.ok(here.region.partitions > 1);
});

test("on Android a link leads into the room, where there is a file for it", async () => {
  const userAgent = "Mozilla/5.0 (Linux; Android 14; Pixel 8) AppleWebKit/537.36 (KHTML, like Gecko) Chrome/126.0.0.0 Mobile Safari/537.36";
  for (const [url, options, isThere] of [[host.url, { userAgent }, true], [host.url, {}, false], [server.url, { userAgent }, true]]) {
    const visit = await Visit.phone(browser, undefined, options);
    const asked = [];
    visit.page.on("response", (response) => response.url().endsWith("/preview.glb") && asked.push(response.status()));
    await visit.open(url);
    await visit.untilIdle();
    await visit.tap(await visit.centre());
    await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
    await visit.page.click("#tools-button");
    await visit.page.waitForSelector("#save-picture");
    if (!isThere) {
      options.userAgent && await eventually("an answer", () => asked.length);
      assert.ok(!await visit.page.isVisible("#room"));
      assert.ok(options.userAgent || !asked.length, "nothing is asked where there is no augmented reality");
      await visit.close();
      continue;
    }
    await visit.page.waitForSelector("#room:not([hidden])");
    await visit.picture("export-1-room");
    const link = await visit.page.getAttribute("#room", "href");
    const [, query, rest] = link.match(/^intent:\/\/arvr\.google\.com\/scene-viewer\/1\.2\?([^#]*)#Intent;scheme=https;package=[\w.]+;(.*)end;$/)
      ?? assert.fail(link);
    const { file, title, mode } = Object.fromEntries(new URLSearchParams(query));
    assert.equal(mode, "ar_preferred");
    assert.match(title, /^A pebble/);
    assert.match(rest, /S\.browser_fallback_url=http%3A%2F%2F/);
    const answer = await fetch(file);
    assert.equal(answer.headers.get("content-type"), "model/gltf-binary");
    assert.match(answer.headers.get("cache-control"), url === host.url ? /immutable/ : /no-cache/);
    const { issues, info } = await validator.validateBytes(new Uint8Array(await answer.arrayBuffer()));
    assert.equal(issues.numErrors, 0, JSON.stringify(issues.messages));
    assert.ok(info.totalTriangleCount > 500 && info.totalTriangleCount <= 5000, `${info.totalTriangleCount}`);
    await visit.close();
  }
});

test("what has a digest in its path may be kept for ever, the rest is asked for again", async () => {
  const header = async (path, name) => (await fetch(host.url + path)).headers.get(name);
  const { models } = await (await fetch(`${host.url}/api/models.json`)).json();
  const blob = `/api/models/${models[0].id}/${models[0].digest}/partitions/0`;
  assert.match(await header(blob, "cache-control"), /public, max-age=31536000, immutable/);
  assert.equal(await header(blob, "content-type"), "application/octet-stream");
  assert.equal(await header("/api/models.json", "cache-control"), "no-cache");
  assert.equal(await header("/api/models.json", "content-encoding"), "gzip");
  for (const part of ["kdstream", "kdstream-more"]) {
    assert.equal(await header(`/${part}.wasm`, "content-type"), "application/wasm");
    assert.equal(await header(`/${part}.wasm`, "content-encoding"), "gzip");
  }
  const missing = await fetch(`${host.url}/api/models/${models[0].id}/${models[0].digest}/partitions/999999`);
  assert.equal(missing.status, 404);
  assert.equal(missing.headers.get("cache-control"), null, "what is not there may come");
});

test("a model has the page that our server makes for it, one folder deeper", async () => {
  const pageOf = async (address) => {
    const answer = await fetch(address);
    assert.equal(answer.status, 200, address);
    return answer.text();
  };
  const ours = (await pageOf(`${server.url}/m/pebble`)).replaceAll("../", "../../").replaceAll("/m/pebble\"", "/m/pebble/\"")
    .replaceAll("/m/pebble?", "/m/pebble/?");
  assert.equal(await pageOf(`${host.url}/m/pebble/`), ours);
  assert.match(ours, /<meta property="og:title" content="A pebble">/);
  const [picture, served] = await Promise.all([host, server].map(({ url }) => fetch(`${url}/m/pebble/picture.jpg`)));
  assert.equal(picture.headers.get("content-type"), "image/jpeg");
  assert.deepEqual(await picture.arrayBuffer(), await served.arrayBuffer());
  const manifest = await fetch(`${host.url}/m/pebble/manifest.json`);
  assert.equal((await manifest.json()).homepage[0].id, "../../m/pebble/");
  const visit = await Visit.phone(browser);
  await visit.open(`${host.url}/m/pebble`); // nginx adds the slash
  await visit.until("the pebble", ({ mode, model, idle, shownLevel }) =>
    mode === "full screen" && model === "pebble" && idle && shownLevel !== null);
  assert.match(new URL(visit.page.url()).pathname, /^\/m\/pebble\/?$/);
  await visit.close();
});
