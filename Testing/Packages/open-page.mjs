// SPDX-License-Identifier: BSD-3-Clause
// Opens a server's page in Chromium as a phone does, waits until its model is shown, and saves a picture: open-page.mjs
// URL PICTURE

import assert from "node:assert/strict";
import { mkdirSync } from "node:fs";
import { dirname } from "node:path";
import { Visit, launchBrowser } from "../Browser/harness.mjs";

const [url, picture] = process.argv.slice(2);
const browser = await launchBrowser();
const visit = await Visit.phone(browser);
await visit.open(url);
const { triangles } = await visit.untilIdle();
mkdirSync(dirname(picture), { recursive: true });
await visit.page.screenshot({ path: picture });
await browser.close();
assert.ok(triangles > 0, `${url} shows no triangle`);
visit.assertClean(url);
console.log(`${triangles} triangles in Chromium`);
