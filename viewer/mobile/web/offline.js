// SPDX-License-Identifier: BSD-3-Clause
// What works without a network: the page's own files (worker.js), models that the user has stored, and the options about both.
// line.js stores what was only viewed. Fetched after the first picture.

import { makeButton } from "./elements.js";
import { emptyStorage, pinBlobs, setStorageLimit, storedBytes } from "./keeping.js";
import { addKept, get, isOffline, mayKeep } from "./line.js";
import { make } from "./list.js";
import { refusalOf } from "./refusal.js";
import { findText, storageLimit, storeBlobs, storeText, trouble as storageTrouble } from "./storage.js";
import { kilobytes, nameOfLevel, t } from "./words.js";

const find = (id) => document.getElementById(id);
const previewLevel = 11; // one piece in every model
const atOnce = 4; // requests at the same time
const mostBlobBytes = 64 << 20;
const size = (bytes) => kilobytes(bytes, bytes < 1e7 ? 1 : 0);

// ---- the list of a model's blobs: doc/protocol.md

function* nodesOf(depth) {
  for (let node = 2 ** depth; node < 2 ** (depth + 1); ++node) {
    yield node;
  }
}

// Yields the blobs of `goal` (a level, or "original"), and of everything coarser.
function* blobsUpTo(goal, { partition_depth: depth, levels, textures }) {
  yield "tree/1";
  for (let page = depth - 5; depth >= 10 && page >= 5; page -= 5) {
    for (const node of nodesOf(page)) {
      yield `tree/${node}`;
    }
  }
  for (const node of nodesOf(Math.max(0, depth - 5))) {
    yield `boxes/${node}`;
  }
  for (const { depth: level } of levelsUpTo(goal, levels)) {
    for (const node of nodesOf(Math.min(depth, Math.max(0, level - previewLevel)))) {
      yield `levels/${level}/${node}`;
      if (textures?.levels) {
        yield `level-textures/${level}/${node}`;
      }
    }
  }
  for (let partition = 0; goal === "original" && partition < 2 ** depth; ++partition) {
    yield `partitions/${partition}`;
    if (textures) {
      yield `textures/${partition}`;
    }
  }
}

function levelsUpTo(goal, levels) {
  const coarsest = Math.min(previewLevel, levels.length - 1);
  return levels.filter(({ depth }) => depth >= coarsest && (goal === "original" || depth <= goal));
}

function bytesUpTo(goal, { levels, original, textures }) {
  const sum = levelsUpTo(goal, levels).reduce((bytes, level) => bytes + level.bytes + (level.tile_bytes ?? 0), 0);
  return sum + (goal === "original" ? original.bytes + (textures?.bytes ?? 0) : 0);
}

// ---- storing a model on request

// run: null while the job is paused; answers to requests of an earlier run are ignored. paths: of all its blobs. begin: what the
// paths begin with. absent: paths of blobs that do not exist.
let job = null; // { id, goal, run, done, all, bytes, trouble, begin, paths, absent }

const newJob = (id, trouble = "") => ({ id, run: null, done: 0, all: 0, bytes: 0, trouble, absent: new Set() });

// Counts what is stored already, and pins it. Returns the paths that are missing.
async function countKept(own) {
  const there = await pinBlobs(own.begin, own.paths);
  const left = [...own.paths].filter((path) => !there.has(path) && !own.absent.has(path));
  own.done = own.all - left.length;
  own.bytes = [...there.values()].reduce((sum, bytes) => sum + bytes, 0);
  return left;
}

// Another tab, or the browser, may have cleared the storage.
async function checkKept(own) {
  await countKept(own);
  if (!await findText(descriptionOf(own.id))) {
    own.done = Math.min(own.done, own.all - 1);
  }
  if (own.done < own.all) {
    own.trouble = t("some stored data was removed");
  }
}

async function keepModel(own, { id, digest, ...description }) {
  const run = (own.run = {});
  own.begin = `/api/models/${id}/${digest}/`;
  own.paths = new Set([...blobsUpTo(own.goal, description)].map((blob) => own.begin + blob));
  own.all = own.paths.size;
  own.trouble = "";
  const next = (await countKept(own)).values();
  const work = async () => {
    for (const path of next) {
      if (own.run !== run) {
        return;
      }
      await keepBlob(own, run, path);
      showOffline();
    }
  };
  await Promise.all(Array.from({ length: atOnce }, work));
  if (own.run === run) {
    await checkKept(own);
    own.run = null;
  }
}

// Fetches and stores a blob. An error pauses the job.
async function keepBlob(own, run, path) {
  const pause = (trouble) => {
    if (own.run === run) {
      own.run = null;
      own.trouble = trouble;
    }
  };
  const { status, bytes } = await get(path, mostBlobBytes).catch(() => ({ status: 0 }));
  if (own.run !== run) {
    return;
  }
  if (status === 200) {
    const isTooMuch = await storedBytes() + bytes.byteLength > storageLimit();
    if (own.run !== run) {
      return;
    }
    if (isTooMuch) {
      return pause(t("the limit is reached"));
    }
    if (!await storeBlobs([{ path, bytes: bytes.buffer }], true)) {
      return pause(t(storageTrouble || "it cannot be stored"));
    }
    addKept(path);
  } else if (status === 404) { // nodes without vertices have no blob
    own.absent.add(path);
  } else {
    return pause(status ? refusalOf(status) : t("the server cannot be reached"));
  }
  if (own.run === run) {
    own.bytes += status === 200 ? bytes.byteLength : 0;
    ++own.done;
  }
}

