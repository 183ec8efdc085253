// SPDX-License-Identifier: BSD-3-Clause
// The page's connection to the server: does what the viewer's ServerLine asks for, and reports what happened. Step "receive" of
// the pipeline picture.

import { refusalOf } from "./refusal.js";
import { findBlob, findText, isPinned, storeBlobs, storeText, storedPathsOf } from "./storage.js";
import { Action } from "./viewer.js";
import { t } from "./words.js";

const stallTimeout = 20000; // ms without data, for an answer
const mostListBytes = 16 << 20;
const longestRetryAfter = 3600; // s
const listPath = "/api/models.json";
const beginOf = (path) => blobPath.exec(path)[0];
const keepPause = 300; // ms during which blobs are collected before they are stored
const textPath = /\/(model|notes)\.json$/;
const blobPath = /^\/api\/models\/([^/]+)\/[0-9a-f]{32}\//;

// The server's token is in the page's link (#token=…, before or after other keys), or is entered. It is stored for this tab or,
// if the user wants that, in this browser, but never in a URL or log. However, a browser may remember the link that was opened.
export let token = "";
export const tokenInLink = /^(.*[#&])token=([\w.-]{1,4096})(?:&(.*))?$/;
export const root = new URL(".", import.meta.url).href; // the page's folder, which contains the models' pages
export const rememberedKey = `kdstream.token ${new URL(root).pathname}`;

// The result of `act`; null if the browser denies storage.
export function unlessDenied(act) {
  try {
    return act();
  } catch {
    return null;
  }
}

// Takes the token from the address, or the stored one; the rest of the address stays. Returns whether the address had one.
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

// Whether the server's latest answer required a token, or another one; and the server's text for users without a token.
let lacking = false;
export let contact = "";
export const lacksToken = () => lacking;

// Whether the token, if there is one, permits the original, too. The server decides; this only avoids offering it in vain.
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

// Data that needs a token is for the token's owner, not for the next user of this browser.
export const mayKeep = () => !token;

// Whether the list is a stored one, because the server cannot be reached.
let offline = false;
export const isOffline = () => offline;

const notKept = () => ({ status: 404, bytes: new TextEncoder().encode('{"error":"it is not stored on this device"}'), retryAfter: 0 });

// All addresses are relative to the page's address, so that the page also works in a folder of the server.
export function addressOf(path) {
  return new URL(path.replace(/^\/+/, ""), root);
}

function streamAddress() {
  const address = addressOf("api/stream");
  address.protocol = address.protocol.replace("http", "ws");
  return address;
}

const now = () => performance.now() / 1000;

// Returns the seconds that a busy server asks to wait; 0 if it does not say.
function retryAfterOf({ status, headers }) {
  const seconds = [403, 429, 503].includes(status) ? Number(headers.get("Retry-After")) : 0;
  if (status === 401) {
    return longestRetryAfter; // asking again does not give anybody a token
  }
  return Math.min(Math.max(seconds, 0), longestRetryAfter) || 0;
}

// Returns the answer's status, body and retryAfter. Stops if the body has more than mostBytes, or if no data comes for
// stallTimeout.
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
        if (response.status === 401) { // for this token; another one may have been entered since
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

// Returns the list of models as bytes. If there is none, throws an error whose message says why; retryAfter is set if a busy
// server sent it.
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

// The latest previews, bytes by path, for the view and for the list's pictures, which need the same ones.
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

// The stored blobs of viewed models: sets of paths, by what the paths begin with.
const kept = new Map();
const keptSoon = new Map(); // promises of those sets

function learnKept(begin) {
  if (!keptSoon.has(begin)) {
    keptSoon.set(begin, storedPathsOf(begin).then((paths) => kept.set(begin, paths)));
  }
  return keptSoon.get(begin);
}

export const addKept = (path) => kept.get(beginOf(path))?.add(path);

// The same as `get`, but if the server cannot be reached, a stored text is used.
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
  #arrived = []; // blobs to store
  #described = new Set(); // models whose descriptions are stored
  #distrusted = new Set(); // blobs whose copy in the browser's cache may be damaged

  #streams;

  // changed: called whenever something has arrived for the viewer. streams: false: everything is fetched by GET, and nothing is
  // stored.
  constructor(viewer, changed, streams = true) {
    this.#viewer = viewer;
    this.#changed = changed;
    this.#streams = streams;
  }

  // Does what the viewer asks for. Call this after every input to the viewer.
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

  // Call this from time to time.
  tick() {
    this.#viewer.tick(now());
    this.exchange();
  }

  // Repeats now what would otherwise be repeated later.
  retryNow() {
    this.#viewer.retryNow();
    this.tick();
  }

  // Each blob that was fetched before comes from the server next time, not from the browser's cache: that keeps a damaged blob as
  // long as a good one.
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
    // Ignores messages of an abandoned connection.
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

  // A browser does not say why a connection failed. If the server answers other requests, it just has no stream for this page.
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

  // Call this when the browser has lost the network: a connection would only stall.
  drop() {
    if (this.#socket) {
      this.#socket.close();
      this.#ended(this.#socket, true);
    }
  }

  // Passes stored blobs to the viewer; ends at once if there are none. "again": the server cannot be reached, so blobs are read
  // even if they were not known to be stored.
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
