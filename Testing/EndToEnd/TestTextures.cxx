// SPDX-License-Identifier: BSD-3-Clause
// Meshes that pictures paint, through kdstream-build and kdstream-convert: colours of vertices, and
// every warning of what could not be carried.
#include "Testing/EndToEnd/ConvertTools.h"
#include "Testing/EndToEnd/GltfFile.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/texture/WritePicture.h"

#include <nlohmann/json.hpp>

using namespace kdstream;
using namespace kdstream::fixtures;
using Json = nlohmann::json;

namespace
{

// Two colours side by side, left and right; or as many as the picture is wide.
Picture Row(const std::vector<std::array<std::uint8_t, 3>>& colors)
{
  Picture picture{ colors.size(), 1, 3, {} };
  for (const auto& color : colors)
  {
    picture.texels.insert(picture.texels.end(), color.begin(), color.end());
  }
  return picture;
}

const std::array<std::uint8_t, 3> red{ 255, 0, 0 }, green{ 0, 255, 0 }, blue{ 0, 0, 255 };

class TestTextures : public ConvertTest
{
protected:
  void WritePicture(const std::string& name, const Picture& picture, PictureType type)
  {
    const std::vector<std::uint8_t> bytes = EncodePicture(picture, type);
    this->WriteText(name, std::string(bytes.begin(), bytes.end()));
  }

  // A square whose corners all lie in the middle of the picture's left, or right, half; or a face
  // of its own for each coordinate.
  static std::string Faces(const std::vector<std::array<float, 2>>& coordinates,
    const std::string& before = "mtllib m.mtl\nusemtl a\n")
  {
    std::string text = before;
    int number = 0;
    for (const auto& c : coordinates)
    {
      const std::string x = std::to_string(number);
      text += "v " + x + " 0 0\nv " + x + " 1 0\nv " + x + ".5 0 1\n";
      text += "vt " + std::to_string(c[0]) + " " + std::to_string(c[1]) + "\n";
      const auto corner = [&](int k)
      { return " " + std::to_string(3 * number + k) + "/" + std::to_string(number + 1); };
      text += "f" + corner(1) + corner(2) + corner(3) + "\n";
      ++number;
    }
    return text;
  }

  // The colour of each face of such a file.
  std::vector<std::array<std::uint8_t, 3>> ColorsOf(const Mesh& mesh)
  {
    std::vector<std::array<std::uint8_t, 3>> colors;
    const std::vector<double> values = ValuesOf(mesh, "RGB");
    for (std::size_t i = 0; i + 9 <= values.size(); i += 9)
    {
      colors.push_back(
        { std::uint8_t(values[i]), std::uint8_t(values[i + 1]), std::uint8_t(values[i + 2]) });
      EXPECT_TRUE(std::equal(&values[i], &values[i] + 3, &values[i] + 3));
    }
    return colors;
  }

  // The warning lines of kdstream-convert but the last, of how much was baked.
  std::string WarningsOf(const std::string& file)
  {
    const Outcome outcome = this->Convert(file);
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    const std::string lead = "kdstream-convert: warning: " + file + ": ";
    std::string all;
    std::istringstream lines(outcome.err);
    for (std::string line; std::getline(lines, line);)
    {
      EXPECT_EQ(line.rfind(lead, 0), 0U) << line;
      const std::string text = line.substr(std::min(lead.size(), line.size()));
      all += text.rfind("textures are baked", 0) == 0 ? "" : text + "\n";
    }
    return all;
  }

