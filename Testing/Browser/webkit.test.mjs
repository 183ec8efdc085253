// SPDX-License-Identifier: BSD-3-Clause
// The walk and the tools in the third engine: WebKit, as a substitute for Safari.

import { after, before, test } from "node:test";
import { useTools, walk } from "./engines.mjs";
import { Server, makeModels } from "./harness.mjs";
import { WebKit } from "./webkit.mjs";

let server, webkit;

before(async () => {
  server = await Server.start(makeModels({ dragon: false }));
  webkit = await WebKit.start(server.port);
});

after(async () => {
  await webkit?.stop();
  await server?.stop();
});

test("the list, a model, the wheel to the original, a double click for a region, and back", async (context) => {
  const visit = webkit.visit();
  context.after(() => visit.close());
  await walk("webkit", visit);
});

test("sides, a distance, a section, light", async (context) => {
  const visit = webkit.visit();
  context.after(() => visit.close());
  await useTools("webkit", visit);
});
