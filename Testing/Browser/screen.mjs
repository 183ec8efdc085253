// SPDX-License-Identifier: BSD-3-Clause
// Starts an X server on a free display, for browsers that have WebGL 2 only with a screen.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { createInterface } from "node:readline";

// Returns the display's name and the process. options: further options of Xvfb.
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