  std::string Digest(const std::string& file, std::vector<std::string> more = {})
  {
    more.insert(more.begin(), { file, "-o", "m.kds", "--quiet", "--stats", "s.json" });
    const Outcome built = this->Build(more);
    EXPECT_EQ(built.exitCode, 0) << built.err;
    return built.exitCode == 0 ? Json::parse(ReadWhole(this->Folder / "s.json"))["digest"] : "";
  }
};

const std::vector<std::array<float, 2>> leftAndRight{ { 0.25F, 0.5F }, { 0.75F, 0.5F } };

// A scene of one mesh with that material's members; more: further members of the document.
std::string Scene(GltfBuffer& buffer, const std::vector<std::array<float, 2>>& at,
  const std::string& material, const std::string& more, bool glb = true)
{
  std::vector<float> points, coordinates;
  for (std::size_t i = 0; i < at.size(); ++i)
  {
    const auto x = float(i);
    points.insert(points.end(), { x, 0, 0, x, 1, 0, x, 0, 1 });
    for (int k = 0; k < 3; ++k)
    {
      coordinates.insert(coordinates.end(), at[i].begin(), at[i].end());
    }
  }
  const int position = buffer.Add(points, "VEC3", gltfFloat, ",\"min\":[0,0,0],\"max\":[9,1,1]");
  const int texture = buffer.Add(coordinates, "VEC2", gltfFloat);
  const std::string rest =
    "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"materials\":[" + material +
    "],\"meshes\":[{\"primitives\":[{\"material\":0,\"attributes\":{\"POSITION\":" +
    std::to_string(position) + ",\"TEXCOORD_0\":" + std::to_string(texture) + "}}]}]," + more;
  return glb ? buffer.Glb(rest) : buffer.Json(rest, "b.bin");
}

std::string Textured(const std::string& more = "")
{
  return "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0" + more + "}}}";
}

}

TEST_F(TestTextures, ObjIsPaintedByItsMaterials)
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

// Nothing is amiss where the original keeps the pictures.
TEST_F(TestTextures, ABuildWarnsOfWhatIsLostWherePicturesAreNotKept)
{
  this->WritePicture("a.png", Row({ red, blue }), PictureType::Png);
  this->WriteText("m.mtl", "newmtl a\nmap_Kd a.png\n");
  this->WriteText("m.obj", Faces(leftAndRight));
  const std::string note = "kdstream-build: note: m.obj: levels are painted with the pictures' "
                           "means (about 0 texels a vertex); the original keeps the pictures\n";
  for (const char* kept : { "on", "tiles" })
  {
    const Outcome built = this->Build({ "m.obj", "-o", "m.kds", "--textures", kept });
    EXPECT_NE(built.err.find(note), std::string::npos) << built.err;
    EXPECT_EQ(built.err.find("warning"), std::string::npos) << built.err;
  }
  const std::string loss = "textures are baked to the colours of vertices: about 0 texels a "
                           "vertex; the pictures are 0.0 of 255 grey values off (RMS)\n";
  EXPECT_EQ(this->Build({ "m.obj", "-o", "m.kds", "--quiet", "--textures", "colors" }).err,
    "kdstream-build: warning: m.obj: " + loss);
  // Colours of vertices are multiplied in.
  GltfBuffer buffer;
  const int tint = buffer.Add(std::vector<float>(18, 0.5F), "VEC3", gltfFloat);
  std::string gltf = Scene(buffer, leftAndRight, Textured(),
    "\"images\":[{\"uri\":\"a.png\"}],\"textures\":[{\"source\":0}]", false);
  const std::string attributes = "\"attributes\":{";
  gltf.insert(
    gltf.find(attributes) + attributes.size(), "\"COLOR_0\":" + std::to_string(tint) + ",");
  this->WriteText("m.gltf", gltf);
  this->WriteText("b.bin", buffer.Bytes);
  EXPECT_EQ(this->Build({ "m.gltf", "-o", "m.kds", "--quiet" }).err,
    "kdstream-build: warning: m.gltf: colours of vertices are multiplied in: the pictures "
    "themselves are not kept\nkdstream-build: warning: m.gltf: " +
      loss);
}

