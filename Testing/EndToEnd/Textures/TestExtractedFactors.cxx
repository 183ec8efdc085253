// SPDX-License-Identifier: BSD-3-Clause
// Materials in an extracted model: several factors with one picture, and texels beyond the
// picture's edges.
#include "Testing/EndToEnd/GltfFile.h"
#include "Testing/EndToEnd/Textures/TexturedFiles.h"

#include <array>
#include <set>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

// A way in which materials show the picture. The index of a way is also its height (z) in the mesh.
struct ShownAs
{
  Color factor;
  bool opaque;
};

const std::vector<ShownAs> ways{ { { 1, 0.25, 1, 1 }, true }, { { 0.5, 1, 0.125, 1 }, true },
  { { 1, 1, 1, 0.5 }, false }, { { 1, 1, 1, 1 }, true } };

class TestExtractedFactors : public TexturedTest
{
protected:
  // Writes a square of small squares for each way, all with the same texture coordinates.
  void WriteScene(const Picture& picture)
  {
    const std::vector<std::uint8_t> bytes = EncodePicture(picture, PictureType::Png);
    this->WriteText("p.png", { bytes.begin(), bytes.end() });
    GltfBuffer buffer;
    std::string materials, primitives;
    for (std::size_t way = 0; way < ways.size(); ++way)
    {
      std::vector<float> points, coordinates;
      constexpr int side = 12;
      for (int i = 0; i < side * side; ++i)
      {
        for (const auto& [x, y] :
          { std::array{ 0, 0 }, { 1, 0 }, { 0, 1 }, { 1, 0 }, { 1, 1 }, { 0, 1 } })
        {
          const float u = float(i % side + x) / side, v = float(i / side + y) / side;
          points.insert(points.end(), { u, v, float(way) });
          coordinates.insert(coordinates.end(), { 0.05F + 0.9F * u, 0.03F + 0.9F * v });
        }
      }
      const int position =
        buffer.Add(points, "VEC3", gltfFloat, ",\"min\":[0,0,0],\"max\":[1,1,9]");
      const int texture = buffer.Add(coordinates, "VEC2", gltfFloat);
      std::ostringstream material, primitive;
      const auto& [factor, opaque] = ways[way];
      material << (way == 0 ? "" : ",") << "{\"alphaMode\":\"" << (opaque ? "OPAQUE" : "BLEND")
               << "\",\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorTexture\":"
                  "{\"index\":0},\"baseColorFactor\":["
               << factor[0] << "," << factor[1] << "," << factor[2] << "," << factor[3] << "]}}";
      primitive << (way == 0 ? "" : ",") << "{\"material\":" << way
                << ",\"attributes\":{\"POSITION\":" << position << ",\"TEXCOORD_0\":" << texture
                << "}}";
      materials += material.str();
      primitives += primitive.str();
    }
    this->WriteText(
      "m.glb", buffer.Glb("\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
                          "\"materials\":[" +
                          materials + "],\"meshes\":[{\"primitives\":[" + primitives +
                          "]}],\"images\":[{\"uri\":\"p.png\"}],\"textures\":[{\"source\":0}]"));
  }

  static Texel Lit(const Texel& texel, const ShownAs& way)
  {
    Texel lit = texel;
    for (std::size_t k = 0; k < 3; ++k)
    {
      lit[k] = ByteOfLinear(LinearOfBytes()[texel[k]] * way.factor[k]);
    }
    lit[3] = way.opaque ? std::uint8_t{ 255 } : std::uint8_t(texel[3] * way.factor[3] + 0.5);
    return lit;
  }
};

Picture Noise(unsigned seed)
{
  std::mt19937 random(seed);
  Picture picture{ 61, 47, 4, {} };
  for (std::size_t i = 0; i < 61 * 47 * 4; ++i)
  {
    picture.texels.push_back(static_cast<std::uint8_t>(random()));
  }
  return picture;
}

}

