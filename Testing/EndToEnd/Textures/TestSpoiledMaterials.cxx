// SPDX-License-Identifier: BSD-3-Clause
// kdstream-build with textured OBJ and PLY files that are damaged in one way: texture coordinates,
// materials and their libraries, numbers of pictures.
#include "Testing/EndToEnd/Textures/SpoiledFiles.h"

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

class TestSpoiledMaterials : public SpoiledTest
{
protected:
  void SetUp() override
  {
    this->WriteBytes("a.png", TwoHalves(PictureType::Png));
    this->WriteMtl("a.png");
  }
  void ExpectObj(const std::vector<std::string>& warnings, const std::vector<Rgb>& colors)
  {
    this->ExpectBuilt("m.obj", warnings, colors);
  }
};

}

TEST_F(TestSpoiledMaterials, CoordinatesOutsideRepeatOrAreClamped)
{
  this->WriteObj({ { "-3.75", "7.5" }, { "12.75", "-0.5" }, { "-0.25", "0" }, { "1.25", "0" } });
  this->ExpectObj({}, { red, blue, blue, red });
  this->WriteMtl("-clamp on a.png");
  this->ExpectObj({}, { red, blue, red, blue });
  this->WriteObj({ { "1e30", "0" }, { "-1e30", "1e38" }, { "0.25", "0.5" } });
  this->ExpectObj({ "2 triangles have texture coordinates of 2^30 texels or more, which are "
                    "not places in a picture" },
    { blue, red, red });
}

TEST_F(TestSpoiledMaterials, InvalidCoordinatesHaveTheMaterialsColour)
{
  const std::string none = " no texture coordinates, or ones that are not numbers (the first is "
                           "triangle 1): the material's colour is used";
  this->WriteObj(
    { { "0.25", "0.5" }, { "nan", "0" }, { "inf", "0" }, { "0", "-inf" }, { "1e99", "0" } });
  this->ExpectObj({ "4 triangles have" + none }, { red, green, green, green, green });
  this->WriteObj({ { "0.25", "0.5" } }, "v 1 0 0\nv 1 1 0\nv 1.5 0 1\nf 4 5 6\n");
  this->ExpectObj({ "1 triangle has" + none }, { red, green });
  // Only one of three corners has a coordinate.
  this->WriteObj({ { "0.25", "0.5" } }, "v 1 0 0\nv 1 1 0\nv 1.5 0 1\nf 4/1 5 6/1\n");
  this->ExpectObj({ "1 triangle has" + none }, { red, green });
}

TEST_F(TestSpoiledMaterials, CoordinatesThatAreNotThereAreLeftOut)
{
  const std::string corners = "v 2 0 0\nv 2 1 0\nv 2.5 0 1\n";
  for (const std::string number : { "3", "-3", "4294967298", "99999999999999999999" })
  {
    this->WriteObj(leftAndRight, corners + "f 7/" + number + " 8/1 9/1\n");
    this->ExpectObj(
      { "1 triangle has no texture coordinates, or ones that are not numbers (the first is "
        "triangle "
        "2): the material's colour is used",
        "1 face names a texture coordinate, normal or colour that does not exist: it is read "
        "without it: face 2 (line 16)" },
      { red, blue, green });
  }
}

TEST_F(TestSpoiledMaterials, MaterialsThatAreNotThereAreWhite)
{
  const std::string third = "v 2 0 0\nv 2 1 0\nv 2.5 0 1\nf 7/1 8/1 9/1\n";
  this->WriteObj(leftAndRight, "usemtl other\n" + third);
  this->ExpectObj({ "line 13: the material 'other' is in no material library: it is drawn white" },
    { red, blue, white });
  this->WriteText("m.mtl", "newmtl a\nmap_Kd a.png\nnewmtl other\n");
  this->ExpectObj({}, { red, blue, white });
  this->WriteText("m.mtl", "newmtl a\nmap_Kd a.png\nnewmtl other\nKd 0 1 0\n");
  this->ExpectObj({}, { red, blue, green });
  // Only one of two libraries exists.
  this->WriteObj(leftAndRight, "", "mtllib gone.mtl\nmtllib m.mtl\nusemtl a\n");
  this->ExpectObj(
    { "line 1: the materials 'gone.mtl' are not there: they are drawn white" }, { red, blue });
  std::filesystem::create_directory(this->Folder / "gone.mtl");
  this->ExpectObj(
    { "line 1: the materials 'gone.mtl' is a directory, not a file: they are drawn white" },
    { red, blue });
}

TEST_F(TestSpoiledMaterials, LibrariesWithoutAnyPictureLeaveTheMeshAsItIs)
{
  std::filesystem::remove(this->Folder / "m.mtl");
  this->WriteObj(leftAndRight);
  this->ExpectObj(
    { "line 1: the materials 'm.mtl' are not there: they are drawn white" }, { white, white });
  std::filesystem::create_directory(this->Folder / "m.mtl");
  this->ExpectObj(
    { "line 1: the materials 'm.mtl' is a directory, not a file: they are drawn white" },
    { white, white });
}

TEST_F(TestSpoiledMaterials, LibrariesThatNameEachOtherAreReadOnce)
{
  this->WriteText("m.mtl", "mtllib m.mtl\nmtllib n.mtl\nnewmtl a\nmap_Kd a.png\nmtllib m.mtl\n");
  this->WriteText("n.mtl", "mtllib m.mtl\nnewmtl a\nKd 0 0 0\n");
  this->WriteObj(leftAndRight, "", "mtllib m.mtl n.mtl m.obj m.mtl\nmtllib n.mtl\nusemtl a\n");
  this->ExpectObj(
    { "the material 'a' is in 'm.mtl' and, with different values, in 'n.mtl': the first is "
      "used for all faces" },
    { red, blue });
}

