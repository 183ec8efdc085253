// SPDX-License-Identifier: BSD-3-Clause
// A textured GLB is built to a lossless store and extracted as a GLB again: coordinates stay the
// same bit for bit, and so does every texel that a triangle uses. Coordinates that are not numbers
// are reported.
#include "Testing/EndToEnd/GltfFile.h"
#include "Testing/EndToEnd/Textures/SameTextures.h"
#include "filters/model/JsonReader.h"

#include <cstring>
#include <limits>
#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

constexpr std::uint32_t side = 20; // cells of the height field

// A primitive: a part of the grid, with a vertex for each of its corners.
struct Part
{
  std::vector<float> points, places;
  std::vector<std::uint16_t> indices;
};

// The part from one column to another. u, v: functions of column and row, 0-1.
template <class U, class V>
Part PartOf(std::uint32_t begin, std::uint32_t end, U&& u, V&& v)
{
  Part part;
  const std::uint32_t columns = end - begin + 1;
  for (std::uint32_t y = 0; y <= side; ++y)
  {
    for (std::uint32_t x = begin; x <= end; ++x)
    {
      const float s = float(x) / side, t = float(y) / side;
      part.points.insert(part.points.end(), { s, t, 0.1F * std::sin(9 * s) * std::cos(7 * t) });
      part.places.insert(part.places.end(), { float(u(s, t)), float(v(s, t)) });
    }
  }
  for (std::uint32_t y = 0; y < side; ++y)
  {
    for (std::uint32_t x = 0; x + 1 < columns; ++x)
    {
      const std::uint32_t a = y * columns + x, b = a + columns;
      for (const std::uint32_t corner : { a, a + 1, b + 1, a, b + 1, b })
      {
        part.indices.push_back(static_cast<std::uint16_t>(corner));
      }
    }
  }
  return part;
}

class TestGlbRoundTrip : public TexturedTest
{
protected:
  // Parts with two pictures, one of which is used twice. Each has other wrap modes and a seam to
  // the next part. One more part has a single colour.
  std::vector<Part> Parts() const
  {
    return { PartOf(
               0, 6, [](float s, float t) { return 3.7F * s + 0.01F * t - 0.4F; },
               [](float, float t) { return 0.9F * t + 0.05F; }),
      PartOf(
        6, 12, [](float s, float) { return 1 - s; },
        [](float s, float t) { return 1.4F * t - 0.2F + 0.02F * s; }),
      PartOf(
        12, 17, [](float s, float t) { return s * 0.5F + t * 0.1F; },
        [](float, float t) { return 0.2F + t / 3; }),
      PartOf(
        17, 20, [](float s, float) { return s; }, [](float, float t) { return t + 1; }) };
  }

  void WriteGlb(const std::string& name, const std::vector<Part>& parts)
  {
    std::mt19937 random(11);
    GltfBuffer buffer;
    std::string primitives, images;
    for (std::size_t i = 0; i < parts.size(); ++i)
    {
      const int points =
        buffer.Add(parts[i].points, "VEC3", gltfFloat, ",\"min\":[0,0,-0.1],\"max\":[1,1,0.1]");
      const int places = buffer.Add(parts[i].places, "VEC2", gltfFloat);
      const int indices = buffer.Add(parts[i].indices, "SCALAR", gltfUnsignedShort);
      primitives +=
        (i == 0 ? "" : ",") + ("{\"attributes\":{\"POSITION\":" + std::to_string(points)) +
        ",\"TEXCOORD_0\":" + std::to_string(places) + "},\"indices\":" + std::to_string(indices) +
        ",\"material\":" + std::to_string(i) + "}";
    }
    for (int i = 0; i < 2; ++i)
    {
      Picture picture{ i == 0 ? 150U : 97U, 120, 3, {} };
      for (std::size_t k = 0; k < 3 * picture.width * picture.height; ++k)
      {
        picture.texels.push_back(static_cast<std::uint8_t>(random()));
      }
      const std::vector<std::uint8_t> png = EncodePicture(picture, PictureType::Png);
      images += (i == 0 ? "" : ",") +
                ("{\"mimeType\":\"image/png\",\"bufferView\":" +
                  std::to_string(buffer.AddView(png.data(), png.size()))) +
                "}";
    }
    const auto textured = [](int texture)
    {
      return "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":" +
             std::to_string(texture) + "}}}";
    };
    this->WriteText(name,
      buffer.Glb(
        "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{"
        "\"primitives\":[" +
        primitives + "]}],\"materials\":[" + textured(0) + "," + textured(1) + "," + textured(2) +
        ",{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.2,0.4,0.6,1]}}],\"images\":[" + images +
        "],\"samplers\":[{\"wrapS\":10497,\"wrapT\":10497},{\"wrapS\":33071,\"wrapT\":"
        "33648}],\"textures\":[{\"source\":0,\"sampler\":0},{\"source\":1,\"sampler\":1},"
        "{\"source\":0,\"sampler\":1}]"));
  }

  // Reads a file as the tests and `extract` write it. A corner with a NaN has no coordinate.
  TexturedMesh ReadGlb(const std::string& name)
  {
    const std::string bytes = ReadWhole(this->Folder / name);
    std::uint32_t size = 0;
    std::memcpy(&size, bytes.data() + 12, sizeof size);
    const auto parsed = ParseJson(bytes.substr(20, size));
    EXPECT_TRUE(parsed);
    const JsonValue& json = *parsed;
    const std::size_t binary = 20 + size + 8;
    const auto viewOf = [&](const JsonValue& number)
    {
      const JsonValue& view = json["bufferViews"][number.GetUint()];
      return bytes.substr(binary + view["byteOffset"].GetUint64(), view["byteLength"].GetUint64());
    };
    TexturedMesh read;
    for (const JsonValue& image : json["images"].GetArray())
    {
      const std::string picture = viewOf(image["bufferView"]);
      read.pictures.emplace_back().bytes.assign(picture.begin(), picture.end());
    }
    for (const JsonValue& material : json["materials"].GetArray())
    {
      read.materials.push_back(MaterialOf(json, material["pbrMetallicRoughness"]));
    }
    EXPECT_EQ(json["meshes"].Size(), 1U);
    EXPECT_FALSE(FindMember(json["nodes"][0], "matrix"));
    for (const JsonValue& primitive : json["meshes"][0]["primitives"].GetArray())
    {
      AddPrimitive(json, primitive, viewOf, read);
    }
    return read;
  }

