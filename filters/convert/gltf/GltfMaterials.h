// SPDX-License-Identifier: BSD-3-Clause
// The materials of a glTF scene, and where their pictures are.
#pragma once

#include "filters/convert/gltf/GltfBuffers.h"
#include "filters/convert/gltf/GltfDocument.h"
#include "filters/texture/TexturedMesh.h"

#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

// A material, and which of a vertex's texture coordinates its picture uses.
struct GltfMaterial
{
  TexturedMaterial textured;
  int coordinates = 0; // the number in TEXCOORD_…
};

struct GltfMaterials
{
  std::vector<GltfMaterial> materials;
  // One for each image; `wrong` says why an image cannot be read.
  std::vector<PictureSource> pictures;
  // One sentence each: references to missing objects, of which twenty are named; features that are
  // not carried.
  std::vector<std::string> warnings;
};

// Reads the materials of `document`, which comes from `file` and has these buffers. Pictures are
// searched for beside the file (FilesBeside). Of picture files, only the sizes are read. Memory:
// also the pictures that are in the JSON itself, each once.
GltfMaterials ReadGltfMaterials(
  const GltfDocument& document, const GltfBuffers& buffers, const std::filesystem::path& file);

}
