// SPDX-License-Identifier: BSD-3-Clause
// Makes a mesh of a VRML face set: joins shared places, cuts polygons, assigns colours and normals
// by vertex, face or index. Part of step "convert" of the pipeline picture.
#pragma once

#include "filters/convert/ForeignMesh.h"
#include "filters/texture/TexturedMesh.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace kdstream
{

// Which of `count` values a corner, or a face, has.
struct VrmlChannel
{
  std::size_t count = 0; // 0: there are none
  bool perVertex = true;
  // Indices of values. By vertex: as long as the face set's; by face: one for each face. Empty: the
  // number of the vertex, or of the face.
  std::span<const std::int32_t> index;
};

struct VrmlFaces
{
  std::span<const Vec3> points;
  std::span<const std::int32_t> index; // a face ends below 0
  VrmlChannel colors, normals, coordinates;
  std::span<const Color> colorValues;
  std::span<const std::array<float, 3>> normalValues;
  std::span<const std::array<float, 2>> coordinateValues;
  Color material{ 1, 1, 1, 1 }; // where there is no colour
  bool hasMaterial = false;
  bool clockwise = false; // faces are seen from the other side
  bool isShared = false;  // other shapes have these points, too
};

// Point i becomes vertex i; if its corners differ in colour, normal or texture coordinate, more
// vertices follow at the end. Attributes: "RGB" if there are colours or a material, "Normals",
// "TCoords". The result's tolerance counts what is repaired: faces of fewer than three corners,
// missing values. O(corners). Errors: InvalidInput for an index of a point that is not there,
// naming `what` and the face; LimitExceeded.
Result<ForeignMesh> ReadVrmlFaces(const VrmlFaces& faces, const std::string& what);

}
