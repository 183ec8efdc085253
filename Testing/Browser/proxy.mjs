// SPDX-License-Identifier: BSD-3-Clause
// A server between the browser and kdstream-serve that does what proxies, caches and broken networks do: it refuses the
// stream, alters blobs on the way, cuts frames short. It speaks as much WebSocket as that takes: whole, unmasked,
// uncompressed messages from the server, each of one frame.

import { EventEmitter, once } from "node:events";
import { createServer, request } from "node:http";
import { connect } from "node:net";

const frameHead = 20; // bytes of a KdStream frame before its payload: doc/protocol.md
const kinds = ["tree", "levels", "partitions", "boxes", "textures"];

// "partitions/12" of the KdStream frame in a message.
function blobOfFrame(message) {
  const [kind, level, number] = [message[4], message[5], message.readUInt32LE(8)];
  return kinds[kind] === "levels" ? `levels/${level}/${number}` : `${kinds[kind]}/${number}`;
}

// "partitions/12" of a blob's path, or nothing.
function blobOfPath(path) {
  return /^\/api\/models\/[^/]+\/[0-9a-f]{32}\/(.+)$/.exec(path)?.[1];
}

export class Proxy extends EventEmitter {
  #server;
  #target; // port
  #sockets = new Set();
  url;

  // What is done to the bytes; may be changed at any time.
  streams = true; // false: an upgrade is answered 404, as by a host of files
  // (name, bytes) => bytes: of a blob, or of the beginning of one that comes in several frames
  alterBlob = null;
  // (message) => message: a whole KdStream frame
  alterFrame = null;
  bytesPerSecond = Infinity; // of each answer to a GET
  stallsAt = Infinity; // bytes of an answer after which nothing more comes
  holds = false; // true: of streams nothing comes any more
  altered = 0; // blobs and frames that were

  static async start(target) {
    const proxy = new Proxy();
    proxy.#target = target;
    proxy.#server = createServer((asked, answer) => proxy.#forward(asked, answer));
    proxy.#server.on("upgrade", (asked, socket) => proxy.#upgrade(asked, socket));
    proxy.#server.listen(0, "127.0.0.1");
    await once(proxy.#server, "listening");
    proxy.url = `http://127.0.0.1:${proxy.#server.address().port}`;
    return proxy;
  }

  // What is connected, but not what will be.
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
      const fields = { ...answered.headers, "content-length": method === "HEAD" ? answered.headers["content-length"] : body.length };
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

  #upgrade(asked, socket) {
    this.#sockets.add(socket);
    socket.on("close", () => this.#sockets.delete(socket));
    if (!this.streams) {
      socket.end("HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
      return;
    }
    const onward = connect(this.#target, "127.0.0.1");
    const end = () => {
      socket.destroy();
      onward.destroy();
    };
    for (const side of [socket, onward]) {
      side.on("error", end).on("close", end);
    }
    const fields = Object.entries(asked.headers)
      .filter(([name]) => name !== "sec-websocket-extensions")
      .map(([name, value]) => `${name}: ${value}\r\n`);
    onward.write(`${asked.method} ${asked.url} HTTP/1.1\r\n${fields.join("")}\r\n`);
    socket.pipe(onward);
    this.#carryBack(onward, socket);
  }

  // From the server to the browser: the answer to the upgrade as it is, then message by message.
  #carryBack(from, to) {
    let waiting = Buffer.alloc(0);
    let upgraded = false;
    from.on("data", (bytes) => {
      waiting = Buffer.concat([waiting, bytes]);
      if (!upgraded) {
        const end = waiting.indexOf("\r\n\r\n");
        if (end < 0) {
          return;
        }
        to.write(waiting.subarray(0, end + 4));
        waiting = waiting.subarray(end + 4);
        upgraded = true;
      }
      for (let frame; !this.holds && (frame = takeFrame(waiting)); waiting = waiting.subarray(frame.bytes)) {
        to.write(makeFrame(frame.first, frame.binary ? this.#alterMessage(frame.payload) : frame.payload));
      }
    });
  }

  #alterMessage(message) {
    const whole = this.alterFrame?.(Buffer.from(message));
    if (whole) {
      this.altered += !whole.equals(message);
      return whole;
    }
    if (message.readUInt32LE(12) > 0) {
      return message; // not the beginning of a blob
    }
    const payload = this.#alter(blobOfFrame(message), message.subarray(frameHead));
    return Buffer.concat([message.subarray(0, frameHead), payload]);
  }
}

// The first WebSocket frame of the bytes, or null while it is not whole.
function takeFrame(bytes) {
  if (bytes.length < 2) {
    return null;
  }
  const short = bytes[1] & 0x7f;
  const head = short < 126 ? 2 : short === 126 ? 4 : 10;
  if (bytes.length < head) {
    return null;
  }
  const length = short < 126 ? short : short === 126 ? bytes.readUInt16BE(2) : Number(bytes.readBigUInt64BE(2));
  if (bytes.length < head + length) {
    return null;
  }
  return { first: bytes[0], binary: (bytes[0] & 0x0f) === 2, payload: bytes.subarray(head, head + length), bytes: head + length };
}

function makeFrame(first, payload) {
  let head;
  if (payload.length < 126) {
    head = Buffer.from([first, payload.length]);
  } else if (payload.length < 65536) {
    head = Buffer.from([first, 126, payload.length >> 8, payload.length & 255]);
  } else {
    head = Buffer.alloc(10);
    head[0] = first;
    head[1] = 127;
    head.writeBigUInt64BE(BigInt(payload.length), 2);
  }
  return Buffer.concat([head, payload]);
}
