// SPDX-License-Identifier: BSD-3-Clause
// Writes meshes with textures: OBJ with .mtl and pictures beside it, and GLB. For kdstream-store
// extract.
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

// All of these functions write the mesh with "Normals", and colours of vertices if there is no
// texture. A picture's source holds PNG bytes, and its name becomes the name of the file. Texture
// coordinates are written with the material's transform applied, or without it if the format has
// transforms of this kind. Every file appears whole or not at all. Errors: LimitExceeded for more
// than the format can number; InputOutput; Cancelled.

// Writes NAME.obj, NAME.mtl and NAME-PICTURE.png. The coordinates of the mesh are in its scalar
// type, as the shortest decimals that read back to the same value. A corner without texture
// coordinates is written without them. After an error no new file is left.
Status WriteTexturedObj(
  const std::filesystem::path& file, const TexturedMesh& textured, const Execution& execution = {});

// Coordinates are floats. Doubles are written relative to the box's middle, which is the node's
// translation. Vertices are split if the texture coordinates of their corners differ. In glTF y is
// up and +z is in front. So the node rotates the mesh, whose own up direction is `up` (of length
// 1); coordinates stay unchanged. metres: the length of a unit of the coordinates in metres. glTF
// is in metres, so the node scales the mesh.
Status WriteGlb(const std::filesystem::path& file, const TexturedMesh& textured, const Vec3& up,
  double metres = 1, const Execution& execution = {});

// u, v from the upper left corner, after the transform.
std::array<double, 2> PictureCoordinateOf(
  const TexturedMaterial& material, const PictureCoordinate& corner);
// Whether the transform leaves coordinates unchanged, or only turns them upside down.
bool IsIdentity(const TextureTransform& transform);
bool IsUpsideDown(const TextureTransform& transform);
// The numbers of the triangles, material by material.
std::vector<std::size_t> TrianglesByMaterial(const TexturedMesh& textured);

}
