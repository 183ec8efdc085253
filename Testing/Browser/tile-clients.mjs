// SPDX-License-Identifier: BSD-3-Clause
// Tests tilesets of kdstream-store export --format 3dtiles in other people's clients, in Chromium, from a plain folder:
// 3d-tiles-renderer with three.js, and Cesium. Run it by hand or by ./dev bench tiles:
//
//   node tile-clients.mjs check PROGRAMS STORE TILESET [N]      checks all tiles' boxes, errors and triangles;
//                                                               every Nth tile is validated and decoded
//   node tile-clients.mjs show PROGRAMS STORE TILESET OUT [CESIUM]  pictures together with kdstream-view's:
//                                                               OUT/NAME-turn-T-zoom-Z.png; CESIUM: the folder of
//                                                               npm's package; without it only three.js is used
//   node tile-clients.mjs bytes PROGRAMS STORE TILESET          bytes until at most 5 % of the pixels are wrong;
//                                                               the larger number of two directions
//   node tile-clients.mjs fly TILESET [MB [STEPS [HOW]]]        memory of the browser while it flies over the
//                                                               model, and of empty pages; MB: the size of the
//                                                               cache; HOW: plain or sparing (doc/3dtiles.md)

import { spawnSync } from "node:child_process";
import { once } from "node:events";
import { closeSync, existsSync, mkdirSync, mkdtempSync, openSync, readFileSync, readSync, rmSync, statSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { basename, extname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { chromium } from "playwright-core";
import { PNG } from "pngjs";
import { allTiles, readTile, readTileset } from "./tileset.mjs";

const width = 800, height = 480; // of every picture, as in ./dev bench view
const viewAngle = 30; // degrees, vertical: kdstream-view's
export const turns = [0, 7]; // of the directions of ./dev bench view

function run(programs, name, ...options) {
  const { status, stdout, stderr, error } = spawnSync(join(programs, name), options, { encoding: "utf8", maxBuffer: 1 << 28 });
  if (status !== 0) {
    throw new Error(`${name} ${options.join(" ")}: ${error ?? stderr}`);
  }
  return stdout;
}

function withFolder(use) {
  const folder = mkdtempSync(join(tmpdir(), "kdstream-tiles-"));
  try {
    return use(folder);
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
}

// ---- files on the disk

// The JSON of a .glb; the rest of the file is not read.
function headOf(file) {
  const opened = openSync(file, "r");
  try {
    const head = Buffer.alloc(20);
    readSync(opened, head, 0, 20, 0);
    const json = Buffer.alloc(head.readUInt32LE(12));
    readSync(opened, json, 0, json.length, 20);
    return JSON.parse(json);
  } finally {
    closeSync(opened);
  }
}

const levelOf = (content) => content.split("/")[0];

export async function checkTileset(programs, store, folder, every = 1) {
  const { default: validator } = await import("gltf-validator");
  const info = JSON.parse(run(programs, "kdstream-store", "info", store, "--json"));
  const root = readTileset(folder); // it names only files that exist; roots of external tilesets agree with it
  const tiles = allTiles(root).filter(({ content }) => content);
  const size = Math.hypot(root.box[3], root.box[7], root.box[11]);
  const levels = new Map(); // tiles, triangles, bytes
  const wrong = [];
  const inside = (point, box, margin) => [0, 1, 2].every((k) => Math.abs(point[k] - box[k]) <= box[3 + 4 * k] + margin);
  const corners = ({ box }) => [-1, 1].map((sign) => [0, 1, 2].map((k) => box[k] + sign * box[3 + 4 * k]));
  for (const tile of allTiles(root)) { // including groups of partitions, which have no content
    const name = tile.content ?? tile.tileset;
    for (const child of tile.children) {
      if (child.error > tile.error || !corners(child).every((corner) => inside(corner, tile.box, 1e-9 * size))) {
        wrong.push(`${child.content ?? child.tileset}: its box leaves its parent's, or its error is larger`);
      }
    }
    if (tile.children.length > 0 ? !(tile.error > 0) : tile.error !== 0) {
      wrong.push(`${name}: an error of ${tile.error}`);
    }
  }
  let validated = 0;
  for (const [i, tile] of tiles.entries()) {
    const file = join(folder, tile.content);
    const gltf = headOf(file);
    const level = levels.get(levelOf(tile.content)) ?? { tiles: 0, triangles: 0, bytes: 0 };
    levels.set(levelOf(tile.content), level);
    level.tiles += 1;
    level.bytes += statSync(file).size;
    for (const { indices, extras } of gltf.meshes[0].primitives) {
      level.triangles += indices === undefined || extras?.skirt ? 0 : gltf.accessors[indices].count / 3;
    }
    if (i % every === 0) {
      ++validated;
      const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(file)), { maxIssues: 0 });
      const { primitives } = await readTile(file);
      if (issues.numErrors + issues.numWarnings > 0) {
        wrong.push(`${tile.content}: ${JSON.stringify(issues.messages)}`);
      }
      for (const { positions, indices } of primitives) {
        if (!positions.every((point) => inside(point, tile.box, 0)) || indices?.some((index) => index >= positions.length)) {
          wrong.push(`${tile.content}: vertices outside of its box, or missing ones`);
        }
      }
    }
  }
  for (const [level, { triangles }] of levels) {
    const expected = level === "original" ? info.triangles : info.levels.find(({ depth }) => String(depth) === level).triangles;
    if (triangles !== expected) {
      wrong.push(`level ${level}: ${triangles} triangles instead of ${expected}`);
    }
  }
  return { levels, tiles: tiles.length, validated, wrong };
}

// ---- cameras

// The place of the eye in a link (viewer/session/ViewLink.cxx): lengths are in radii of the sphere around the model's
// box, from its middle.
function placeOf(link) {
  const bytes = Buffer.from(/view=([\w-]+)/.exec(link)[1], "base64url");
  let at = 1;
  const take = (half, count) => {
    const whole = bytes.readUIntBE(at, count);
    at += count;
    return (whole / (2 ** (8 * count) - 2) - 0.5) * 2 * half;
  };
  const focal = [take(16, 5), take(16, 5), take(16, 5)];
  const distance = take(16, 5) + 16;
  const turn = [take(1, 3), take(1, 3), take(1, 3), take(1, 3)]; // w x y z
  const length = Math.hypot(...turn);
  return { focal, distance, turn: turn.map((part) => part / length) };
}

function product(a, b) { // of matrices, stored by columns
  return Array.from({ length: 16 }, (_, i) => [0, 1, 2, 3].reduce((sum, k) => sum + a[4 * k + i % 4] * b[4 * (i >> 2) + k], 0));
}

// The camera's matrix in the tileset: its columns are right, up, back and the eye. radius: of the sphere.
function cameraOf({ focal, distance, turn: [w, x, y, z] }, radius, transform) {
  const right = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)];
  const up = [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)];
  const back = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)];
  const eye = focal.map((coordinate, k) => radius * (coordinate + distance * back[k]));
  const away = Math.hypot(...eye);
  const near = Math.max(away - 1.2 * radius, 0.05 * distance * radius);
  return { matrix: product(transform, [...right, 0, ...up, 0, ...back, 0, ...eye, 1]), near, far: away + 1.2 * radius, viewAngle };
}

