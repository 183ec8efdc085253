// SPDX-License-Identifier: BSD-3-Clause
// A server between the browser and kdstream-serve that behaves like proxies, caches and broken networks: it refuses the
// stream, changes blobs in transit, and truncates frames.

import { EventEmitter, once } from "node:events";
import { STATUS_CODES, createServer, request } from "node:http";
import { WebSocket, WebSocketServer } from "ws";

const frameHead = 20; // bytes of a KdStream frame before its payload: doc/protocol.md
const kinds = ["tree", "levels", "partitions", "boxes", "textures", "level-textures"];
const ofLevels = [1, 5]; // kinds of blobs

// The name of the blob, such as "partitions/12", in the KdStream frame of a message.
function blobOfFrame(message) {
  const [kind, level, number] = [message[4], message[5], message.readUInt32LE(8)];
  return ofLevels.includes(kind) ? `${kinds[kind]}/${level}/${number}` : `${kinds[kind]}/${number}`;
}

// The name of the blob, such as "partitions/12", in a path; nothing if the path is not a blob's.
function blobOfPath(path) {
  return /^\/api\/models\/[^/]+\/[0-9a-f]{32}\/(.+)$/.exec(path)?.[1];
}

export class Proxy extends EventEmitter {
  #server;
  #target; // the server's port
  #sockets = new Set();
  url;

  // These members say how the bytes are changed. They may be set at any time.
  streams = true; // false: an upgrade is answered 404, as by a host of files
  // (name, bytes) => bytes: changes a blob, or the beginning of a blob that comes in several frames
  alterBlob = null;
  // (message) => message: changes a whole KdStream frame
  alterFrame = null;
  // (path, bytes, fields) => bytes: changes any other answer to a GET, and perhaps its fields
  alterFile = null;
  // (asked, answer) => boolean: whether this function has answered instead of the server
  intercept = null;
  bytesPerSecond = Infinity; // of each answer to a GET
  stallsAt = Infinity; // after this number of bytes of an answer nothing more comes
  holds = false; // true: nothing more comes from streams
  altered = 0; // number of changed blobs and frames

  static async start(target) {
    const proxy = new Proxy();
    proxy.#target = target;
    proxy.#server = createServer((asked, answer) => proxy.#forward(asked, answer));
    proxy.#server.on("upgrade", (...asked) => proxy.#upgrade(...asked));
    proxy.#server.listen(0, "127.0.0.1");
    await once(proxy.#server, "listening");
    proxy.url = `http://127.0.0.1:${proxy.#server.address().port}`;
    return proxy;
  }

  // Ends all present connections; later ones work.
  cut() {
    this.#sockets.forEach((socket) => socket.destroy());
  }

  async stop() {
    this.cut();
    this.#server.closeAllConnections();
    this.#server.close();
    await once(this.#server, "close");
  }

  #alter(name, bytes) {
    const altered = this.alterBlob?.(name, Buffer.from(bytes));
    this.altered += altered !== undefined && !altered.equals(bytes);
    return altered ?? bytes;
  }

  // ---- GET

  #forward(asked, answer) {
    if (this.intercept?.(asked, answer)) {
      return;
    }
    const { method, url: path, headers } = asked;
    const onward = request({ host: "127.0.0.1", port: this.#target, method, path, headers }, async (answered) => {
      const parts = [];
      for await (const part of answered) {
        parts.push(part);
      }
      let body = Buffer.concat(parts);
      const name = blobOfPath(path);
      if (name && answered.statusCode === 200) {
        body = this.#alter(name, body);
      }
      const altered = { ...answered.headers };
      body = name ? body : this.alterFile?.(path, body, altered) ?? body;
      const fields = { ...altered, "content-length": method === "HEAD" ? answered.headers["content-length"] : body.length };
      answer.writeHead(answered.statusCode, fields);
      await this.#pace(answer, body);
    });
    onward.on("error", () => answer.writeHead(502).end());
    asked.pipe(onward);
  }

  async #pace(answer, body) {
    const step = Math.max(1, Math.ceil(this.bytesPerSecond / 10)); // ten a second
    for (let begin = 0; begin < body.length && step < Infinity; begin += step) {
      if (begin >= this.stallsAt) {
        await once(this, "goes on");
      }
      answer.write(body.subarray(begin, begin + step));
      await new Promise((resolve) => setTimeout(resolve, 100));
    }
    answer.end(step < Infinity ? undefined : body);
  }

  // Ends a stall.
  goOn() {
    this.stallsAt = Infinity;
    this.emit("goes on");
  }

  // ---- the stream

  // Opens a stream to the server first, and passes the server's answer to the browser.
  #upgrade(asked, socket, head) {
    socket.on("error", () => {}); // the page was closed: its end follows
    this.#sockets.add(socket);
    socket.on("close", () => this.#sockets.delete(socket));
    const refuse = (status) => socket.end(`HTTP/1.1 ${status} ${STATUS_CODES[status]}\r\nContent-Length: 0\r\nConnection: close\r\n\r\n`);
    if (!this.streams) {
      refuse(404);
      return;
    }
    const { host, origin, cookie, authorization, "sec-websocket-protocol": protocols } = asked.headers;
    const headers = Object.fromEntries(Object.entries({ host, origin, cookie, authorization }).filter(([, value]) => value));
    const onward = new WebSocket(`ws://127.0.0.1:${this.#target}${asked.url}`, protocols?.split(/, */) ?? [],
      { headers, perMessageDeflate: false });
    onward.on("error", () => socket.destroy());
    socket.on("close", () => onward.readyState === WebSocket.CONNECTING && onward.terminate());
    onward.on("unexpected-response", (_, { statusCode }) => refuse(statusCode));
    onward.on("open", () => {
      const upgrades = new WebSocketServer({ noServer: true, perMessageDeflate: false, handleProtocols: () => onward.protocol });
      upgrades.handleUpgrade(asked, socket, head, (browser) => this.#carry(browser, onward));
    });
  }

  #carry(browser, onward) {
    browser.on("message", (message, binary) => onward.send(message, { binary }));
    onward.on("message", (message, binary) => {
      if (!this.holds) {
        browser.send(binary ? this.#alterMessage(message) : message, { binary });
      }
    });
    for (const [side, other] of [[browser, onward], [onward, browser]]) {
      side.on("error", () => {});
      side.on("close", (code, reason) => {
        if (code === 1006) { // without a Close frame
          other.terminate();
        } else {
          other.close(code === 1005 ? undefined : code, reason);
        }
      });
    }
  }

  #alterMessage(message) {
    const whole = this.alterFrame?.(Buffer.from(message));
    if (whole) {
      this.altered += !whole.equals(message);
      return whole;
    }
    if (message.readUInt32LE(12) > 0) {
      return message; // this message does not begin a blob
    }
    const payload = this.#alter(blobOfFrame(message), message.subarray(frameHead));
    return Buffer.concat([message.subarray(0, frameHead), payload]);
  }
}
