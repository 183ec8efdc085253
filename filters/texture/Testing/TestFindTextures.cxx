// SPDX-License-Identifier: BSD-3-Clause
// FindTextures: mesh colours come from existing pictures that faces use; else from the vertices'
// own colours; else from colours of materials.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/texture/FindTextures.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace kdstream::test
{
namespace
{

enum class TextureKind
{
  None,
  Colors,
  Pictures
};

TextureKind TextureKindOf(const FoundTextures& found)
{
  return !found.any     ? TextureKind::None
         : found.colors ? TextureKind::Colors
                        : TextureKind::Pictures;
}

// A triangle, whose vertices have colours or not.
std::string Obj(const std::string& library, bool colored, const std::string& face)
{
  const std::string color = colored ? " 1 0 0\n" : "\n";
  return library + "v 0 0 0" + color + "v 1 0 0" + color + "v 0 1 0" + color + face;
}

std::string Ply(bool colored, const std::string& face, std::size_t faces)
{
  const std::string color = colored ? " 255 0 0\n" : "\n";
  return std::string("ply\nformat ascii 1.0\ncomment TextureFile ") + face +
         "\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
         "property float s\nproperty float t\n" +
         (colored ? "property uchar red\nproperty uchar green\nproperty uchar blue\n" : "") +
         "element face " + std::to_string(faces) +
         "\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0 0" + color + "1 0 0 1 0" +
         color + "0 1 0 0 1" + color + (faces > 0 ? "3 0 1 2\n" : "");
}

}

TEST(FindTextures, PicturesCountWhereFacesUseThem)
{
  const fixtures::TemporaryFolder folder;
  folder.Write("t.png", "x");
  folder.Write("a.mtl", "newmtl there\nmap_Kd t.png\nnewmtl lower\nmap_kd t.png\n"
                        "newmtl gone\nmap_Kd gone.png\nnewmtl red\nKd 1 0 0\n");
  folder.Write("red.mtl", "newmtl red\nkd 1 0 0\n");
  folder.Write("own.mtl", "newmtl red\nKd 1 0 0\n");
  const std::string library = "mtllib a.mtl\n", missing = "gone.png";
  const struct
  {
    std::string name, text;
    TextureKind kind;
    std::string warning;
  } cases[] = {
    { "used.obj", Obj(library, true, "usemtl there\nf 1 2 3\n"), TextureKind::Pictures, "" },
    { "lower.obj", Obj("MTLLIB a.mtl\n", true, "usemtl lower\nf 1 2 3\n"), TextureKind::Pictures,
      "" },
    { "notused.obj", Obj(library, true, "usemtl red\nf 1 2 3\n"), TextureKind::None, missing },
    { "nomaterial.obj", Obj(library, true, "f 1 2 3\n"), TextureKind::None, missing },
    { "gone.obj", Obj(library, true, "usemtl gone\nf 1 2 3\n"), TextureKind::None, missing },
    { "bare.obj", Obj(library, false, "usemtl gone\nf 1 2 3\n"), TextureKind::Pictures, "" },
    { "cloud.obj", Obj(library, true, ""), TextureKind::None, missing },
    { "red.obj", Obj("mtllib red.mtl\n", false, "usemtl red\nf 1 2 3\n"), TextureKind::Colors, "" },
    { "colored.obj", Obj("mtllib red.mtl\n", true, "usemtl red\nf 1 2 3\n"), TextureKind::None,
      "" },
    { "own.obj", Obj("", false, "usemtl red\nf 1 2 3\n"), TextureKind::Colors, "" },
    { "used.ply", Ply(true, "t.png", 1), TextureKind::Pictures, "" },
    { "gone.ply", Ply(true, "gone.png", 1), TextureKind::None, missing },
    { "bare.ply", Ply(false, "gone.png", 1), TextureKind::Pictures, "" },
    { "cloud.ply", Ply(true, "t.png", 0), TextureKind::None, "" },
  };
  for (const auto& c : cases)
  {
    SCOPED_TRACE(c.name);
    const Result<FoundTextures> found = FindTextures(folder.Write(c.name, c.text));
    ASSERT_TRUE(found) << found.GetError().message;
    EXPECT_EQ(TextureKindOf(*found), c.kind);
    const bool reported = std::any_of(found->warnings.begin(), found->warnings.end(),
      [&](const std::string& text) { return text.find(c.warning) != std::string::npos; });
    EXPECT_TRUE(c.warning.empty() || reported);
  }
}

TEST(FindTextures, MaterialsThatDifferAreReported)
{
  const fixtures::TemporaryFolder folder;
  folder.Write("one.mtl", "newmtl m\nKd 1 0 0\nnewmtl same\nKd 1 1 1\n");
  folder.Write("two.mtl", "newmtl m\nKd 0 0 1\nnewmtl same\nKd 1 1 1\n");
  const Result<TexturedFile> read = ReadTextured(
    folder.Write("a.obj", Obj("mtllib one.mtl\nmtllib two.mtl\n", false, "usemtl m\nf 1 2 3\n")));
  ASSERT_TRUE(read) << read.GetError().message;
  ASSERT_EQ(read->warnings.size(), 1U);
  for (const char* name : { "'m'", "'one.mtl'", "'two.mtl'" })
  {
    EXPECT_NE(read->warnings[0].find(name), std::string::npos) << read->warnings[0];
  }
}

TEST(FindTextures, WhatTexturedFilesHoldBesidesIsReported)
{
  const fixtures::TemporaryFolder folder;
  folder.Write("a.mtl", "newmtl m\nmap_Kd t.png\n");
  const Result<TexturedFile> read = ReadTextured(folder.Write(
    "a.obj", Obj("mtllib a.mtl\n", false, "vt 0 0\nusemtl m\nf 1/1 2/1 3/1\nl 1 2\nwhat 1\n") +
               std::string(100, '\0')));
  ASSERT_TRUE(read) << read.GetError().message;
  ASSERT_EQ(read->warnings.size(), 2U);
  EXPECT_NE(read->warnings[0].find(": 1 line"), std::string::npos) << read->warnings[0];
  EXPECT_NE(read->warnings[1].find("'what' in line 9"), std::string::npos) << read->warnings[1];
  EXPECT_EQ(read->tolerance.Of(Lapse::PaddedEnd), 100U);
}

// Empty lists of coordinates in faces do not count if vertices have coordinates.
TEST(FindTextures, CoordinatesOfVerticesCountWhereNoFaceHasSome)
{
  const fixtures::TemporaryFolder folder;
  std::string text = Ply(false, "t.png", 1);
  const std::string list = "property list uchar int vertex_indices\n";
  text.replace(text.find(list), list.size(), list + "property list uchar float texcoord\n");
  text.replace(text.rfind("3 0 1 2"), 7, "3 0 1 2 0");
  const Result<TexturedFile> read = ReadTextured(folder.Write("a.ply", text));
  ASSERT_TRUE(read) << read.GetError().message;
  ASSERT_EQ(read->textured.corners.size(), 1U);
  EXPECT_EQ(read->textured.corners[0],
    (std::array<PictureCoordinate, 3>{ { { 0, 0 }, { 1, 0 }, { 0, 1 } } }));
  EXPECT_EQ(read->textured.materialOf, std::vector<std::uint32_t>{ 0 });
  EXPECT_TRUE(read->warnings.empty());
}

}
