// SPDX-License-Identifier: BSD-3-Clause
// kdstream-build with textured meshes of any format: its messages about pictures that it does not
// keep, the files that it depends on, and the same store however it is built.
#include "Testing/EndToEnd/Textures/BakedColors.h"
#include "Testing/Fixtures/Meshes.h"

#include <nlohmann/json.hpp>

#include <map>

using namespace kdstream;
using namespace kdstream::fixtures;
using Json = nlohmann::json;

namespace
{

class TestTexturedBuild : public BakedColorsTest
{
protected:
  // Builds the file, and returns the store's digest; the statistics are in s.json.
  std::string Digest(const std::string& file, std::vector<std::string> more = {})
  {
    more.insert(more.begin(), { file, "-o", "m.kds", "--quiet", "--stats", "s.json" });
    const Outcome built = this->Build(more);
    EXPECT_EQ(built.exitCode, 0) << built.err;
    return built.exitCode == 0 ? Json::parse(ReadWhole(this->Folder / "s.json"))["digest"] : "";
  }
};

}

// There is nothing to report if the original keeps the pictures.
TEST_F(TestTexturedBuild, ABuildWarnsOfWhatIsLostWherePicturesAreNotKept)
{
  this->WritePicture("a.png", Row({ red, blue }), PictureType::Png);
  this->WriteText("m.mtl", "newmtl a\nmap_Kd a.png\n");
  this->WriteText("m.obj", Faces(leftAndRight));
  const std::string note =
    "kdstream-build: note: m.obj: the original keeps the pictures, and levels have them with fewer "
    "texels; vertex colours are their means (about 0 texels a vertex)\n";
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
}

// COLOR_0 multiplies the picture's colours: so does the tile's.
TEST_F(TestTexturedBuild, GltfWithColoursOfVerticesKeepsItsPictures)
{
  this->WritePicture("a.png", Row({ red, blue }), PictureType::Png);
  GltfBuffer buffer;
  std::vector<float> tints;
  for (int i = 0; i < 18; ++i)
  {
    tints.push_back(i < 9 ? 0.5F : float(i % 4) / 3); // one tint, and nine
  }
  const int tint = buffer.Add(tints, "VEC3", gltfFloat);
  std::string gltf = Scene(buffer, leftAndRight, Textured(),
    "\"images\":[{\"uri\":\"a.png\"}],\"textures\":[{\"source\":0}]", false);
  const std::string attributes = "\"attributes\":{";
  gltf.insert(
    gltf.find(attributes) + attributes.size(), "\"COLOR_0\":" + std::to_string(tint) + ",");
  this->WriteText("m.gltf", gltf);
  this->WriteText("b.bin", buffer.Bytes);
  const Outcome built =
    this->Build({ "m.gltf", "-o", "m.kds", "--quiet", "--texture-quality", "lossless" });
  EXPECT_EQ(built.exitCode, 0);
  EXPECT_EQ(built.err, "");
  EXPECT_EQ(this->Store({ "extract", "m.kds", "--all", "-o", "out.glb", "--quiet" }).exitCode, 0);
  EXPECT_NE(ReadWhole(this->Folder / "out.glb").find("image/png"), std::string::npos);
  const auto colorsOf = [&](const std::string& input)
  {
    EXPECT_EQ(this->Convert(input).exitCode, 0);
    const Mesh mesh = this->Read("out.ply");
    const std::vector<double> values = ValuesOf(mesh, "RGB");
    std::map<Vec3, std::array<double, 3>> colors;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
    {
      colors[mesh.points[v]] = { values[3 * v], values[3 * v + 1], values[3 * v + 2] };
    }
    return colors;
  };
  // The vertex colours of the result are means over a triangle: those of one tint are the same,
  // the others are in the same order.
  const auto before = colorsOf("m.gltf"), after = colorsOf("out.glb");
  ASSERT_EQ(before.size(), 6U);
  for (const auto& [place, color] : before)
  {
    ASSERT_TRUE(after.contains(place));
    for (const auto& [other, otherColor] : before)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        if (place[0] == 0)
        {
          EXPECT_NEAR(after.at(place)[k], color[k], 1);
        }
        else if (other[0] == 1 && color[k] > otherColor[k] + 20)
        {
          EXPECT_GT(after.at(place)[k], after.at(other)[k]);
        }
      }
    }
  }
}

