// SPDX-License-Identifier: BSD-3-Clause
// Textured meshes through the programs, OBJ by its materials and PLY by its texture files: vertex
// colours, and every warning about what could not be kept. TestTexturedGltf tests glTF, and
// TestTexturedBuild what a build adds.
#include "Testing/EndToEnd/Textures/BakedColors.h"

#include <nlohmann/json.hpp>

using namespace kdstream;
using namespace kdstream::fixtures;
using Json = nlohmann::json;

namespace
{

class TestTextures : public BakedColorsTest
{
};

}

TEST_F(TestTextures, ObjIsColoredByItsMaterials)
{
  this->WritePicture("a.png", Row({ red, blue }), PictureType::Png);
  this->WriteText("m.mtl", "newmtl a\nKd 0.1 0.1 0.1\nmap_Kd a.png\n");
  this->WriteText("m.obj", Faces(leftAndRight));
  const Outcome built = this->Build({ "m.obj", "-o", "m.kds", "--quiet", "--stats", "s.json" });
  EXPECT_EQ(built.exitCode, 0);
  EXPECT_EQ(built.err, "");
  const Json stats = Json::parse(ReadWhole(this->Folder / "s.json"));
  EXPECT_EQ(stats["textures"]["pictures"], 1);
  EXPECT_EQ(stats["textures"]["texels"], 0);
  EXPECT_NEAR(stats["textures"]["loss"].get<double>(), 0, 1e-3);
  EXPECT_EQ(stats["input"], "m.obj");
  EXPECT_EQ(WarningsOf("m.obj"), "");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ red, blue }));
  EXPECT_EQ(Find(this->Read("out.ply"), "TCoords"), nullptr);
}

TEST_F(TestTextures, MapsHaveOptionsAndNamesWithBlanks)
{
  this->WritePicture("a b.png", Row({ red, blue }), PictureType::Png);
  const auto colors = [&](const std::string& map, std::vector<std::array<float, 2>> at)
  {
    this->WriteText("m.mtl", "newmtl a\nmap_Kd " + map + "\n");
    this->WriteText("m.obj", Faces(at));
    EXPECT_EQ(WarningsOf("m.obj"), "") << map;
    return ColorsOf(this->Read("out.ply"));
  };
  const std::vector<std::array<float, 2>> outside{ { 1.25F, 0 }, { -0.25F, 0 } };
  EXPECT_EQ(colors("a b.png", leftAndRight), (std::vector{ red, blue }));
  EXPECT_EQ(colors("-o 0.5 0 0 a b.png", leftAndRight), (std::vector{ blue, red }));
  EXPECT_EQ(colors("-s 3 -bm 2 a b.png", leftAndRight), (std::vector{ blue, red }));
  EXPECT_EQ(colors("a b.png", outside), (std::vector{ red, blue }));
  EXPECT_EQ(colors("-mm 0 1 -clamp on a b.png", outside), (std::vector{ blue, red }));
  EXPECT_EQ(colors("C:\\scans\\a b.png", leftAndRight), (std::vector{ red, blue }));
  EXPECT_EQ(colors("/home/me/a b.png", leftAndRight), (std::vector{ red, blue }));
  EXPECT_EQ(colors("../../a b.png", leftAndRight), (std::vector{ red, blue }));
}

TEST_F(TestTextures, TheLowerEdgeOfAPictureIsAtVZero)
{
  Picture picture = Row({ red, blue });
  std::swap(picture.width, picture.height); // red is above
  this->WritePicture("a.png", picture, PictureType::Png);
  this->WriteText("m.mtl", "newmtl a\nmap_Kd a.png\n");
  this->WriteText("m.obj", Faces({ { 0.5F, 0.25F }, { 0.5F, 0.75F } }));
  EXPECT_EQ(WarningsOf("m.obj"), "");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ blue, red }));
}

