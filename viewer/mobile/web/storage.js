// SPDX-License-Identifier: BSD-3-Clause
// What this browser stores of a server's models, in IndexedDB: the list, descriptions, and blobs by their paths, which name
// model, digest and blob. (Each origin has its own database.) If all blobs together exceed the limit, those that were least
// recently used are removed, except blobs that the user has asked to store.
//
// If the browser does not allow storage, or if storage is full or was cleared, functions do nothing, or find nothing; then the
// network is used. A sum is stored in the same transaction as its terms, so several tabs can share the database.

const limits = [50e6, 200e6, 1e9];
export const limitKey = "kdstream.limit";

let opened = null; // promise of the database, or of null
export let trouble = ""; // why nothing can be stored, or ""

export const done = (request) => new Promise((resolve, reject) => {
  request.onsuccess = () => resolve(request.result);
  request.onerror = () => reject(request.error);
});

function open() {
  opened ??= new Promise((resolve) => {
    const give = (database) => {
      trouble = database ? "" : "this browser stores nothing for this page";
      resolve(database);
    };
    try {
      const request = indexedDB.open("kdstream", 1);
      request.onupgradeneeded = () => {
        const database = request.result;
        database.createObjectStore("blobs");
        database.createObjectStore("entries", { keyPath: "path" }).createIndex("used", ["pinned", "used"]);
        database.createObjectStore("texts");
      };
      request.onsuccess = () => {
        const forget = () => (opened = null); // cleared by the user, or needed by a newer version of the page
        request.result.onclose = forget;
        request.result.onversionchange = () => {
          request.result.close();
          forget();
        };
        give(request.result);
      };
      request.onerror = request.onblocked = () => give(null);
    } catch {
      give(null);
    }
  });
  return opened;
}

// Returns the result of `act`, which gets the stores; or `otherwise` if that is not possible.
export async function within(mode, act, otherwise) {
  const database = await open();
  if (!database) {
    return otherwise;
  }
  try {
    const names = ["blobs", "entries", "texts"];
    const transaction = database.transaction(names, mode);
    const ended = new Promise((resolve, reject) => {
      transaction.oncomplete = resolve;
      transaction.onabort = transaction.onerror = () => reject(transaction.error);
    });
    ended.catch(() => {}); // the error of `act` is the one to report, if it fails first
    const stores = Object.fromEntries(names.map((name) => [name, transaction.objectStore(name)]));
    const result = await act(stores);
    await ended;
    return result;
  } catch (error) {
    if (error?.name === "QuotaExceededError") {
      trouble = "the browser's storage is full";
    } else if (error?.name === "InvalidStateError") {
      opened = null; // the browser has closed the database
    }
    return otherwise;
  }
}

async function addBytes(texts, bytes) {
  const sum = (await done(texts.get("bytes")) ?? 0) + bytes;
  texts.put(Math.max(sum, 0), "bytes");
  return sum;
}

// Removes the least recently used blobs that are not pinned, until `bytes` are freed.
export async function freeBytes({ blobs, entries, texts }, bytes) {
  let freed = 0;
  const unpinned = IDBKeyRange.bound([0, 0], [0, Infinity]);
  const request = entries.index("used").openCursor(unpinned);
  for (let cursor; freed < bytes && (cursor = await done(request)); cursor.continue()) {
    freed += cursor.value.size;
    blobs.delete(cursor.value.path);
    entries.delete(cursor.value.path);
  }
  await addBytes(texts, -freed);
}

export function storageLimit() {
  try {
    const limit = Number(localStorage.getItem(limitKey));
    return limits.includes(limit) ? limit : limits[1];
  } catch {
    return limits[1];
  }
}

export const rangeOf = (begin) => IDBKeyRange.bound(begin, `${begin}\uffff`);

// Returns an ArrayBuffer, or null.
export function findBlob(path) {
  return within("readwrite", async ({ blobs, entries }) => {
    const [bytes, entry] = await Promise.all([done(blobs.get(path)), done(entries.get(path))]);
    if (!bytes || !entry) {
      return null;
    }
    entries.put({ ...entry, used: Date.now() });
    return bytes;
  }, null);
}

// all: [{ path, bytes }]. pinned: stored on request, so they are not removed to make room. Returns whether they were stored.
export async function storeBlobs(all, pinned = false) {
  const put = () => within("readwrite", async (stores) => {
    let grown = 0;
    for (const { path, bytes } of all) {
      const before = await done(stores.entries.get(path));
      grown += bytes.byteLength - (before?.size ?? 0);
      stores.blobs.put(bytes, path);
      stores.entries.put({ path, size: bytes.byteLength, used: Date.now(), pinned: pinned || before?.pinned ? 1 : 0 });
    }
    const sum = await addBytes(stores.texts, grown);
    if (sum > storageLimit()) {
      await freeBytes(stores, sum - 0.9 * storageLimit());
    }
    return true;
  }, false);
  if (await put()) {
    trouble = "";
    return true;
  }
  if (trouble && opened) { // storage is full: make room, and try once more
    const size = all.reduce((sum, { bytes }) => sum + bytes.byteLength, 0);
    await within("readwrite", (stores) => freeBytes(stores, 4 * size));
    return put();
  }
  return false;
}

// Whether the user has asked to store this blob.
export const isPinned = (path) => within("readonly", async ({ entries }) => Boolean((await done(entries.get(path)))?.pinned), false);

// The list of models and their descriptions are stored as bytes, under their paths.
export const findText = (path) => within("readonly", async ({ texts }) => await done(texts.get(path)) ?? null, null);
export const storeText = (path, bytes) => within("readwrite", ({ texts }) => done(texts.put(bytes, path)));

// Returns the paths of the blobs whose paths begin with `begin`.
export const storedPathsOf = (begin) => within("readonly",
  async ({ entries }) => new Set(await done(entries.getAllKeys(rangeOf(begin)))), new Set());

// Returns the paths of all descriptions and blobs, to mark stored models in the list.
export const storedPaths = () => within("readonly",
  async ({ entries, texts }) => new Set((await Promise.all([done(entries.getAllKeys()), done(texts.getAllKeys())])).flat()),
  new Set());
