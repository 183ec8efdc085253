// SPDX-License-Identifier: BSD-3-Clause
// Binary PLY files with pictures, as MeshLab and others write them, in both byte orders:
// coordinates of faces and numbers of pictures, or coordinates of vertices.
#include "Testing/EndToEnd/Textures/TexturedFiles.h"

#include <algorithm>
#include <cstring>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

using Rgb = std::array<double, 3>;
const Rgb red{ 255, 0, 0 }, green{ 0, 255, 0 }, blue{ 0, 0, 255 };

// The bytes of a PLY's body, in one of the byte orders.
class Body
{
public:
  explicit Body(bool isBig)
    : IsBig(isBig)
  {
  }
  template <class T>
  Body& Add(std::initializer_list<T> values)
  {
    for (const T value : values)
    {
      char raw[sizeof(T)];
      std::memcpy(raw, &value, sizeof(T)); // this machine is little endian
      if (this->IsBig)
      {
        std::reverse(raw, raw + sizeof(T));
      }
      this->Bytes.append(raw, sizeof(T));
    }
    return *this;
  }

  std::string Bytes;

private:
  bool IsBig;
};

class TestTexturedPly : public TexturedTest
{
protected:
  void SetUp() override
  {
    this->WritePng("a.png", { 2, 1, 3, { 255, 0, 0, 0, 0, 255 } });
    this->WritePng("b.png", { 1, 1, 3, { 0, 255, 0 } });
  }
  void WritePng(const std::string& name, const Picture& picture)
  {
    const std::vector<std::uint8_t> png = EncodePicture(picture, PictureType::Png);
    this->WriteText(name, { png.begin(), png.end() });
  }

  static std::string Begin(bool isBig, const std::string& comments)
  {
    return std::string("ply\nformat binary_") + (isBig ? "big" : "little") + "_endian 1.0\n" +
           comments;
  }

  // The colour of each vertex that kdstream-convert writes; there must be no warning except the one
  // about baking.
  std::vector<Rgb> ColorsOf(const std::string& input)
  {
    const Outcome converted =
      RunTool(this->Folder, "convert", { input, "-o", "out.ply", "--quiet" });
    EXPECT_EQ(converted.exitCode, 0) << converted.err;
    EXPECT_EQ(std::count(converted.err.begin(), converted.err.end(), '\n'), 1) << converted.err;
    EXPECT_NE(converted.err.find("textures are baked"), std::string::npos) << converted.err;
    const Mesh mesh = this->Read("out.ply");
    std::vector<Rgb> colors;
    for (const Attribute& array : mesh.attributes)
    {
      for (std::size_t v = 0; array.name == "RGB" && v < mesh.points.size(); ++v)
      {
        colors.push_back({ array.Get(v, 0), array.Get(v, 1), array.Get(v, 2) });
      }
    }
    return colors;
  }

  static std::vector<Rgb> OfTriangles(const std::vector<Rgb>& each)
  {
    std::vector<Rgb> colors;
    for (const Rgb& color : each)
    {
      colors.insert(colors.end(), 3, color);
    }
    return colors;
  }

  static void AddPoints(Body& body, float x)
  {
    body.Add<float>({ x, 0, 0 }).Add<float>({ x, 1, 0 }).Add<float>({ x, 0, 1 });
  }
};

}

