// SPDX-License-Identifier: BSD-3-Clause
// Shared by the fuzz targets of textured files: a folder in memory for a mesh and the files that it
// names, and the conditions that everything read must fulfil.
#pragma once

#include "filters/codec/TextureTile.h"
#include "filters/texture/BakeTextures.h"
#include "filters/texture/MakeTile.h"
#include "filters/texture/WritePicture.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace kdstream::test
{

// The folder has a picture, "a.png". It is never removed, because fuzzers do not end normally.
class FuzzFolder
{
public:
  FuzzFolder()
  {
    std::string name = "/dev/shm/kdstream-fuzz-XXXXXX";
    if (!::mkdtemp(name.data()))
    {
      std::abort();
    }
    this->Path = name;
    const auto png = EncodePicture({ 2, 1, 3, { 255, 0, 0, 0, 0, 255 } }, PictureType::Png);
    this->Write("a.png", { reinterpret_cast<const char*>(png.data()), png.size() });
  }

  std::filesystem::path Write(const std::string& name, std::string_view content) const
  {
    const std::filesystem::path file = this->Path / name;
    std::ofstream(file, std::ios::binary) << content;
    return file;
  }

private:
  std::filesystem::path Path;
};

inline void Require(bool holds)
{
  if (!holds)
  {
    std::abort();
  }
}

// A tile can be made of everything that was read, whatever coordinates the corners have. Here every
// other picture is one that could not be read.
inline void CheckTile(const TexturedMesh& textured)
{
  std::vector<Picture> pictures(textured.pictures.size());
  for (std::size_t i = 0; i < pictures.size(); i += 2)
  {
    pictures[i] = { 2, 1, 3, { 255, 0, 0, 0, 0, 255 } };
  }
  const std::size_t count = pictures.size();
  const PicturesInMemory source(std::move(pictures));
  const TexturedTriangles texturedTriangles{ textured.mesh.triangles, textured.corners,
    textured.materialOf };
  constexpr unsigned quality = 50;
  constexpr std::int64_t mostSide = 128;
  const auto made =
    MakeTile(texturedTriangles, { textured.materials, count }, source, { quality, mostSide });
  Require(made && made->counts.triangles == textured.mesh.triangles.size());
  (void)EncodeTextureTile(made->tile, textured.mesh.triangles);
}

// All numbers name elements that exist, before and after baking.
inline void CheckTextured(TexturedMesh textured)
{
  Mesh& mesh = textured.mesh;
  const std::size_t triangles = mesh.triangles.size();
  Require(textured.corners.size() == triangles && textured.materialOf.size() == triangles);
  for (const Triangle& t : mesh.triangles)
  {
    Require(t[0] < mesh.points.size() && t[1] < mesh.points.size() && t[2] < mesh.points.size());
  }
  for (const std::uint32_t material : textured.materialOf)
  {
    Require(material < textured.materials.size());
  }
  for (const TexturedMaterial& material : textured.materials)
  {
    Require(material.picture == noPicture || material.picture < textured.pictures.size());
  }
  CheckTile(textured);
  constexpr std::uint64_t mostPixels = 1 << 16;
  const Result<BakeReport> report = BakeTextures(textured, mostPixels);
  Require(bool(report));
  for (const Attribute& attribute : mesh.attributes)
  {
    const bool points = attribute.association == AttributeAssociation::Point;
    Require(attribute.TupleCount() == (points ? mesh.points.size() : triangles));
  }
}

}