  // Builds a lossless store and extracts it.
  std::string BuildAndExtract(const std::string& input, const std::string& output)
  {
    const Outcome built = this->Build({ input, "-o", "m.kds", "--quiet", "--precision", "lossless",
      "--texture-quality", "lossless", "--up", "0,1,0", "--vertices-per-partition", "60" });
    EXPECT_EQ(built.exitCode, 0) << built.err;
    const Outcome extracted = this->Store({ "extract", "m.kds", "--all", "-o", output, "--quiet" });
    EXPECT_EQ(extracted.exitCode, 0) << extracted.err;
    EXPECT_EQ(extracted.err, "");
    return built.err;
  }

private:
  static TexturedMaterial MaterialOf(const JsonValue& json, const JsonValue& pbr)
  {
    TexturedMaterial material;
    if (!FindMember(pbr, "baseColorTexture"))
    {
      return material;
    }
    const JsonValue& texture = json["textures"][pbr["baseColorTexture"]["index"].GetUint()];
    const JsonValue& sampler = json["samplers"][texture["sampler"].GetUint()];
    const auto wrapOf = [&](const char* which)
    {
      const unsigned wrap = sampler[which].GetUint();
      return wrap == 33071   ? TextureWrap::Clamp
             : wrap == 33648 ? TextureWrap::Mirror
                             : TextureWrap::Repeat;
    };
    material.picture = texture["source"].GetUint();
    material.wrapU = wrapOf("wrapS");
    material.wrapV = wrapOf("wrapT");
    return material;
  }

  template <class View>
  static void AddPrimitive(
    const JsonValue& json, const JsonValue& primitive, const View& viewOf, TexturedMesh& read)
  {
    const auto bytesOf = [&](const JsonValue& accessor)
    { return viewOf(json["accessors"][accessor.GetUint()]["bufferView"]); };
    const JsonValue& attributes = primitive["attributes"];
    const std::string points = bytesOf(attributes["POSITION"]),
                      indices = bytesOf(primitive["indices"]);
    const std::uint32_t material = primitive["material"].GetUint();
    const bool hasPicture = read.materials[material].picture != noPicture;
    const std::string places = hasPicture ? bytesOf(attributes["TEXCOORD_0"]) : "";
    const bool isShort =
      json["accessors"][primitive["indices"].GetUint()]["componentType"].GetInt() ==
      gltfUnsignedShort;
    const std::size_t each = isShort ? 2 : 4;
    for (std::size_t i = 0; i < indices.size() / each; i += 3)
    {
      std::array<PictureCoordinate, 3> corners{};
      Triangle triangle{};
      for (std::size_t k = 0; k < 3; ++k)
      {
        std::uint32_t vertex = 0; // stored as little endian
        std::memcpy(&vertex, indices.data() + (i + k) * each, each);
        std::array<float, 3> point{};
        std::memcpy(point.data(), points.data() + vertex * sizeof point, sizeof point);
        corners[k] = noPictureCoordinate;
        if (hasPicture)
        {
          std::memcpy(&corners[k], places.data() + vertex * sizeof corners[k], sizeof corners[k]);
        }
        triangle[k] = static_cast<VertexId>(read.mesh.points.size());
        read.mesh.points.push_back({ point[0], point[1], point[2] });
      }
      if (std::any_of(corners.begin(), corners.end(),
            [](const PictureCoordinate& corner) { return BitsOf(corner) == 0; }))
      {
        corners.fill(noPictureCoordinate);
      }
      read.mesh.triangles.push_back(triangle);
      read.corners.push_back(corners);
      read.materialOf.push_back(material);
    }
  }
};

}

TEST_F(TestGlbRoundTrip, CoordinatesAndTexelsComeBack)
{
  this->WriteGlb("in.glb", this->Parts());
  this->BuildAndExtract("in.glb", "out.glb");
  const TexturedMesh before = this->ReadGlb("in.glb"), after = this->ReadGlb("out.glb");
  EXPECT_EQ(before.mesh.triangles.size(), 2 * side * side);
  EXPECT_EQ(after.pictures.size(), 2U);
  ExpectSameTextures(before, after);
  // Do it a second time, with the output as input.
  this->BuildAndExtract("out.glb", "again.glb");
  ExpectSameTextures(before, this->ReadGlb("again.glb"));
}

TEST_F(TestGlbRoundTrip, CoordinatesThatAreNotNumbersAreNamed)
{
  std::vector<Part> parts = this->Parts();
  parts[1].places[2 * 10] = std::numeric_limits<float>::quiet_NaN();
  parts[2].places[2 * 30 + 1] = std::numeric_limits<float>::infinity();
  this->WriteGlb("in.glb", parts);
  const std::string warnings = this->BuildAndExtract("in.glb", "out.glb");
  EXPECT_NE(warnings.find("9 triangles have no texture coordinates, or ones that are not numbers "
                          "(the first is triangle 244)"),
    std::string::npos)
    << warnings;
  ExpectSameTextures(this->ReadGlb("in.glb"), this->ReadGlb("out.glb"));
}