// The picture of kdstream-view from a direction (of ./dev bench view) at a zoom, and the place of its eye.
function ownView(programs, store, turn, zoom) {
  return withFolder((folder) => {
    const steps = [{ select: basename(store, ".kds") }, { wait: "idle" }];
    let t = 0;
    const swipe = (from, to) => steps.push({ t: (t += 1), touches: [{ id: 1, x: from[0], y: from[1] }] },
      { t: (t += 0.1), touches: [{ id: 1, x: to[0], y: to[1] }] }, { t: (t += 0.1), touches: [] });
    for (let i = 0; i < turn % 4; ++i) {
      swipe([290, 240], [510, 240]);
    }
    swipe([400, 240], [401, 240 + [0, 90, -90][turn >> 2]]);
    steps.push({ select: basename(store, ".kds") }, { zoom, x: 400, y: 240 }, { wait: "idle" }, { screenshot: "own.png" });
    writeFileSync(join(folder, "session.jsonl"), steps.map((step) => `${JSON.stringify(step)}\n`).join(""));
    const { status, stderr } = spawnSync(resolve(programs, "kdstream-view"), [resolve(store), "--offscreen", "auto", "--size", `${width}x${height}`,
      "--light", "plain", "--replay", "session.jsonl", "--report", "report.json"], { cwd: folder, encoding: "utf8" });
    if (status !== 0) {
      throw new Error(`kdstream-view: ${stderr}`);
    }
    const report = JSON.parse(readFileSync(join(folder, "report.json"), "utf8"));
    return { place: placeOf(report.link), picture: readFileSync(join(folder, "own.png")), bytes: report.bytes, triangles: report.peak_triangles };
  });
}

function radiusOf(programs, store) {
  return withFolder((folder) => {
    run(programs, "kdstream-store", "export", store, folder, "--model", "m", "--quiet");
    const { box } = JSON.parse(readFileSync(join(folder, "api/models/m/model.json"), "utf8"));
    return Math.hypot(...[0, 1, 2].map((k) => (box.hi[k] - box.lo[k]) / 2));
  });
}

// ---- pages: each has open(tileset, options), look(camera), and settle(), which draws

// The light is that of kdstream-view (viewer/session/appearance/SceneAppearance.h), whatever the client usually does,
// so that pictures can be compared.
const stone = "vec3(217.0, 208.0, 192.0) / 255.0"; // kdstream-view draws models without colours in this colour
const lit = `
vec3 litAsKdStream(vec3 base, vec3 normal, vec3 toEye) {
  vec3 at[2]; at[0] = normalize(vec3(-0.75, 0.95, 0.75)); at[1] = normalize(vec3(0.3, 0.2, 1.0));
  vec3 color[2]; color[0] = 0.8 * vec3(1.0, 0.97, 0.91); color[1] = 0.36 * vec3(0.92, 0.95, 1.0);
  vec3 diffuse = vec3(0.0), specular = vec3(0.0);
  for (int i = 0; i < 2; ++i) {
    float facing = dot(normal, at[i]);
    if (facing > 0.0) {
      diffuse += facing * color[i];
      specular += pow(max(0.0, dot(reflect(-at[i], normal), toEye)), 30.0) * color[i];
    }
  }
  return min(base * (0.15 + 0.85 * diffuse) + ${stone} * 0.14 * specular, 1.0);
}`;