TEST_F(TestTextures, PicturesAreFoundAsPeopleNameThem)
{
  this->WritePicture("my t.png", Row({ red, blue }), PictureType::Png);
  this->WriteText("m.obj", Faces(leftAndRight));
  for (const std::string name : { "\"my t.png\"", "Textures\\My T.PNG", "-s 1 1 1 'my t.png'",
         "C:\\scans\\MY T.png", "my t.png # paint" })
  {
    SCOPED_TRACE(name);
    this->WriteText("m.mtl", "newmtl a\nKd 0 1 0\nmap_Kd " + name + "\n");
    EXPECT_EQ(WarningsOf("m.obj"), "");
    EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ red, blue }));
  }
}

TEST_F(TestTextures, TilesHaveTheirOwnPictures)
{
  this->WritePicture("t.1001.png", Row({ red }), PictureType::Png);
  this->WritePicture("t.1012.png", Row({ green, blue }), PictureType::Png);
  this->WriteText("m.mtl", "newmtl a\nKd 0 0 0\nmap_Kd t.<UDIM>.png\n");
  this->WriteText(
    "m.obj", Faces({ { 0.5F, 0.5F }, { 1.75F, 1.5F }, { 1.25F, 1.5F }, { 3.5F, 0 }, { -1, 0 } }));
  EXPECT_EQ(WarningsOf("m.obj"),
    "the picture 't.1004.png' (m.mtl, line 3) is not there: the material's colour is used\n");
  const std::array<std::uint8_t, 3> black{};
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ red, blue, green, black, black }));
}

TEST_F(TestTextures, WhatIsMissingIsNamedAndTheRestIsBuilt)
{
  this->WritePicture("a.png", Row({ red, blue }), PictureType::Png);
  this->WriteText("m.mtl",
    "newmtl a\nmap_Kd a.png\nmap_Bump n.png\nnewmtl b\nKd 0 1 0\nmap_Kd gone.png\nmap_Bump n.png\n"
    "map_Ks s.png\nnewmtl c\nKd 0 x 0\n");
  this->WriteText(
    "m.obj", Faces(leftAndRight, "mtllib m.mtl\nmtllib other.mtl\nusemtl a\n") +
               "usemtl b\nv 9 0 0\nv 9 1 0\nv 9 0 1\nf -3/1 -2/1 -1/1\nusemtl d\nusemtl d\n"
               "v 8 0 0\nv 8 1 0\nv 8 0 1\nf -3/1 -2/1 -1/1\n");
  EXPECT_EQ(WarningsOf("m.obj"),
    "m.mtl, line 10 cannot be read: 'Kd 0 x 0'\n"
    "line 2: the materials 'other.mtl' are not there: they are drawn white\n"
    "left out: textures of materials: map_Bump, map_Ks\n"
    "line 19: the material 'd' is in no material library: it is drawn white\n"
    "the picture 'gone.png' (m.mtl, line 6) is not there: the material's colour is used\n");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")),
    (std::vector{ red, blue, green, std::array<std::uint8_t, 3>{ 255, 255, 255 } }));
  // Without any picture the mesh is read as before, in chunks.
  this->WriteText("bare.obj", Faces(leftAndRight, "mtllib none.mtl\nusemtl a\n"));
  const Outcome built = this->Build({ "bare.obj", "-o", "m.kds", "--quiet" });
  EXPECT_EQ(built.err, "kdstream-build: warning: bare.obj: line 1: the materials 'none.mtl' are "
                       "not there: they are drawn white\n");
}

TEST_F(TestTextures, FacesWithoutCoordinatesAreCounted)
{
  this->WritePicture("a.png", Row({ red, blue }), PictureType::Png);
  this->WriteText("m.mtl", "newmtl a\nKd 0 1 0\nmap_Kd a.png\n");
  this->WriteText(
    "m.obj", Faces(leftAndRight) +
               "v 9 0 0\nv 9 1 0\nv 9 0 1\nf 7 8 9\nvt nan 0\nv 8 0 0\nv 8 1 0\nv 8 0 1\n"
               "f 10/3 11/1 12/1\n");
  EXPECT_EQ(WarningsOf("m.obj"),
    "2 triangles have no texture coordinates, or ones that are not numbers (the first is triangle "
    "2): the material's colour is used\n");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ red, blue, green, green }));
}

