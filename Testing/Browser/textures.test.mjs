// SPDX-License-Identifier: BSD-3-Clause
// The pictures of a textured model arrive after the triangles that show them, and the browser decodes them.

import assert from "node:assert/strict";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { Server, Visit, buildStore, eventually, launchBrowser, runProgram, temporaryFolder } from "./harness.mjs";
import { difference } from "./pixels.mjs";
import { Proxy } from "./proxy.mjs";

const folder = temporaryFolder();
let server, proxy, browser;

before(async () => {
  const meshes = temporaryFolder();
  runProgram("kdstream-generate", "statue", join(meshes, "statue.obj"), "--vertices", "20000", "--picture-side", "512", "--quiet");
  buildStore(join(meshes, "statue.obj"), join(folder, "statue.kds"), "--title", "A statue", "--vertices-per-partition", "500");
  buildStore(join(meshes, "statue.obj"), join(folder, "baked.kds"), "--title", "Only baked", "--vertices-per-partition", "500",
    "--textures", "colors");
  browser = await launchBrowser();
  server = await Server.start(folder);
  proxy = await Proxy.start(server.port);
});

after(async () => {
  await browser?.close();
  await proxy?.stop();
  await server?.stop();
});

// In a small window, because a software renderer takes long for every pixel of a texture.
async function visitNear(address, model) {
  const visit = await Visit.desktop(browser);
  await visit.page.setViewportSize({ width: 420, height: 420 });
  await visit.open(`${address}/#model=${model}`);
  await visit.until("full screen", ({ mode, idle, shownLevel }) => mode === "full screen" && idle && shownLevel !== null);
  const { x, y } = await visit.centre();
  await visit.page.mouse.move(x, y + 60);
  for (let i = 0; i < 4; ++i) {
    await visit.page.mouse.wheel(0, -300);
    await visit.untilIdle();
  }
  return visit;
}

const isOfLevel = (name) => name.startsWith("level-textures/");
const isTexture = (name) => isOfLevel(name) || name.startsWith("textures/");

for (const way of ["streamed", "got"]) {
  test(`they are seen from near, ${way}`, async () => {
    proxy.streams = way === "streamed";
    const sent = [];
    proxy.alterBlob = (name, bytes) => {
      sent.push(name);
      return bytes;
    };
    const visit = await visitNear(proxy.url, "statue");
    const textures = sent.filter(isTexture);
    assert.ok(textures.length > 3, `${textures.length} textures`);
    assert.equal(new Set(textures).size, textures.length, "each once");
    assert.ok(textures.some(isOfLevel), "of levels too");
    assert.ok(!textures.every(isOfLevel), "of the original too");
    const textured = (name) => name.replace(/^[^/]+/, isOfLevel(name) ? "levels" : "partitions");
    assert.ok(textures.every((name) => sent.includes(textured(name))), "of what is there");
    const status = await visit.status();
    assert.equal(status.error, "");
    assert.ok(status.memory.graphics > 100_000);
    const withTextures = await visit.picture(`textures-1-${way}`);

    const baked = await visitNear(server.url, "baked");
    const apart = difference(withTextures, await baked.picture("textures-2-baked"), 8);
    assert.ok(apart > 0.02, `a picture's details are not those of the vertices: ${apart}`);
    assert.deepEqual(visit.errors.filter((text) => !/api\/stream/.test(text)), []);

    await visit.page.evaluate(() => document.querySelector("[name=coloring][value=none]").click());
    await visit.untilIdle();
    await visit.page.evaluate(() => document.querySelector("[name=coloring][value=own]").click());
    await visit.untilIdle();
    assert.ok(difference(withTextures, await visit.picture("textures-3-again")) < 0.001, "the same after plain stone");
    await visit.close();
    await baked.close();
  });
}

test("one that is damaged is named, and the model stays to be looked at", async () => {
  proxy.streams = true;
  proxy.alterBlob = (name, bytes) => {
    if (isTexture(name)) {
      bytes[bytes.length >> 1] ^= 1;
    }
    return bytes;
  };
  const visit = await visitNear(proxy.url, "statue");
  await visit.untilSaid(/^A part of “A statue” is missing \((level-)?textures\/[\d/]+\): .*its checksum is wrong\.$/);
  const { triangles, original } = await visit.status();
  assert.ok(triangles > 1000 && original);
  proxy.alterBlob = null;
  await visit.page.locator("#message-action").click();
  await visit.untilIdle();
  await visit.untilQuiet();
  await visit.close();
});

test("a lost context has them again", async () => {
  const visit = await visitNear(server.url, "statue");
  const before = await visit.picture("textures-4-before");
  await visit.page.evaluate(async () => {
    const lose = document.getElementById("view").getContext("webgl2").getExtension("WEBGL_lose_context");
    lose.loseContext();
    await new Promise((resolve) => setTimeout(resolve, 100));
    lose.restoreContext();
  });
  await eventually("the picture again", async () => {
    await visit.untilIdle();
    return difference(before, await visit.picture("textures-5-after"));
  }, (apart) => apart < 0.001);
  assert.deepEqual(visit.errors, []);
  await visit.close();
});

test("the original is kept with them", async () => {
  const visit = await visitNear(server.url, "statue");
  await visit.page.locator("#menu-button").click();
  await eventually("details to choose from", () => visit.page.locator("#keep-goal option").count(), (count) => count > 1);
  await visit.page.locator("#keep-goal").selectOption("original");
  await visit.page.locator("#keep").click();
  const kept = () => visit.page.evaluate(() => new Promise((resolve) => {
    const request = indexedDB.open("kdstream");
    request.onsuccess = () => {
      const all = request.result.transaction("entries").objectStore("entries").getAllKeys();
      all.onsuccess = () => {
        request.result.close();
        resolve(all.result);
      };
    };
  }));
  const count = (paths, kind) => paths.filter((path) => path.includes(`/${kind}/`)).length;
  const paths = await eventually("all of it", kept, (all) => count(all, "partitions") > 8
    && count(all, "textures") === count(all, "partitions") && count(all, "level-textures") === count(all, "levels"));
  assert.ok(count(paths, "textures") >= 32, `${count(paths, "textures")} textures`);
  await visit.close();
});
