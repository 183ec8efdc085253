// SPDX-License-Identifier: BSD-3-Clause
// The WebAssembly has two parts (PartWasm.cmake): the first has the functions that run before the first picture, the second has
// all others. They share a memory, and a table of functions, to which the second part adds its own. Until the second part is
// loaded, the table has stubs. A stub that is called fetches the second part, and blocks the page meanwhile; so code that needs
// the second part waits for it first (rest.js).

import { imports, useMemory } from "./gl.js";

const addressOf = (name) => new URL(name, import.meta.url).href;
const secondPart = "kdstream-more.wasm";

let first; // the exports of the first part
let firstArrived;
const firstIsThere = new Promise((resolve) => (firstArrived = resolve));
let importModule; // the name under which the parts import each other; in another version it differs
let joined = false;
let join;

// Whether both parts are loaded; and a promise that is fulfilled then.
export const isWhole = () => joined;
export const whole = new Promise((resolve) => {
  join = () => {
    joined = true;
    resolve();
  };
});

// heard: called with the number of bytes so far, whenever some have arrived.
async function read(name, heard) {
  const response = await fetch(addressOf(name), { credentials: "same-origin" });
  if (!response.ok) {
    throw new Error(`the server says ${response.status}`);
  }
  const parts = [];
  let bytes = 0;
  const reader = response.body.getReader();
  for (let part; (part = await reader.read()).value;) {
    parts.push(part.value);
    bytes += part.value.length;
    heard(bytes);
  }
  return new Blob(parts).arrayBuffer();
}

// The stubs, by their index in the table.
const stubs = new Proxy({}, {
  get: (_, place) => (...values) => {
    console.error(`function ${place} is not there yet`); // later.txt must not name it, or its caller must wait
    joinAtOnce();
    return first.__indirect_function_table.get(Number(place))(...values);
  },
});

// A name that is not in `imports` is the one under which the parts import each other.
const given = new Proxy(imports, {
  get(known, name) {
    if (Object.hasOwn(known, name)) {
      return known[name];
    }
    importModule = name;
    return stubs;
  },
});

// Returns the exports of the first part.
export async function loadFirstPart(heard) {
  const { instance } = await WebAssembly.instantiate(await read("kdstream.wasm", heard), given);
  first = instance.exports;
  useMemory(first.memory);
  first._initialize();
  firstArrived();
  return first;
}

// Throws if the second part cannot be fetched, or does not fit; in the second case the error is `outdated`.
export async function loadSecondPart(heard) {
  const bytes = await read(secondPart, heard);
  await firstIsThere;
  try {
    await WebAssembly.instantiate(bytes, { [importModule]: first });
  } catch (error) {
    throw Object.assign(error, { outdated: true });
  }
  join();
}

// This may fail: some browsers refuse to compile large modules synchronously, and the server may be away. Then the viewer has
// stopped.
function joinAtOnce() {
  try {
    joinNow();
  } catch (error) {
    throw Object.assign(error, { isPartMissing: true });
  }
}

function joinNow() {
  const request = new XMLHttpRequest();
  request.open("GET", addressOf(secondPart), false);
  request.overrideMimeType("text/plain; charset=x-user-defined"); // one byte per character
  request.send();
  const bytes = Uint8Array.from(request.responseText, (character) => character.charCodeAt(0) & 0xff);
  new WebAssembly.Instance(new WebAssembly.Module(bytes), { [importModule]: first });
  join();
}