TEST_F(TestTextures, PicturesAreTakenForWhatTheyAre)
{
  this->WriteText("m.mtl", "newmtl a\nKd 0 1 0\nmap_Kd a.jpg\n");
  this->WriteText("m.obj", Faces(leftAndRight));
  this->WritePicture("a.jpg", Row({ red, blue }), PictureType::Png);
  EXPECT_EQ(WarningsOf("m.obj"),
    "the picture 'a.jpg' (m.mtl, line 3) is named as a JPEG file but contains a PNG\n");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ red, blue }));
  const auto expect = [&](const std::string& what)
  {
    EXPECT_EQ(WarningsOf("m.obj"),
      "the picture 'a.jpg' (m.mtl, line 3): " + what + ": the material's colour is used\n");
    EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ green, green }));
  };
  const std::string whole = ReadWhole(this->Folder / "a.jpg");
  this->WriteText("a.jpg", whole.substr(0, whole.size() / 2));
  expect("it is a damaged or truncated PNG (it ends too early)");
  this->WriteText("a.jpg", "");
  expect("it is empty");
  this->WriteText("a.jpg", "GIF89a");
  expect("it is neither JPEG, PNG nor WebP");
  this->WritePicture("a.jpg", Row({ red, blue, red }), PictureType::Webp);
  const Outcome built = this->Build({ "m.obj", "-o", "m.kds", "--quiet", "--texture-pixels", "2" });
  EXPECT_EQ(built.err,
    "kdstream-build: warning: m.obj: the picture 'a.jpg' (m.mtl, line 3): it claims 3 x 1 pixels, "
    "more than the limit of 2: the material's colour is used\n");
}

TEST_F(TestTextures, HostileMaterialsAreBounded)
{
  this->WritePicture("a.png", Row({ red, blue }), PictureType::Png);
  this->WriteText("m.mtl", "newmtl a\nmap_Kd a.png\n");
  // Libraries beyond a limit are left out. A library, or a mesh, that names itself as a library
  // does no harm.
  std::string names;
  for (int i = 0; i < 300; ++i)
  {
    names += "mtllib x" + std::to_string(i) + ".mtl\n";
  }
  this->WriteText("many.obj", Faces(leftAndRight, "mtllib m.mtl\nusemtl a\n") + names);
  const std::string warnings = WarningsOf("many.obj");
  EXPECT_NE(warnings.find("line 268: the materials 'x255.mtl' and what follows are left out: more "
                          "than 256 libraries\n"),
    std::string::npos)
    << warnings;
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ red, blue }));
  this->WriteText("m.mtl",
    "newmtl a\nmap_Kd a.png\nmtllib m.mtl\nmap_Kd\nnewmtl a\nmap_Kd -o\n"
    "newmtl b\nmap_Kd -o nan 1 1 a.png\nmap_Kd -s 1e999 a.png\nmap_Kd -o x y\n");
  this->WriteText("self.obj", Faces(leftAndRight, "mtllib m.mtl self.obj m.mtl\nusemtl a\n"));
  EXPECT_EQ(WarningsOf("self.obj"),
    "m.mtl, line 4 cannot be read: 'map_Kd'\n"
    "m.mtl, line 6 cannot be read: 'map_Kd -o'\n"
    "m.mtl, line 8 cannot be read: 'map_Kd -o nan 1 1 a.png'\n"
    "the material 'a' is in 'm.mtl' twice with different values: the first is used\n");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ red, blue }));
}

