// SPDX-License-Identifier: BSD-3-Clause
// New vertices morph to their places on a desktop. The test waits for a fast machine, so it is one of the slow tests.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Visit, makeModels, startForTests } from "./harness.mjs";
import { difference } from "./pixels.mjs";

let server, browser;

startForTests(makeModels, async (started) => {
  ({ server, browser } = started);
});

// A slow machine may have drawn too few frames while the list was shown. Then nothing morphs for this time
// (GeomorphClock::rest), in seconds.
const geomorphRest = 10.5;

// New vertices morph to their places, and get there; but not if the user prefers reduced motion.
test("new vertices morph", async () => {
  const geomorphsSeen = async (reducedMotion) => {
    const visit = await Visit.desktop(browser, { reducedMotion, viewport: { width: 640, height: 400 } });
    const { page } = visit;
    await visit.open(server.url);
    await visit.untilIdle();
    const framesMorphing = await visit.countFrames("gliding");
    const middle = await visit.centre();
    await page.mouse.click(middle.x, middle.y);
    await visit.until("full screen", ({ mode, idle }) => mode === "full screen" && idle);
    if (reducedMotion === "no-preference" && await framesMorphing() === 0) {
      await page.waitForTimeout(1000 * geomorphRest);
    }
    for (let i = 0; i < 8; ++i) {
      await page.mouse.wheel(0, -100);
      const { gliding: isMorphing } = await visit.untilIdle();
      assert.equal(isMorphing, false);
    }
    const seen = await framesMorphing();
    const picture = await visit.around(middle);
    visit.assertClean(server.url);
    await visit.close();
    return { seen, picture };
  };
  const morphing = await geomorphsSeen("no-preference"), still = await geomorphsSeen("reduce");
  assert.ok(morphing.seen > 0, "frames on the way were drawn");
  assert.equal(still.seen, 0);
  assert.ok(difference(morphing.picture, still.picture) < 0.01, "the same in the end");
});
