// SPDX-License-Identifier: BSD-3-Clause
// Checks the output of kdstream-store export --format 3dtiles, and the tileset that kdstream-serve makes, with other
// people's software: Khronos' validator, npm's meshoptimizer, and 3d-tiles-renderer with three.js in Chromium.

import assert from "node:assert/strict";
import { once } from "node:events";
import { readFileSync, readdirSync, statSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import validator from "gltf-validator";
import { Server, buildStore, launchBrowser, makeModels, makeToken, runProgram, temporaryFolder } from "./harness.mjs";
import { difference } from "./pixels.mjs";
import { PointFinder, allTiles, readObj, readTile, readTileset } from "./tileset.mjs";
import { PNG } from "pngjs";

const models = makeModels({ whole: true, vase: true });
const out = temporaryFolder();

function exportTiles(model, name, ...options) {
  runProgram("kdstream-store", "export", join(models, `${model}.kds`), join(out, name), "--format", "3dtiles", "--quiet", ...options);
  return join(out, name);
}

// The level of a tile: "11", "12" … or "original", the name of its folder.
const levelOf = (content) => content.split("/")[0];

// meets: whether tiles of a level must have their common vertices in exactly the same places, bit for bit.
async function check(folder, model, meets = true) {
  const root = readTileset(folder);
  const tiles = allTiles(root);
  const files = readdirSync(folder, { recursive: true }).filter((file) => statSync(join(folder, file)).isFile()).sort();
  const named = tiles.flatMap(({ content, tileset }) => [content, tileset]).filter(Boolean);
  assert.deepEqual([...named, "tileset.json"].sort(), files, "each file is named once");

  const inside = (point, box, margin = 0) => [0, 1, 2].every((k) => Math.abs(point[k] - box[k]) <= box[3 + 4 * k] + margin);
  const corners = (box) => [-1, 1].map((sign) => [0, 1, 2].map((k) => box[k] + sign * box[3 + 4 * k]));
  const size = Math.hypot(root.box[3], root.box[7], root.box[11]);
  const shown = new Map(); // the triangles of each level; each has three places
  for (const tile of tiles) {
    for (const child of tile.children) {
      assert.ok(child.error <= tile.error, "errors are monotone");
      assert.ok(corners(child.box).every((corner) => inside(corner, tile.box, 1e-9 * size)), "boxes lie in their parents'");
    }
    assert.ok(tile.children.length > 0 ? tile.error > 0 : tile.error === 0, "the original has no error");
    if (!tile.content) {
      continue;
    }
    const report = await validator.validateBytes(new Uint8Array(readFileSync(join(folder, tile.content))), { maxIssues: 0 });
    assert.equal(report.issues.numErrors + report.issues.numWarnings, 0, `${tile.content}: ${JSON.stringify(report.issues.messages)}`);
    const { gltf, primitives } = await readTile(join(folder, tile.content));
    for (const [p, { positions, indices, isSkirt }] of primitives.entries()) {
      const { doubleSided } = gltf.materials[gltf.meshes[0].primitives[p].material];
      assert.equal(doubleSided, !isSkirt, "only skirts have one side: their backs would be dark points on borders");
      assert.ok(positions.every((point) => inside(point, tile.box)), `${tile.content} lies in its box`);
      const level = levelOf(tile.content);
      if (!isSkirt) {
        const list = shown.get(level) ?? [];
        for (let i = 0; i < indices.length; i += 3) {
          list.push([0, 1, 2].map((k) => positions[indices[i + k]]));
        }
        shown.set(level, list);
      }
    }
  }

  // The tiles show the same triangles as the store, each once.
  const { box } = JSON.parse(describe(model));
  const middle = [0, 1, 2].map((k) => (box.lo[k] + box.hi[k]) / 2);
  for (const [level, list] of shown) {
    const obj = join(temporaryFolder(), "level.obj");
    runProgram("kdstream-store", "extract", join(models, `${model}.kds`), ...(level === "original" ? ["--all"] : ["--level", level]), "-o", obj, "--quiet");
    const { points, triangles } = readObj(obj);
    assert.equal(list.length, triangles.length, `${folder}: triangles of ${level}`);
    const countPlaces = (places) => new Set(places.map(String)).size;
    if (meets) {
      assert.equal(countPlaces(list.flat()), countPlaces(triangles.flat().map((i) => points[i])), `${folder}: places of ${level}`);
    }
    const finder = new PointFinder(points.map((point) => point.map((x, k) => x - middle[k])), size * 2e-5);
    const key = (corners) => {
      const first = corners.indexOf(Math.min(...corners));
      return [0, 1, 2].map((k) => corners[(first + k) % 3]).join();
    };
    const expected = new Map();
    triangles.forEach((triangle) => expected.set(key(triangle), (expected.get(key(triangle)) ?? 0) + 1));
    for (const places of list) {
      const near = places.map((place) => finder.near(place));
      const candidates = near[0].flatMap((a) => near[1].flatMap((b) => near[2].map((c) => key([a, b, c]))));
      const found = candidates.find((candidate) => (expected.get(candidate) ?? 0) > 0);
      assert.ok(found !== undefined, `${folder}: a triangle of ${level} that the store does not have: ${places.join(" | ")}`);
      expected.set(found, expected.get(found) - 1);
    }
  }
  return { tiles, shown };
}

function describe(model) {
  runProgram("kdstream-store", "export", join(models, `${model}.kds`), join(out, "www"), "--quiet");
  return readFileSync(join(out, "www/api/models", model, "model.json"), "utf8");
}

test("tiles are valid, lie in their boxes and hold the triangles of each level", async () => {
  await check(exportTiles("pebble", "pebble"), "pebble");
  // Floats, relative to the middle of each tile.
  await check(exportTiles("pebble", "plain", "--compression", "none"), "pebble", false);
  await check(exportTiles("pebble", "draco", "--compression", "draco"), "pebble");
  runProgram("kdstream-generate", "relief", join(out, "hill.ply"), "--vertices", "48400", "--quiet");
  buildStore(join(out, "hill.ply"), join(models, "hill.kds"), "--vertices-per-partition", "300", "--cell-vertices", "1");
  // Levels on a coarse grid, in many pieces: skirts beside the lattice.
  await check(exportTiles("hill", "hill"), "hill");
  buildStore(join(out, "hill.ply"), join(models, "exact.kds"), "--vertices-per-partition", "2000", "--precision", "lossless");
  await check(exportTiles("exact", "exact"), "exact");
  const { tiles, shown } = await check(exportTiles("vase", "vase"), "vase");
  assert.ok(tiles.length > 32 && shown.size > 2);
});

test("normals have a length of 1, colours and none where they are not wanted", async () => {
  const folder = exportTiles("vase", "coloured");
  const { primitives } = await readTile(join(folder, allTiles(readTileset(folder)).at(-1).content));
  for (const normal of primitives[0].attributes.NORMAL) {
    assert.ok(Math.abs(Math.hypot(...normal) / 127 - 1) < 0.02, String(normal));
  }
  assert.equal(primitives[0].attributes.COLOR_0.length, primitives[0].positions.length);
  const packed = exportTiles("vase", "packed", "--compression", "draco");
  const { primitives: [ofDraco] } = await readTile(join(packed, allTiles(readTileset(packed)).at(-1).content));
  assert.ok(ofDraco.attributes.NORMAL.every((normal) => Math.abs(Math.hypot(...normal) - 1) < 1e-3));
  const sums = [ofDraco, primitives[0]].map(({ attributes }) => [0, 1, 2, 3].map((k) =>
    attributes.COLOR_0.reduce((sum, color) => sum + color[k], 0) / attributes.COLOR_0.length));
  sums[0].forEach((value, k) => assert.ok(Math.abs(value / sums[1][k] - 1) < 0.05, JSON.stringify(sums)));
  const bare = exportTiles("vase", "bare", "--normals", "off");
  const { gltf } = await readTile(join(bare, allTiles(readTileset(bare)).at(-1).content));
  assert.deepEqual(Object.keys(gltf.meshes[0].primitives[0].attributes), ["POSITION", "COLOR_0"]);
});

test("tiles beside each other are lit alike along their border", async () => {
  const folder = exportTiles("pebble", "lit", "--compression", "none");
  const known = new Map();
  let shared = 0;
  for (const { content } of allTiles(readTileset(folder)).filter(({ content }) => content && levelOf(content) === "original")) {
    const { primitives: [{ positions, indices, attributes }] } = await readTile(join(folder, content));
    for (const v of new Set(indices)) {
      const place = positions[v].map((x) => Math.round(x * 1e5)).join();
      const [normal, other] = [attributes.NORMAL[v], known.get(place)];
      known.set(place, normal);
      if (other) {
        ++shared;
        assert.ok(Math.hypot(...normal.map((x, k) => x - other[k])) < 1e-5, `${content}: ${normal} | ${other}`);
      }
    }
  }
  assert.ok(shared > 100, String(shared));
});

test("an origin places the tileset on the globe", () => {
  const { transform } = readTileset(exportTiles("pebble", "globe", "--origin", "13.05,47.8,430,90"));
  const [x, y, z] = transform.slice(12, 15);
  assert.ok(Math.abs(Math.hypot(x, y, z) - 6367000) < 10000);
  assert.ok(Math.abs(Math.atan2(y, x) * 180 / Math.PI - 13.05) < 1e-3);
  const column = (k) => transform.slice(4 * k, 4 * k + 3);
  const dot = (a, b) => a.reduce((sum, value, k) => sum + value * b[k], 0);
  for (const [a, b] of [[0, 1], [1, 2], [2, 0]]) {
    assert.ok(Math.abs(dot(column(a), column(b))) < 1e-12);
    assert.ok(Math.abs(dot(column(a), column(a)) - 1) < 1e-12);
  }
});

// ---- drawing with three.js

const page = `<!doctype html><style>body { margin: 0 } canvas { display: block }</style>
<script type="importmap">{ "imports": { "three": "/npm/three/build/three.module.js", "three/addons/": "/npm/three/examples/jsm/",
  "3d-tiles-renderer/three": "/npm/3d-tiles-renderer/build/index.three.js", "meshoptimizer": "/npm/meshoptimizer/meshopt_decoder.mjs" } }</script>
<script type="module">
import * as THREE from "three";
import { DRACOLoader } from "three/addons/loaders/DRACOLoader.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { TilesRenderer } from "3d-tiles-renderer/three";
import { MeshoptDecoder } from "meshoptimizer";

const size = 480;
const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
renderer.setSize(size, size);
document.body.append(renderer.domElement);
const camera = new THREE.PerspectiveCamera(30, 1, 0.001, 1000);
const loader = new GLTFLoader();
loader.setMeshoptDecoder(MeshoptDecoder);
loader.setDRACOLoader(new DRACOLoader().setDecoderPath("/npm/three/examples/jsm/libs/draco/gltf/"));

function makeScene() {
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(1, 0, 1);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x404040, 3));
  return scene;
}

// From a direction, all of a sphere: { middle, radius }.
function look(direction, { middle, radius }) {
  const eye = new THREE.Vector3(...direction).normalize().multiplyScalar(radius / Math.sin(Math.PI / 12));
  camera.near = radius / 10;
  camera.far = radius * 10;
  camera.updateProjectionMatrix();
  camera.position.copy(eye.add(new THREE.Vector3(...middle)));
  camera.lookAt(...middle);
  camera.updateMatrixWorld();
}

window.drawFile = async (url, direction, sphere) => {
  const scene = makeScene();
  scene.add((await loader.loadAsync(url)).scene);
  look(direction, sphere);
  renderer.render(scene, camera);
};

function openTiles(url, errorTarget, token) {
  const scene = makeScene();
  const tiles = new TilesRenderer(url);
  tiles.manager.addHandler(/\\.glb$/, loader);
  tiles.errorTarget = errorTarget;
  if (token) {
    tiles.fetchOptions.headers = { Authorization: "Bearer " + token };
  }
  tiles.setCamera(camera);
  tiles.setResolution(camera, size, size);
  tiles.group.rotation.x = -Math.PI / 2;
  scene.add(tiles.group);
  return { scene, tiles };
}

// What is there while most of the tiles have not come: pictures from one direction after the other, and what they show.
let held;
window.openHeld = (url) => (held = openTiles(url, 1));
window.drawHeld = async (direction, sphere) => {
  look(direction, sphere);
  for (let i = 0; i < 6; ++i) {
    held.tiles.group.updateMatrixWorld(true);
    held.tiles.update();
    await new Promise((done) => setTimeout(done, 30));
  }
  renderer.render(held.scene, camera);
  const shown = [...held.tiles.visibleTiles].map((tile) => tile.content?.uri);
  return { picture: renderer.domElement.toDataURL(), shown };
};
window.closeHeld = () => held.tiles.dispose();

window.drawTileset = async (url, direction, sphere, errorTarget, token) => {
  const { scene, tiles } = openTiles(url, errorTarget, token);
  let failed;
  tiles.addEventListener("load-error", ({ error, url: of }) => (failed = of + ": " + error));
  look(direction, sphere);
  for (let still = 0; still < 10;) {
    tiles.group.updateMatrixWorld(true);
    tiles.update();
    const { queued, downloading, parsing } = tiles.stats;
    still = (queued ?? 0) + downloading + parsing > 0 || !tiles.root ? 0 : still + 1;
    if (failed) {
      throw new Error(failed);
    }
    await new Promise(requestAnimationFrame);
  }
  renderer.render(scene, camera);
  let triangles = 0;
  tiles.forEachLoadedModel((model, tile) => {
    if (tiles.visibleTiles.has(tile)) {
      model.traverse(({ geometry }) => (triangles += (geometry?.index?.count ?? 0) / 3));
    }
  });
  const { visible } = tiles.stats;
  tiles.dispose();
  return { visible, triangles };
};

// The tiles of a given cut, some coarse beside some fine.
const loaded = new Map();
window.drawTiles = async (urls, transform, directions, sphere, { skirts = true, bothSides = true } = {}) => {
  const scene = makeScene();
  const group = new THREE.Group();
  group.rotation.x = -Math.PI / 2;
  const placed = new THREE.Group();
  placed.matrixAutoUpdate = false;
  placed.matrix.fromArray(transform).multiply(new THREE.Matrix4().makeRotationX(Math.PI / 2));
  group.add(placed);
  scene.add(group);
  for (const url of urls) {
    if (!loaded.has(url)) {
      loaded.set(url, (await loader.loadAsync(url)).scene);
    }
    const tile = loaded.get(url);
    tile.traverse((mesh) => {
      mesh.visible = skirts || mesh.geometry?.userData.skirt !== true;
      if (mesh.material) {
        mesh.material.side = bothSides && !mesh.geometry.userData.skirt ? THREE.DoubleSide : THREE.FrontSide;
      }
    });
    placed.add(tile);
  }
  const pictures = [];
  for (const direction of directions) {
    look(direction, sphere);
    renderer.render(scene, camera);
    pictures.push(renderer.domElement.toDataURL());
  }
  return pictures;
};
window.isReady = true;
</script>`;

let host, url, browser, visit;
let waiting; // answers for tiles that are held back

before(async () => {
  const types = { ".js": "text/javascript", ".mjs": "text/javascript", ".json": "application/json", ".glb": "model/gltf-binary" };
  const npm = fileURLToPath(new URL("node_modules", import.meta.url));
  host = createServer((request, response) => {
    const path = new URL(request.url, "http://host").pathname;
    const file = path.startsWith("/npm/") ? join(npm, path.slice(5)) : join(out, path);
    if (path !== "/" && !statSync(file, { throwIfNoEntry: false })?.isFile()) {
      response.writeHead(404).end();
      return;
    }
    const answer = () => response.writeHead(200, { "Content-Type": types[extname(path)] ?? "text/html" }).end(path === "/" ? page : readFileSync(file));
    waiting && extname(path) === ".glb" ? waiting.push(answer) : answer();
  }).listen(0, "127.0.0.1");
  await once(host, "listening");
  url = `http://127.0.0.1:${host.address().port}/`;
  browser = await launchBrowser();
  visit = await (await browser.newContext({ viewport: { width: 480, height: 480 }, deviceScaleFactor: 1 })).newPage();
  visit.setDefaultTimeout(0);
  visit.on("pageerror", (error) => console.error(String(error)));
  await visit.goto(url);
  await visit.waitForFunction(() => window.isReady);
});

after(async () => {
  await browser?.close();
  host?.close();
});

const keep = (name, png) => process.env.KDSTREAM_PICTURES && writeFileSync(join(process.env.KDSTREAM_PICTURES, `tiles-${name}.png`), png);

// The sphere around the box, in the page's coordinates, where y is up.
function sphereOf({ box, transform }) {
  const [x, y, z] = [0, 1, 2].map((k) => transform[k] * box[0] + transform[4 + k] * box[1] + transform[8 + k] * box[2] + transform[12 + k]);
  return { middle: [x, z, -y], radius: Math.hypot(box[3], box[7], box[11]) };
}

const shape = "dragon";

test("3d-tiles-renderer shows what the whole mesh looks like, and less where less will do", async () => {
  const folder = exportTiles(shape, "shown");
  runProgram("kdstream-store", "export", join(models, `${shape}.kds`), join(out, "whole.glb"), "--format", "glb", "--quiet");
  const sphere = sphereOf(readTileset(folder));
  const direction = [0.5, 0.4, 1];
  await visit.evaluate((options) => window.drawFile(...options), [`${url}whole.glb`, direction, sphere]);
  const whole = await visit.locator("canvas").screenshot();
  keep("whole", whole);
  let before = Infinity;
  for (const [errorTarget, most] of [[1, 0.02], [16, 0.1]]) {
    const shown = await visit.evaluate((options) => window.drawTileset(...options), [`${url}shown/tileset.json`, direction, sphere, errorTarget]);
    const picture = await visit.locator("canvas").screenshot();
    keep(`target-${errorTarget}`, picture);
    assert.ok(shown.visible > 0 && shown.triangles < before, JSON.stringify(shown));
    before = shown.triangles;
    assert.ok(difference(picture, whole) < most, `${errorTarget}: ${difference(picture, whole)}, ${JSON.stringify(shown)}`);
  }
});

test("tiles by Draco look like those by meshoptimizer", async () => {
  const sphere = sphereOf(readTileset(exportTiles("vase", "by-draco", "--compression", "draco")));
  exportTiles("vase", "by-meshopt");
  const pictures = [];
  for (const folder of ["by-draco", "by-meshopt"]) {
    await visit.evaluate((options) => window.drawTileset(...options), [`${url}${folder}/tileset.json`, [0.5, 0.4, 1], sphere, 0]);
    pictures.push(await visit.locator("canvas").screenshot());
    keep(folder, pictures.at(-1));
  }
  assert.ok(difference(...pictures) < 0.01, String(difference(...pictures)));
});

test("textured tiles show their pictures", async () => {
  const meshes = temporaryFolder();
  runProgram("kdstream-generate", "statue", join(meshes, "statue.obj"), "--vertices", "20000", "--picture-side", "512", "--quiet");
  buildStore(join(meshes, "statue.obj"), join(models, "statue.kds"), "--textures", "tiles");
  const folder = exportTiles("statue", "statue");
  runProgram("kdstream-store", "extract", join(models, "statue.kds"), "--all", "-o", join(out, "statue.glb"), "--quiet");
  const sphere = sphereOf(readTileset(folder));
  const draw = async (name, ...more) => {
    await visit.evaluate(([how, ...options]) => window[how](...options), [name, ...more]);
    return visit.locator("canvas").screenshot();
  };
  const whole = await draw("drawFile", `${url}statue.glb`, [0.5, 0.4, 1], sphere);
  const shown = await draw("drawTileset", `${url}statue/tileset.json`, [0.5, 0.4, 1], sphere, 0);
  keep("statue", shown);
  keep("statue-whole", whole);
  assert.ok(difference(shown, whole) < 0.02, String(difference(shown, whole)));

  // A server of another origin makes the same tiles on request.
  const server = await Server.start(models, { more: ["--allow-origin", url.slice(0, -1)] });
  const served = await draw("drawTileset", `${server.url}/api/models/statue/3dtiles/tileset.json`, [0.5, 0.4, 1], sphere, 0);
  keep("statue-served", served);
  assert.ok(difference(served, shown) < 0.001, String(difference(served, shown)));
  await server.stop();
});

test("a tileset from kdstream-serve looks like the exported one, and ends where the token's detail does", async () => {
  const root = readTileset(exportTiles("vase", "to-serve"));
  const levels = [...new Set(allTiles(root).filter(({ content }) => content).map(({ content }) => levelOf(content)))].filter((level) => level !== "original");
  const coarsest = Math.min(...levels), finest = Math.max(...levels);
  assert.ok(coarsest < finest, String(levels));
  const sphere = sphereOf(root), direction = [0.5, 0.4, 1];
  // The exported tiles, not finer than a level.
  const drawn = new Map();
  for (const level of [String(coarsest), String(finest), "original"]) {
    await visit.evaluate((options) => window.drawTiles(...options),
      [makeCut(root, level, () => false).map((content) => `${url}to-serve/${content}`), root.transform, [direction], sphere]);
    drawn.set(level, await visit.locator("canvas").screenshot());
  }
  assert.ok(difference(drawn.get(String(coarsest)), drawn.get(String(finest))) > 0.01 && difference(drawn.get(String(finest)), drawn.get("original")) > 0.01);

  const keys = join(temporaryFolder(), "tokens.json");
  writeFileSync(keys, JSON.stringify({ secret: "0123456789abcdef0123456789abcdef" }), { mode: 0o600 });
  const server = await Server.start(models, { more: ["--tokens", keys, "--allow-origin", url.slice(0, -1)] });
  const answers = [];
  const remember = (response) => response.url().includes("/3dtiles/") && answers.push(
    { status: response.status(), of: response.url().split("/").at(-2), glb: response.url().endsWith(".glb") });
  visit.on("response", remember);
  for (const [detail, level] of [["preview", String(coarsest)], ["levels", String(finest)], ["regions", "original"]]) {
    answers.length = 0;
    await visit.evaluate((options) => window.drawTileset(...options),
      [`${server.url}/api/models/vase/3dtiles/tileset.json`, direction, sphere, 0, makeToken(keys, "--models", "vase", "--detail", detail)]);
    const picture = await visit.locator("canvas").screenshot();
    keep(`served-${detail}`, picture);
    assert.ok(difference(picture, drawn.get(level)) < 0.001, `${detail}: ${difference(picture, drawn.get(level))}`);
    assert.deepEqual(answers.filter(({ status }) => status >= 400), [], `${detail}: nothing is asked for that the token does not give`);
    const asked = [...new Set(answers.filter(({ glb }) => glb).map(({ of }) => of))];
    assert.ok(asked.includes(level), `${detail}: ${asked}`);
    const isFiner = (other) => level !== "original" && (other === "original" || Number(other) > Number(level));
    assert.deepEqual(asked.filter(isFiner), [], `${detail}: tiles finer than ${level}`);
  }
  visit.off("response", remember);
  await server.stop();
});

// A random cut through the tree of tiles, not finer than a given level.
function makeCut(tile, finest, stops) {
  const ends = tile.children.length === 0 || levelOf(tile.content) === finest || stops();
  return ends ? [tile.content] : tile.children.flatMap((child) => makeCut(child, finest, stops));
}

function makeRandom(seed) {
  return () => (seed = (seed * 48271) % 2147483647) / 2147483647;
}

// The number of pixels that show the background although the whole mesh covers everything within `margin` around them.
function countHoles(picture, whole, margin) {
  const isBackground = ({ data }, i) => data[4 * i] > 250 && data[4 * i + 1] < 5 && data[4 * i + 2] > 250;
  const [seen, mask] = [PNG.sync.read(picture), PNG.sync.read(whole)];
  let holes = 0;
  for (let y = margin; y + margin < seen.height; ++y) {
    for (let x = margin; x + margin < seen.width; ++x) {
      if (!isBackground(seen, y * seen.width + x)) {
        continue;
      }
      let deep = true;
      for (let v = y - margin; deep && v <= y + margin; ++v) {
        for (let u = x - margin; deep && u <= x + margin; ++u) {
          deep = !isBackground(mask, v * seen.width + u);
        }
      }
      holes += deep;
    }
  }
  return holes;
}

test("no background shines through where levels meet", async () => {
  const folder = exportTiles(shape, "cracks");
  const root = readTileset(folder);
  const sphere = sphereOf(root);
  const directions = Array.from({ length: 36 }, (_, i) => [Math.cos(i * Math.PI / 6), Math.floor(i / 12) - 1, Math.sin(i * Math.PI / 6)]);
  const draw = async (contents, how) => (await visit.evaluate((options) => window.drawTiles(...options),
    [contents.map((content) => `${url}cracks/${content}`), root.transform, directions, sphere, how]))
    .map((picture) => Buffer.from(picture.split(",")[1], "base64"));
  const finest = "14"; // coarse, because the processor draws
  const whole = await draw(makeCut(root, finest, () => false));
  const holesOf = (pictures) => pictures.reduce((sum, picture, i) => sum + countHoles(picture, whole[i], 6), 0);
  const random = makeRandom(7919);
  let first;
  for (let count = 0; count < 3;) {
    const cut = makeCut(root, finest, () => random() < 0.3);
    if (new Set(cut.map(levelOf)).size < 3) {
      continue; // too few levels in the cut
    }
    first ??= cut;
    ++count;
    const shown = await draw(cut);
    keep(`cut-${count}`, shown[5]);
    assert.equal(holesOf(shown), 0, `cut ${count}`);
  }
  // Does the same with a client whose tiles arrive a few at a time.
  waiting = [];
  await visit.evaluate((options) => void window.openHeld(...options), [`${url}cracks/tileset.json`]);
  let mixed = 0;
  for (const [i, direction] of directions.entries()) {
    waiting.splice(0, i === 0 ? 1 : Math.ceil(random() * 6)).forEach((answer) => answer());
    const { picture, shown } = await visit.evaluate((options) => window.drawHeld(...options), [direction, sphere]);
    mixed += new Set(shown.map((uri) => uri.split("/").at(-2))).size > 1;
    const png = Buffer.from(picture.split(",")[1], "base64");
    keep(`held-${i}`, png);
    assert.ok(shown.length === 0 || countHoles(png, whole[i], 6) === 0, `held, view ${i}: ${shown}`);
  }
  assert.ok(mixed > 12, `${mixed} of 36 pictures show several levels`);
  waiting.forEach((answer) => answer());
  waiting = null;
  await visit.evaluate(() => window.closeHeld());

  // Without inner faces: they hide most of what a gap lets through, so without them gaps are visible.
  const closed = holesOf(await draw(first, { bothSides: false }));
  const bare = await draw(first, { bothSides: false, skirts: false });
  keep("cut-1-bare", bare[5]);
  const open = holesOf(bare);
  assert.ok(open > 1000 && closed < open / 1000, `${closed} pixels with skirts, ${open} without`);
});