// Each texel counts once a triangle, however far that reaches.
TEST_F(TestTextures, CoordinatesFarOutOfRangeAreCountedSensibly)
{
  this->WritePicture("a.png", Row({ red, blue }), PictureType::Png);
  this->WriteText("m.mtl", "newmtl a\nmap_Kd a.png\n");
  this->WriteText("m.obj",
    "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1e20 0\nvt 0 1e20\n"
    "f 1/1 2/2 3/3\n");
  EXPECT_NE(this->Build({ "m.obj", "-o", "m.kds", "--stats", "s.json" })
              .err.find("(about 0.667 texels a vertex)"),
    std::string::npos);
  EXPECT_EQ(Json::parse(ReadWhole(this->Folder / "s.json"))["textures"]["texels"], 2);
}

TEST_F(TestTextures, OptionOffReadsInChunksAsBefore)
{
  this->WritePicture("a.png", Row({ red, blue }), PictureType::Png);
  this->WriteText("m.mtl", "newmtl a\nmap_Kd a.png\n");
  this->WriteText("m.obj", Faces(leftAndRight));
  const Outcome built =
    this->Build({ "m.obj", "-o", "m.kds", "--quiet", "--stats", "s.json", "--textures", "off" });
  EXPECT_EQ(built.err,
    "kdstream-build: warning: m.obj: not carried by this version: materials and their textures\n");
  const Json stats = Json::parse(ReadWhole(this->Folder / "s.json"));
  EXPECT_FALSE(stats.contains("textures"));
  EXPECT_FALSE(stats["seconds"].contains("convert"));
  EXPECT_EQ(stats["attributes"].size(), 1U);
  EXPECT_EQ(stats["attributes"][0]["name"], "TCoords");
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
  std::swap(picture.width, picture.height); // red above
  this->WritePicture("a.png", picture, PictureType::Png);
  this->WriteText("m.mtl", "newmtl a\nmap_Kd a.png\n");
  this->WriteText("m.obj", Faces({ { 0.5F, 0.25F }, { 0.5F, 0.75F } }));
  EXPECT_EQ(WarningsOf("m.obj"), "");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ blue, red }));
}

TEST_F(TestTextures, TilesHaveTheirOwnPictures)
{
  this->WritePicture("t.1001.png", Row({ red }), PictureType::Png);
  this->WritePicture("t.1012.png", Row({ green, blue }), PictureType::Png);
  this->WriteText("m.mtl", "newmtl a\nKd 0 0 0\nmap_Kd t.<UDIM>.png\n");
  this->WriteText(
    "m.obj", Faces({ { 0.5F, 0.5F }, { 1.75F, 1.5F }, { 1.25F, 1.5F }, { 3.5F, 0 }, { -1, 0 } }));
  EXPECT_EQ(WarningsOf("m.obj"),
    "the picture 't.1004.png' (m.mtl, line 3) is not there: the material's colour is taken\n");
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
    "m.mtl, line 10: cannot be understood: 'Kd 0 x 0'\n"
    "line 2: the materials 'other.mtl' are not there: they count as white\n"
    "pictures of materials that are not carried: map_Bump, map_Ks\n"
    "line 19: the material 'd' is in no library: it counts as white\n"
    "the picture 'gone.png' (m.mtl, line 6) is not there: the material's colour is taken\n");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")),
    (std::vector{ red, blue, green, std::array<std::uint8_t, 3>{ 255, 255, 255 } }));
  // Without any picture the mesh is what it was, and read in chunks.
  this->WriteText("bare.obj", Faces(leftAndRight, "mtllib none.mtl\nusemtl a\n"));
  const Outcome built = this->Build({ "bare.obj", "-o", "m.kds", "--quiet" });
  EXPECT_EQ(built.err,
    "kdstream-build: warning: bare.obj: line 1: the materials 'none.mtl' are not there: they count "
    "as white\nkdstream-build: warning: bare.obj: not carried by this version: materials and their "
    "textures\n");
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
    "2 triangles have no texture coordinates, or such that are no numbers (the first is triangle "
    "2): the material's colour is taken\n");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ red, blue, green, green }));
}

