// SPDX-License-Identifier: BSD-3-Clause
// FilesBeside and MaterialNames: names as other programs and systems write them.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/texture/FilesBeside.h"
#include "filters/texture/ObjMaterials.h"

#include <gtest/gtest.h>

namespace kdstream::test
{

TEST(FilesBeside, FindsFilesHoweverTheyAreNamed)
{
  const fixtures::TemporaryFolder folder;
  std::filesystem::create_directory(folder / "Maps");
  for (const std::string name : { "t.png", "a b.png", "a#1.png", "Maps/Deep.PNG", "same.png",
         "Same.png", "q\"q.png", "100%.png", "Geb\xC3\xA4ude.png" })
  {
    folder.Write(name, "x");
  }
  FilesBeside files(folder / "mesh.obj");
  const auto find = [&](const std::string& written)
  { return files.Find(written).lexically_relative((folder / "mesh.obj").parent_path()).string(); };
  for (const std::string written : { "t.png", "\"t.png\"", " 't.png' ", "T.PNG", "Textures\\T.PNG",
         "C:\\scans\\T.png", "/home/x/t.png", "../other/t.PNG", "t.png # the paint", "./T.png" })
  {
    EXPECT_EQ(find(written), "t.png") << written;
  }
  EXPECT_EQ(find("a b.png"), "a b.png");
  EXPECT_EQ(find("\"A  B.png\""), "a b.png");
  EXPECT_EQ(find("a%20b.png"), "a b.png");
  EXPECT_EQ(find("A%20b.png"), "a b.png");
  EXPECT_EQ(find("100%.png"), "100%.png");
  EXPECT_EQ(find("Geb\xE4ude.png"), "Geb\xC3\xA4ude.png");
  EXPECT_EQ(find("%2e%2e/t.png"), "t.png");
  EXPECT_EQ(find("a#1.png"), "a#1.png");
  EXPECT_EQ(find("maps\\deep.png"), "Maps/Deep.PNG");
  EXPECT_EQ(find("Maps/Deep.PNG"), "Maps/Deep.PNG");
  EXPECT_EQ(find("q\"q.png"), "q\"q.png");
  // If several files fit, or none, the result is where the file should be.
  EXPECT_EQ(find("same.png"), "same.png");
  EXPECT_EQ(find("SAME.png"), "SAME.png");
  EXPECT_EQ(find("\"gone.png\""), "gone.png");
  EXPECT_EQ(find("sub\\gone.png"), "sub/gone.png");
  EXPECT_EQ(find("../../etc/passwd"), "passwd");
}

TEST(FilesBeside, SaysWhyNothingIsFound)
{
  for (const std::string written : { "t.png", "maps/../t.png", "\"a b.png\"", "file:t.png" })
  {
    EXPECT_EQ(WhyMissing(written), "is not there") << written;
  }
  for (const std::string written : { "../t.png", "maps/../../t.png", "..\\t.png", "C:\\t.png",
         "/t.png", "'../t.png'", "%2e%2e/t.png", "file:///t.png" })
  {
    EXPECT_EQ(WhyMissing(written), "lies outside the mesh's folder, and nothing is read there")
      << written;
  }
  EXPECT_EQ(WhyMissing("http://a.example/t.png"), "lies on the web, and nothing is downloaded");
  EXPECT_EQ(WhyMissing("t.mtl", true), "are not there");
  EXPECT_EQ(
    WhyMissing("../t.mtl", true), "lie outside the mesh's folder, and nothing is read there");
}

TEST(FilesBeside, PicturesElsewhereAreNamedAsTheyAreWritten)
{
  const fixtures::TemporaryFolder folder;
  folder.Write("t.png", "x");
  const PictureSource near = PictureBeside(folder / "t.png", "../maps/t.png", "<", ">");
  EXPECT_EQ(near.name, "<'t.png'>");
  EXPECT_EQ(near.wrong, "");
  const PictureSource far = PictureBeside(folder / "u.png", "../maps/u.png", "<", ">");
  EXPECT_EQ(far.name, "<'../maps/u.png'>");
  EXPECT_EQ(far.wrong, "it lies outside the mesh's folder, and nothing is read there");
}

TEST(MaterialNames, AreFoundAsTheyAreWrittenOrElseIfOneFits)
{
  MaterialNames names;
  names.Add("paint #1", 1);
  names.Add("paint #2", 2);
  names.Add("Red", 3);
  names.Add("red wall", 4);
  names.Add("\"blue\"", 5);
  names.Add("twice", 6);
  names.Add("TWICE", 7);
  names.Add("green # moss", 8);
  names.Add("Red", 9);
  const auto find = [&](const std::string& name) { return int(names.Find(name).value_or(0)); };
  EXPECT_EQ(find("paint #1"), 1);
  EXPECT_EQ(find("paint #2"), 2);
  EXPECT_EQ(find("paint"), 0);
  EXPECT_EQ(find("Red"), 3);
  EXPECT_EQ(find("red"), 3);
  EXPECT_EQ(find("\"RED\""), 3);
  EXPECT_EQ(find("red # dark"), 3);
  EXPECT_EQ(find("Red  wall"), 4);
  EXPECT_EQ(find("blue"), 5);
  EXPECT_EQ(find("twice"), 6);
  EXPECT_EQ(find("TWICE"), 7);
  EXPECT_EQ(find("Twice"), 0);
  EXPECT_EQ(find("green"), 8);
  EXPECT_EQ(find("gone"), 0);
}

}
