// SPDX-License-Identifier: BSD-3-Clause
// The service worker: stores the page's own files, so that the page opens without a network. They are of one version, all or
// none, whose digests are built in (MakePage.cmake); if a server has another version in between, it is asked again next time.
// storage.js stores models.

/* global pageVersion, pageFiles: { "page.js": SHA-256 } */

const { scope } = self.registration;
const ours = `kdstream page ${scope} `; // paths of an origin share its caches
const name = ours + pageVersion;
const addressOf = (file) => new URL(file, scope).href;

async function digestOf(bytes) {
  const digest = new Uint8Array(await crypto.subtle.digest("SHA-256", bytes));
  return [...digest].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}

async function fetchFile([file, digest]) {
  const answer = await fetch(addressOf(file), { cache: "no-cache" });
  if (!answer.ok || await digestOf(await answer.clone().arrayBuffer()) !== digest) {
    throw new Error(`${file} is not of this version`);
  }
  return [addressOf(file), answer];
}

// Languages but this browser's are not kept.
const languages = navigator.languages.map((each) => `words/${each.split("-")[0].toLowerCase()}.js`);
const isKept = (file) => !file.startsWith("words/") || languages.includes(file);

async function keepFiles() {
  const answers = await Promise.all(Object.entries(pageFiles).filter(([file]) => isKept(file)).map(fetchFile));
  const cache = await caches.open(name);
  await Promise.all(answers.map(([address, answer]) => cache.put(address, answer)));
}

async function dropOthers() {
  const names = await caches.keys();
  await Promise.all(names.filter((other) => other.startsWith(ours) && other !== name).map((other) => caches.delete(other)));
}

// If a file is missing, the browser has cleared the storage: then all come from the server, until the next version. A language
// that the URL or the page asks for, but not the browser, is stored when it is first used.
async function answerWith(file, request) {
  const cache = await caches.open(name).catch(() => null);
  const kept = await cache?.match(addressOf(file)).catch(() => null);
  if (!kept && !isKept(file)) {
    const [address, answer] = await fetchFile([file, pageFiles[file]]).catch(() => []);
    answer && await cache?.put(address, answer.clone()).catch(() => {});
    return answer ?? fetch(request);
  }
  if (!kept) {
    await caches.delete(name).catch(() => false);
  }
  return kept ?? fetch(request);
}

// The page of a model (m/ID), or of all of them (m/), is the same page, seen from a folder below. The head that a server gives it is not for browsers.
async function answerWithModel(up, request) {
  const cache = await caches.open(name).catch(() => null);
  const kept = await cache?.match(addressOf("index.html")).catch(() => null);
  return kept ? new Response((await kept.text()).replace(/ (href|src)="/g, ` $1="${up}`), kept) : fetch(request);
}

self.addEventListener("install", (event) => event.waitUntil(keepFiles()));
self.addEventListener("activate", (event) => event.waitUntil(dropOthers()));
self.addEventListener("message", ({ data }) => data === "take over" && self.skipWaiting());
self.addEventListener("fetch", (event) => {
  const [address] = event.request.url.split(/[?#]/);
  const file = address === scope ? "index.html" : address.startsWith(scope) ? address.slice(scope.length) : "";
  if (event.request.method === "GET" && Object.hasOwn(pageFiles, file)) {
    event.respondWith(answerWith(file, event.request));
  } else if (event.request.mode === "navigate" && /^m\/([^/]+\/?)?$/.test(file)) {
    event.respondWith(answerWithModel("../".repeat(file.split("/").length - 1), event.request));
  }
});
