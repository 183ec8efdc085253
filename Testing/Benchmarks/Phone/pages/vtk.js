// SPDX-License-Identifier: BSD-3-Clause
// Shows a mesh from a file with vtk.js, as its examples do: ?mesh=NAME.ply.

import "@kitware/vtk.js/Rendering/Profiles/Geometry";
import vtkPLYReader from "@kitware/vtk.js/IO/Geometry/PLYReader";
import vtkActor from "@kitware/vtk.js/Rendering/Core/Actor";
import vtkMapper from "@kitware/vtk.js/Rendering/Core/Mapper";
import vtkGenericRenderWindow from "@kitware/vtk.js/Rendering/Misc/GenericRenderWindow";
import { eyeDistance, viewAngle } from "./eye.js";

const name = new URLSearchParams(location.search).get("mesh");
const place = document.getElementById("view");
const view = vtkGenericRenderWindow.newInstance({ background: [0.19, 0.196, 0.21] });
view.setContainer(place);
view.resize();

const reader = vtkPLYReader.newInstance();
const mapper = vtkMapper.newInstance({ scalarVisibility: false });
const actor = vtkActor.newInstance();
await reader.setUrl(name, { binary: true });
mapper.setInputConnection(reader.getOutputPort());
actor.setMapper(mapper);
actor.getProperty().setColor(0.85, 0.82, 0.75);
const renderer = view.getRenderer();
renderer.addActor(actor);

const [x0, x1, y0, y1, z0, z1] = actor.getBounds();
const middle = [(x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2];
const distance = eyeDistance([x1 - x0, y1 - y0, z1 - z0], place.clientWidth / place.clientHeight);
const camera = renderer.getActiveCamera();
camera.setViewAngle(viewAngle);
camera.setFocalPoint(...middle);
camera.setPosition(middle[0], middle[1], middle[2] + distance);
camera.setViewUp(0, 1, 0);
renderer.resetCameraClippingRange();

function turn(radians) {
  camera.azimuth(-radians * 180 / Math.PI);
  view.getRenderWindow().render();
}

requestAnimationFrame(() => {
  turn(0);
  window.peer = { turn };
});
