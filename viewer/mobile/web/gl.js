// SPDX-License-Identifier: BSD-3-Clause
// The functions that the viewer in WebAssembly calls: OpenGL ES 3 as a WebGL 2 context, and a clock.
//
// In WebAssembly, WebGL objects are numbers; 0 means none.

const objects = new WeakMap(); // by context: its objects by number, and its uniforms' places; freed with the context
let things; // the current context's objects by number
let places; // the current context's uniforms: their numbers, by the program's number and the uniform's name
let lastThing = 0;

let gl = null;
let memory = null;

// Returns the canvas's WebGL 2 context, or null.
export function gainCanvas(canvas) {
  const context = canvas.getContext("webgl2", { alpha: false });
  context && forgetObjects(context);
  return context;
}

// Forgets a context's objects, because the context is new, or was lost together with them.
export function forgetObjects(context) {
  objects.set(context, [new Map(), new Map()]);
}

// Makes later calls draw into this context.
export function useContext(context) {
  gl = context;
  [things, places] = objects.get(context) ?? [];
}

// Sets the memory that the viewer exports.
export function useMemory(exported) {
  memory = exported;
}

export const bytesAt = (begin, count) => new Uint8Array(memory.buffer, begin, count);
const integers = (begin, count) => new Int32Array(memory.buffer, begin, count);
const floats = (begin, count) => new Float32Array(memory.buffer, begin, count);

function textAt(begin) {
  const all = bytesAt(begin);
  return new TextDecoder().decode(all.slice(0, all.indexOf(0)));
}

// Writes a text of at most `most` bytes, including the final 0.
function putText(text, most, begin) {
  const { written } = new TextEncoder().encodeInto(text ?? "", bytesAt(begin, most - 1));
  bytesAt(begin, most)[written] = 0;
}

function numberOf(thing) {
  if (thing) {
    things.set(++lastThing, thing);
  }
  return thing ? lastThing : 0;
}

const thingOf = (number) => things.get(number) ?? null;

// glGen… and glDelete…: there are `count` numbers at `begin`.
const makeSome = (make) => (count, begin) => {
  for (let i = 0; i < count; ++i) {
    integers(begin, count)[i] = numberOf(gl[make]());
  }
};

const deleteSome = (drop) => (count, begin) => {
  for (const number of integers(begin, count)) {
    gl[drop](thingOf(number));
    things.delete(number);
  }
};

// Pictures of textures: the browser decodes them in the background.
const mimeTypes = ["", "image/jpeg", "image/png", "image/webp"]; // TileImage
let waitingPictures = 0;
let onPictures = () => {};
let nextCall = 0; // ms

export const picturesAreWaiting = () => waitingPictures > 0;

// loaded: called when some pictures have been decoded, and when all have been.
export function listenToPictures(loaded) {
  onPictures = loaded;
}

// Replaces the texture's content once the picture has been decoded. If it cannot be decoded, has another size, or is too large
// for the device, the vertices' colours stay.
async function uploadPicture(number, begin, count, format, width, height) {
  const [context, owners, texture] = [gl, things, thingOf(number)];
  const bytes = new Blob([bytesAt(begin, count).slice()], { type: mimeTypes[format] });
  ++waitingPictures;
  try {
    const picture = await createImageBitmap(bytes, { premultiplyAlpha: "none", colorSpaceConversion: "none" });
    if (picture.width === width && picture.height === height && owners.get(number) === texture
      && Math.max(width, height) <= context.getParameter(context.MAX_TEXTURE_SIZE)) {
      const target = context.TEXTURE_2D;
      context.bindTexture(target, texture);
      context.texImage2D(target, 0, context.RGB, context.RGB, context.UNSIGNED_BYTE, picture);
      context.texParameteri(target, context.TEXTURE_MAX_LEVEL, 2);
      context.generateMipmap(target);
    }
    picture.close();
  } catch {
    // it is not a picture; vertex colours stay
  }
  --waitingPictures;
  if (!waitingPictures || performance.now() >= nextCall) {
    nextCall = performance.now() + 500;
    onPictures();
  }
}