TEST_F(TestSpoiledMaterials, LongLinesAndFilesTakeNoMemory)
{
  // Sparse files: the rest of each is zero bytes.
  this->WriteObj(leftAndRight, "", "mtllib long.mtl\nmtllib m.mtl\nusemtl a\n");
  this->WriteText("long.mtl", "newmtl z\nKd 0 0 0\nmap_Kd ");
  std::filesystem::resize_file(this->Folder / "long.mtl", 50'000'000);
  this->ExpectObj({ "long.mtl: line 3: is longer than 16 MiB" }, { red, blue });
  std::filesystem::resize_file(this->Folder / "long.mtl", 100'000'000);
  this->ExpectObj({ "line 1: the materials 'long.mtl' are more than 64 MiB: they are drawn white" },
    { red, blue });
}

TEST_F(TestSpoiledMaterials, HostileNumbersAreReported)
{
  this->WriteText(
    "m.mtl", "newmtl a\nKd 0 1 0\nKd nan 0 0\nmap_Kd -o inf 0 0 a.png\nKd 1e999 0 0\nKd 0 0 x\n");
  this->WriteText("n.mtl", "newmtl b\nmap_Kd a.png\n");
  this->WriteObj(leftAndRight, "usemtl b\nv 2 0 0\nv 2 1 0\nv 2.5 0 1\nf 7/1 8/1 9/1\n",
    "mtllib m.mtl n.mtl\nusemtl a\n");
  this->ExpectObj({ "m.mtl, line 3 cannot be read: 'Kd nan 0 0'",
                    "m.mtl, line 4 cannot be read: 'map_Kd -o inf 0 0 a.png'",
                    "m.mtl, line 5 cannot be read: 'Kd 1e999 0 0'" },
    { green, green, red });
  // Finite but useless: all coordinates show the same texel.
  this->WriteText("m.mtl", "newmtl a\nmap_Kd -s 0 0 0 -o 0.75 0.5 a.png\n");
  this->WriteObj(leftAndRight);
  this->ExpectObj({}, { blue, blue });
  this->WriteText("m.mtl", "newmtl a\nmap_Kd -s 1e300 1e300 -o 1e308 1e308 a.png\n");
  const Outcome built = this->Build({ "m.obj", "-o", "m.kds", "--quiet" });
  EXPECT_EQ(built.exitCode, 0) << built.err;
}

TEST_F(TestSpoiledMaterials, PicturesOfPlysThatAreNotThereAreCounted)
{
  const std::string number = "property list uchar float texcoord\nproperty int texnumber\n";
  const std::string white0 = " (the first is face 0): they are drawn white";
  this->WritePly("a.png", { List("0.25") + " 7", List("0.75") + " 0" }, number);
  this->ExpectBuilt(
    "m.ply", { "1 face has a texnumber without a TextureFile" + white0 }, { white, blue });
  this->WritePly("a.png", { List("0.25") + " -1", List("0.75") + " 1" }, number);
  this->ExpectBuilt(
    "m.ply", { "2 faces have a texnumber without a TextureFile" + white0 }, { white, white });
  // Faces have numbers of pictures, and vertices have coordinates.
  this->WriteText("v.ply",
    "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 6\nproperty float x\n"
    "property float y\nproperty float z\nproperty float u\nproperty float v\nelement face 2\n"
    "property list uchar int vertex_indices\nproperty int texnumber\nend_header\n"
    "0 0 0 0.25 0.5\n0 1 0 0.25 0.5\n0.5 0 1 0.25 0.5\n1 0 0 0.75 0.5\n1 1 0 0.75 0.5\n"
    "1.5 0 1 0.75 0.5\n3 0 1 2 9\n3 3 4 5 0\n");
  this->ExpectBuilt("v.ply",
    { "1 triangle has a texnumber without a TextureFile (the first is triangle 0): they are "
      "drawn white" },
    { white, blue });
}

TEST_F(TestSpoiledMaterials, ListsOfPlysThatDoNotFitAreCountedOrRefused)
{
  for (const std::string list : { "0", "5 0 0 0 0 0", "7 0 0 0 0 0 0 0" })
  {
    this->WritePly("a.png", { list, List("0.75") });
    this->ExpectBuilt("m.ply",
      { "1 face has a texcoord whose length does not match its corners (the first is face 0): they "
        "are "
        "drawn white" },
      { white, blue });
  }
  this->WritePly("a.png", { List("nan"), List("0.75") });
  this->ExpectBuilt("m.ply",
    { "1 triangle has no texture coordinates, or ones that are not numbers (the first is triangle "
      "0): the material's colour is used" },
    { white, blue });
  const std::string huge = "property list uint float texcoord\n";
  this->WritePly("a.png", { List("0.25"), "4000000000 0 0" }, huge);
  this->ExpectRefused("m.ply", "face 1");
  this->WritePly("a.png", { List("0.25"), "-6 0 0" }, "property list int float texcoord\n");
  this->ExpectRefused("m.ply", "face 1");
  this->WritePly("a.png", { List("0.25"), "6 0 0 0 0 0" });
  this->ExpectRefused("m.ply", "face 1");
  // Without coordinates the picture is not used.
  this->WritePly("a.png", { "", "" }, "");
  this->ExpectBuilt(
    "m.ply", { "not supported by this version and left out: texture 'a.png'" }, { white, white });
}
