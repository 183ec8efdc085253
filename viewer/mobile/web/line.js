// SPDX-License-Identifier: BSD-3-Clause
// The page's sockets: does what the viewer's line to the server wants, and tells it what happened. Step "receive" of
// the README's picture.

import { Action } from "./viewer.js";

const longestSilence = 20000; // ms, of an answer
const mostListBytes = 16 << 20;

// All addresses are relative to the page's, so that it works below a path too.
function addressOf(path) {
  return new URL(path.replace(/^\/+/, ""), new URL(".", location.href));
}

function streamAddress() {
  const address = addressOf("api/stream");
  address.protocol = address.protocol.replace("http", "ws");
  return address;
}

const now = () => performance.now() / 1000;

// The answer's status and body; stops where it has more than mostBytes, or falls silent.
async function get(path, mostBytes, cache = "default") {
  const controller = new AbortController();
  let timer = 0;
  const wait = () => {
    clearTimeout(timer);
    timer = setTimeout(() => controller.abort(), longestSilence);
  };
  try {
    wait();
    const response = await fetch(addressOf(path), { signal: controller.signal, cache });
    const reader = response.body.getReader();
    const parts = [];
    let length = 0;
    for (;;) {
      wait();
      const { done, value } = await reader.read();
      if (done) {
        return { status: response.status, bytes: join(parts, length) };
      }
      length += value.length;
      if (length > mostBytes) {
        controller.abort();
        return { status: 413, bytes: new TextEncoder().encode('{"error":"the answer is too large"}') };
      }
      parts.push(value);
    }
  } finally {
    clearTimeout(timer);
  }
}

function join(parts, length) {
  const bytes = new Uint8Array(length);
  let end = 0;
  for (const part of parts) {
    bytes.set(part, end);
    end += part.length;
  }
  return bytes;
}

// The list of models as bytes. Throws an error whose message says why there is none.
export async function getList() {
  const { status, bytes } = await get("api/models.json", mostListBytes).catch(() => {
    throw new Error("the server does not answer");
  });
  if (status !== 200) {
    throw new Error(`the server says ${status}`);
  }
  return bytes;
}

export class Line {
  #viewer;
  #changed;
  #socket = null;
  #fetched = new Set(); // paths
  #distrusted = new Set(); // those of them whose copy in the browser's cache may be damaged

  // changed: called whenever something came for the viewer.
  constructor(viewer, changed) {
    this.#viewer = viewer;
    this.#changed = changed;
  }

  // Carries out what the viewer wants by now. Call after every input of it.
  exchange() {
    this.#viewer.exchange(now());
    for (;;) {
      const action = this.#viewer.nextAction();
      switch (action.kind) {
        case Action.connect:
          this.#connect();
          break;
        case Action.send:
          this.#socket?.send(action.text);
          break;
        case Action.close:
          this.#close();
          break;
        case Action.fetch:
          this.#fetch(action.text, action.mostBytes);
          break;
        default:
          return;
      }
    }
  }

  // Call now and then.
  tick() {
    this.#viewer.tick(now());
    this.exchange();
  }

  // Tries again now what would be tried again later.
  hurry() {
    this.#viewer.hurry();
    this.tick();
  }

  // What has been fetched before is fetched from the server again, not from the browser's cache, which keeps a damaged blob
  // for as long as a good one.
  distrustCache() {
    this.#distrusted = new Set(this.#fetched);
  }

  #connect() {
    this.#close();
    let socket;
    try {
      socket = new WebSocket(streamAddress(), "kdstream.v1");
    } catch {
      this.#ended(null, false);
      return;
    }
    this.#socket = socket;
    socket.binaryType = "arraybuffer";
    let opened = false;
    // What a connection says after it was given up no longer counts.
    const listen = (name, tell) => socket.addEventListener(name, (event) => {
      if (this.#socket === socket) {
        tell(event);
        this.#told();
      }
    });
    listen("open", () => {
      opened = true;
      this.#viewer.socketOpened(now());
    });
    listen("message", ({ data }) => {
      if (!this.#viewer.socketMessage(data, now())) {
        socket.close();
      }
    });
    listen("close", ({ reason }) => this.#ended(socket, opened, reason));
  }

  #close() {
    const socket = this.#socket;
    this.#socket = null;
    socket?.close();
  }

  // A browser does not tell why a connection could not be made: if the server answers otherwise, it has no stream for
  // us.
  async #ended(socket, opened, reason) {
    let refused = false;
    if (!opened) {
      refused = await getList().then(() => true, () => false);
    }
    if (this.#socket === socket) {
      this.#socket = null;
      this.#viewer.socketEnded(refused, reason || (opened ? "it was closed" : "the server does not answer"), now());
      this.#told();
    }
  }

  async #fetch(path, mostBytes) {
    const cache = this.#distrusted.delete(path) ? "reload" : "default";
    this.#fetched.add(path);
    try {
      const { status, bytes } = await get(path, mostBytes, cache);
      this.#viewer.fetched(status, bytes, now());
    } catch {
      this.#viewer.fetchFailed("the server does not answer", now());
    }
    this.#told();
  }

  #told() {
    this.exchange();
    this.#changed();
  }
}
