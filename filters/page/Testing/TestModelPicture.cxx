// SPDX-License-Identifier: BSD-3-Clause
// The picture for a link: where the model is in it, and how hostile previews are handled.
#include "filters/page/ModelPicture.h"

#include "Testing/Fixtures/Meshes.h"
#include "filters/core/VectorMath.h"
#include "filters/page/PreviewGlb.h"
#include "filters/store/Testing/StoreTest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <random>
#include <type_traits>

#include <jpeglib.h>
#include <nlohmann/json.hpp>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

struct Pixels
{
  unsigned width = 0, height = 0;
  std::vector<std::uint8_t> rgb;

  std::array<int, 3> At(unsigned x, unsigned y) const
  {
    const auto* at = &this->rgb[(std::size_t{ y } * this->width + x) * 3];
    return { at[0], at[1], at[2] };
  }
  // Whether the pixel differs from the background, which has the same colour along a row.
  bool IsModel(unsigned x, unsigned y) const
  {
    const auto here = this->At(x, y), ground = this->At(0, y);
    return std::abs(here[0] - ground[0]) + std::abs(here[1] - ground[1]) +
             std::abs(here[2] - ground[2]) >
           24;
  }
};

Pixels Decoded(const std::vector<std::uint8_t>& jpeg)
{
  jpeg_decompress_struct codec{};
  jpeg_error_mgr errors{};
  codec.err = jpeg_std_error(&errors);
  jpeg_create_decompress(&codec);
  jpeg_mem_src(&codec, jpeg.data(), static_cast<unsigned long>(jpeg.size()));
  jpeg_read_header(&codec, TRUE);
  jpeg_start_decompress(&codec);
  Pixels pixels{ codec.output_width, codec.output_height, {} };
  pixels.rgb.resize(std::size_t{ 3 } * pixels.width * pixels.height);
  while (codec.output_scanline < codec.output_height)
  {
    JSAMPROW row = &pixels.rgb[std::size_t{ 3 } * pixels.width * codec.output_scanline];
    jpeg_read_scanlines(&codec, &row, 1);
  }
  jpeg_finish_decompress(&codec);
  jpeg_destroy_decompress(&codec);
  return pixels;
}

class TestModelPicture : public StoreTest
{
protected:
  Result<std::vector<std::uint8_t>> Draw(const Mesh& mesh, BuildOptions options = {})
  {
    this->Build(mesh, options);
    this->store = *Store::Open(this->File());
    this->blob = *this->store->Read(
      BlobOfPiece(PreviewPiece(this->store->Info()), this->store->Info().depths));
    EXPECT_TRUE(HasPicture(this->store->Info()));
    return DrawModelPicture(this->store->Info(), this->blob);
  }
  std::shared_ptr<Store> store;
  std::vector<std::uint8_t> blob;
};

Mesh Upright() // a tall torus in the plane of x and z
{
  Mesh mesh = Torus(60, 30);
  for (Vec3& point : mesh.points)
  {
    point = { point[0], point[2], point[1] };
  }
  return mesh;
}

}

TEST_F(TestModelPicture, TheModelFillsIt)
{
  BuildOptions options;
  options.up = Vec3{ 0, 0, 1 };
  options.view = Vec3{ 0, -1, 0 };
  const auto jpeg = this->Draw(Upright(), options);
  ASSERT_TRUE(jpeg) << jpeg.GetError().message;
  EXPECT_LT(jpeg->size(), 200000u);
  const auto pixels = Decoded(*jpeg);
  ASSERT_EQ(pixels.width, pictureWidth);
  ASSERT_EQ(pixels.height, pictureHeight);
  unsigned left = pictureWidth, right = 0, top = pictureHeight, bottom = 0, covered = 0;
  for (unsigned y = 0; y < pictureHeight; ++y)
  {
    for (unsigned x = 0; x < pictureWidth; ++x)
    {
      if (pixels.IsModel(x, y))
      {
        left = std::min(left, x);
        right = std::max(right, x);
        top = std::min(top, y);
        bottom = std::max(bottom, y);
        ++covered;
      }
    }
  }
  EXPECT_NEAR(bottom - top, 0.88 * pictureHeight, 12) << "as high as it fits";
  EXPECT_NEAR((left + right) / 2.0, pictureWidth / 2.0, 12) << "in the middle";
  EXPECT_NEAR((top + bottom) / 2.0, pictureHeight / 2.0, 12);
  EXPECT_FALSE(pixels.IsModel(pictureWidth / 2, pictureHeight / 2)) << "through the hole";
  EXPECT_GT(covered, pictureHeight * pictureHeight / 8);
  EXPECT_FALSE(pixels.IsModel(3, 3));
  EXPECT_EQ(*DrawModelPicture(this->store->Info(), this->blob), *jpeg) << "the same again";
}

