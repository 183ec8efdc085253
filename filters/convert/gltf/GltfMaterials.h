// SPDX-License-Identifier: BSD-3-Clause
// What paints a glTF scene: materials and where their pictures are.
#pragma once

#include "filters/convert/gltf/GltfBuffers.h"
#include "filters/convert/gltf/GltfDocument.h"
#include "filters/texture/TexturedMesh.h"

#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

// A material and which of a vertex' texture coordinates its picture has.
struct GltfMaterial
{
  TexturedMaterial textured;
  int coordinates = 0; // TEXCOORD_…
};

struct GltfMaterials
{
  std::vector<GltfMaterial> materials;
  // One for each image; `wrong` says why an image cannot be read.
  std::vector<PictureSource> pictures;
  // A sentence each: what names none that is there, of twenty; what is not carried.
  std::vector<std::string> warnings;
};

// The materials of a document of that file, and of its buffers; pictures are searched for beside
// the file (FilesBeside). Reads only the sizes of files. Memory: also the pictures that are in the
// JSON itself, each once.
GltfMaterials ReadGltfMaterials(
  const GltfDocument& document, const GltfBuffers& buffers, const std::filesystem::path& file);

}
