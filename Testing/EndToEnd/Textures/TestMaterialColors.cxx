// SPDX-License-Identifier: BSD-3-Clause
// Meshes with more or less than pictures: materials with only colours, coordinates that are not
// places in a picture, incomplete parts. Tests what is kept, and how the rest is reported.
#include "Testing/EndToEnd/GltfFile.h"
#include "Testing/EndToEnd/Textures/TexturedFiles.h"

#include <array>
#include <map>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

class TestMaterialColors : public TexturedTest
{
protected:
  std::string WarningsOf(const std::string& file, const std::vector<std::string>& more = {})
  {
    std::vector<std::string> arguments{ file, "-o", "m.kds", "--quiet" };
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome built = this->Build(arguments);
    EXPECT_EQ(built.exitCode, 0) << built.err;
    return built.err;
  }
};

}

// Two adjacent triangles with the materials a and b, and a separate triangle with the material a.
TEST_F(TestMaterialColors, ColoursOfMaterialsBecomeThoseOfVertices)
{
  const std::string lead = "kdstream-build: warning: m.obj: ";
  const std::string left =
    lead + "not supported by this version and left out: materials and their textures\n";
  const auto colors = [&](const std::string& materials, const std::string& place,
                        const std::vector<std::string>& more, const std::string& warnings)
  {
    this->WriteText("m.mtl", materials);
    this->WriteText("m.obj", "mtllib m.mtl\nv 0 0 0" + place + "\nv 1 0 0" + place + "\nv 0 1 0" +
                               place + "\nv 1 1 0" + place + "\nv 5 5 5" + place + "\nv 6 5 5" +
                               place + "\nv 5 6 5" + place +
                               "\nusemtl a\nf 1 2 3\nusemtl b\nf 2 4 3\nusemtl a\nf 5 6 7\n");
    std::vector<std::string> all = more;
    all.insert(all.end(), { "--precision", "lossless" });
    EXPECT_EQ(this->WarningsOf("m.obj", all), warnings) << materials;
    EXPECT_EQ(this->Store({ "extract", "m.kds", "--all", "-o", "out.ply", "--quiet" }).exitCode, 0);
    const Mesh mesh = this->Read("out.ply");
    std::map<Vec3, std::array<double, 3>> found;
    for (std::size_t v = 0; v < mesh.points.size() && !mesh.attributes.empty(); ++v)
    {
      const Attribute& rgb = mesh.attributes[0];
      found[mesh.points[v]] = { rgb.Get(v, 0), rgb.Get(v, 1), rgb.Get(v, 2) };
    }
    return found;
  };
  const std::string redAndBlue = "newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 0 1\n";
  auto found = colors(redAndBlue, "", {}, "");
  const double mean = ByteOfLinear(0.5);
  EXPECT_EQ(found[(Vec3{ 0, 0, 0 })], (std::array<double, 3>{ 255, 0, 0 }));
  EXPECT_EQ(found[(Vec3{ 1, 1, 0 })], (std::array<double, 3>{ 0, 0, 255 }));
  EXPECT_EQ(found[(Vec3{ 1, 0, 0 })], (std::array<double, 3>{ mean, 0, mean }));
  EXPECT_EQ(found[(Vec3{ 5, 6, 5 })], (std::array<double, 3>{ 255, 0, 0 }));
  // Colours are kept if one is not grey, or if there are two greys. They are not kept if there is
  // one grey, or if no face has the colour. The last mesh has vertices with colours.
  EXPECT_EQ(colors("newmtl a\nKd 1 0 0\nnewmtl b\nKd 1 0 0\n", "", {}, "").size(), 7U);
  EXPECT_EQ(colors("newmtl a\nKd 0.5 0.5 0.5\nnewmtl b\nKd 1 1 1\n", "", {}, "").size(), 7U);
  EXPECT_TRUE(colors("newmtl a\nKd 0.8 0.8 0.8\nnewmtl b\nKd 0.8\n", "", {}, "").empty());
  EXPECT_TRUE(colors("newmtl a\nKd 1 1 1\nnewmtl b\nnewmtl c\nKd 1 0 0\n", "", {}, "").empty());
  EXPECT_TRUE(colors("newmtl a\nKd 0.8 0.8 0.8\n", "", {},
    lead + "line 11: the material 'b' is in no material library: it is drawn white\n")
                .empty());
  EXPECT_EQ(colors(redAndBlue, " 0 1 0", {}, left)[(Vec3{ 0, 0, 0 })],
    (std::array<double, 3>{ 0, 255, 0 }));
  EXPECT_TRUE(colors(redAndBlue, "", { "--textures", "off" }, "").empty());
}