TEST_F(TestModelPicture, CloudsAreDiscs)
{
  const auto jpeg = this->Draw(Cloud(4));
  ASSERT_TRUE(jpeg) << jpeg.GetError().message;
  const auto pixels = Decoded(*jpeg);
  unsigned covered = 0;
  for (unsigned y = 0; y < pictureHeight; y += 4)
  {
    for (unsigned x = 0; x < pictureWidth; x += 4)
    {
      covered += pixels.IsModel(x, y);
    }
  }
  EXPECT_GT(covered, 2000u) << "of 47,250";
}

TEST_F(TestModelPicture, ColoursAreTheModels)
{
  Mesh mesh = Torus(60, 30);
  Attribute colors{ { "RGB", AttributeType::UInt8, AttributeAssociation::Point, 3 }, {} };
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
  {
    colors.values.insert(colors.values.end(), { 220, 10, 10 });
  }
  mesh.attributes.push_back(colors);
  const auto jpeg = this->Draw(mesh);
  ASSERT_TRUE(jpeg) << jpeg.GetError().message;
  const auto pixels = Decoded(*jpeg);
  std::size_t red = 0;
  for (unsigned y = 0; y < pictureHeight; ++y)
  {
    for (unsigned x = 0; x < pictureWidth; ++x)
    {
      const auto [r, g, b] = pixels.At(x, y);
      red += r > 3 * std::max(g, b);
    }
  }
  EXPECT_GT(red, 50000u);
}

namespace
{

// Returns the JSON of a .glb, after checking the lengths in it.
nlohmann::json JsonOf(const std::vector<std::uint8_t>& glb)
{
  const auto word = [&glb](std::size_t at)
  {
    std::uint32_t value = 0;
    std::memcpy(&value, &glb[at], sizeof value);
    return value;
  };
  EXPECT_EQ(std::string(glb.begin(), glb.begin() + 4), "glTF");
  EXPECT_EQ(word(4), 2u);
  EXPECT_EQ(word(8), glb.size());
  const auto length = word(12);
  auto json = nlohmann::json::parse(glb.begin() + 20, glb.begin() + 20 + length);
  EXPECT_EQ(length % 4, 0u);
  EXPECT_EQ(word(20 + length), glb.size() - 28 - length);
  EXPECT_EQ(json["buffers"][0]["byteLength"], glb.size() - 28 - length);
  const auto& last = json["bufferViews"].back();
  EXPECT_EQ(last["byteOffset"].get<std::size_t>() + last["byteLength"].get<std::size_t>(),
    json["buffers"][0]["byteLength"].get<std::size_t>());
  return json;
}

}