TEST_F(TestExtractedFactors, EachFactorHasItsTexels)
{
  const Picture before = Noise(7);
  this->WriteScene(before);
  const Outcome built = this->Build({ "m.glb", "-o", "m.kds", "--quiet", "--precision", "lossless",
    "--texture-quality", "lossless", "--vertices-per-partition", "100" });
  ASSERT_EQ(built.exitCode, 0) << built.err;
  const Outcome extracted =
    this->Store({ "extract", "m.kds", "--all", "-o", "out.obj", "--quiet" });
  ASSERT_EQ(extracted.exitCode, 0) << extracted.err;
  const TexturedMesh after = this->ReadWithTextures("out.obj");
  const std::vector<Picture> pictures = PicturesOf(after);
  EXPECT_EQ(pictures.size(), ways.size());
  EXPECT_TRUE(this->Files().contains("out-picture-0.png"));
  EXPECT_TRUE(this->Files().contains("out-picture-3.png"));
  std::size_t looked = 0;
  for (std::size_t t = 0; t < after.mesh.triangles.size(); ++t)
  {
    const TexturedMaterial& material = after.materials[after.materialOf[t]];
    ASSERT_LT(material.picture, pictures.size());
    // The file has the input's axes: z is up, and says which way it is.
    const Vec3& place = after.mesh.points[after.mesh.triangles[t][0]];
    const auto way = static_cast<std::size_t>(std::lround(place[2]));
    ASSERT_LT(way, ways.size());
    for (int i = 1; i <= 4; ++i)
    {
      std::array<double, 2> at{};
      const std::array<double, 3> shares{ 0.2 * i, 0.1, 0.9 - 0.2 * i };
      for (std::size_t k = 0; k < 3; ++k)
      {
        at[0] += shares[k] * double(after.corners[t][k][0]);
        at[1] += shares[k] * double(after.corners[t][k][1]);
      }
      const PlaceInPicture in = PlaceOf(material, at[0], at[1]);
      const auto texelOf = [&](const Picture& picture)
      { return PictureTexels(picture).At(in, TextureWrap::Clamp, TextureWrap::Clamp); };
      ASSERT_EQ(texelOf(pictures[material.picture]), Lit(texelOf(before), ways[way])) << way;
      ++looked;
    }
  }
  EXPECT_EQ(looked, ways.size() * 2 * 12 * 12 * 4);
}

// Readers such as VTK's take "-clamp on" for a part of the name.
TEST_F(TestExtractedFactors, EdgesAreClampedWhereTheyAreSeenByThemselves)
{
  const auto maps = [&](const std::string& quality, const std::string& edge)
  {
    this->WriteHardObj("hard", 3);
    std::string mesh = ReadWhole(this->Folder / "hard.obj");
    if (edge == "within")
    {
      // Makes every coordinate lie between 0 and 1, unless it is not a number.
      std::istringstream lines(mesh);
      mesh.clear();
      for (std::string line; std::getline(lines, line);)
      {
        mesh +=
          (line.rfind("vt ", 0) == 0 ? "vt 0.25 " + std::to_string(double(mesh.size() % 97) / 97)
                                     : line) +
          "\n";
      }
      this->WriteText("hard.obj", mesh);
    }
    EXPECT_EQ(
      this->Build({ "hard.obj", "-o", "m.kds", "--quiet", "--texture-quality", quality }).exitCode,
      0);
    EXPECT_EQ(this->Store({ "extract", "m.kds", "--all", "-o", "out.obj", "--quiet" }).exitCode, 0);
    std::istringstream lines(ReadWhole(this->Folder / "out.mtl"));
    std::multiset<std::string> found;
    for (std::string line; std::getline(lines, line);)
    {
      if (line.rfind("map_Kd", 0) == 0)
      {
        found.insert(line);
      }
    }
    return found;
  };
  using Maps = std::multiset<std::string>;
  EXPECT_EQ(maps("90", "beyond"), (Maps{ "map_Kd out-partition-0.png" }));
  EXPECT_EQ(maps("lossless", "beyond"),
    (Maps{ "map_Kd -clamp on out-picture-1.png", "map_Kd out-picture-0.png" }));
  EXPECT_EQ(
    maps("lossless", "within"), (Maps{ "map_Kd out-picture-0.png", "map_Kd out-picture-1.png" }));
}