const functions = {
  kdstream_upload_picture: uploadPicture,
  emscripten_performance_now: () => performance.now(),
  emscripten_notify_memory_growth() {},

  glBufferData: (target, size, begin, usage) => gl.bufferData(target, bytesAt(begin, size), usage),
  glClearDepthf: (depth) => gl.clearDepth(depth),
  glCreateProgram: () => numberOf(gl.createProgram()),
  glCreateShader: (kind) => numberOf(gl.createShader(kind)),
  glDeleteBuffers: deleteSome("deleteBuffer"),
  glDeleteFramebuffers: deleteSome("deleteFramebuffer"),
  glDeleteTextures: deleteSome("deleteTexture"),
  glDeleteVertexArrays: deleteSome("deleteVertexArray"),
  glGenBuffers: makeSome("createBuffer"),
  glGenFramebuffers: makeSome("createFramebuffer"),
  glGenTextures: makeSome("createTexture"),
  glGenVertexArrays: makeSome("createVertexArray"),
  // Called only for the version, and for the bound framebuffer, which is the canvas's.
  glGetIntegerv(name, begin) {
    integers(begin, 1)[0] = gl && name !== gl.DRAW_FRAMEBUFFER_BINDING ? 3 : 0;
  },
  glGetProgramInfoLog: (program, most, length, begin) => putText(gl.getProgramInfoLog(thingOf(program)), most, begin),
  glGetProgramiv(program, name, begin) {
    integers(begin, 1)[0] = gl.getProgramParameter(thingOf(program), name);
  },
  glGetShaderInfoLog: (shader, most, length, begin) => putText(gl.getShaderInfoLog(thingOf(shader)), most, begin),
  glGetShaderiv(shader, name, begin) {
    integers(begin, 1)[0] = gl.getShaderParameter(thingOf(shader), name);
  },
  glGetUniformLocation(program, begin) {
    const name = textAt(begin);
    const key = `${program} ${name}`;
    if (!places.has(key)) {
      places.set(key, numberOf(gl.getUniformLocation(thingOf(program), name)));
    }
    return places.get(key);
  },
  glShaderSource: (shader, count, begin) =>
    gl.shaderSource(thingOf(shader), [...integers(begin, count)].map(textAt).join("")),
  glTexImage2D: (target, level, inner, width, height, border, format, type, begin) =>
    gl.texImage2D(target, level, inner, width, height, border, format, type, bytesAt(begin, 4)), // one texel
  glUniform3fv: (place, count, begin) => gl.uniform3fv(thingOf(place), floats(begin, 3 * count)),
  glUniformMatrix3fv: (place, count, transpose, begin) =>
    gl.uniformMatrix3fv(thingOf(place), false, floats(begin, 9 * count)),
};

// All other functions are the same in WebGL; the digits are the positions of arguments that are objects.
const alike = [
  ["", "activeTexture blendFunc checkFramebufferStatus clear colorMask depthFunc depthMask disable disableVertexAttribArray drawArrays drawElements enable enableVertexAttribArray getError texParameteri texStorage2D vertexAttrib4f vertexAttribPointer viewport"],
  ["0", "bindVertexArray compileShader linkProgram uniform1f uniform1i uniform2f uniform3f uniform4f useProgram"],
  ["1", "bindBuffer bindFramebuffer bindTexture"],
  ["3", "framebufferTexture2D"],
  ["01", "attachShader"],
];
for (const [objects, names] of alike) {
  for (const name of names.split(" ")) {
    functions["gl" + name[0].toUpperCase() + name.slice(1)] = (...values) =>
      gl[name](...values.map((value, place) => objects.includes(place) ? thingOf(value) : value));
  }
}
for (const kind of ["Program", "Shader"]) {
  functions["glDelete" + kind] = (number) => {
    gl["delete" + kind](thingOf(number));
    things.delete(number);
  };
}

function proc_exit() {
  throw new Error("aborted");
}

export const imports = { env: functions, wasi_snapshot_preview1: { proc_exit } };
