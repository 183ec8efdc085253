// SPDX-License-Identifier: BSD-3-Clause
// A line between a browser and a server on this machine, with any speed and delay; like ShapedProxy.h, but for programs
// in Node. Counts the received bytes.

import { once } from "node:events";
import { connect, createServer } from "node:net";

const longestQueue = 256 * 1024; // bytes that may wait in each connection; with more, the server is not read

export class Line {
  #server;
  #sockets = new Set();
  #free = 0; // ms: when the last waiting byte will have left
  bytes = 0; // from the server
  url;

  // target: a port. rate: bytes a second of all connections together; roundTrip: ms.
  static async start(target, { rate = Infinity, roundTrip = 0 } = {}) {
    const line = new Line();
    line.#server = createServer((near) => line.#carry(near, connect(target, "127.0.0.1"), rate, roundTrip));
    line.#server.listen(0, "127.0.0.1");
    await once(line.#server, "listening");
    line.url = `http://127.0.0.1:${line.#server.address().port}`;
    return line;
  }

  async stop() {
    this.#sockets.forEach((socket) => socket.destroy());
    this.#server.close();
    await once(this.#server, "close");
  }

  #carry(near, far, rate, roundTrip) {
    const end = () => {
      near.destroy();
      far.destroy();
    };
    for (const socket of [near, far]) {
      this.#sockets.add(socket);
      socket.setNoDelay(true);
      socket.on("error", end).on("close", () => {
        this.#sockets.delete(socket);
        end();
      });
    }
    const [there, back] = [new Schedule(), new Schedule()];
    const opened = performance.now() + roundTrip; // after a handshake
    near.on("data", (part) => {
      there.add(Math.max(opened, performance.now()) + roundTrip / 2, () => far.write(part));
    });
    let waiting = 0;
    far.on("data", (part) => {
      this.bytes += part.length;
      waiting += part.length;
      if (waiting > longestQueue) {
        far.pause();
      }
      this.#free = Math.max(this.#free, performance.now()) + 1000 * part.length / rate;
      back.add(this.#free + roundTrip / 2, () => {
        near.write(part);
        waiting -= part.length;
        if (waiting <= longestQueue) {
          far.resume();
        }
      });
    });
  }
}

// Runs each task at its time, in the order in which the tasks were added. If the time has passed, the task runs at
// once.
class Schedule {
  #actions = []; // { time, act }
  #timer = null;

  add(time, act) {
    this.#actions.push({ time, act });
    this.#timer ?? this.#go();
  }

  #go() {
    this.#timer = null;
    while (this.#actions.length && this.#actions[0].time <= performance.now()) {
      this.#actions.shift().act();
    }
    if (this.#actions.length) {
      this.#timer = setTimeout(() => this.#go(), this.#actions[0].time - performance.now());
    }
  }
}