// Wedge coordinates as MeshLab exports them, with flags and a quality of faces between them.
TEST_F(TestTexturedPly, FacesHaveCoordinatesAndNumbers)
{
  for (const bool isBig : { false, true })
  {
    SCOPED_TRACE(isBig);
    Body body(isBig);
    for (const float x : { 0.0F, 1.0F, 2.0F })
    {
      AddPoints(body, x);
    }
    const struct
    {
      float u;
      std::int32_t number;
    } faces[] = { { 0.25F, 0 }, { 0.75F, 0 }, { 0.25F, 1 } };
    std::int32_t vertex = 0;
    for (const auto& face : faces)
    {
      body.Add<std::uint8_t>({ 3 }).Add<std::int32_t>({ vertex, vertex + 1, vertex + 2 });
      body.Add<std::int32_t>({ 7 });
      body.Add<std::uint8_t>({ 6 }).Add<float>({ face.u, 0.5F, face.u, 0.5F, face.u, 0.5F });
      body.Add<std::int32_t>({ face.number });
      vertex += 3;
    }
    this->WriteText("m.ply",
      Begin(isBig, "comment VCGLIB generated\ncomment TextureFile a.png\ncomment TextureFile "
                   "b.png\n") +
        "element vertex 9\nproperty float x\nproperty float y\nproperty float z\nelement face 3\n"
        "property list uchar int vertex_indices\nproperty int flags\nproperty list uchar float "
        "texcoord\nproperty int texnumber\nend_header\n" +
        body.Bytes);
    EXPECT_EQ(this->ColorsOf("m.ply"), OfTriangles({ red, blue, green }));
    const Outcome built = this->Build({ "m.ply", "-o", "m.kds", "--quiet" });
    EXPECT_EQ(built.exitCode, 0) << built.err;
    EXPECT_NE(this->Store({ "info", "m.kds" }).out.find("texture bytes"), std::string::npos);
  }
}

TEST_F(TestTexturedPly, VerticesHaveCoordinates)
{
  for (const bool isBig : { false, true })
  {
    for (const auto& [u, v] : { std::pair{ "texture_u", "texture_v" }, { "s", "t" }, { "u", "v" } })
    {
      SCOPED_TRACE(std::string(u) + (isBig ? " big" : " little"));
      Body body(isBig);
      for (const float x : { 0.0F, 1.0F })
      {
        const float at = x < 0.5F ? 0.25F : 0.75F;
        body.Add<float>({ x, 0, 0, at, 0.5F }).Add<float>({ x, 1, 0, at, 0.5F });
        body.Add<float>({ x, 0, 1, at, 0.5F });
      }
      body.Add<std::uint8_t>({ 3 }).Add<std::uint32_t>({ 0, 1, 2 });
      body.Add<std::uint8_t>({ 3 }).Add<std::uint32_t>({ 3, 4, 5 });
      this->WriteText("m.ply",
        Begin(isBig, "comment TextureFile a.png\n") +
          "element vertex 6\nproperty float x\nproperty float y\nproperty float z\nproperty "
          "float " +
          u + "\nproperty float " + v +
          "\nelement face 2\nproperty list uchar uint vertex_indices\nend_header\n" + body.Bytes);
      EXPECT_EQ(this->ColorsOf("m.ply"), OfTriangles({ red, blue }));
    }
  }
}

// A quad with coordinates as doubles, and with 16-bit numbers. v points up: the picture is red
// above.
TEST_F(TestTexturedPly, OtherTypesAreRead)
{
  this->WritePng("a.png", { 1, 2, 3, { 255, 0, 0, 0, 0, 255 } });
  for (const bool isBig : { false, true })
  {
    Body body(isBig);
    body.Add<double>({ 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0 });
    body.Add<std::int16_t>({ 0 }).Add<std::uint16_t>({ 8 }).Add<double>(
      { 0.5, 0.75, 0.5, 0.75, 0.5, 0.75, 0.5, 0.75 });
    body.Add<std::uint32_t>({ 4 }).Add<std::uint16_t>({ 0, 1, 2, 3 });
    this->WriteText("m.ply",
      Begin(isBig, "comment TextureFile a.png\n") +
        "element vertex 4\nproperty double x\nproperty double y\nproperty double z\nelement face "
        "1\nproperty short texnumber\nproperty list ushort double texcoord\nproperty list uint "
        "ushort vertex_indices\nend_header\n" +
        body.Bytes);
    EXPECT_EQ(this->ColorsOf("m.ply"), (std::vector<Rgb>{ red, red, red, red }));
  }
}