const threePage = `<!doctype html><style>body { margin: 0 } canvas { display: block }</style>
<script type="importmap">{ "imports": { "three": "/npm/three/build/three.module.js", "three/addons/": "/npm/three/examples/jsm/",
  "3d-tiles-renderer/three": "/npm/3d-tiles-renderer/build/index.three.js", "meshoptimizer": "/npm/meshoptimizer/meshopt_decoder.mjs" } }</script>
<script type="module">
import * as THREE from "three";
import { DRACOLoader } from "three/addons/loaders/DRACOLoader.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { TilesRenderer } from "3d-tiles-renderer/three";
import { MeshoptDecoder } from "meshoptimizer";

const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true, antialias: true });
document.body.append(renderer.domElement);
const camera = new THREE.PerspectiveCamera(${viewAngle}, ${width / height});
camera.matrixAutoUpdate = false;
const loader = new GLTFLoader();
loader.setMeshoptDecoder(MeshoptDecoder);
loader.setDRACOLoader(new DRACOLoader().setDecoderPath("/npm/three/examples/jsm/libs/draco/gltf/"));
let tiles, scene, failed, reference;

function shade(mesh) {
  const { map, vertexColors, side } = mesh.material;
  mesh.material.dispose();
  if (map) {
    map.colorSpace = THREE.NoColorSpace; // kept as it is written
  }
  mesh.material = new THREE.ShaderMaterial({
    side, vertexColors, uniforms: { map: { value: map } },
    vertexShader: \`varying vec3 place, direction, tint; varying vec2 texel;
      void main() {
        vec4 seen = modelViewMatrix * vec4(position, 1.0);
        place = seen.xyz; direction = normalMatrix * normal; texel = uv; tint = vec3(1.0);
        #ifdef USE_COLOR_ALPHA
          tint = color.rgb;
        #elif defined(USE_COLOR)
          tint = color;
        #endif
        gl_Position = projectionMatrix * seen;
      }\`,
    fragmentShader: \`varying vec3 place, direction, tint; varying vec2 texel; uniform sampler2D map;
      \${${JSON.stringify(lit)}}
      vec3 srgb(vec3 c) { return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c)); }
      void main() {
        vec3 normal = normalize(direction) * (gl_FrontFacing ? 1.0 : -1.0);
        vec3 base = \${map ? "texture2D(map, texel).rgb" : vertexColors ? "srgb(tint)" : "${stone}"};
        gl_FragColor = vec4(litAsKdStream(base, normal, normalize(-place)), 1.0);
      }\`,
  });
}

// What doc/3dtiles.md recommends where memory is short.
const common = [THREE.DoubleSide, THREE.FrontSide].map((side) => new THREE.MeshStandardMaterial({ side }));
function spare({ scene: model, tile }) {
  model.traverse((mesh) => {
    for (const attribute of mesh.isMesh ? [mesh.geometry.index, ...Object.values(mesh.geometry.attributes)] : []) {
      (attribute.data ?? attribute).onUploadCallback = function () { this.array = null; };
    }
    if (mesh.isMesh) {
      mesh.material.dispose();
      mesh.material = common[mesh.material.side === THREE.DoubleSide ? 0 : 1];
    }
  });
  tile.engineData.metadata = null;
}

// flight: "plain", which leaves tiles as they come, or "sparing"; else they are lit as by kdstream-view.
window.openTileset = ({ url, errorTarget, ratio = 1, megabytes, flight }) => {
  tiles?.dispose();
  failed = null;
  scene = new THREE.Scene();
  scene.background = new THREE.Color(1, 0, 1);
  renderer.setPixelRatio(ratio);
  renderer.setSize(${width}, ${height});
  tiles = new TilesRenderer(url);
  tiles.manager.addHandler(/\\.glb$/, loader);
  tiles.errorTarget = errorTarget;
  if (megabytes) {
    tiles.lruCache.minBytesSize = 0.75e6 * megabytes;
    tiles.lruCache.maxBytesSize = 1e6 * megabytes;
  }
  tiles.setCamera(camera);
  tiles.setResolution(camera, ${width}, ${height});
  tiles.addEventListener("load-error", ({ error, url: of }) => (failed = of + ": " + error));
  if (flight) {
    scene.add(new THREE.HemisphereLight(0xffffff, 0x404040, 3));
  } else {
    tiles.addEventListener("load-model", ({ scene: model }) => model.traverse((mesh) => mesh.isMesh && shade(mesh)));
  }
  if (flight === "sparing") {
    tiles.loadAncestors = false;
    tiles.downloadQueue.maxJobsPerOrigin = 6;
    tiles.parseQueue.maxJobs = 2;
    tiles.addEventListener("load-model", spare);
  }
  scene.add(tiles.group);
};
window.look = ({ matrix, near, far }) => {
  Object.assign(camera, { near, far });
  camera.updateProjectionMatrix();
  camera.matrix.fromArray(matrix);
  camera.updateMatrixWorld(true);
};
window.drawNothing = () => {
  renderer.setSize(${width}, ${height});
  renderer.render(new THREE.Scene(), camera);
};
const frame = () => new Promise((done) => setTimeout(done, 30)); // no frame of the page is drawn for it
function update() {
  if (failed) {
    throw new Error(failed);
  }
  tiles.group.updateMatrixWorld(true);
  tiles.update();
  const { queued, downloading, parsing } = tiles.stats;
  return { downloading: (queued ?? 0) + downloading, parsing, isIdle: Boolean(tiles.root) && !tiles.isLoading && (queued ?? 0) + downloading + parsing === 0 };
}
function count() {
  let triangles = 0;
  tiles.forEachLoadedModel((model, tile) => {
    if (tiles.visibleTiles.has(tile)) {
      model.traverse(({ geometry }) => (triangles += (geometry?.index?.count ?? 0) / 3));
    }
  });
  return { visible: tiles.stats.visible, triangles, cached: tiles.lruCache.cachedBytes };
}
// A client draws each frame, which passes the vertices of new tiles to the graphics card. Where the processor draws, frames
// of a million triangles would take too long: new tiles are drawn once, into a pixel.
const pixel = new THREE.WebGLRenderTarget(1, 1);
const drawn = new WeakSet();
function drawNew() {
  renderer.setRenderTarget(pixel);
  for (const { engineData: { scene: model } } of tiles.visibleTiles) {
    if (model && !drawn.has(model)) {
      drawn.add(model);
      renderer.render(model, camera);
    }
  }
  renderer.setRenderTarget(null);
}
// Waits until all tiles have come, at most for so many milliseconds, and draws them.
window.settle = async ({ most = Infinity, drawsNew = false } = {}) => {
  const end = performance.now() + most;
  for (let still = 0; still < 10 && performance.now() < end; await frame()) {
    still = update().isIdle ? still + 1 : 0;
    if (drawsNew) {
      drawNew();
    }
  }
  renderer.render(scene, camera);
  return count();
};

// The mean of 2 x 2 pixels, each of several samples.
function pixels() {
  const gl = renderer.getContext();
  const fine = new Uint8Array(16 * ${width * height}), coarse = new Uint8Array(3 * ${width * height});
  gl.readPixels(0, 0, ${2 * width}, ${2 * height}, gl.RGBA, gl.UNSIGNED_BYTE, fine);
  for (let y = 0, i = 0; y < ${height}; ++y) {
    for (let x = 0; x < ${width}; ++x) {
      for (let k = 0; k < 3; ++k, ++i) {
        const at = 4 * (2 * y * ${2 * width} + 2 * x) + k;
        coarse[i] = (fine[at] + fine[at + 4] + fine[at + ${8 * width}] + fine[at + ${8 * width + 4}] + 2) >> 2;
      }
    }
  }
  return coarse;
}
window.keepReference = () => (reference = pixels());

// Of the object's pixels the share with a channel that is off by more than 8 of 255.
function shareOfWrong() {
  const seen = pixels();
  const isBackground = (picture, i) => picture[i] > 250 && picture[i + 1] < 5 && picture[i + 2] > 250;
  let all = 0, wrong = 0;
  for (let i = 0; i < seen.length; i += 3) {
    if (!isBackground(seen, i) || !isBackground(reference, i)) {
      ++all;
      wrong += [0, 1, 2].some((k) => Math.abs(seen[i + k] - reference[i + k]) > 8);
    }
  }
  return wrong / all;
}

// The pixels through which background shines: mostly background, with the object less than 4 pixels away on both sides,
// and the object in the reference as far as 6 pixels around.
function countHoles() {
  const seen = pixels();
  const shines = (picture, x, y) => {
    const i = 3 * (y * ${width} + x);
    return Math.min(picture[i], picture[i + 2]) - picture[i + 1] > 100;
  };
  const isThin = (x, y, right, down) => [-1, 1].every((sign) => [1, 2, 3].some((k) => !shines(seen, x + sign * k * right, y + sign * k * down)));
  let holes = 0;
  for (let y = 6; y + 6 < ${height}; ++y) {
    for (let x = 6; x + 6 < ${width}; ++x) {
      if (shines(seen, x, y) && (isThin(x, y, 1, 0) || isThin(x, y, 0, 1))) {
        let deep = true;
        for (let k = 0; deep && k < 169; ++k) {
          deep = !shines(reference, x - 6 + k % 13, y - 6 + Math.floor(k / 13));
        }
        holes += deep;
      }
    }
  }
  return holes;
}

// Takes one answer of the server after the other; a sample whenever 15 % more bytes have come and something else is shown.
window.sampleArrivals = async () => {
  const samples = [];
  let bytes = 0, shown = "";
  const draw = (anyway) => {
    const now = [...tiles.visibleTiles].map((tile) => tile.content?.uri).sort().join();
    if (now !== shown && (anyway || bytes > 1.15 * (samples.at(-1)?.bytes ?? 0))) {
      shown = now;
      renderer.render(scene, camera);
      samples.push({ bytes, wrong: shareOfWrong(), holes: countHoles(), tiles: tiles.visibleTiles.size });
    }
  };
  for (let still = 0; still < 10; await frame()) {
    const { downloading, parsing, isIdle } = update();
    still = isIdle ? still + 1 : 0;
    if (parsing === 0) {
      draw(false);
      if (downloading > 0 || !tiles.root) {
        bytes = await window.nextAnswer();
        still = 0;
      }
    }
  }
  draw(true);
  return { samples, ...count(), bytes };
};
window.isReady = true;
</script>`;

