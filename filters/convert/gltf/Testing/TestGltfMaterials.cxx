// SPDX-License-Identifier: BSD-3-Clause
// Pictures in a glTF's own bytes: each is read once, however many images name it.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/convert/gltf/GltfMaterials.h"

#include <gtest/gtest.h>

#include <fstream>

using namespace kdstream;

namespace
{

// Reads the materials of a file with a buffer of twelve bytes, and one material for each image.
GltfMaterials Read(const std::string& uri, const std::string& views, std::size_t images)
{
  std::string imageJson, textures, materials;
  for (std::size_t i = 0; i < images; ++i)
  {
    const std::string comma = i == 0 ? "" : ",", number = std::to_string(i);
    imageJson += comma + "{\"bufferView\":" + std::to_string(i % 2) + "}";
    textures += comma + "{\"source\":" + number + "}";
    materials +=
      comma + "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":" + number + "}}}";
  }
  const fixtures::TemporaryFolder folder;
  const std::filesystem::path file = folder / "in.gltf";
  std::ofstream(file)
    << "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":12,\"uri\":\"" + uri +
         "\"}],\"bufferViews\":[" + views + "],\"images\":[" + imageJson + "],\"textures\":[" +
         textures + "],\"materials\":[" + materials + "]}";
  const Result<GltfDocument> document = ReadGltfDocument(file);
  EXPECT_TRUE(document) << document.GetError().message;
  return document ? ReadGltfMaterials(*document, GltfBuffers::Open(*document, file), file)
                  : GltfMaterials();
}

std::string Text(const PictureSource& picture)
{
  return { picture.bytes.begin(), picture.bytes.end() };
}

}

TEST(GltfMaterials, BytesThatManyImagesNameAreThereOnce)
{
  const GltfMaterials read = Read("data:,abcdefghijkl",
    "{\"buffer\":0,\"byteLength\":6},{\"buffer\":0,\"byteOffset\":6,\"byteLength\":6}", 400);
  ASSERT_EQ(read.pictures.size(), 400U);
  EXPECT_EQ(Text(read.pictures[0]), "abcdef");
  EXPECT_EQ(Text(read.pictures[1]), "ghijkl");
  for (std::size_t i = 2; i < 400; ++i)
  {
    EXPECT_TRUE(read.pictures[i].bytes.empty());
    EXPECT_EQ(read.materials[i].textured.picture, i % 2);
  }
}

TEST(GltfMaterials, ViewsOfTheSameBytesDoNotMultiplyThem)
{
  const GltfMaterials read = Read("data:;base64,YWJjZGVmZ2hpamts",
    "{\"buffer\":0,\"byteLength\":12},{\"buffer\":0,\"byteOffset\":1,\"byteLength\":11}", 2);
  ASSERT_EQ(read.pictures.size(), 2U);
  EXPECT_EQ(Text(read.pictures[0]), "abcdefghijkl");
  EXPECT_TRUE(read.pictures[1].bytes.empty());
  EXPECT_NE(read.pictures[1].wrong.find("shares bytes with other images"), std::string::npos);
}