TEST_F(TestTextures, PicturesAreTakenForWhatTheyAre)
{
  this->WriteText("m.mtl", "newmtl a\nKd 0 1 0\nmap_Kd a.jpg\n");
  this->WriteText("m.obj", Faces(leftAndRight));
  this->WritePicture("a.jpg", Row({ red, blue }), PictureType::Png);
  EXPECT_EQ(
    WarningsOf("m.obj"), "the picture 'a.jpg' (m.mtl, line 3): is named as JPEG, but is a PNG\n");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ red, blue }));
  const auto expect = [&](const std::string& what)
  {
    EXPECT_EQ(WarningsOf("m.obj"),
      "the picture 'a.jpg' (m.mtl, line 3): " + what + ": the material's colour is taken\n");
    EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ green, green }));
  };
  const std::string whole = ReadWhole(this->Folder / "a.jpg");
  this->WriteText("a.jpg", whole.substr(0, whole.size() / 2));
  expect("it is a damaged or truncated PNG (it ends too early)");
  this->WriteText("a.jpg", "");
  expect("it is empty");
  this->WriteText("a.jpg", "GIF89a");
  expect("it is no JPEG, PNG or WebP");
  this->WritePicture("a.jpg", Row({ red, blue, red }), PictureType::Webp);
  const Outcome built = this->Build({ "m.obj", "-o", "m.kds", "--quiet", "--texture-pixels", "2" });
  EXPECT_EQ(built.err,
    "kdstream-build: warning: m.obj: the picture 'a.jpg' (m.mtl, line 3): it claims 3 x 1 pixels, "
    "more than the limit of 2: the material's colour is taken\n");
}

TEST_F(TestTextures, TheFilesThatAMeshNamesAreToldToTheBuild)
{
  this->WritePicture("a.png", Row({ red, blue }), PictureType::Png);
  this->WriteText("m.mtl", "newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd gone.png\n");
  this->WriteText("m.obj", Faces(leftAndRight, "mtllib m.mtl\nmtllib n.mtl\nusemtl a\n"));
  const auto named = [&](const std::string& file)
  {
    std::istringstream lines(this->Convert(file, { "--progress-lines" }).err);
    std::multiset<std::string> names;
    for (std::string line; std::getline(lines, line);)
    {
      if (line.rfind("named ", 0) == 0)
      {
        names.insert(line.substr(6));
      }
    }
    return names;
  };
  using Names = std::multiset<std::string>;
  EXPECT_EQ(named("m.obj"), (Names{ "a.png", "gone.png", "m.mtl", "n.mtl" }));
  GltfBuffer buffer;
  const std::string images = "\"images\":[{\"uri\":\"a.png\"}],\"textures\":[{\"source\":0}]";
  this->WriteText("m.gltf", Scene(buffer, leftAndRight, Textured(), images, false));
  this->WriteText("b.bin", buffer.Bytes);
  EXPECT_EQ(named("m.gltf"), (Names{ "a.png", "b.bin" }));
}

TEST_F(TestTextures, HostileMaterialsAreBounded)
{
  this->WritePicture("a.png", Row({ red, blue }), PictureType::Png);
  this->WriteText("m.mtl", "newmtl a\nmap_Kd a.png\n");
  // A library that names itself is no library; the mesh as its own materials neither.
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
    "m.mtl, line 4: cannot be understood: 'map_Kd'\n"
    "m.mtl, line 6: cannot be understood: 'map_Kd -o'\n"
    "m.mtl, line 8: cannot be understood: 'map_Kd -o nan 1 1 a.png'\n");
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
    { "f 1/9 2/1 3/1", "face 2 (line 13): names texture coordinate 9, but there are 2" },
    { "f 1 2", "face 2 (line 13): a face of 2 corners" },
    { "f 1 2 -99", "face 2 (line 13): names vertex -99, but there are 6 before it" },
    { "f 1 2 x", "face 2 (line 13): 'x' is no number of a vertex" },
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