const cesiumPage = `<!doctype html><link rel="stylesheet" href="/cesium/Build/Cesium/Widgets/widgets.css">
<style>body { margin: 0 } #scene { width: ${width}px; height: ${height}px } .cesium-widget-credits { display: none !important }</style><div id="scene"></div>
<script>window.CESIUM_BASE_URL = "/cesium/Build/Cesium/";</script><script src="/cesium/Build/Cesium/Cesium.js"></script>
<script type="module">
const { scene } = new Cesium.CesiumWidget("scene", { globe: false, skyBox: false, skyAtmosphere: false, baseLayer: false, shouldAnimate: false,
  useDefaultRenderLoop: false, msaaSamples: 4, contextOptions: { webgl: { preserveDrawingBuffer: true } } });
scene.backgroundColor = new Cesium.Color(1, 0, 1, 1);
scene.highDynamicRange = false;
scene.fog.enabled = false;
// The place of the model on the globe: Cesium knows no other.
const there = Cesium.Transforms.eastNorthUpToFixedFrame(Cesium.Cartesian3.fromDegrees(13.05, 47.8, 430));
let tileset, failed;
window.openTileset = async ({ url, errorTarget, hasColors }) => {
  scene.primitives.removeAll();
  tileset = await Cesium.Cesium3DTileset.fromUrl(url, { modelMatrix: there, maximumScreenSpaceError: errorTarget, dynamicScreenSpaceError: false,
    foveatedScreenSpaceError: false, backFaceCulling: true, customShader: new Cesium.CustomShader({
      lightingModel: Cesium.LightingModel.UNLIT,
      fragmentShaderText: ${JSON.stringify(lit)} + \`
        void fragmentMain(FragmentInput fsInput, inout czm_modelMaterial material) {
          vec3 base = \${hasColors ? "czm_linearToSrgb(material.diffuse)" : "${stone}"};
          material.diffuse = czm_srgbToLinear(litAsKdStream(base, normalize(fsInput.attributes.normalEC), normalize(-fsInput.attributes.positionEC)));
        }\` }) });
  tileset.tileFailed.addEventListener(({ url: of, message }) => (failed = of + ": " + message));
  scene.primitives.add(tileset);
};
window.look = ({ matrix, near, far }) => {
  const m = Cesium.Matrix4.multiply(there, Cesium.Matrix4.fromArray(matrix), new Cesium.Matrix4());
  const column = (k) => new Cesium.Cartesian3(m[4 * k], m[4 * k + 1], m[4 * k + 2]);
  scene.camera.frustum = new Cesium.PerspectiveFrustum({ near, far, aspectRatio: ${width / height},
    fov: ${2 * Math.atan(Math.tan(viewAngle * Math.PI / 360) * width / height)} });
  scene.camera.setView({ destination: column(3), endTransform: Cesium.Matrix4.IDENTITY,
    orientation: { direction: Cesium.Cartesian3.negate(column(2), new Cesium.Cartesian3()), up: column(1) } });
};
window.settle = async ({ most = Infinity } = {}) => {
  const end = performance.now() + most;
  for (let still = 0; still < 3 && performance.now() < end;) {
    scene.initializeFrame();
    scene.render();
    if (failed) {
      throw new Error(failed);
    }
    still = tileset.tilesLoaded ? still + 1 : 0;
    await new Promise((done) => setTimeout(done, 150));
  }
  const { selected, numberOfTrianglesSelected } = tileset.statistics;
  return { visible: selected, triangles: numberOfTrianglesSelected, cached: tileset.totalMemoryUsageInBytes };
};
window.isReady = true;
</script>`;

