// SPDX-License-Identifier: BSD-3-Clause
// What the user decides about stored data (storage.js): to store models for offline use, the limit, and to remove everything.

import { done, freeBytes, limitKey, rangeOf, storageLimit, within } from "./storage.js";

export function setStorageLimit(bytes) {
  try {
    localStorage.setItem(limitKey, bytes);
  } catch {
    // then the usual limit is used
  }
  return within("readwrite", async (stores) => {
    const sum = await done(stores.texts.get("bytes")) ?? 0;
    await freeBytes(stores, sum - storageLimit());
  });
}

// Returns the bytes of all stored blobs.
export const storedBytes = () => within("readonly", async ({ texts }) => await done(texts.get("bytes")) ?? 0, 0);

// Pins those of the blobs that are stored, and returns their sizes by path. paths: a Set. begin: what all paths begin with.
export function pinBlobs(begin, paths) {
  return within("readwrite", async ({ entries }) => {
    const there = (await done(entries.getAll(rangeOf(begin)))).filter(({ path }) => paths.has(path));
    there.filter(({ pinned }) => !pinned).forEach((entry) => entries.put({ ...entry, pinned: 1 }));
    return new Map(there.map(({ path, size }) => [path, size]));
  }, new Map());
}

export async function emptyStorage() {
  await within("readwrite", ({ blobs, entries, texts }) => Promise.all([blobs, entries, texts].map((all) => done(all.clear()))));
}