TEST_F(TestMaterialColors, CoordinatesWithoutAPlaceAreCounted)
{
  const std::vector<std::uint8_t> png =
    EncodePicture({ 2, 2, 1, { 10, 90, 160, 250 } }, PictureType::Png);
  this->WriteText("a.png", { png.begin(), png.end() });
  this->WriteText("m.mtl", "newmtl a\nmap_Kd a.png\n");
  const auto warning = [&](const std::string& coordinate)
  {
    this->WriteText("m.obj",
      "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0.1 0.1\nvt 0.9 0.1\nvt 0.1 "
      "0.9\nvt " +
        coordinate + "\nf 1/1 2/2 3/3\nf 2/4 4/3 3/1\nf 2/4 4/4 3/4\n");
    return this->WarningsOf("m.obj");
  };
  const std::string lead = "kdstream-build: warning: m.obj: ";
  const std::string far = lead +
                          "2 triangles have texture coordinates of 2^30 texels or more, which "
                          "are not places in a picture\n";
  for (const char* huge : { "6e8 0", "0 -3e9", "1e12 1e12", "1e30 0", "-3e38 3e38" })
  {
    EXPECT_EQ(warning(huge), far) << huge;
  }
  EXPECT_EQ(warning("1 0.5"), "");
  EXPECT_EQ(warning("100 0"), lead + "1 triangle repeats a texture more than twice along one side: "
                                     "painted in the texture's mean colour\n");
}

TEST_F(TestMaterialColors, TrianglesThatAreNotWholeAreSaid)
{
  const auto warning = [&](std::size_t first, std::size_t second, bool indexed)
  {
    GltfBuffer buffer;
    std::string primitives;
    for (const std::size_t corners : { first, second })
    {
      std::vector<float> points;
      std::vector<std::uint16_t> indices;
      const std::size_t whole = corners / 3 * 3; // the remaining corners belong to no triangle
      for (std::size_t i = 0; i < corners; ++i)
      {
        if (i < whole || !indexed)
        {
          points.insert(points.end(), { float(i), float(i * i % 7), float(primitives.size()) });
        }
        indices.push_back(static_cast<std::uint16_t>(i % whole));
      }
      const int position =
        buffer.Add(points, "VEC3", gltfFloat, ",\"min\":[0,0,0],\"max\":[99,9,99]");
      primitives += std::string(primitives.empty() ? "" : ",") +
                    "{\"attributes\":{\"POSITION\":" + std::to_string(position) + "}" +
                    (indexed ? ",\"indices\":" +
                                 std::to_string(buffer.Add(indices, "SCALAR", gltfUnsignedShort))
                             : "") +
                    "}";
    }
    this->WriteText(
      "m.glb", buffer.Glb("\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
                          "\"meshes\":[{\"primitives\":[" +
                          primitives + "]}]"));
    return this->WarningsOf("m.glb");
  };
  const std::string lead = "kdstream-build: warning: m.glb: ";
  const std::string after = " of triangles, which is not a multiple of three\n";
  EXPECT_EQ(warning(9, 6, true), "");
  EXPECT_EQ(warning(9, 7, true),
    lead +
      "1 face has fewer than three corners and is dropped: mesh 0, part 1: the last of 7 indices" +
      after);
  EXPECT_EQ(warning(11, 7, true), lead +
                                    "2 faces have fewer than three corners and are dropped; the "
                                    "first: mesh 0, part 0: the last of 11 indices" +
                                    after);
}