TEST_F(TestTextures, PlyIsPaintedByItsTextureFiles)
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
  EXPECT_EQ(
    WarningsOf("m.ply"), "the picture 'c.jpg' (TextureFile): is named as JPEG, but is a PNG\n");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ red, blue, green }));
  const std::array<std::uint8_t, 3> white{ 255, 255, 255 };
  this->WriteText(
    "m.ply", head + "property list uchar float texcoord\nproperty int texnumber\nend_header\n" +
               places + "3 0 1 2 4 0.25 0.5 0.25 0.5 0\n3 3 4 5" + list("0.75") + " 0\n3 6 7 8" +
               list("nan") + " 2\n");
  EXPECT_EQ(WarningsOf("m.ply"),
    "1 face has a texcoord of another length than its corners (the first is face 0): they "
    "count as white\n"
    "1 face has a texnumber that no TextureFile has (the first is face 2): they count as "
    "white\n");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ white, blue, white }));
  this->WriteText("m.ply", head + "property list uchar float texcoord\nend_header\n" + places +
                             "3 0 1 2" + list("0.25") + "\n3 3 4 5" + list("0.75") +
                             "\n3 6 7 8 6 0.25 x 0 0 0 0\n");
  this->ExpectError("m.ply", "face 2");
  // Of vertices.
  std::string own = head;
  own.replace(own.find("element face"), 0,
    "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float s\nproperty "
    "float t\n");
  std::string painted;
  std::istringstream lines(places);
  for (std::string line; std::getline(lines, line);)
  {
    painted += line + " 9 9 9 " + (line[0] == '0' ? "0.25" : "0.75") + " 0\n";
  }
  this->WriteText("m.ply", own + "end_header\n" + painted + "3 0 1 2\n3 3 4 5\n3 6 7 8\n");
  EXPECT_EQ(WarningsOf("m.ply"), "colours of vertices are left out: pictures paint instead\n");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ red, blue, blue }));
}

