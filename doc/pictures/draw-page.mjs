#!/usr/bin/env node
// SPDX-License-Identifier: BSD-3-Clause
// Draws the page's pictures of the documents anew, beside this file: the phone's (phone-*.png) and those of each attribute of
// <kdstream-viewer> (embed-*.png). Its environment is that of the browser tests (Testing/Browser/harness.mjs).

import { createServer } from "node:http";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { Server, Visit, buildStore, eventually, launchBrowser, temporaryFolder } from "../../Testing/Browser/harness.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const models = temporaryFolder();
buildStore(process.env.KDSTREAM_DRAGON, join(models, "dragon.kds"), "--title", "Stanford dragon",
  "--credit", "Stanford Computer Graphics Laboratory");
const server = await Server.start(models);
const browser = await launchBrowser();

async function drawPhone() {
  const visit = await Visit.phone(browser, { width: 412, height: 915 });
  const draw = (name) => visit.page.screenshot({ path: join(here, `phone-${name}.png`) });
  await visit.open(server.url);
  await visit.untilIdle();
  await visit.page.waitForSelector("#models img:not([hidden])");
  await draw("preview");
  await visit.tap(await visit.centre());
  await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
  await visit.pinch(await visit.centre(), 100, 170);
  await visit.untilIdle();
  await draw("level");
  await visit.doubleTap(await visit.centre());
  await visit.until("the region", ({ region, idle }) => idle && region !== null && region.shown === region.partitions);
  await draw("region");
  await visit.close();
}

// A page of another origin with the viewer only.
let body = "";
const host = createServer((_, response) => response.setHeader("Content-Type", "text/html; charset=utf-8").end(body));
await new Promise((started) => host.listen(0, "127.0.0.1", started));

async function openEmbed(attributes, isPhone) {
  body = `<!doctype html><title>A museum</title><link rel="icon" href="data:,"><meta name="viewport" content="width=device-width">
    <style>body { margin: 0 } kdstream-viewer { width: 320px; height: 240px }</style>
    <script src="${server.url}/embed.js"></script><kdstream-viewer model="dragon" ${attributes}></kdstream-viewer>`;
  const visit = await (isPhone ? Visit.phone(browser, undefined, { reducedMotion: "no-preference" })
    : Visit.desktop(browser, { reducedMotion: "no-preference" }));
  await visit.open(`http://localhost:${host.address().port}/`);
  return visit;
}

async function drawEmbed(name, attributes, { isPhone = false, sleeps = false, waitFor = (status) => status?.idle } = {}) {
  const visit = await openEmbed(attributes, isPhone);
  const viewer = visit.page.locator("kdstream-viewer");
  if (!sleeps) {
    await eventually("a picture", () => viewer.evaluate((element) => element.status().catch(() => null)), waitFor);
  }
  await viewer.screenshot({ path: join(here, `embed-${name}.png`) });
  const poster = name === "model" && await viewer.evaluate(async (element) => {
    const bytes = new Uint8Array(await (await element.picture()).arrayBuffer());
    return `data:image/png;base64,${btoa(String.fromCharCode(...bytes))}`;
  });
  await visit.close();
  return poster;
}

await drawPhone();
const poster = await drawEmbed("model", "");
const from = (side) => openEmbed("", false).then(async (visit) => {
  const viewer = visit.page.locator("kdstream-viewer");
  await eventually("a picture", () => viewer.evaluate((element) => element.status().catch(() => null)), (status) => status?.idle);
  const first = await viewer.evaluate((element) => element.link());
  await viewer.evaluate((element, asked) => element.lookFrom(asked), side);
  const link = await eventually("another view", () => viewer.evaluate((element) => element.link()), (found) => found !== first);
  await visit.close();
  return link;
});
await drawEmbed("view", `view="${(await from("top")).replaceAll("&", "&amp;")}"`);
await drawEmbed("poster", `autoplay="false" poster="${poster}"`, { sleeps: true });
await drawEmbed("turn", "turn", { waitFor: (status) => status?.spinning && status.frames > 60 });
await drawEmbed("scroll", "", { isPhone: true });
await drawEmbed("scroll-off", 'scroll="off"', { isPhone: true });
await drawEmbed("theme", 'theme="light"');
await drawEmbed("logo", `logo="${server.url}/icon.svg"`);
await browser.close();
await server.stop();
host.close();
