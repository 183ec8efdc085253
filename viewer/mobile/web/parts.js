// SPDX-License-Identifier: BSD-3-Clause
// The WebAssembly has two parts (PartWasm.cmake): the first has what runs before the first picture, the second everything else.
// They share a memory, and a table of functions, to which the second adds its own. Until it is loaded there are stubs: they fetch
// it, and block the page meanwhile. So code that needs the second part waits for it first (rest.js).

import { imports, useMemory } from "./gl.js";

const addressOf = (name) => new URL(name, import.meta.url).href;
const secondPart = "kdstream-more.wasm";

let first; // what the first part exports
let firstArrived;
const firstIsThere = new Promise((resolve) => (firstArrived = resolve));
let importModule; // the name by which the parts know each other: those of another version have another one
let joined = false;
let join;

// Whether both parts are there; and a promise that is kept then.
export const isWhole = () => joined;
export const whole = new Promise((resolve) => {
  join = () => {
    joined = true;
    resolve();
  };
});

// heard: called whenever some of it has come, with the bytes so far.
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

// Stubs by their place in the table.
const stubs = new Proxy({}, {
  get: (_, place) => (...values) => {
    console.error(`function ${place} is not there yet`); // the function is missing in later.txt
    joinAtOnce();
    return first.__indirect_function_table.get(Number(place))(...values);
  },
});

// A name that is not ours is that of the parts for each other.
const given = new Proxy(imports, {
  get(known, name) {
    if (Object.hasOwn(known, name)) {
      return known[name];
    }
    importModule = name;
    return stubs;
  },
});

// Gives what it exports.
export async function loadFirstPart(heard) {
  const { instance } = await WebAssembly.instantiate(await read("kdstream.wasm", heard), given);
  first = instance.exports;
  useMemory(first.memory);
  first._initialize();
  firstArrived();
  return first;
}

// Throws if it cannot be fetched; the error is `outdated` if it is of another version.
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

// Some browsers compile parts only while the page runs, and the server may be away: then the viewer has stopped.
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
  request.overrideMimeType("text/plain; charset=x-user-defined"); // a byte a character
  request.send();
  const bytes = Uint8Array.from(request.responseText, (character) => character.charCodeAt(0) & 0xff);
  new WebAssembly.Instance(new WebAssembly.Module(bytes), { [importModule]: first });
  join();
}
