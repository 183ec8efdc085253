// SPDX-License-Identifier: BSD-3-Clause
// Shows a mesh from a file with three.js, as its examples do: ?mesh=NAME.ply or NAME.glb.

import { AmbientLight, Color, DirectionalLight, Mesh, MeshLambertMaterial, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { PLYLoader } from "three/examples/jsm/loaders/PLYLoader.js";
import { eyeDistance, viewAngle } from "./eye.js";

const name = new URLSearchParams(location.search).get("mesh");
const place = document.getElementById("view");
const renderer = new WebGLRenderer({ antialias: true });
renderer.setPixelRatio(devicePixelRatio);
renderer.setSize(place.clientWidth, place.clientHeight);
place.append(renderer.domElement);

const scene = new Scene();
scene.background = new Color(0x303236);
const camera = new PerspectiveCamera(viewAngle, place.clientWidth / place.clientHeight, 1, 100);
const light = new DirectionalLight(0xffffff, 2);
light.position.set(-1, 1, 2);
camera.add(light);
scene.add(camera, new AmbientLight(0xffffff, 0.5));

async function load() {
  if (name.endsWith(".ply")) {
    return new PLYLoader().loadAsync(name);
  }
  const { scene: loaded } = await new GLTFLoader().loadAsync(name);
  return loaded.getObjectsByProperty("isMesh", true)[0].geometry;
}

const geometry = await load();
geometry.computeVertexNormals();
geometry.computeBoundingBox();
const sides = geometry.boundingBox.getSize(new Vector3());
const mesh = new Mesh(geometry, new MeshLambertMaterial({ color: 0xd9d0c0 }));
mesh.position.copy(geometry.boundingBox.getCenter(new Vector3())).negate();
scene.add(mesh);
const distance = eyeDistance(sides.toArray(), camera.aspect);
camera.near = distance - sides.length();
camera.far = distance + sides.length();
camera.updateProjectionMatrix();

let angle = 0;
function turn(radians) {
  angle -= radians;
  camera.position.set(distance * Math.sin(angle), 0, distance * Math.cos(angle));
  camera.lookAt(0, 0, 0);
  renderer.render(scene, camera);
}

requestAnimationFrame(() => {
  turn(0);
  window.peer = { turn };
});
