// SPDX-License-Identifier: BSD-3-Clause
// Writes meshes with textures: OBJ with its .mtl and pictures beside it, and GLB. For
// kdstream-store extract.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/texture/TexturedMesh.h"

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

// What all of these functions write: the mesh with "Normals", and colours of vertices where there
// is no texture. A picture's source holds PNG bytes, and its name becomes the file's name. Texture
// coordinates are written with the material's transform applied, or without it where the format has
// such a transform. Every file appears whole or not at all. Errors: LimitExceeded for more than the
// format can number; InputOutput; Cancelled.

// NAME.obj, NAME.mtl and NAME-PICTURE.png. The coordinates of the mesh in its scalar type, as the
// shortest decimals that read back to the same value. A corner without coordinates has none. After
// an error no new file is left.
Status WriteTexturedObj(
  const std::filesystem::path& file, const TexturedMesh& textured, const Execution& execution = {});

// Coordinates are floats. Doubles are written relative to the box's middle, which is the node's
// translation. Vertices are split where texture coordinates of their corners differ. In glTF y is
// up and +z is in front: the node rotates the mesh, whose own up direction is `up` (of length 1);
// coordinates stay.
// metres: that a unit of the coordinates has: glTF is in metres, the node scales.
Status WriteGlb(const std::filesystem::path& file, const TexturedMesh& textured, const Vec3& up,
  double metres = 1, const Execution& execution = {});

// u, v from the upper left, as the transform makes them.
std::array<double, 2> PictureCoordinateOf(
  const TexturedMaterial& material, const PictureCoordinate& corner);
// Whether it leaves coordinates as they are, or turns them upside down and no more.
bool IsIdentity(const TextureTransform& transform);
bool IsUpsideDown(const TextureTransform& transform);
// The numbers of the triangles, those of each material one after the other.
std::vector<std::size_t> TrianglesByMaterial(const TexturedMesh& textured);

}
