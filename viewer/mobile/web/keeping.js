// SPDX-License-Identifier: BSD-3-Clause
// What the user decides about stored data (storage.js): what is kept on purpose, at most how much, and that nothing is.

import { done, freeBytes, limitKey, rangeOf, storageLimit, within } from "./storage.js";

export function setStorageLimit(bytes) {
  try {
    localStorage.setItem(limitKey, bytes);
  } catch {
    // then it is the usual one
  }
  return within("readwrite", async (stores) => {
    const sum = await done(stores.texts.get("bytes")) ?? 0;
    await freeBytes(stores, sum - storageLimit());
  });
}

// Of all blobs.
export const storedBytes = () => within("readonly", async ({ texts }) => await done(texts.get("bytes")) ?? 0, 0);

// Pins those of the blobs that are there; gives their sizes by their paths. begin: of all the paths, a Set.
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
