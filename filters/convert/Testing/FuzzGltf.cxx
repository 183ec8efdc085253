// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry to what we read of glTF ourselves, before VTK does: ./dev fuzz.
#include "filters/convert/GltfAccessors.h"
#include "filters/convert/GltfBuffers.h"
#include "filters/convert/GltfMaterials.h"

#include <cmath>
#include <cstdlib>

namespace
{

void Require(bool holds)
{
  if (!holds)
  {
    std::abort();
  }
}

// Below the folder, and nowhere else.
void RequireBelow(const std::filesystem::path& file)
{
  const std::string name = file.lexically_normal().string();
  Require(name.rfind("/folder/", 0) == 0);
}

void Check(const kdstream::GltfMaterials& read)
{
  for (const kdstream::GltfMaterial& material : read.materials)
  {
    Require(material.paint.picture == kdstream::noPicture ||
            material.paint.picture < read.pictures.size());
    for (const double value : material.paint.factor)
    {
      Require(value >= 0 && value <= 1);
    }
    Require(material.coordinates >= 0 && material.coordinates < 100);
  }
  for (const kdstream::PictureSource& picture : read.pictures)
  {
    if (!picture.file.empty())
    {
      RequireBelow(picture.file);
    }
  }
}

}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  using namespace kdstream;
  GltfDocument document;
  document.json = nlohmann::json::parse(data, data + size, nullptr, false);
  if (!document.json.is_object())
  {
    return 0;
  }
  (void)CheckGltfNodes(document.json);
  (void)CheckGltfExtensions(document.json);
  (void)CheckGltfMeshes(document.json);
  for (const bool isGlb : { false, true })
  {
    document.isGlb = isGlb;
    document.binary = isGlb ? 100 : 0;
    document.binaryBytes = isGlb ? 1000 : 0;
    (void)CheckGltfAccessors(document);
    Check(ReadGltfMaterials(document, isGlb ? "/folder/m.glb" : "/folder/m.gltf"));
  }
  if (CheckGltfBuffers(document, "/folder"))
  {
    for (const std::filesystem::path& file : GltfBufferFiles(document.json, "/folder"))
    {
      RequireBelow(file);
    }
  }
  return 0;
}
