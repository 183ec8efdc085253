// SPDX-License-Identifier: BSD-3-Clause
// The WebAssembly, which comes in two parts (PartWasm.cmake): the first has what runs until there is a picture, the second
// all else. They share a memory, and a table of functions, into which the second puts its own. Until it has come stand-ins
// are there: they fetch it, and the page stands still meanwhile. So who needs the second part waits for it first (rest.js).

import { imports, useMemory } from "./gl.js";

const addressOf = (name) => new URL(name, import.meta.url).href;
const secondPart = "kdstream-more.wasm";

let first; // what the first part exports
let firstCame;
const firstIsThere = new Promise((resolve) => (firstCame = resolve));
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

// By their place in the table.
const stubs = new Proxy({}, {
  get: (_, place) => (...values) => {
    console.error(`function ${place} is not there yet`); // it lacks a guard: later.txt
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
  firstCame();
  return first;
}

// Throws where it cannot be had; an error that is `outdated` where it is of another version.
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

// Some browsers compile so much only while the page goes on, and the server may be away: then the viewer has stopped.
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