const types = { ".js": "text/javascript", ".mjs": "text/javascript", ".json": "application/json", ".glb": "model/gltf-binary", ".css": "text/css",
  ".wasm": "application/wasm" };

// A plain web server for the tileset, which compresses JSON as such servers do. While `held` is set, answers of the
// tileset wait for next().
class Host {
  bytes = 0; // of the tileset's files
  held = false;
  #waiting = [];
  #wanted = null;

  static async start(tileset, cesium) {
    const host = new Host();
    const npm = fileURLToPath(new URL("node_modules", import.meta.url));
    host.server = createServer((request, response) => {
      const path = new URL(request.url, "http://host").pathname;
      const pages = { "/three": threePage, "/cesium": cesiumPage };
      const file = path.startsWith("/npm/") ? join(npm, path.slice(5))
        : path.startsWith("/cesium/") ? join(cesium, path.slice(8)) : join(tileset, path.slice("/tiles/".length));
      if (pages[path]) {
        response.writeHead(200, { "Content-Type": "text/html" }).end(pages[path]);
      } else if (path.includes("..") || !statSync(file, { throwIfNoEntry: false })?.isFile()) {
        response.writeHead(404).end();
      } else {
        const isJson = extname(file) === ".json";
        const body = isJson ? gzipSync(readFileSync(file)) : readFileSync(file);
        const answer = () => {
          host.bytes += path.startsWith("/tiles/") ? body.length : 0;
          response.writeHead(200, { "Content-Type": types[extname(file)] ?? "application/octet-stream", "Cache-Control": "no-store",
            ...(isJson ? { "Content-Encoding": "gzip" } : {}) }).end(body);
        };
        path.startsWith("/tiles/") && host.held ? host.#wait(answer) : answer();
      }
    }).listen(0, "127.0.0.1");
    await once(host.server, "listening");
    host.url = `http://127.0.0.1:${host.server.address().port}`;
    return host;
  }
  #wait(answer) {
    this.#waiting.push(answer);
    this.#wanted?.();
  }
  // Sends one answer, as soon as one is requested. Returns the number of bytes so far.
  async next() {
    if (this.#waiting.length === 0) {
      await Promise.race([new Promise((done) => (this.#wanted = done)), new Promise((done) => setTimeout(done, 1000))]);
      this.#wanted = null;
    }
    this.#waiting.shift()?.();
    return this.bytes;
  }
  begin(held) {
    this.#waiting = [];
    this.held = held;
    this.bytes = 0;
  }
}

async function withBrowser(use) {
  const browser = await chromium.launch({ executablePath: process.env.KDSTREAM_CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync"] });
  try {
    return await use(browser);
  } finally {
    await browser.close();
  }
}

async function withPage(tileset, cesium, client, use) {
  const host = await Host.start(resolve(tileset), cesium && resolve(cesium));
  return withBrowser(async (browser) => {
    const page = await (await browser.newContext({ viewport: { width, height }, deviceScaleFactor: 1 })).newPage();
    page.setDefaultTimeout(0);
    page.on("pageerror", (error) => console.error(String(error)));
    await page.exposeFunction("nextAnswer", () => host.next());
    await page.goto(`${host.url}/${client}`);
    await page.waitForFunction(() => window.isReady);
    return use(page, host, browser);
  }).finally(() => {
    host.server.closeAllConnections();
    host.server.close();
  });
}

// ---- pictures

// The mean difference of the channels (of 255), over the pixels that show the object in both pictures; and the share of
// the pixels that show it in only one.
function compareObjects(own, other) {
  const [first, second] = [PNG.sync.read(own), PNG.sync.read(other)];
  let both = 0, either = 0, sum = 0;
  for (let i = 0; i < first.data.length; i += 4) {
    const down = (Math.floor(i / 4 / first.width) + 0.5) / first.height; // the background of kdstream-view
    const before = [33 + 58 * down, 35 + 59 * down, 40 + 59 * down].every((value, k) => Math.abs(first.data[i + k] - value) <= 2);
    const [red, green, blue] = second.data.subarray(i, i + 3);
    const behind = red > 250 && green < 5 && blue > 250;
    if (!before || !behind) {
      ++either;
      if (!before && !behind) {
        ++both;
        sum += [0, 1, 2].reduce((total, k) => total + Math.abs(first.data[i + k] - second.data[i + k]), 0) / 3;
      }
    }
  }
  return { mean: sum / both, alone: 1 - both / either, pixels: both };
}

function beside(pictures) {
  const all = new PNG({ width: width * pictures.length, height });
  pictures.forEach((picture, i) => PNG.bitblt(PNG.sync.read(picture), all, 0, 0, width, height, i * width, 0));
  return PNG.sync.write(all);
}

// views: turns, which are directions of ./dev bench view, and zooms. errorTarget: in pixels.
export async function showClients(programs, store, tileset, out, cesium, views = [[0, 1], [3, 4]], errorTarget = 1) {
  const radius = radiusOf(programs, store);
  const root = readTileset(tileset), { transform } = root;
  const { images, meshes } = headOf(join(tileset, allTiles(root).find(({ content }) => content).content));
  const hasColors = images !== undefined || meshes[0].primitives[0].attributes.COLOR_0 !== undefined;
  const looks = views.map(([turn, zoom]) => ({ turn, zoom, own: ownView(programs, store, turn, zoom), shown: [] }));
  for (const client of cesium ? ["three", "cesium"] : ["three"]) {
    await withPage(tileset, cesium, client, async (page, host) => {
      for (const view of looks) {
        host.begin(false);
        await page.evaluate((options) => window.openTileset(options), { url: "/tiles/tileset.json", errorTarget, hasColors });
        await page.evaluate((camera) => window.look(camera), cameraOf(view.own.place, radius, transform));
        const { visible, triangles } = await page.evaluate(() => window.settle());
        const picture = await page.locator("canvas").first().screenshot();
        console.error(`${client}: ${JSON.stringify({ visible, triangles, seconds: performance.now() / 1e3 })}`);
        view.shown.push({ client, picture, visible, triangles, bytes: host.bytes, ...compareObjects(view.own.picture, picture) });
      }
    });
  }
  mkdirSync(out, { recursive: true });
  for (const { turn, zoom, own, shown } of looks) {
    writeFileSync(join(out, `${basename(store, ".kds")}-turn-${turn}-zoom-${zoom}.png`), beside([own.picture, ...shown.map(({ picture }) => picture)]));
  }
  return looks;
}

// ---- bytes

// For zooms of 1, 4 and 16 the larger numbers of two directions: kB of the first picture, until at most 5 % of the pixels
// are wrong, and of all; the share of wrong pixels in the end; and pixels through which background shines, of all pictures
// on the way.
export async function measureBytes(programs, store, tileset) {
  const radius = radiusOf(programs, store);
  const { transform } = readTileset(tileset);
  const rows = [];
  await withPage(tileset, null, "three", async (page, host) => {
    for (const zoom of [1, 4, 16]) {
      const looks = [];
      for (const turn of turns) {
        const camera = cameraOf(ownView(programs, store, turn, zoom).place, radius, transform);
        const open = async (errorTarget) => {
          await page.evaluate((options) => window.openTileset(options), { url: "/tiles/tileset.json", errorTarget, ratio: 2 });
          await page.evaluate((where) => window.look(where), camera);
        };
        host.begin(false);
        await open(0); // shows the original
        await page.evaluate(() => window.settle());
        await page.evaluate(() => window.keepReference() && null);
        host.begin(true);
        await open(1);
        const { samples, bytes, triangles } = await page.evaluate(() => window.sampleArrivals());
        // From this sample on, few pixels are wrong.
        const begun = samples.findLastIndex(({ wrong }) => wrong > 0.05) + 1;
        looks.push({ first: samples[0].bytes, few: samples[begun]?.bytes ?? Infinity, settled: samples.at(-1).wrong, bytes, triangles,
          holes: samples.reduce((sum, sample) => sum + sample.holes, 0), pictures: samples.length });
      }
      rows.push({ zoom, ...Object.fromEntries(Object.keys(looks[0]).map((key) => [key, Math.max(...looks.map((look) => look[key]))])) });
    }
  });
  return rows;
}

// ---- memory

// The memory of a process, in bytes; nothing of one that has ended. own is what Chromium's task manager calls its memory
// footprint: heaps, stacks and whatever else it allocates. shared is memory that it shares with other processes of the
// browser, as when it passes vertices to the process of the graphics card. files are programs and libraries, which all
// tabs share.
function memoryOf(pid) {
  const file = `/proc/${pid}/status`;
  const status = existsSync(file) ? readFileSync(file, "utf8") : "";
  const [anonymous, swapped, shared, files] = ["RssAnon", "VmSwap", "RssShmem", "RssFile"]
    .map((name) => 1024 * Number(new RegExp(`${name}:\\s*(\\d+)`).exec(status)?.[1] ?? 0));
  return { own: anonymous + swapped, shared, files };
}

// Keeps the largest memory of a browser's processes: `page` of the one that has the page, `card` of the one that draws.
// Looks ten times a second, since tiles take most memory while they are decoded.
class MemoryWatch {
  most = {};
  #pids = new Map(); // of each kind; a browser has a page in reserve, too, which may end
  #timer;

  static async start(browser) {
    const watch = new MemoryWatch();
    const { processInfo } = await (await browser.newBrowserCDPSession()).send("SystemInfo.getProcessInfo");
    for (const [kind, typeOfKind] of [["page", "renderer"], ["card", "GPU"]]) {
      watch.#pids.set(kind, processInfo.filter(({ type }) => type === typeOfKind).map(({ id }) => id));
      watch.most[kind] = { own: 0, shared: 0, files: 0 };
    }
    watch.look();
    watch.#timer = setInterval(() => watch.look(), 100);
    return watch;
  }
  // Returns the memory of the page's process now.
  look() {
    const now = {};
    for (const [kind, pids] of this.#pids) {
      now[kind] = pids.map(memoryOf).reduce((largest, each) => (each.own > largest.own ? each : largest));
      Object.keys(now[kind]).forEach((key) => (this.most[kind][key] = Math.max(this.most[kind][key], now[kind][key])));
    }
    return now.page;
  }
  stop() {
    clearInterval(this.#timer);
    return this.most;
  }
}

const seconds = (count) => new Promise((done) => setTimeout(done, 1000 * count));

// A page that Playwright does not attach itself to: it would have Chromium keep what the page fetches, up to 100 MB, in
// the page's process.
class BarePage {
  #browser; #session;
  #answers = new Map();

  static async open(browser, url) {
    const page = new BarePage();
    page.#browser = await browser.newBrowserCDPSession();
    page.#browser.on("Target.receivedMessageFromTarget", ({ message }) => {
      const { id, result, error } = JSON.parse(message);
      page.#answers.get(id)?.(error ? Promise.reject(new Error(error.message)) : result);
      page.#answers.delete(id);
    });
    const { targetId } = await page.#browser.send("Target.createTarget", { url, width, height });
    page.#session = (await page.#browser.send("Target.attachToTarget", { targetId, flatten: false })).sessionId;
    return page;
  }
  #sent = 0;
  async send(method, params = {}) {
    const id = ++this.#sent;
    const answer = new Promise((done) => this.#answers.set(id, done));
    await this.#browser.send("Target.sendMessageToTarget", { sessionId: this.#session, message: JSON.stringify({ id, method, params }) });
    return answer;
  }
  async evaluate(use, argument = null) {
    const { result, exceptionDetails } = await this.send("Runtime.evaluate",
      { expression: `(${use})(${JSON.stringify(argument)})`, awaitPromise: true, returnByValue: true });
    if (exceptionDetails) {
      throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    }
    return result.value;
  }
}

async function withBarePage(tileset, use) {
  const host = await Host.start(resolve(tileset));
  return withBrowser(async (browser) => {
    const page = await BarePage.open(browser, `${host.url}/three`);
    while (!await page.evaluate(() => Boolean(window.isReady))) {
      await seconds(0.1);
    }
    const watch = await MemoryWatch.start(browser);
    try {
      return await use(page, host, watch);
    } finally {
      watch.stop();
    }
  }).finally(() => {
    host.server.closeAllConnections();
    host.server.close();
  });
}

// The memory of a tab in which nothing is open, and of a page in which three.js draws an empty scene.
export async function measureEmptyPages() {
  const blank = await withBrowser(async (browser) => {
    await BarePage.open(browser, "about:blank");
    await seconds(1); // its process may be exchanged at first
    const watch = await MemoryWatch.start(browser);
    await seconds(3);
    return watch.stop();
  });
  const scene = await withBarePage(tmpdir(), async (page, host, watch) => {
    await page.evaluate(() => window.drawNothing());
    await seconds(3);
    return watch.stop();
  });
  return { blank, scene };
}

// Flies around the model, down to its surface and up again, twice. how: "plain" or "sparing", of openTileset. Returns the
// largest memory, in bytes: of processes; and of JavaScript's heap and its buffers, which are part of what is the page's
// own. kept: what of the page's own is left when JavaScript's garbage is collected in the end. onStep: called with the
// memory at each step.
export async function flyOver(tileset, megabytes, how = "plain", steps = 48, onStep = () => {}) {
  const { box, transform } = readTileset(tileset);
  const radius = Math.hypot(box[3], box[7], box[11]);
  return withBarePage(tileset, async (page, host, watch) => {
    const most = { heap: 0, buffers: 0, both: 0, triangles: 0, cached: 0 };
    await page.evaluate((options) => window.openTileset(options), { url: "/tiles/tileset.json", errorTarget: 1, megabytes, flight: how });
    for (let step = 0; step < steps; ++step) {
      const around = 4 * Math.PI * step / steps, up = 0.7 * Math.sin(3 * around);
      // In radii; if the model is a ball, its surface is at 0.58.
      const distance = 2.1 - 1.45 * Math.cos(around + Math.PI) ** 2;
      const half = [around / 2, -up / 2];
      const [c, s, d, e] = [Math.cos(half[0]), Math.sin(half[0]), Math.cos(half[1]), Math.sin(half[1])];
      await page.evaluate((camera) => window.look(camera), cameraOf({ focal: [0, 0, 0], distance, turn: [c * d, c * e, s * d, -s * e] }, radius, transform));
      const shown = await page.evaluate((how) => window.settle(how), { most: 30000, drawsNew: true });
      const { usedSize, backingStorageSize = 0 } = await page.send("Runtime.getHeapUsage");
      const now = { heap: usedSize, buffers: backingStorageSize, both: usedSize + backingStorageSize, triangles: shown.triangles, cached: shown.cached };
      Object.keys(most).forEach((key) => (most[key] = Math.max(most[key], now[key])));
      onStep({ step, ...now, ...watch.look() });
    }
    watch.stop();
    await page.send("HeapProfiler.collectGarbage");
    await seconds(3);
    return { ...most, page: { ...watch.most.page }, card: { ...watch.most.card }, kept: watch.look().own, bytes: host.bytes };
  });
}

// ---- run by hand

const megabytes = (bytes) => `${(bytes / 1e6).toFixed(1)} MB`;
const kilobytes = (bytes) => `${(bytes / 1e3).toFixed(0)} kB`;

const ofProcess = ({ own, shared, files }) => `${megabytes(own)} of its own, ${megabytes(shared)} shared, ${megabytes(files)} of files`;

async function main([command, ...words]) {
  if (command === "check" && words.length >= 3) {
    const { levels, tiles, validated, wrong } = await checkTileset(words[0], words[1], words[2], Number(words[3] ?? 1));
    for (const [level, { tiles: count, triangles, bytes }] of levels) {
      console.log(`${level}: ${count} tiles, ${triangles} triangles, ${megabytes(bytes)}`);
    }
    console.log(`${tiles} tiles; ${validated} validated and decoded; ${wrong.length} wrong`);
    wrong.slice(0, 20).forEach((line) => console.log(line));
    return wrong.length > 0 ? 1 : 0;
  }
  if (command === "show" && words.length >= 4 && (!words[4] || existsSync(join(words[4], "Build/Cesium/Cesium.js")))) {
    for (const { turn, zoom, own, shown } of await showClients(...words)) {
      console.log(`turn ${turn}, zoom ${zoom}: kdstream-view ${own.triangles} triangles, ${kilobytes(own.bytes)}`);
      for (const { client, visible, triangles, bytes, mean, alone } of shown) {
        console.log(`  ${client}: ${visible} tiles, ${triangles} triangles, ${kilobytes(bytes)}; differs by ${mean.toFixed(2)} of 255, outline by ${(100 * alone).toFixed(2)} %`);
      }
    }
    return 0;
  }
  if (command === "bytes" && words.length === 3) {
    for (const { zoom, first, few, settled, bytes, triangles, holes, pictures } of await measureBytes(...words)) {
      console.log(`zoom ${zoom}: ${holes} pixels of background shine through ${pictures} pictures; first picture ${kilobytes(first)}, 5 % ${few < Infinity ? kilobytes(few) : "never"}, in the end ${kilobytes(bytes)}, ${triangles} triangles, ${(100 * settled).toFixed(2)} % wrong`);
    }
    return 0;
  }
  if (command === "fly" && words.length >= 1) {
    for (const [name, { page, card }] of Object.entries(await measureEmptyPages())) {
      console.log(`${name === "blank" ? "an empty tab" : "an empty scene of three.js"}: ${ofProcess(page)}; the process that draws: ${ofProcess(card)}`);
    }
    for (const how of words[3] ? [words[3]] : ["plain", "sparing"]) {
      const most = await flyOver(words[0], Number(words[1] ?? 0), how, Number(words[2] ?? 48), (now) => console.error(JSON.stringify(now)));
      console.log(`${how}: ${ofProcess(most.page)}; ${megabytes(most.kept)} of its own without garbage; the process that draws: ${ofProcess(most.card)}`);
      console.log(`  JavaScript's heap ${megabytes(most.heap)}, its buffers ${megabytes(most.buffers)}, both ${megabytes(most.both)}; cache ${megabytes(most.cached)}; ${most.triangles} triangles, ${megabytes(most.bytes)} fetched`);
    }
    return 0;
  }
  console.error("usage: tile-clients.mjs check|show|bytes|fly …, as its first lines say");
  return 2;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  process.exitCode = await main(process.argv.slice(2));
}
