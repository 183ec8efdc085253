// SPDX-License-Identifier: BSD-3-Clause
// Makes a mesh of a VRML face set: joins shared places, cuts polygons, and assigns colours and
// normals to vertices or faces, directly or by indices. Part of step "convert" of the pipeline
// picture.
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

// Says which of `count` values a corner or a face uses.
struct VrmlChannel
{
  std::size_t count = 0; // 0 if there are no values
  bool perVertex = true;
  // Indices of values. By vertex, there are as many as in the face set's index; by face, one for
  // each face. If empty, the number of the vertex or of the face is the index.
  std::span<const std::int32_t> index;
};

struct VrmlFaces
{
  std::span<const Vec3> points;
  std::span<const std::int32_t> index; // a value below 0 ends a face
  VrmlChannel colors, normals, coordinates;
  std::span<const Color> colorValues;
  std::span<const std::array<float, 3>> normalValues;
  std::span<const std::array<float, 2>> coordinateValues;
  Color material{ 1, 1, 1, 1 }; // if there are no colours
  bool hasMaterial = false;
  bool clockwise = false; // front faces have clockwise corners
  bool isShared = false;  // other shapes have these points, too
};

// Point i becomes vertex i. If the corners at a point differ in colour, normal or texture
// coordinate, more vertices follow at the end. Attributes: "RGB" if there are colours or a
// material, "Normals", "TCoords". The result's tolerance counts what is repaired: faces of fewer
// than three corners, and missing values. O(corners). Errors: InvalidInput for an index of a point
// that does not exist, naming `what` and the face; LimitExceeded.
Result<ForeignMesh> ReadVrmlFaces(const VrmlFaces& faces, const std::string& what);

}
