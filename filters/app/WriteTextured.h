// SPDX-License-Identifier: BSD-3-Clause
// Meshes with pictures as files: OBJ with its .mtl and pictures beside it, and GLB. For
// kdstream-store extract.
#pragma once

#include "filters/core/Result.h"
#include "filters/texture/TexturedMesh.h"

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

// What all of these write: the mesh with "Normals", and, where no picture paints, colours of
// vertices. A picture is PNG bytes in its source, and its name is what it is called as a file.
// Coordinates of corners are those that the material's transform makes of them; as they are where
// the format has that transform itself. Every file appears whole or not at all. Errors:
// LimitExceeded for more than the format can number; InputOutput.

// NAME.obj, NAME.mtl and NAME-PICTURE.png. The coordinates of the mesh in its scalar type, as the
// shortest decimals that read back to the same value. A corner without coordinates has none.
Status WriteTexturedObj(const std::filesystem::path& file, const TexturedMesh& textured);

// Coordinates are floats: of doubles they are differences to the box's middle, where the node
// stands. Vertices are split where coordinates of their corners differ. The format has y up and +z
// in front: the node turns the mesh so, whose own up is `up`, of length 1, and coordinates stay.
Status WriteGlb(const std::filesystem::path& file, const TexturedMesh& textured, const Vec3& up);

// u, v from the upper left, as the transform makes them.
std::array<double, 2> PictureCoordinateOf(
  const TexturedMaterial& material, const PictureCoordinate& corner);
// Whether it leaves coordinates as they are, or turns them upside down and no more.
bool IsIdentity(const TextureTransform& transform);
bool IsUpsideDown(const TextureTransform& transform);
// The numbers of the triangles, those of each material one after the other.
std::vector<std::size_t> TrianglesByMaterial(const TexturedMesh& textured);

}