TEST_F(TestTextures, ErrorsOfAnObjNameFaceAndLine)
{
  this->WritePicture("a.png", Row({ red, blue }), PictureType::Png);
  this->WriteText("m.mtl", "newmtl a\nmap_Kd a.png\n");
  const std::string good = Faces(leftAndRight);
  const struct
  {
    std::string line, error;
  } cases[] = {
    { "f 1 2 -99", "face 2 (line 13) names vertex -99, but only 6 come before it" },
    { "f 1 2 x", "face 2 (line 13): 'x' is not the number of a vertex" },
    { "v 1 2 z", "vertex 6 (line 13): 'z' is not a number" },
    { "vt q", "texture coordinate 2 (line 13): 'q' is not a number" },
    { "vn 1 2", "normal 0 (line 13): " },
  };
  for (const auto& c : cases)
  {
    this->WriteText("m.obj", good + c.line + "\n");
    this->ExpectError("m.obj", c.error);
  }
}

TEST_F(TestTextures, PlyIsTexturedByItsTextureFiles)
{
  this->WritePicture("a b.png", Row({ red, blue }), PictureType::Png);
  this->WritePicture("c.jpg", Row({ green }), PictureType::Png);
  const std::string points = "element vertex 9\nproperty float x\nproperty float y\nproperty float "
                             "z\nelement face 3\nproperty list uchar int vertex_indices\n";
  const std::string head =
    "ply\nformat ascii 1.0\ncomment TextureFile a b.png\ncomment TextureFile "
    "/x/c.jpg\n" +
    points;
  std::string places;
  for (int i = 0; i < 3; ++i)
  {
    const std::string x = std::to_string(i);
    places += x + " 0 0\n" + x + " 1 0\n" + x + " 0 1\n";
  }
  const auto list = [](const std::string& at)
  { return " 6 " + at + " 0.5 " + at + " 0.5 " + at + " 0.5"; };
  this->WriteText(
    "m.ply", head + "property list uchar float texcoord\nproperty int texnumber\nend_header\n" +
               places + "3 0 1 2" + list("0.25") + " 0\n3 3 4 5" + list("0.75") + " 0\n3 6 7 8" +
               list("0.5") + " 1\n");
  EXPECT_EQ(WarningsOf("m.ply"),
    "the picture 'c.jpg' (TextureFile) is named as a JPEG file but contains a PNG\n");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ red, blue, green }));
  const std::array<std::uint8_t, 3> white{ 255, 255, 255 };
  this->WriteText(
    "m.ply", head + "property list uchar float texcoord\nproperty int texnumber\nend_header\n" +
               places + "3 0 1 2 4 0.25 0.5 0.25 0.5 0\n3 3 4 5" + list("0.75") + " 0\n3 6 7 8" +
               list("nan") + " 2\n");
  EXPECT_EQ(WarningsOf("m.ply"),
    "1 face has a texcoord whose length does not match its corners (the first is face 0): they are "
    "drawn white\n"
    "1 face has a texnumber without a TextureFile (the first is face 2): they are drawn white\n");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ white, blue, white }));
  this->WriteText("m.ply", head + "property list uchar float texcoord\nend_header\n" + places +
                             "3 0 1 2" + list("0.25") + "\n3 3 4 5" + list("0.75") +
                             "\n3 6 7 8 6 0.25 x 0 0 0 0\n");
  this->ExpectError("m.ply", "face 2");
  // Coordinates of vertices.
  std::string own = head;
  own.replace(own.find("element face"), 0,
    "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float s\nproperty "
    "float t\n");
  std::string coloredLines;
  std::istringstream lines(places);
  for (std::string line; std::getline(lines, line);)
  {
    coloredLines += line + " 9 9 9 " + (line[0] == '0' ? "0.25" : "0.75") + " 0\n";
  }
  this->WriteText("m.ply", own + "end_header\n" + coloredLines + "3 0 1 2\n3 3 4 5\n3 6 7 8\n");
  EXPECT_EQ(WarningsOf("m.ply"), "vertex colours are left out: textures replace them\n");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ red, blue, blue }));
}