TEST_F(TestTextures, GltfIsPaintedByPicturesInItAndBeside)
{
  const std::string beside = "\"images\":[{\"uri\":\"a%20b.png\"}],\"textures\":[{\"source\":0}]";
  this->WritePicture("a b.png", Row({ red, blue }), PictureType::Png);
  const auto colors = [&](const std::string& material, const std::string& more)
  {
    GltfBuffer buffer;
    this->WriteText("m.glb", Scene(buffer, leftAndRight, material, more));
    EXPECT_EQ(WarningsOf("m.glb"), "") << material;
    return ColorsOf(this->Read("out.ply"));
  };
  const std::vector plain{ red, blue }, swapped{ blue, red };
  EXPECT_EQ(colors(Textured(), beside), plain);
  EXPECT_EQ(Find(this->Read("out.ply"), "TCoords"), nullptr);
  // In the file's own buffer, as WebP, and as text.
  GltfBuffer own;
  const std::vector<std::uint8_t> webp = EncodePicture(Row({ red, blue }), PictureType::Webp);
  const int view = own.AddView(webp.data(), webp.size());
  const std::string inside =
    "\"images\":[{\"mimeType\":\"image/webp\",\"bufferView\":" + std::to_string(view) +
    "}],\"textures\":[{\"extensions\":{\"EXT_texture_webp\":{\"source\":0}}}]";
  GltfBuffer apart = own;
  this->WriteText("m.glb", Scene(own, leftAndRight, Textured(), inside));
  EXPECT_EQ(WarningsOf("m.glb"), "");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), plain);
  this->WriteText("m.gltf", Scene(apart, leftAndRight, Textured(), inside, false));
  this->WriteText("b.bin", apart.Bytes);
  EXPECT_EQ(WarningsOf("m.gltf"), "");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), plain);
  // Two texels, red and blue, as a data URI.
  const std::vector<std::uint8_t> png = EncodePicture(Row({ red, blue }), PictureType::Png);
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < png.size(); i += 3)
  {
    const auto at = [&](std::size_t k) { return i + k < png.size() ? unsigned(png[i + k]) : 0U; };
    const unsigned bits = at(0) << 16U | at(1) << 8U | at(2);
    for (const unsigned shift : { 18U, 12U, 6U, 0U })
    {
      text += digits[(bits >> shift) & 63U];
    }
  }
  EXPECT_EQ(colors(Textured(), "\"images\":[{\"uri\":\"data:image/png;base64," + text +
                                 "\"}],\"textures\":[{\"source\":0}]"),
    plain);
  // Transforms, wrap modes and factors.
  const auto transform = [&](const std::string& members)
  { return Textured(",\"extensions\":{\"KHR_texture_transform\":{" + members + "}}"); };
  EXPECT_EQ(colors(transform("\"offset\":[0.5,0]"), beside), swapped);
  EXPECT_EQ(colors(transform("\"scale\":[3,1]"), beside), swapped);
  EXPECT_EQ(colors(transform("\"rotation\":3.14159265"), beside), swapped);
  // A quarter turn: u' = v, which is 0.5 at both.
  EXPECT_EQ(colors(transform("\"rotation\":1.5707963,\"offset\":[-0.25,0]"), beside),
    (std::vector{ red, red }));
  EXPECT_EQ(colors(transform("\"rotation\":-1.5707963,\"offset\":[1.25,0]"), beside),
    (std::vector{ blue, blue }));
  const std::string far = transform("\"offset\":[1,0]");
  const auto sampler = [&](const std::string& wrap)
  {
    return "\"images\":[{\"uri\":\"a%20b.png\"}],\"textures\":[{\"source\":0,\"sampler\":0}],"
           "\"samplers\":[{\"wrapS\":" +
           wrap + "}]";
  };
  EXPECT_EQ(colors(far, sampler("10497")), plain);
  EXPECT_EQ(colors(far, sampler("33648")), swapped);
  EXPECT_EQ(colors(far, sampler("33071")), (std::vector{ blue, blue }));
  EXPECT_EQ(colors("{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,0,1],\"baseColorTexture\":{"
                   "\"index\":0}}}",
              beside),
    (std::vector{ red, { 0, 0, 0 } }));
}

TEST_F(TestTextures, WhatAGltfLosesIsNamed)
{
  this->WritePicture("a.png", Row({ red, blue }), PictureType::Png);
  const std::string factor = "\"baseColorFactor\":[0,1,0,1],";
  GltfBuffer buffer;
  this->WriteText(
    "m.glb", Scene(buffer, leftAndRight,
               "{\"normalTexture\":{\"index\":0},\"emissiveTexture\":{\"index\":0},"
               "\"pbrMetallicRoughness\":{" +
                 factor +
                 "\"metallicRoughnessTexture\":{\"index\":0},"
                 "\"baseColorTexture\":{\"index\":0}}}",
               "\"images\":[{\"uri\":\"../gone.png\"}],\"textures\":[{\"source\":0}]"));
  EXPECT_EQ(WarningsOf("m.glb"),
    "pictures of materials that are not carried: normalTexture, emissiveTexture, "
    "metallicRoughnessTexture\n"
    "image 0 'gone.png' is not there: the material's colour is taken\n");
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ green, green }));
  const Outcome off = this->Convert("m.glb", { "--textures", "off" });
  EXPECT_NE(off.err.find("pictures are left out\n"), std::string::npos) << off.err;
  EXPECT_EQ(ColorsOf(this->Read("out.ply")), (std::vector{ green, green }));
  for (const std::string nodes : { "{\"children\":[0]}", "{\"children\":[1]},{\"children\":[0]}" })
  {
    GltfBuffer cyclic;
    const std::string json =
      cyclic.Json("\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[" + nodes + "]", "b.bin");
    this->WriteText("b.bin", "");
    this->WriteText("c.gltf", json);
    this->ExpectError("c.gltf", "node 0 is its own descendant");
  }
}

