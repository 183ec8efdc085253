// SPDX-License-Identifier: BSD-3-Clause
// The page's sockets: does what the viewer's connection to the server asks for, and reports what happened. Step "receive" of the
// pipeline picture.

import { refusalOf } from "./refusal.js";
import { findBlob, findText, isPinned, storeBlobs, storeText, storedPathsOf } from "./storage.js";
import { Action } from "./viewer.js";
import { t } from "./words.js";

const stallTimeout = 20000; // ms, of an answer
const mostListBytes = 16 << 20;
const longestRetryAfter = 3600; // s
const listPath = "/api/models.json";
const beginOf = (path) => blobPath.exec(path)[0];
const keepPause = 300; // ms during which blobs are gathered before they are stored
const textPath = /\/(model|notes)\.json$/;
const blobPath = /^\/api\/models\/([^/]+)\/[0-9a-f]{32}\//;

// The server's token is in the page's link (#token=…, before or after other keys), or is entered. It is stored for this tab, or
// in this browser if the user wants that, and never in a URL or log. But a browser may remember the link that was opened.
export let token = "";
export const tokenInLink = /^(.*[#&])token=([\w.-]{1,4096})(?:&(.*))?$/;
export const root = new URL(".", import.meta.url).href; // the page's folder: a model's page is below it
export const rememberedKey = `kdstream.token ${new URL(root).pathname}`;

// The result of `act`; null if the browser denies storage.
export function unlessDenied(act) {
  try {
    return act();
  } catch {
    return null;
  }
}

// Takes the token from the address, whose rest stays, or the kept one. True if the address had one.
export function takeToken() {
  const [, before, found, after = ""] = location.hash.match(tokenInLink) ?? [];
  if (found) {
    history.replaceState(history.state, "", location.pathname + location.search + (before + after).replace(/[#&]$/, ""));
    keepToken(found);
    return true;
  }
  token = unlessDenied(() => sessionStorage.getItem("token") ?? localStorage.getItem(rememberedKey)) ?? token;
  return false;
}

export function keepToken(given) {
  token = given;
  unlessDenied(() => sessionStorage.setItem("token", given));
}

export const hasToken = () => token !== "";

// Whether the server's latest answer was that it wants one, or another one; and what it says to those who have none.
let lacking = false;
export let contact = "";
export const lacksToken = () => lacking;

// Whether the token, if there is one, is for the original too. The server decides; this only spares an invitation.
export function mayHaveOriginal() {
  try {
    return !token || JSON.parse(atob(token.split(".")[1].replace(/-/g, "+").replace(/_/g, "/"))).detail === "regions";
  } catch {
    return true;
  }
}

function contactIn(bytes) {
  try {
    const { contact: text } = JSON.parse(new TextDecoder().decode(bytes));
    return typeof text === "string" ? text : "";
  } catch {
    return "";
  }
}

// Data that need a token are for its bearer, not for the next user of this browser.
export const mayKeep = () => !token;

// Whether the list is that of an earlier day, as the server cannot be reached.
let offline = false;
export const isOffline = () => offline;

const notKept = () => ({ status: 404, bytes: new TextEncoder().encode('{"error":"it is not stored on this device"}'), retryAfter: 0 });

// All addresses are relative to the page's, so that it works below a path too.
export function addressOf(path) {
  return new URL(path.replace(/^\/+/, ""), root);
}

function streamAddress() {
  const address = addressOf("api/stream");
  address.protocol = address.protocol.replace("http", "ws");
  return address;
}

const now = () => performance.now() / 1000;

// The seconds that a busy server asks for; 0 if it does not say.
function retryAfterOf({ status, headers }) {
  const seconds = [403, 429, 503].includes(status) ? Number(headers.get("Retry-After")) : 0;
  if (status === 401) {
    return longestRetryAfter; // nobody gets a token by asking again
  }
  return Math.min(Math.max(seconds, 0), longestRetryAfter) || 0;
}

// The answer's status, body and retryAfter; stops where it has more than mostBytes, or falls silent.
export async function get(path, mostBytes, cache = "default") {
  const controller = new AbortController();
  let timer = 0;
  const wait = () => {
    clearTimeout(timer);
    timer = setTimeout(() => controller.abort(), stallTimeout);
  };
  try {
    wait();
    const headers = token ? { Authorization: `Bearer ${token}` } : {};
    const response = await fetch(addressOf(path), { signal: controller.signal, cache, headers });
    lacking = response.status === 401;
    const reader = response.body.getReader();
    const parts = [];
    let length = 0;
    for (;;) {
      wait();
      const { done, value } = await reader.read();
      if (done) {
        const bytes = join(parts, length);
        if (response.status === 401) { // about this token: others may have come since
          contact = contactIn(bytes);
        }
        return { status: response.status, bytes, retryAfter: retryAfterOf(response) };
      }
      length += value.length;
      if (length > mostBytes) {
        controller.abort();
        return { status: 413, bytes: new TextEncoder().encode('{"error":"the answer is too large"}'), retryAfter: 0 };
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

// The list of models as bytes. Throws an error whose message says why there is none; retryAfter is set if a busy server has sent
// it.
export async function getList() {
  let answer;
  try {
    answer = await get(listPath, mostListBytes);
  } catch {
    const kept = mayKeep() ? await findText(listPath) : null;
    if (!kept) {
      throw new Error(t("the server does not answer"));
    }
    offline = true;
    return kept;
  }
  offline = false;
  const { status, bytes, retryAfter } = answer;
  if (status !== 200) {
    throw Object.assign(new Error(refusalOf(status, retryAfter, Boolean(token))), { retryAfter });
  }
  if (mayKeep()) {
    storeText(listPath, bytes);
  }
  return bytes;
}

// The latest previews, [path, bytes], whether they were fetched for the view or for a picture of the list: the other needs the same.
const mostPreviews = 32;
const previews = new Map();
const isPreview = /\/levels\/\d+\/1$/; // a level in one piece

function keepPreview({ path, bytes }) {
  if (isPreview.test(path)) {
    previews.delete(path);
    previews.set(path, bytes);
    if (previews.size > mostPreviews) {
      previews.delete(previews.keys().next().value);
    }
  }
}

// Stored blobs of viewed models: sets of paths, by their prefixes.
const kept = new Map();
const keptSoon = new Map(); // promises of stored blobs

function learnKept(begin) {
  if (!keptSoon.has(begin)) {
    keptSoon.set(begin, storedPathsOf(begin).then((paths) => kept.set(begin, paths)));
  }
  return keptSoon.get(begin);
}

export const addKept = (path) => kept.get(beginOf(path))?.add(path);

// As `get`, but a stored text is used if the server cannot be reached.
export async function getOrFind(path, mostBytes, cache = "default", keeps = true) {
  try {
    const answer = await get(path, mostBytes, cache);
    if (keeps && mayKeep() && answer.status === 200 && textPath.test(path)) {
      storeText(path, answer.bytes);
    }
    return answer;
  } catch (error) {
    if (!offline) {
      throw error;
    }
    const text = await findText(path);
    return text ? { status: 200, bytes: text, retryAfter: 0 } : notKept();
  }
}

export class Line {
  #viewer;
  #changed;
  #socket = null;
  #fetched = new Set(); // paths
  #arrived = []; // blobs that are to be kept
  #described = new Set(); // models whose descriptions are
  #distrusted = new Set(); // blobs whose copy in the browser's cache may be damaged

  #streams;

  // changed: called whenever something arrived for the viewer. streams: false: all comes by GET, and nothing of it is kept.
  constructor(viewer, changed, streams = true) {
    this.#viewer = viewer;
    this.#changed = changed;
    this.#streams = streams;
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
        case Action.search:
          this.#search(action.text);
          break;
        default:
          this.#keepArrivals();
          return;
      }
    }
  }

  #keepArrivals() {
    for (let arrival; (arrival = this.#viewer.nextArrival());) {
      keepPreview(arrival);
      this.#keep(arrival);
    }
  }

  #keep(arrival) {
    if (this.#streams && mayKeep() && this.#arrived.push(arrival) === 1) {
      setTimeout(() => this.#store(), keepPause);
    }
  }

  #store() {
    const arrived = this.#arrived;
    this.#arrived = [];
    storeBlobs(arrived).then((stored) => stored && arrived.forEach(({ path }) => addKept(path)));
    for (const id of new Set(arrived.map(({ path }) => blobPath.exec(path)[1]))) {
      if (!this.#described.has(id)) {
        this.#described.add(id);
        getOrFind(`/api/models/${id}/model.json`, mostListBytes).catch(() => this.#described.delete(id));
      }
    }
  }

  // Call now and then.
  tick() {
    this.#viewer.tick(now());
    this.exchange();
  }

  // Tries again now what would be tried again later.
  retryNow() {
    this.#viewer.retryNow();
    this.tick();
  }

  // From now on everything is fetched from the server, not from the browser's cache, which keeps a damaged blob as long as a good
  // one.
  distrustCache() {
    this.#distrusted = new Set(this.#fetched);
  }

  #connect() {
    this.#close();
    if (!this.#streams) {
      this.#viewer.socketEnded(true, "", now(), 0);
      return;
    }
    let socket;
    try {
      socket = new WebSocket(streamAddress(), ["kdstream.v2", ...(token ? [token] : [])]);
    } catch {
      this.#ended(null, false);
      return;
    }
    this.#socket = socket;
    socket.binaryType = "arraybuffer";
    let opened = false;
    // Messages of an abandoned connection are ignored.
    const listen = (name, handle) => socket.addEventListener(name, (event) => {
      if (this.#socket === socket) {
        handle(event);
        this.#update();
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

  // A browser does not say why a connection failed: if the server answers other requests, it has no stream for us.
  async #ended(socket, opened, reason) {
    let refused = false;
    let trouble = null;
    if (!opened) {
      refused = await getList().then(() => true, (error) => {
        trouble = error;
        return false;
      });
    }
    if (this.#socket === socket) {
      this.#socket = null;
      const why = reason || trouble?.message || "it was closed"; // this reason is shown only if a stream had opened
      this.#viewer.socketEnded(refused, why, now(), trouble?.retryAfter ?? 0);
      this.#update();
    }
  }

  // The browser has no network any more: a connection would only stall.
  drop() {
    if (this.#socket) {
      this.#socket.close();
      this.#ended(this.#socket, true);
    }
  }

  // Gives what is kept; at once, where that is nothing. "again": the server has gone, and what is known may be out of date.
  async #search(text) {
    const [head, ...paths] = text.split("\n");
    const [search, again] = head.split(" ");
    const begin = beginOf(paths[0]);
    if (mayKeep() && !kept.has(begin)) {
      await learnKept(begin);
    }
    const stored = (path) => mayKeep() && (again || kept.get(begin).has(path));
    const give = (index, bytes) => bytes && this.#viewer.found(search, index, bytes);
    const reads = [];
    for (const [index, path] of paths.entries()) {
      if (stored(path)) {
        reads.push(findBlob(path).then((bytes) => give(index, bytes ?? previews.get(path))));
      } else if (previews.has(path)) {
        give(index, previews.get(path));
        this.#keep({ path, bytes: previews.get(path) });
      }
    }
    reads.length && await Promise.all(reads);
    this.#viewer.endSearch(search, again && mayKeep() && await isPinned(`${begin}tree/1`), now());
    this.#update();
  }

  async #fetch(path, mostBytes) {
    const cache = this.#distrusted.delete(path) ? "reload" : "default";
    this.#fetched.add(path);
    try {
      const { status, bytes, retryAfter } = await getOrFind(path, mostBytes, cache, this.#streams);
      this.#viewer.fetched(status, bytes, now(), retryAfter);
    } catch {
      this.#viewer.fetchFailed("the server does not answer", now());
    }
    this.#update();
  }

  #update() {
    this.exchange();
    this.#changed();
  }
}
