// SPDX-License-Identifier: BSD-3-Clause
// An X server on a display that is free, for browsers that draw with WebGL 2 only where there is a screen.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { createInterface } from "node:readline";

// Its display's name and its process. options: further ones of Xvfb.
export async function startScreen({ width, height }, ...options) {
  const server = spawn("Xvfb", ["-displayfd", "3", "-screen", "0", `${width}x${height}x24`, "-nolisten", "tcp", ...options],
    { stdio: ["ignore", "ignore", "inherit", "pipe"] });
  process.on("exit", () => server.kill("SIGKILL"));
  const failed = once(server, "error").then(([error]) => [error.message]);
  const ended = once(server, "exit").then(([code]) => [`it ended with ${code}`]);
  const [display] = await Promise.race([once(createInterface({ input: server.stdio[3] }), "line"), failed, ended]);
  assert.match(display, /^\d+$/, "Xvfb did not start");
  return { display: `:${display}`, server };
}

export async function stopScreen(screen) {
  const ended = once(screen.server, "exit");
  screen.server.kill("SIGTERM");
  await ended;
}
