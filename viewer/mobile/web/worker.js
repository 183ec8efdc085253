// SPDX-License-Identifier: BSD-3-Clause
// The service worker: stores the page's own files, so that the page opens without a network. They are all of one version, or none
// is stored; the version's digests are built in (MakePage.cmake). If the server has another version by now, storing is tried
// again next time. Models are stored by storage.js.

/* global pageVersion, pageFiles: { "page.js": SHA-256 } */

const { scope } = self.registration;
const ours = `kdstream page ${scope} `; // the caches of an origin are shared by all its paths
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

// Languages that this browser does not ask for are not stored with the page.
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

// If a file is missing, the browser has cleared the storage. Then all files come from the server, until there is a new version.
// Exception: a language that only the URL or the page asks for is stored when it is first used.
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

// The page of a model (m/ID), or of all models (m/), is the same page, but in a folder below. What a server adds to its head is
// not for browsers.
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