TEST_F(TestModelPicture, AsGltfItStandsOnTheOriginInMetres)
{
  BuildOptions options;
  options.up = Vec3{ 0, 0, 1 };
  options.view = Vec3{ 0, -1, 0 };
  options.unit = "cm";
  options.credit = "Ann \"the\" <maker>";
  ASSERT_TRUE(this->Draw(Upright(), options));
  const auto& info = this->store->Info();
  ASSERT_TRUE(HasPreviewGlb(info));
  const auto glb = EncodePreviewGlb(info, this->blob);
  ASSERT_TRUE(glb) << glb.GetError().message;
  const auto json = JsonOf(*glb);
  EXPECT_EQ(json["asset"]["copyright"], options.credit);
  const auto& position = json["accessors"][0];
  const auto& indices = json["accessors"][2];
  const auto piece = DecodePreview(info, this->blob);
  EXPECT_EQ(position["count"], piece->positions.size());
  EXPECT_EQ(indices["count"], 3 * piece->triangles.size());
  const Vec3 sides = Minus(info.box.hi, info.box.lo);
  const auto length = [&](std::size_t k)
  { return position["max"][k].get<double>() - position["min"][k].get<double>(); };
  EXPECT_NEAR(length(0), sides[0] / 100, sides[0] / 5000) << "to the right";
  EXPECT_NEAR(length(1), sides[2] / 100, sides[2] / 5000) << "up";
  EXPECT_NEAR(length(2), sides[1] / 100, sides[1] / 2000) << "to the front";
  EXPECT_NEAR(position["min"][1].get<double>(), 0, 1e-6) << "it stands";
  EXPECT_NEAR(position["min"][0].get<double>() + position["max"][0].get<double>(), 0, 1e-6);
  EXPECT_EQ(*EncodePreviewGlb(info, this->blob), *glb);
  auto unknown = info;
  unknown.unit = "spans";
  const auto scaled = JsonOf(*EncodePreviewGlb(unknown, this->blob))["accessors"][0];
  EXPECT_NEAR(scaled["max"][0].get<double>() - scaled["min"][0].get<double>(), 1, 1e-6);
  auto cloud = info;
  cloud.primitive = PrimitiveType::Points;
  EXPECT_FALSE(HasPreviewGlb(cloud));
}

namespace
{

// The values of an accessor of a .glb, as stored in the buffer.
template <class T>
std::vector<T> ValuesOf(const std::vector<std::uint8_t>& glb, const nlohmann::json& json,
  const nlohmann::json& accessor, std::size_t width)
{
  const auto& part = json["accessors"][accessor.get<std::size_t>()];
  const auto& view = json["bufferViews"][part["bufferView"].get<std::size_t>()];
  EXPECT_FALSE(view.contains("byteStride"));
  constexpr int ofFloat = 5126, ofUint32 = 5125;
  EXPECT_EQ(part["componentType"], (std::is_same_v<T, float> ? ofFloat : ofUint32));
  const std::size_t zero = 0;
  const auto begin = glb.size() - json["buffers"][0]["byteLength"].get<std::size_t>() +
                     view.value("byteOffset", zero) + part.value("byteOffset", zero);
  std::vector<T> values(part["count"].get<std::size_t>() * width);
  std::memcpy(values.data(), &glb.at(begin), values.size() * sizeof(T));
  return values;
}

std::vector<Vec3> VectorsOf(
  const std::vector<std::uint8_t>& glb, const nlohmann::json& json, const char* name)
{
  const auto values =
    ValuesOf<float>(glb, json, json["meshes"][0]["primitives"][0]["attributes"][name], 3);
  std::vector<Vec3> vectors;
  for (std::size_t i = 0; i < values.size(); i += 3)
  {
    vectors.push_back({ values[i], values[i + 1], values[i + 2] });
  }
  return vectors;
}

// The same triangle, beginning with its lowest corner.
Triangle FromLowest(Triangle triangle)
{
  std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()), triangle.end());
  return triangle;
}

}

