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
  TexturedMaterial paint;
  int coordinates = 0; // TEXCOORD_…
};

struct GltfMaterials
{
  std::vector<GltfMaterial> materials;
  std::vector<PictureSource> pictures; // one an image; what names none that can be is `wrong`
  // A sentence each: what names none that is there, of twenty; what is not carried.
  std::vector<std::string> warnings;
};

// Of a document of that file, beside which pictures are looked for (FilesBeside), and its buffers.
// Nothing is read but the sizes of files. Memory: besides, pictures that are in the JSON itself,
// each once.
GltfMaterials ReadGltfMaterials(
  const GltfDocument& document, const GltfBuffers& buffers, const std::filesystem::path& file);

}