// The digest by which a server recognizes the same original under other options. It covers the file
// that the user named and the glTF's buffers, however the pictures have changed.
TEST_F(TestTexturedBuild, TheDigestOfTheInputIsOfWhatHoldsTheMesh)
{
  GltfBuffer buffer;
  this->WritePicture("a.png", Row({ red, blue }), PictureType::Png);
  this->WriteText(
    "m.gltf", Scene(buffer, leftAndRight, Textured(),
                "\"images\":[{\"uri\":\"a.png\"}],\"textures\":[{\"source\":0}]", false));
  this->WriteText("b.bin", buffer.Bytes);
  const auto digestOf = [this](std::vector<std::string> options)
  {
    options.insert(options.end(), { "m.gltf", "-o", "m.kds", "--stats", "s.json", "--quiet" });
    const Outcome built = this->Build(options);
    EXPECT_EQ(built.exitCode, 0) << built.err;
    const std::string stats = ReadWhole(this->Folder / "s.json"), key = "\"input_digest\": \"";
    const std::size_t place = stats.find(key);
    EXPECT_NE(place, std::string::npos) << stats;
    return place == std::string::npos ? "" : stats.substr(place + key.size(), 32);
  };
  const std::string digest = digestOf({});
  EXPECT_EQ(digestOf({ "--precision", "12", "--title", "another" }), digest);
  EXPECT_EQ(digestOf({ "--textures", "off" }), digest);
  EXPECT_EQ(digestOf({ "--textures", "colors" }), digest);
  this->WritePicture("a.png", Row({ blue, red }), PictureType::Png);
  EXPECT_EQ(digestOf({}), digest);
  std::string bytes = buffer.Bytes;
  bytes.back() = static_cast<char>(bytes.back() ^ 1);
  this->WriteText("b.bin", bytes);
  EXPECT_NE(digestOf({}), digest);
}

// Each texel counts once in a triangle, however far the coordinates reach.
TEST_F(TestTexturedBuild, CoordinatesFarOutOfRangeAreCountedSensibly)
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

TEST_F(TestTexturedBuild, OptionOffReadsInChunksAsBefore)
{
  this->WritePicture("a.png", Row({ red, blue }), PictureType::Png);
  this->WriteText("m.mtl", "newmtl a\nmap_Kd a.png\n");
  this->WriteText("m.obj", Faces(leftAndRight));
  const Outcome built =
    this->Build({ "m.obj", "-o", "m.kds", "--quiet", "--stats", "s.json", "--textures", "off" });
  EXPECT_EQ(built.err, "");
  const Json stats = Json::parse(ReadWhole(this->Folder / "s.json"));
  EXPECT_FALSE(stats.contains("textures"));
  EXPECT_FALSE(stats["seconds"].contains("convert"));
  EXPECT_EQ(stats["attributes"].size(), 1U);
  EXPECT_EQ(stats["attributes"][0]["name"], "TCoords");
}

TEST_F(TestTexturedBuild, TheFilesThatAMeshNamesAreReportedToTheBuild)
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

TEST_F(TestTexturedBuild, ObjPlyAndGlbOfOneMeshGiveOneStore)
{
  // A strip that is cut along a chart's edge, so that one place has two coordinates.
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
      // Eighths and sixteenths are exact in all formats. The second chart is upside down.
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
  // In OBJ and PLY, each place is written once.
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

  // White vertices, as modelling programs write them, change nothing; a single other colour does.
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

TEST_F(TestTexturedBuild, NeitherThreadsNorMemoryChangeTheStore)
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
