// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry to reading a whole glTF: ./dev fuzz. The input is read as a .gltf with a
// buffer, and as a .glb; it is split into JSON and bytes at the first 0.
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/gltf/GltfDocument.h"
#include "filters/convert/gltf/GltfMaterials.h"
#include "filters/texture/Testing/FuzzFolder.h"

#include <cstring>
#include <string>
#include <string_view>

namespace
{

using namespace kdstream;
using test::Require;

std::string Number(std::size_t value)
{
  const auto small = static_cast<std::uint32_t>(value);
  return { reinterpret_cast<const char*>(&small), sizeof small };
}

std::string Glb(std::string_view json, std::string_view bytes)
{
  return "glTF" + Number(2) + Number(28 + json.size() + bytes.size()) + Number(json.size()) +
         "JSON" + std::string(json) + Number(bytes.size()) + std::string("BIN\0", 4) +
         std::string(bytes);
}

void CheckMesh(const ForeignMesh& read)
{
  for (const Triangle& t : read.mesh.triangles)
  {
    for (const VertexId corner : t)
    {
      Require(corner < read.mesh.points.size());
    }
  }
  for (const Attribute& attribute : read.mesh.attributes)
  {
    Require(attribute.TupleCount() == read.mesh.points.size());
  }
}

void CheckMaterials(const std::filesystem::path& file)
{
  const Result<GltfDocument> document = ReadGltfDocument(file);
  if (!document)
  {
    return;
  }
  const GltfMaterials read = ReadGltfMaterials(*document, GltfBuffers::Open(*document, file), file);
  for (const GltfMaterial& material : read.materials)
  {
    Require(
      material.textured.picture == noPicture || material.textured.picture < read.pictures.size());
    Require(material.coordinates >= 0 && material.coordinates < 100);
  }
  for (const PictureSource& picture : read.pictures)
  {
    const std::string place = picture.file.lexically_normal().string();
    Require(place.empty() || place.starts_with(file.parent_path().string() + "/"));
  }
}

}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  static const test::FuzzFolder folder;
  const std::string_view all(reinterpret_cast<const char*>(data), size);
  const std::size_t end = std::min(all.find('\0'), size);
  const std::string_view bytes = all.substr(std::min(end + 1, size));
  folder.Write("b.bin", bytes);
  for (const std::filesystem::path& file : { folder.Write("m.gltf", all.substr(0, end)),
         folder.Write("m.glb", Glb(all.substr(0, end), bytes)) })
  {
    CheckMaterials(file);
    const TextureOptions options{ true, 1 << 16 };
    if (const Result<ForeignMesh> read = ReadGltf(file, options, {}))
    {
      CheckMesh(*read);
    }
    else
    {
      Require(!read.GetError().message.empty());
    }
  }
  return 0;
}