TEST_F(TestModelPicture, AsGltfItHasThePreviewsTriangles)
{
  Mesh mesh = Upright();
  for (Vec3& point : mesh.points) // so that it is not its own mirror image
  {
    point = { point[0] + 0.3 * point[2] + 5, point[1] + 0.2 * point[0] * point[2], point[2] - 7 };
  }
  BuildOptions options;
  options.up = Vec3{ 0, 0, 1 };
  options.view = Vec3{ 0, -1, 0 };
  options.unit = "mm";
  ASSERT_TRUE(this->Draw(mesh, options));
  const auto& info = this->store->Info();
  const auto glb = EncodePreviewGlb(info, this->blob);
  ASSERT_TRUE(glb) << glb.GetError().message;
  const auto json = JsonOf(*glb);
  for (const auto& node : json["nodes"])
  {
    for (const char* moves : { "matrix", "translation", "rotation", "scale" })
    {
      EXPECT_FALSE(node.contains(moves)) << moves;
    }
  }

  const auto piece = DecodePreview(info, this->blob);
  ASSERT_TRUE(piece);
  Box box;
  for (const Vec3& point : piece->positions)
  {
    box.Add(point);
  }
  const Vec3 middle = Times(Plus(box.lo, box.hi), 0.5);
  const auto positions = VectorsOf(*glb, json, "POSITION"),
             normals = VectorsOf(*glb, json, "NORMAL");
  ASSERT_EQ(positions.size(), piece->positions.size());
  ASSERT_EQ(normals.size(), positions.size());
  std::vector<VertexId> vertexAt; // for each vertex of the file, that of the preview
  for (const Vec3& position : positions)
  {
    // x to the right for a viewer looking along +y; y up from the base; z towards the viewer;
    // metres.
    const Vec3 back{ middle[0] + 1000 * position[0], middle[1] - 1000 * position[2],
      box.lo[2] + 1000 * position[1] };
    const auto nearest = std::min_element(piece->positions.begin(), piece->positions.end(),
      [&back](const Vec3& one, const Vec3& other)
      { return Length(Minus(one, back)) < Length(Minus(other, back)); });
    EXPECT_LT(Length(Minus(*nearest, back)), 1e-5 * Length(Minus(box.hi, box.lo)));
    vertexAt.push_back(static_cast<VertexId>(nearest - piece->positions.begin()));
  }

  const auto corners =
    ValuesOf<std::uint32_t>(*glb, json, json["meshes"][0]["primitives"][0]["indices"], 1);
  std::vector<Triangle> found, expected;
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
  {
    const Triangle triangle{ corners[i], corners[i + 1], corners[i + 2] };
    const Vec3 facing = Cross(Minus(positions.at(triangle[1]), positions.at(triangle[0])),
      Minus(positions.at(triangle[2]), positions.at(triangle[0])));
    for (const VertexId corner : triangle)
    {
      EXPECT_NEAR(Length(normals[corner]), 1, 1e-5);
      EXPECT_GT(Dot(normals[corner], facing), 0) << "normals are on the triangle's front";
    }
    found.push_back(
      FromLowest({ vertexAt[triangle[0]], vertexAt[triangle[1]], vertexAt[triangle[2]] }));
  }
  std::transform(
    piece->triangles.begin(), piece->triangles.end(), std::back_inserter(expected), FromLowest);
  std::sort(found.begin(), found.end());
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(found, expected);
}

TEST_F(TestModelPicture, HostilePreviewsAreErrors)
{
  ASSERT_TRUE(this->Draw(Torus(30, 20)));
  const auto& info = this->store->Info();
  EXPECT_FALSE(DrawModelPicture(info, {}));
  std::mt19937 random(7);
  for (int i = 0; i < 50; ++i)
  {
    auto damaged = this->blob;
    damaged[random() % damaged.size()] ^= static_cast<std::uint8_t>(1u << random() % 8);
    EXPECT_FALSE(DrawModelPicture(info, damaged));
    EXPECT_FALSE(EncodePreviewGlb(info, damaged));
  }
  EXPECT_EQ(DrawModelPicture(info, std::vector<std::uint8_t>((4u << 20) + 1)).GetError().code,
    ErrorCode::LimitExceeded);
  auto odd = info; // with directions that no store should have
  for (const Vec3& wrong :
    { Vec3{ 0, 0, 0 }, Vec3{ 1e300, 1e300, 1e300 }, Vec3{ NAN, 0, 0 }, Vec3{ 0, 1, 0 } })
  {
    odd.homeView = HomeView{ wrong, wrong, false };
    EXPECT_TRUE(DrawModelPicture(odd, this->blob)) << wrong[0];
    EXPECT_TRUE(EncodePreviewGlb(odd, this->blob)) << wrong[0];
  }
}