TEST_F(TestTextures, ObjPlyAndGlbOfOneMeshGiveOneStore)
{
  // A strip that is cut along a chart's edge: a place with two coordinates.
  Picture picture{ 32, 32, 3, std::vector<std::uint8_t>(32 * 32 * 3) };
  for (std::size_t i = 0; i < picture.texels.size(); ++i)
  {
    picture.texels[i] = static_cast<std::uint8_t>(i * 7919 >> 4);
  }
  this->WritePicture("a.png", picture, PictureType::Png);
  constexpr int side = 12;
  std::vector<float> points, coordinates; // split along the middle
  std::vector<std::uint16_t> triangles;
  std::string obj = "mtllib m.mtl\nusemtl a\n", vt, faces, ply;
  const auto place = [](int column) { return column <= side ? column : column - 1; };
  for (int column = 0; column <= 2 * side + 1; ++column)
  {
    for (int row = 0; row <= side; ++row)
    {
      const float x = float(place(column)) / 8, y = float(row) / 8,
                  z = float((row * row + place(column)) % 5) / 16;
      // Eighths and sixteenths, exact in all formats; the second chart is upside down.
      const float u = float(place(column)) / 32,
                  v = column <= side ? float(row) / 16 : 1 - float(row) / 16;
      points.insert(points.end(), { x, y, z });
      coordinates.insert(coordinates.end(), { u, v });
    }
  }
  const auto number = [](int column, int row) { return column * (side + 1) + row; };
  for (int column = 0; column < 2 * side + 1; ++column)
  {
    for (int row = 0; row < side && column != side; ++row)
    {
      const int a = number(column, row), b = number(column + 1, row),
                c = number(column + 1, row + 1), d = number(column, row + 1);
      for (const int corner : { a, b, c, a, c, d })
      {
        triangles.push_back(static_cast<std::uint16_t>(corner));
      }
    }
  }
  // OBJ and PLY have each place once.
  const auto once = [&](int vertex)
  {
    const int column = vertex / (side + 1);
    return number(place(column), vertex % (side + 1));
  };
  std::string plyPoints;
  char line[300];
  for (int v = 0; v < number(2 * side + 1, 0); ++v)
  {
    const int split = v / (side + 1) <= side ? v : v + side + 1;
    std::snprintf(line, sizeof line, "%g %g %g\n", double(points[std::size_t(3 * split)]),
      double(points[std::size_t(3 * split + 1)]), double(points[std::size_t(3 * split + 2)]));
    obj += std::string("v ") + line;
    plyPoints += line;
  }
  for (std::size_t v = 0; v < coordinates.size(); v += 2)
  {
    std::snprintf(
      line, sizeof line, "vt %g %g\n", double(coordinates[v]), 1 - double(coordinates[v + 1]));
    obj += line;
  }
  for (std::size_t t = 0; t < triangles.size(); t += 3)
  {
    std::string corners, list;
    obj += "f";
    for (std::size_t k = 0; k < 3; ++k)
    {
      const int v = triangles[t + k];
      obj += " " + std::to_string(once(v) + 1) + "/" + std::to_string(v + 1);
      corners += " " + std::to_string(once(v));
      std::snprintf(line, sizeof line, " %g %g", double(coordinates[std::size_t(2 * v)]),
        1 - double(coordinates[std::size_t(2 * v + 1)]));
      list += line;
    }
    obj += "\n";
    ply += "3" + corners + " 6" + list + "\n";
  }
  this->WriteText("m.obj", obj);
  this->WriteText("m.mtl", "newmtl a\nmap_Kd a.png\n");
  this->WriteText("m.ply",
    "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex " +
      std::to_string(number(2 * side + 1, 0)) +
      "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
      std::to_string(triangles.size() / 3) +
      "\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n" +
      plyPoints + ply);
  GltfBuffer buffer;
  const int position = buffer.Add(points, "VEC3", gltfFloat, ",\"min\":[0,0,0],\"max\":[9,9,9]");
  const int texture = buffer.Add(coordinates, "VEC2", gltfFloat);
  const int index = buffer.Add(triangles, "SCALAR", gltfUnsignedShort);
  const auto glb = [&](const std::string& more)
  {
    return buffer.Glb(
      "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"materials\":[" +
      Textured() +
      "],\"images\":[{\"uri\":\"a.png\"}],\"textures\":[{\"source\":0}],\"meshes\":[{"
      "\"primitives\":[{\"material\":0,\"indices\":" +
      std::to_string(index) + ",\"attributes\":{\"POSITION\":" + std::to_string(position) +
      ",\"TEXCOORD_0\":" + std::to_string(texture) + more + "}}]}]");
  };
  this->WriteText("m.glb", glb(""));
  const std::string digest = this->Digest("m.obj");
  EXPECT_EQ(Json::parse(ReadWhole(this->Folder / "s.json"))["vertices"], number(2 * side + 1, 0));
  EXPECT_EQ(this->Digest("m.ply"), digest);
  EXPECT_EQ(this->Digest("m.glb"), digest);
  EXPECT_EQ(Json::parse(ReadWhole(this->Folder / "s.json"))["textures"]["pictures"], 1);

  // White vertices, as modellers write them, change nothing; a single one that is not does.
  std::vector<float> colors(points.size(), 1);
  const int white = buffer.Add(colors, "VEC3", gltfFloat);
  this->WriteText("white.glb", glb(",\"COLOR_0\":" + std::to_string(white)));
  EXPECT_EQ(this->Digest("white.glb"), digest);
  colors.back() = 0.5F;
  const int tinted = buffer.Add(colors, "VEC3", gltfFloat);
  this->WriteText("tinted.glb", glb(",\"COLOR_0\":" + std::to_string(tinted)));
  EXPECT_NE(this->Digest("tinted.glb"), digest);
  EXPECT_EQ(WarningsOf("tinted.glb"), "");
}