const descriptionOf = (id) => `/api/models/${id}/model.json`;

async function describe(id) {
  const path = descriptionOf(id);
  const { status, bytes } = await get(path, mostBlobBytes);
  if (status !== 200) {
    throw new Error(refusalOf(status));
  }
  await storeText(path, bytes);
  return JSON.parse(new TextDecoder().decode(bytes));
}

async function startOrPause() {
  if (job.run) {
    job.run = null;
  } else {
    try {
      const description = await describe(job.id);
      job.goal = find("keep-goal").value === "original" ? "original" : Number(find("keep-goal").value);
      await keepModel(job, description);
    } catch (error) {
      job.trouble = isOffline() ? t("the server cannot be reached") : error.message;
    }
  }
  showOffline();
}

// ---- the options

let changed = () => {};

function describeJob() {
  if (job.trouble) {
    return t("Paused: {why}.", { why: job.trouble });
  }
  const part = t("{done} of {all} parts, {bytes}", { done: job.done, all: job.all, bytes: size(job.bytes) });
  if (!job.all) {
    return "";
  }
  return job.done === job.all ? t("Stored: it opens offline.") : job.run ? `${part} …` : t("Paused after {part}", { part });
}

async function showOffline() {
  find("keep").textContent = t(job?.run ? "Pause" : job?.done < job?.all ? "Go on" : "Keep offline");
  find("keep-goal").disabled = Boolean(job?.run);
  find("keep-state").textContent = job ? describeJob() : "";
  const bytes = await storedBytes();
  find("stored").textContent = storageTrouble
    ? t("Nothing more can be stored: {why}.", { why: t(storageTrouble) })
    : t("{bytes} of {limit} are used.", { bytes: size(bytes), limit: size(storageLimit()) });
  changed();
}

// Shows the options for the open model. listener: called whenever the stored data has changed.
export async function openOfflineOptions(id, listener) {
  find("offline").hidden = !mayKeep();
  if (!mayKeep()) {
    return;
  }
  if (changed !== listener) {
    changed = listener;
    makeOfflineOptions();
  }
  if (job?.id !== id && !job?.run) {
    job = newJob(id);
    find("keep-goal").replaceChildren();
    describe(id).then((description) => {
      const goals = [...levelsUpTo("original", description.levels).map(({ depth }) => depth), "original"];
      find("keep-goal").replaceChildren(...goals.map((goal) => new Option(
        `${nameOfLevel(goal === "original" ? -1 : goal)}, ${size(bytesUpTo(goal, description))}`, goal)));
      find("keep-goal").value = "original";
    }, () => {});
  }
  if (job.all && !job.run && job.done === job.all) {
    await checkKept(job);
  }
  find("limit").value = storageLimit();
  await showOffline();
}

function makeOfflineOptions() {
  const row = (...children) => make("div", { className: "row" }, ...children);
  const limit = make("select", { id: "limit", ariaLabel: t("Storage limit") }, new Option(t("At most 50 MB"), 5e7),
    new Option(t("At most 200 MB"), 2e8), new Option(t("At most 1 GB"), 1e9));
  limit.addEventListener("change", async () => {
    await setStorageLimit(Number(limit.value));
    showOffline();
  });
  const empty = async () => {
    if (job) {
      const wasKeeping = job.run;
      job.run = null; // answers to its requests are then ignored
      job = newJob(job.id, wasKeeping ? t("all stored data was removed") : "");
    }
    await emptyStorage();
    showOffline();
  };
  find("offline").replaceChildren(make("legend", { textContent: t("Offline") }),
    row(make("select", { id: "keep-goal", ariaLabel: t("Detail to store") }),
      makeButton("Keep offline", startOrPause, { id: "keep", className: "plain" })),
    make("p", { id: "keep-state", role: "status" }),
    row(limit, makeButton("Empty", empty, { id: "empty-storage", className: "plain" })),
    make("p", { id: "stored" }));
}

// ---- the page's own files

// Stores the page's own files. updated: called if there is a newer version of the page, with a function that switches to it.
export async function keepPage(updated) {
  try {
    const registration = await navigator.serviceWorker?.register(new URL("worker.js", import.meta.url));
    const look = (worker) => {
      const tell = () => worker.state === "installed" && navigator.serviceWorker.controller && updated(() => {
        navigator.serviceWorker.addEventListener("controllerchange", () => location.reload());
        worker.postMessage("take over");
      });
      worker.addEventListener("statechange", tell);
      tell();
    };
    registration?.addEventListener("updatefound", () => registration.installing && look(registration.installing));
    for (const worker of [registration?.waiting, registration?.installing]) {
      worker && look(worker);
    }
  } catch {
    // not possible over plain HTTP, or if the user forbids it: then the page needs its server
  }
}