TEST_F(TestTextures, NeitherThreadsNorMemoryChangeTheStore)
{
  Picture picture{ 64, 64, 3, std::vector<std::uint8_t>(64 * 64 * 3) };
  for (std::size_t i = 0; i < picture.texels.size(); ++i)
  {
    picture.texels[i] = static_cast<std::uint8_t>(i * 7919 >> 3);
  }
  this->WritePicture("a.png", picture, PictureType::Png);
  this->WriteText("m.mtl", "newmtl a\nmap_Kd a.png\n");
  const Mesh sphere = DisplacedSphere(5);
  std::string text = "mtllib m.mtl\nusemtl a\n";
  for (const Vec3& p : sphere.points)
  {
    char line[200];
    std::snprintf(
      line, sizeof line, "v %.6f %.6f %.6f\nvt %.6f %.6f\n", p[0], p[1], p[2], p[0], p[1]);
    text += line;
  }
  for (const Triangle& t : sphere.triangles)
  {
    text += "f";
    for (const VertexId v : t)
    {
      text += " " + std::to_string(v + 1) + "/" + std::to_string(v + 1);
    }
    text += "\n";
  }
  this->WriteText("m.obj", text);
  const std::string digest = this->Digest("m.obj");
  EXPECT_EQ(this->Digest("m.obj", { "--threads", "1" }), digest);
  EXPECT_EQ(this->Digest("m.obj", { "--memory", "64M" }), digest);
  EXPECT_NE(this->Digest("m.obj", { "--textures", "off" }), digest);
}
