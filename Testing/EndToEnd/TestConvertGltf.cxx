// SPDX-License-Identifier: BSD-3-Clause
// kdstream-convert with glTF scenes of every kind: checks the number of points and triangles, the
// box, and the signed volume, which is negative if faces look inside.
#include "Testing/EndToEnd/ConvertTools.h"
#include "Testing/EndToEnd/GltfFile.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/VectorMath.h"

#ifdef KDSTREAM_HAS_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif
#ifdef KDSTREAM_HAS_DRACO
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#endif

#include <array>
#include <cmath>
#include <limits>
#include <memory>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

constexpr int gltfByte = 5120, gltfShort = 5122, gltfUnsignedInt = 5125;
const std::vector<std::uint16_t> cubeCorners{ 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
  2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5 };

// The corners of the cube from -size to size; z varies slowest.
template <class T>
std::vector<T> CubePlaces(T size)
{
  std::vector<T> places;
  for (int i = 0; i < 8; ++i)
  {
    for (int k = 0; k < 3; ++k)
    {
      places.push_back(static_cast<T>((i >> k) % 2 == 1 ? size : -size));
    }
  }
  return places;
}

class TestConvertGltf : public ConvertTest
{
protected:
  // A scene with these nodes, whose mesh has one part: the cube or another one. more: further
  // members.
  static std::string Scene(const std::string& part, const std::string& nodes,
    const std::string& roots = "0", const std::string& more = "")
  {
    return "\"scene\":0,\"scenes\":[{\"nodes\":[" + roots + "]}],\"nodes\":[" + nodes +
           "],\"meshes\":[{\"primitives\":[{" + part + "}]}]" + more;
  }
  static std::string Part(int places, int corners, const std::string& more = "")
  {
    return "\"attributes\":{\"POSITION\":" + std::to_string(places) + more +
           "},\"indices\":" + std::to_string(corners);
  }
  // A glTF with cubes at these nodes.
  std::string Cubes(const std::string& nodes, const std::string& roots = "0")
  {
    GltfBuffer buffer;
    const int places = buffer.Add(CubePlaces(1.0F), "VEC3", gltfFloat);
    const int corners = buffer.Add(cubeCorners, "SCALAR", gltfUnsignedShort);
    return buffer.Glb(Scene(Part(places, corners), nodes, roots));
  }

  void Expect(const std::string& glb, std::size_t points, std::size_t triangles, const Vec3& lo,
    const Vec3& hi, double volume, const std::string& warnings = "", double near = 1e-6)
  {
    this->WriteText("in.glb", glb);
    std::string lines;
    if (!warnings.empty())
    {
      lines = "kdstream-convert: warning: in.glb: " + warnings + "\n";
    }
    this->Last = this->Converted("in.glb", lines);
    EXPECT_EQ(this->Last.points.size(), points);
    EXPECT_EQ(this->Last.triangles.size(), triangles);
    const Box box = BoxOf(this->Last);
    for (std::size_t k = 0; k < 3; ++k)
    {
      EXPECT_NEAR(box.lo[k], lo[k], near) << k;
      EXPECT_NEAR(box.hi[k], hi[k], near) << k;
    }
    EXPECT_NEAR(VolumeOf(this->Last), volume, 1e-5 * std::abs(volume));
  }
  void ExpectGlbError(const std::string& glb, const std::string& what)
  {
    this->WriteText("in.glb", glb);
    this->ExpectError("in.glb", what);
  }

  Mesh Last;
};

}

TEST_F(TestConvertGltf, MirroredNodesKeepTheirOutside)
{
  this->Expect(
    this->Cubes("{\"mesh\":0},{\"mesh\":0,\"scale\":[-1,1,1],\"translation\":[4,0,0]}", "0,1"), 16,
    24, { -1, -1, -1 }, { 5, 1, 1 }, 16);
  this->Expect(this->Cubes("{\"mesh\":0,\"matrix\":[0,2,0,0,2,0,0,0,0,0,2,0,0,0,3,1]}"), 8, 12,
    { -2, -2, 1 }, { 2, 2, 5 }, 64);
  this->Expect(this->Cubes("{\"scale\":[1,-1,1],\"children\":[1,2]},{\"mesh\":0},"
                           "{\"mesh\":0,\"translation\":[0,4,0],\"scale\":[1,1,-3]}"),
    16, 24, { -1, -5, -3 }, { 1, 1, 3 }, 32);
  // Normals are transformed by the inverse transpose, so that they stay perpendicular to the faces.
  GltfBuffer buffer;
  const int places = buffer.Add(std::vector<float>{ 0, 0, 0, 1, 0, 0, 0, 1, 1 }, "VEC3", gltfFloat);
  const auto side = float(std::sqrt(0.5));
  const int normals = buffer.Add(
    std::vector<float>{ 0, -side, side, 0, -side, side, 0, -side, side }, "VEC3", gltfFloat);
  this->WriteText(
    "in.glb", buffer.Glb(Scene("\"attributes\":{\"POSITION\":" + std::to_string(places) +
                                 ",\"NORMAL\":" + std::to_string(normals) + "}",
                "{\"mesh\":0,\"scale\":[-1,3,1]}")));
  const Mesh read = this->Converted("in.glb");
  ASSERT_EQ(read.triangles.size(), 1U);
  const Triangle& t = read.triangles[0];
  const Vec3 across =
    Cross(Minus(read.points[t[1]], read.points[t[0]]), Minus(read.points[t[2]], read.points[t[0]]));
  const std::vector<double> turned = ValuesOf(read, "Normals");
  ASSERT_EQ(turned.size(), 9U);
  for (std::size_t k = 0; k < 3; ++k)
  {
    EXPECT_NEAR(turned[k], across[k] / Length(across), 1e-6);
  }
}

TEST_F(TestConvertGltf, OffsetsOfNodesSurvive)
{
  const Mesh ball = AsFloats(DisplacedSphere(3));
  std::vector<float> values;
  std::vector<std::uint32_t> corners;
  for (const Vec3& point : ball.points)
  {
    values.insert(values.end(), { float(point[0]), float(point[1]), float(point[2]) });
  }
  for (const Triangle& t : ball.triangles)
  {
    corners.insert(corners.end(), t.begin(), t.end());
  }
  GltfBuffer buffer;
  const std::string part =
    Part(buffer.Add(values, "VEC3", gltfFloat), buffer.Add(corners, "SCALAR", gltfUnsignedInt));
  const auto expect = [&](const std::string& nodes, const Vec3& offset, std::size_t balls)
  {
    SCOPED_TRACE(nodes);
    GltfBuffer copy = buffer;
    this->WriteText("in.glb", copy.Glb(Scene(part, nodes)));
    const Mesh read = this->Converted("in.glb");
    ASSERT_EQ(read.points.size(), balls * ball.points.size());
    EXPECT_EQ(read.scalarType, ScalarType::Float64);
    double farthest = 0;
    for (std::size_t i = 0; i < ball.points.size(); ++i)
    {
      farthest = std::max(farthest,
        Length(Minus(Minus(read.points[read.points.size() - ball.points.size() + i], offset),
          ball.points[i])));
    }
    EXPECT_LT(farthest, 2e-9);
  };
  const Vec3 planetary{ 500000.25, 120.5, -4649776.75 };
  const std::string place = "\"translation\":[500000.25,120.5,-4649776.75]";
  expect("{\"mesh\":0," + place + "}", planetary, 1);
  expect("{\"mesh\":0,\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,500000.25,120.5,-4649776.75,1]}",
    planetary, 1);
  expect("{\"translation\":[500000,100,-4649776],\"children\":[1]},"
         "{\"mesh\":0,\"translation\":[0.25,20.5,-0.75]}",
    planetary, 1);
  // A cube near the origin needs no doubles, but a cube far away does.
  expect("{\"children\":[1,2]},{\"mesh\":0},{\"mesh\":0," + place + "}", planetary, 2);
  // The two translations cancel: the result is as fine as the file, so floats are enough.
  GltfBuffer copy = buffer;
  this->WriteText("in.glb", copy.Glb(Scene(part, "{" + place +
                                                   ",\"children\":[1]},{\"mesh\":0,\"translation\":"
                                                   "[-500000.25,-120.5,4649776.75]}")));
  const Mesh back = this->Converted("in.glb");
  EXPECT_EQ(back.scalarType, ScalarType::Float32);
  EXPECT_EQ(back.points, ball.points);
}

TEST_F(TestConvertGltf, WhatIsExtractedComesBack)
{
  Mesh ball = DisplacedSphere(4);
  for (Vec3& point : ball.points)
  {
    point = Plus(Times(point, 0.05), { 500000.25, 5000120.5, 312.75 });
  }
  ball.scalarType = ScalarType::Float64;
  ASSERT_TRUE(WriteMesh(this->Folder / "ball.ply", ball));
  for (const bool isZUp : { false, true })
  {
    const std::string store = isZUp ? "z.kds" : "y.kds";
    const Outcome built = this->Build({ "ball.ply", "-o", store, "--quiet", "--precision",
      "lossless", "--up", isZUp ? "0,0,1" : "0,1,0" });
    ASSERT_EQ(built.exitCode, 0) << built.err;
    std::filesystem::remove(this->Folder / "ball.glb");
    const Outcome extracted =
      RunTool(this->Folder, "store", { "extract", store, "--all", "-o", "ball.glb" });
    ASSERT_EQ(extracted.exitCode, 0) << extracted.err;
    const Mesh read = this->Converted("ball.glb");
    EXPECT_EQ(read.scalarType, ScalarType::Float64);
    ASSERT_EQ(read.points.size(), ball.points.size());
    EXPECT_EQ(read.triangles.size(), ball.triangles.size());
    EXPECT_NEAR(VolumeOf(read), VolumeOf(ball), 1e-9);
    const Box before = BoxOf(ball), after = BoxOf(read);
    for (std::size_t k = 0; k < 3; ++k)
    {
      // If z is up, x y z become x z -y.
      const std::size_t from = !isZUp || k == 0 ? k : 3 - k;
      const bool turned = isZUp && k == 2;
      EXPECT_NEAR(after.lo[k], turned ? -before.hi[from] : before.lo[from], 1e-8) << isZUp << k;
      EXPECT_NEAR(after.hi[k], turned ? -before.lo[from] : before.hi[from], 1e-8) << isZUp << k;
    }
  }
}

TEST_F(TestConvertGltf, InstancesAreExpanded)
{
  GltfBuffer buffer;
  const int places = buffer.Add(CubePlaces(1.0F), "VEC3", gltfFloat);
  const int corners = buffer.Add(cubeCorners, "SCALAR", gltfUnsignedShort);
  const int moved = buffer.Add(std::vector<float>{ 0, 0, 0, 4, 0, 0, 8, 0, 0 }, "VEC3", gltfFloat);
  const int sized = buffer.Add(std::vector<float>{ 1, 1, 1, 1, 2, 1, -1, 1, 1 }, "VEC3", gltfFloat);
  // Rotations as integers: none, a quarter around z, and a half around z.
  const int turned = buffer.Add(
    std::vector<std::int8_t>{ 0, 0, 0, 127, 0, 0, 90, 90, 0, 0, 127, 0 }, "VEC4", gltfByte);
  buffer.NormalizeLast();
  const auto instances = [&](const std::string& attributes)
  {
    return "{\"mesh\":0,\"translation\":[0,0,10],\"extensions\":{\"EXT_mesh_gpu_instancing\":{"
           "\"attributes\":{" +
           attributes + "}}}}";
  };
  const auto glb = [&](const std::string& attributes)
  {
    GltfBuffer copy = buffer;
    return copy.Glb(Scene(Part(places, corners), instances(attributes), "0",
      ",\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\"],\"extensionsRequired\":[\"EXT_mesh_gpu_"
      "instancing\"]"));
  };
  const std::string translation = "\"TRANSLATION\":" + std::to_string(moved);
  this->Expect(glb(translation), 24, 36, { -1, -1, 9 }, { 9, 1, 11 }, 24);
  this->Expect(glb(translation + ",\"SCALE\":" + std::to_string(sized) +
                   ",\"ROTATION\":" + std::to_string(turned)),
    24, 36, { -1, -1, 9 }, { 9, 1, 11 }, 32);
  this->ExpectGlbError(glb(translation + ",\"SCALE\":" + std::to_string(places)),
    "node 0: its instances' SCALE has another type or another number of elements than the others");
  this->ExpectGlbError(glb("\"TRANSLATION\":77"),
    "node 0: its instances' TRANSLATION names accessor 77, but there are 5");
}

TEST_F(TestConvertGltf, SparseAccessorsAreOverlaid)
{
  GltfBuffer buffer;
  const std::vector<float> cube = CubePlaces(1.0F);
  buffer.Add(cube, "VEC3", gltfFloat);
  const int corners = buffer.Add(cubeCorners, "SCALAR", gltfUnsignedShort);
  const std::vector<std::uint8_t> seventh{ 0, 7 };
  const std::vector<float> far{ 9, 9, 9, 3, 3, 3 };
  const std::vector<std::uint32_t> all{ 0, 1, 2, 3, 4, 5, 6, 7 };
  const int one = buffer.AddView(seventh.data(), seventh.size());
  const int values = buffer.AddView(far.data(), far.size() * sizeof(float));
  const int eight = buffer.AddView(all.data(), all.size() * sizeof(std::uint32_t));
  const auto sparse = [&](int count, int indices, const std::string& type, int over,
                        const std::string& view = "", int skip = 0)
  {
    GltfBuffer copy = buffer;
    const int places = copy.AddJson(
      "{" + view +
      "\"componentType\":5126,\"type\":\"VEC3\",\"count\":8,"
      "\"sparse\":{\"count\":" +
      std::to_string(count) + ",\"indices\":{\"bufferView\":" + std::to_string(indices) +
      ",\"byteOffset\":" + std::to_string(skip) + ",\"componentType\":" + type +
      "},\"values\":{\"bufferView\":" + std::to_string(over) +
      ",\"byteOffset\":" + std::to_string(12 * skip) + "}}}");
    return copy.Glb(Scene(Part(places, corners), "{\"mesh\":0}"));
  };
  const std::string view = "\"bufferView\":0,";
  this->Expect(sparse(1, one, "5121", values, view, 1), 8, 12, { -1, -1, -1 }, { 3, 3, 3 }, 12);
  // All values replace zeros, because there is no bufferView.
  this->Expect(sparse(8, eight, "5125", 0), 8, 12, { -1, -1, -1 }, { 1, 1, 1 }, 8);
  this->ExpectGlbError(sparse(3, one, "5121", values, view),
    "has a property 'sparse' that claims 3 elements, more than its bufferView has");
  this->ExpectGlbError(sparse(1, one, "5126", values, view), "its indices are not whole numbers");
  this->ExpectGlbError(sparse(1, values, "5125", values, view), "is sparse, and names its element");
  this->ExpectGlbError(sparse(1, 99, "5121", values, view),
    "has a property 'sparse' that names bufferView 99, but there are 5");
}

TEST_F(TestConvertGltf, WholeNumbersAreRead)
{
  const auto scene = [](GltfBuffer& buffer, int places, const std::string& more = "")
  {
    const int corners = buffer.Add(cubeCorners, "SCALAR", gltfUnsignedShort);
    return Scene(Part(places, corners, more), "{\"mesh\":0,\"scale\":[0.01,0.01,0.01]}", "0",
      ",\"extensionsRequired\":[\"KHR_mesh_quantization\"]");
  };
  GltfBuffer shorts;
  const int places = shorts.Add(CubePlaces<std::int16_t>(1000), "VEC3", gltfShort);
  this->Expect(shorts.Glb(scene(shorts, places)), 8, 12, { -10, -10, -10 }, { 10, 10, 10 }, 8000);
  GltfBuffer bytes;
  const int parts = bytes.Add(CubePlaces<std::int8_t>(127), "VEC3", gltfByte);
  bytes.NormalizeLast();
  const int normals = bytes.Add(CubePlaces<std::int8_t>(127), "VEC3", gltfByte);
  bytes.NormalizeLast();
  std::vector<std::uint16_t> quarters;
  for (int i = 0; i < 8; ++i)
  {
    quarters.insert(quarters.end(), { std::uint16_t(13107 * (i % 6)), std::uint16_t{ 65535 } });
  }
  const int coordinates = bytes.Add(quarters, "VEC2", gltfUnsignedShort);
  bytes.NormalizeLast();
  this->Expect(
    bytes.Glb(scene(bytes, parts,
      ",\"NORMAL\":" + std::to_string(normals) + ",\"TEXCOORD_0\":" + std::to_string(coordinates))),
    8, 12, { -0.01, -0.01, -0.01 }, { 0.01, 0.01, 0.01 }, 8e-6);
  EXPECT_NEAR(ValuesOf(this->Last, "Normals")[0], -std::sqrt(1.0 / 3), 1e-6);
  EXPECT_NEAR(ValuesOf(this->Last, "TCoords")[2], 0.2, 1e-6);
  EXPECT_EQ(ValuesOf(this->Last, "TCoords")[1], 1);
}

TEST_F(TestConvertGltf, EveryModeIsJoined)
{
  const auto read =
    [&](int mode, const std::vector<std::uint8_t>& corners, const std::string& warnings = "")
  {
    GltfBuffer buffer;
    const int places =
      buffer.Add(std::vector<float>{ 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0 }, "VEC3", gltfFloat);
    const int indices = buffer.Add(corners, "SCALAR", gltfUnsignedByte);
    this->WriteText("in.glb",
      buffer.Glb(
        Scene(Part(places, indices) + ",\"mode\":" + std::to_string(mode), "{\"mesh\":0}")));
    const Mesh mesh = this->Converted(
      "in.glb", warnings.empty() ? "" : "kdstream-convert: warning: in.glb: " + warnings + "\n");
    EXPECT_EQ(mesh.points.size(), 4U);
    return mesh.triangles;
  };
  EXPECT_EQ(read(5, { 0, 1, 2, 3 }), (std::vector<Triangle>{ { 0, 1, 2 }, { 2, 1, 3 } }));
  EXPECT_EQ(read(6, { 0, 1, 3, 2 }), (std::vector<Triangle>{ { 0, 1, 3 }, { 0, 3, 2 } }));
  EXPECT_TRUE(read(0, { 0, 1, 2, 3 }).empty());
  EXPECT_TRUE(read(1, { 0, 1, 2, 3 }, "left out: 2 line cells; their points stay").empty());
  EXPECT_TRUE(read(3, { 0, 1, 2, 3 }, "left out: 1 line cell; their points stay").empty());
  GltfBuffer buffer;
  const int places = buffer.Add(CubePlaces(1.0F), "VEC3", gltfFloat);
  const int wrong = buffer.Add(std::vector<std::uint16_t>{ 0, 1, 8 }, "SCALAR", gltfUnsignedShort);
  this->ExpectGlbError(buffer.Glb(Scene(Part(places, wrong), "{\"mesh\":0}")),
    "mesh 0, part 0: its index 2 names vertex 8, but there are 8");
}

TEST_F(TestConvertGltf, TheSceneToBeShownIsRead)
{
  GltfBuffer buffer;
  const int places = buffer.Add(CubePlaces(1.0F), "VEC3", gltfFloat);
  const int corners = buffer.Add(cubeCorners, "SCALAR", gltfUnsignedShort);
  const auto glb = [&](const std::string& scenes)
  {
    return buffer.Glb(scenes +
                      "\"nodes\":[{\"mesh\":0},{\"children\":[2]},{\"mesh\":0,"
                      "\"translation\":[9,0,0]}],\"meshes\":[{\"primitives\":[{" +
                      Part(places, corners) + "}]}]");
  };
  const std::string two = "\"scenes\":[{\"nodes\":[0]},{\"nodes\":[1]}],";
  this->Expect(glb("\"scene\":1," + two), 8, 12, { 8, -1, -1 }, { 10, 1, 1 }, 8);
  this->Expect(glb(two), 8, 12, { -1, -1, -1 }, { 1, 1, 1 }, 8,
    "the default scene does not exist; the first of 2 is read");
  this->Expect(glb("\"scenes\":[{\"nodes\":[1]}],"), 8, 12, { 8, -1, -1 }, { 10, 1, 1 }, 8);
  this->Expect(glb(""), 16, 24, { -1, -1, -1 }, { 10, 1, 1 }, 16,
    "it has no scene: all of its nodes are read");
  this->ExpectGlbError(glb("\"scene\":2," + two), "names scene 2, but there are 2");
  this->ExpectGlbError(
    glb("\"scenes\":[{\"nodes\":[3]}],"), "scene 0 names node 3, but there are 3");
}

TEST_F(TestConvertGltf, SkinsAndShapesStandAsTheirNodesDo)
{
  GltfBuffer buffer;
  const int places = buffer.Add(CubePlaces(1.0F), "VEC3", gltfFloat);
  const int corners = buffer.Add(cubeCorners, "SCALAR", gltfUnsignedShort);
  std::vector<std::uint8_t> numbers;
  std::vector<float> weights, higher;
  for (int i = 0; i < 8; ++i)
  {
    numbers.insert(numbers.end(), { 0, 1, 0, 0 });
    weights.insert(weights.end(), { 0.5F, 0.5F, 0, 0 });
    higher.insert(higher.end(), { 0, 0, 3 });
  }
  const std::string joints =
    ",\"JOINTS_0\":" + std::to_string(buffer.Add(numbers, "VEC4", gltfUnsignedByte)) +
    ",\"WEIGHTS_0\":" + std::to_string(buffer.Add(weights, "VEC4", gltfFloat));
  const std::string pose =
    "skins and animations are left out: the mesh is read as its nodes place it";
  const auto skinned = [&](const std::string& attributes, const std::string& joint)
  {
    GltfBuffer copy = buffer;
    return copy.Glb(Scene(Part(places, corners, attributes),
      "{\"mesh\":0,\"skin\":0,\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]},"
      "{\"translation\":[5,0,0],\"children\":[2]},{\"translation\":[0,2,0]}",
      "0,1", ",\"skins\":[{\"joints\":[1" + joint + "]}]"));
  };
  // Halfway between the joints at (5, 0, 0) and (5, 2, 0).
  this->Expect(skinned(joints, ",2"), 8, 12, { 4, 0, -1 }, { 6, 2, 1 }, 8, pose);
  // If the points have no joints, the skin leaves them where they are.
  this->Expect(skinned("", ",2"), 8, 12, { -1, -1, -1 }, { 1, 1, 1 }, 8);
  this->ExpectGlbError(skinned(joints, ""), "skin 0: vertex 0 names joint 1, but there are 1");
  const int shape = buffer.Add(higher, "VEC3", gltfFloat);
  const std::string part =
    Part(places, corners) + ",\"targets\":[{\"POSITION\":" + std::to_string(shape) + "}]";
  const std::string shaped =
    "morph targets are left out: the mesh has the shape that their weights give it";
  this->Expect(buffer.Glb(Scene(part, "{\"mesh\":0,\"weights\":[0.5]}")), 8, 12, { -1, -1, 0.5 },
    { 1, 1, 2.5 }, 8, shaped);
  this->Expect(
    buffer.Glb(Scene(part, "{\"mesh\":0}")), 8, 12, { -1, -1, -1 }, { 1, 1, 1 }, 8, shaped);
}

TEST_F(TestConvertGltf, ColoursOfAllTypesAreRead)
{
  const auto read = [&](auto values, const std::string& type, int component, bool normalized)
  {
    GltfBuffer buffer;
    const int places =
      buffer.Add(std::vector<float>{ 0, 0, 0, 1, 0, 0, 0, 1, 0 }, "VEC3", gltfFloat);
    const int colors = buffer.Add(values, type, component);
    if (normalized)
    {
      buffer.NormalizeLast();
    }
    this->WriteText(
      "in.glb", buffer.Glb(Scene("\"attributes\":{\"POSITION\":" + std::to_string(places) +
                                   ",\"COLOR_0\":" + std::to_string(colors) + "}",
                  "{\"mesh\":0}")));
    return ValuesOf(this->Converted("in.glb"), "RGB");
  };
  const std::vector<double> expected{ 255, 0, 0, 0, 255, 0, 255, 255, 255 };
  const std::vector<std::uint8_t> bytes{ 255, 0, 0, 255, 0, 255, 0, 255, 255, 255, 255, 255 };
  EXPECT_EQ(read(bytes, "VEC4", gltfUnsignedByte, true), expected);
  EXPECT_EQ(read(bytes, "VEC4", gltfUnsignedByte, false), expected);
  const std::vector<std::uint16_t> shorts{ 65535, 0, 0, 0, 65535, 0, 65535, 65535, 65535 };
  EXPECT_EQ(read(shorts, "VEC3", gltfUnsignedShort, true), expected);
  const std::vector<float> floats{ 1, 0, 0, 0, 1, 0, 1, 1, 1 };
  EXPECT_EQ(read(floats, "VEC3", gltfFloat, false), expected);
}

TEST_F(TestConvertGltf, FurtherArraysAreCarried)
{
  GltfBuffer buffer;
  const int places = buffer.Add(std::vector<float>{ 0, 0, 0, 1, 0, 0, 0, 1, 0 }, "VEC3", gltfFloat);
  const int classes = buffer.Add(std::vector<std::uint8_t>{ 3, 1, 2 }, "SCALAR", gltfUnsignedByte);
  const int heat = buffer.Add(std::vector<float>{ 0.5F, 1.5F, -2 }, "SCALAR", gltfFloat);
  this->WriteText("in.glb",
    buffer.Glb(Scene("\"attributes\":{\"POSITION\":" + std::to_string(places) + ",\"_CLASS\":" +
                       std::to_string(classes) + ",\"_HEAT\":" + std::to_string(heat) + "}",
      "{\"mesh\":0}")));
  const Mesh read = this->Converted("in.glb");
  EXPECT_EQ(ValuesOf(read, "_CLASS"), (std::vector<double>{ 3, 1, 2 }));
  EXPECT_EQ(ValuesOf(read, "_HEAT"), (std::vector{ 0.5, 1.5, -2.0 }));
}

TEST_F(TestConvertGltf, PointsThatAreNotFiniteAreDropped)
{
  std::vector<float> places = CubePlaces(1.0F);
  places[7 * 3 + 1] = std::numeric_limits<float>::quiet_NaN();
  std::vector<std::uint8_t> numbers{ 0, 1, 2, 3, 4, 5, 6, 7 };
  GltfBuffer buffer;
  const int position = buffer.Add(places, "VEC3", gltfFloat);
  const int corners = buffer.Add(cubeCorners, "SCALAR", gltfUnsignedShort);
  const int number = buffer.Add(numbers, "SCALAR", gltfUnsignedByte);
  this->WriteText("in.glb",
    buffer.Glb(
      Scene(Part(position, corners, ",\"_NUMBER\":" + std::to_string(number)), "{\"mesh\":0}")));
  const Outcome outcome = this->Convert("in.glb");
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  const Mesh read = this->Read("out.ply");
  EXPECT_EQ(read.points.size(), 7U);
  EXPECT_EQ(read.triangles.size(), 9U);
  EXPECT_EQ(ValuesOf(read, "_NUMBER"), (std::vector<double>{ 0, 1, 2, 3, 4, 5, 6 }));
}

TEST_F(TestConvertGltf, AGlbMayEndLaterAndNotEarlier)
{
  const std::string glb = this->Cubes("{\"mesh\":0}");
  this->WriteText("in.glb", glb + "xx");
  const Outcome later = this->Convert("in.glb");
  EXPECT_EQ(later.exitCode, 0) << later.err;
  EXPECT_EQ(this->Read("out.ply").points.size(), 8U);
  this->ExpectGlbError(glb.substr(0, glb.size() - 1), "bytes; the file has");
  this->ExpectGlbError("glTF" + std::string(3, '\0'), "ends inside its header: it has 7 bytes");
  std::string first = glb;
  first[4] = 1;
  this->ExpectGlbError(first, "has version 1 of glTF; only version 2 can be read");
  std::string json = glb;
  json[60] = '\x01';
  this->ExpectGlbError(json, "its JSON is damaged at byte 60");
  this->WriteText("in.gltf", "{\"asset\":{\"version\":\"1.0\"}}");
  this->ExpectError("in.gltf", "has version \"1.0\" of glTF; only version 2 can be read");
  this->WriteText("in.gltf", "{\"asset\":{\"version\":\"2.0\"}");
  this->ExpectError("in.gltf", "its JSON breaks off at byte 26");
  this->WriteText("in.gltf", "{\"a\":1}");
  this->ExpectError("in.gltf", "is not glTF: its JSON has no asset version");
}

TEST_F(TestConvertGltf, ExtensionsThatAreNotReadAreNamed)
{
  const auto glb = [&](const std::string& more)
  {
    GltfBuffer buffer;
    const int places = buffer.Add(CubePlaces(1.0F), "VEC3", gltfFloat);
    const int corners = buffer.Add(cubeCorners, "SCALAR", gltfUnsignedShort);
    return buffer.Glb(Scene(Part(places, corners), "{\"mesh\":0}", "0", more));
  };
  this->ExpectGlbError(glb(",\"extensionsRequired\":[\"EXT_odd_geometry\"]"),
    "needs the extension \"EXT_odd_geometry\", which is not read: save it without");
  const Vec3 lo{ -1, -1, -1 }, hi{ 1, 1, 1 };
  this->Expect(glb(",\"extensionsUsed\":[\"EXT_odd_geometry\"]"), 8, 12, lo, hi, 8,
    "extensions that are not read: \"EXT_odd_geometry\"");
  this->Expect(glb(",\"extensionsRequired\":[\"KHR_materials_unlit\"]"), 8, 12, lo, hi, 8,
    "extensions that are not read: \"KHR_materials_unlit\"");
  this->Expect(glb(",\"extensionsUsed\":[\"KHR_materials_pbrSpecularGlossiness\"],\"materials\":[{"
                   "\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{\"diffuseFactor\":[1,"
                   "0,0,1]}}}]"),
    8, 12, lo, hi, 8);
}

TEST_F(TestConvertGltf, ScenesOnThePlanetStandThere)
{
  GltfBuffer buffer;
  const int places = buffer.Add(CubePlaces(1.0F), "VEC3", gltfFloat);
  const int corners = buffer.Add(cubeCorners, "SCALAR", gltfUnsignedShort);
  for (const std::string list : { "extensionsUsed", "extensionsRequired" })
  {
    this->Expect(buffer.Glb(Scene(Part(places, corners), "{\"mesh\":0,\"scale\":[0.5,1,1]}", "0",
                   ",\"" + list +
                     "\":[\"CESIUM_RTC\"],\"extensions\":{\"CESIUM_RTC\":{"
                     "\"center\":[4000000.25,100,-5000000]}}")),
      8, 12, { 3999999.75, 99, -5000001 }, { 4000000.75, 101, -4999999 }, 4);
  }
}

TEST_F(TestConvertGltf, HiddenNodesAreLeftOut)
{
  GltfBuffer buffer;
  const int places = buffer.Add(CubePlaces(1.0F), "VEC3", gltfFloat);
  const int corners = buffer.Add(cubeCorners, "SCALAR", gltfUnsignedShort);
  this->Expect(buffer.Glb(Scene(Part(places, corners),
                 "{\"mesh\":0},{\"children\":[2],\"extensions\":{\"KHR_node_visibility\":{"
                 "\"visible\":false}}},{\"mesh\":0,\"translation\":[9,9,9]}",
                 "0,1", ",\"extensionsUsed\":[\"KHR_node_visibility\"]")),
    8, 12, { -1, -1, -1 }, { 1, 1, 1 }, 8,
    "left out: 1 node that is hidden, with what is below it");
}

TEST_F(TestConvertGltf, BytesInTheFileAreReadHoweverTheyAreWritten)
{
  GltfBuffer buffer;
  const int places = buffer.Add(CubePlaces(1.0F), "VEC3", gltfFloat);
  const int corners = buffer.Add(cubeCorners, "SCALAR", gltfUnsignedShort);
  std::string hex;
  for (const char c : buffer.Bytes)
  {
    constexpr char digits[] = "0123456789ABCDEF";
    const auto byte = static_cast<unsigned char>(c);
    hex += std::string("%") + digits[byte >> 4U] + digits[byte & 15U];
  }
  const auto encoded = [&](const std::string& digits, const std::string& lines)
  {
    std::string text;
    for (std::size_t i = 0; i < buffer.Bytes.size(); i += 3)
    {
      std::uint32_t bits = 0;
      for (std::size_t k = 0; k < 3; ++k)
      {
        bits = bits << 8U |
               (i + k < buffer.Bytes.size() ? static_cast<unsigned char>(buffer.Bytes[i + k]) : 0U);
      }
      for (std::size_t k = 0; k < 4; ++k)
      {
        text += digits[(bits >> (18 - 6 * k)) & 63U];
      }
      text += i % 57 == 54 ? lines : "";
    }
    return text;
  };
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789";
  std::string escaped;
  for (const char c : encoded(letters + "+/", ""))
  {
    escaped += c == '+' ? "%2B" : c == '/' ? "%2f" : std::string(1, c);
  }
  for (const std::string& uri : { "data:application/octet-stream," + hex,
         "data:application/gltf-buffer;base64," + encoded(letters + "-_", ""),
         "data:;base64," + encoded(letters + "+/", "\\r\\n"), "data:;base64," + escaped })
  {
    SCOPED_TRACE(uri.substr(0, 60));
    this->WriteText("in.gltf", buffer.Json(Scene(Part(places, corners), "{\"mesh\":0}"), uri));
    EXPECT_NEAR(VolumeOf(this->Converted("in.gltf")), 8, 1e-6);
  }
  this->WriteText(
    "in.gltf", buffer.Json(Scene(Part(places, corners), "{\"mesh\":0}"), "data:;base64,A*A="));
  this->ExpectError("in.gltf", "buffer 0 is a data URI that is not base64");
}

TEST_F(TestConvertGltf, BuffersAreFoundAsPicturesAre)
{
  GltfBuffer buffer;
  const int places = buffer.Add(CubePlaces(1.0F), "VEC3", gltfFloat);
  const int corners = buffer.Add(cubeCorners, "SCALAR", gltfUnsignedShort);
  std::filesystem::create_directories(this->Folder / "sub");
  this->WriteText("sub/mesh.bin", buffer.Bytes);
  this->WriteText("other.bin", buffer.Bytes);
  for (const std::string uri : { "sub\\\\mesh.bin", "Sub/MESH.BIN", "sub/mesh.bin?v=1",
         "C:\\\\scans\\\\other.bin", "../elsewhere/other.bin" })
  {
    SCOPED_TRACE(uri);
    this->WriteText("in.gltf", buffer.Json(Scene(Part(places, corners), "{\"mesh\":0}"), uri));
    EXPECT_NEAR(VolumeOf(this->Converted("in.gltf")), 8, 1e-6);
  }
}

TEST_F(TestConvertGltf, ABufferThatNothingNeedsMayBeMissing)
{
  GltfBuffer buffer;
  const int places = buffer.Add(CubePlaces(1.0F), "VEC3", gltfFloat);
  const int corners = buffer.Add(cubeCorners, "SCALAR", gltfUnsignedShort);
  this->WriteText("mesh.bin", buffer.Bytes);
  std::string json = buffer.Json(Scene(Part(places, corners), "{\"mesh\":0.0}"), "mesh.bin");
  json.insert(json.rfind("]}"), ",{\"byteLength\":99,\"uri\":\"anim.bin\"}");
  this->WriteText("in.gltf", json);
  EXPECT_NEAR(VolumeOf(this->Converted("in.gltf", "kdstream-convert: warning: in.gltf: buffer 1 "
                                                  "cannot be read, but no geometry needs it\n")),
    8, 1e-6);
  std::filesystem::remove(this->Folder / "mesh.bin");
  this->ExpectError("in.gltf", "the file 'mesh.bin', in which its geometry is, is not there: put "
                               "it into the folder of the glTF, under this name\n");
}

// Parts that share one accessor of points keep only the points that they use; parts without
// triangles keep all.
TEST_F(TestConvertGltf, SharedPointsAreNotMultiplied)
{
  GltfBuffer buffer;
  const int places = buffer.Add(CubePlaces(1.0F), "VEC3", gltfFloat);
  std::string parts;
  for (std::size_t i = 0; i < cubeCorners.size(); i += 3)
  {
    const int corners =
      buffer.Add(std::vector<std::uint16_t>(cubeCorners.begin() + std::ptrdiff_t(i),
                   cubeCorners.begin() + std::ptrdiff_t(i) + 3),
        "SCALAR", gltfUnsignedShort);
    parts += (i == 0 ? "" : "},{") + Part(places, corners);
  }
  this->Expect(buffer.Glb(Scene(parts, "{\"mesh\":0}")), 36, 12, { -1, -1, -1 }, { 1, 1, 1 }, 8);
  this->WriteText("in.glb",
    buffer.Glb(Scene(parts + "},{\"mode\":0,\"attributes\":{\"POSITION\":0}", "{\"mesh\":0}")));
  EXPECT_EQ(this->Converted("in.glb").points.size(), 44U);
}

TEST_F(TestConvertGltf, WhatHasNoBytesIsBound)
{
  std::string parts;
  for (int i = 0; i < 60; ++i)
  {
    parts += std::string(i == 0 ? "" : ",") + "{\"attributes\":{\"POSITION\":0}}";
  }
  this->WriteText("in.gltf",
    "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],"
    "\"meshes\":[{\"primitives\":[" +
      parts + "]}],\"accessors\":[{\"componentType\":5126,\"type\":\"VEC3\",\"count\":1000000}]}");
  this->ExpectError("in.gltf", "elements of accessors without a bufferView");
}

TEST_F(TestConvertGltf, ScenesThatShowNothingSayWhy)
{
  this->WriteText("in.gltf", "{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[]}]}");
  this->ExpectError("in.gltf", "holds no points; no node of its scene shows a mesh that has "
                               "points: correct the file, or export it again\n");
}

TEST_F(TestConvertGltf, WhatIsShownTooOftenIsRefusedBeforeItTakesMemory)
{
  GltfBuffer buffer;
  const int places = buffer.Add(std::vector<float>(3 * 90000, 1.0F), "VEC3", gltfFloat);
  std::string nodes = "{\"children\":[1";
  for (int i = 2; i <= 50000; ++i)
  {
    nodes += "," + std::to_string(i);
  }
  nodes += "]}";
  for (int i = 1; i <= 50000; ++i)
  {
    nodes += ",{\"mesh\":0}";
  }
  this->WriteText("in.glb",
    buffer.Glb(Scene("\"attributes\":{\"POSITION\":" + std::to_string(places) + "}", nodes)));
  const Outcome outcome = this->Convert("in.glb");
  EXPECT_EQ(outcome.exitCode, 1);
  EXPECT_NE(
    outcome.err.find("its nodes show more than 4294967294 points or triangles"), std::string::npos)
    << outcome.err;
  EXPECT_LE(outcome.peakBytes, std::uint64_t{ 200 } << 20);
  // An accessor claims elements for which there are no bytes.
  GltfBuffer zeros;
  zeros.AddJson("{\"componentType\":5126,\"type\":\"VEC3\",\"count\":1000000000}");
  this->ExpectGlbError(zeros.Glb(Scene("\"attributes\":{\"POSITION\":0}", "{\"mesh\":0}")),
    "accessor 0 claims 1000000000 elements without a bufferView");
}

#ifdef KDSTREAM_HAS_MESHOPTIMIZER

namespace
{

struct Compressed
{
  std::vector<unsigned char> bytes;
  std::size_t count, stride;
  std::string mode, filter = "NONE";
};

Compressed Attributes(const void* values, std::size_t count, std::size_t stride)
{
  std::vector<unsigned char> bytes(meshopt_encodeVertexBufferBound(count, stride));
  meshopt_encodeVertexVersion(0);
  bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), values, count, stride));
  return { bytes, count, stride, "ATTRIBUTES" };
}

Compressed Corners(bool sequence)
{
  const std::vector<unsigned int> corners(cubeCorners.begin(), cubeCorners.end());
  std::vector<unsigned char> bytes(1000);
  meshopt_encodeIndexVersion(1);
  bytes.resize(
    sequence
      ? meshopt_encodeIndexSequence(bytes.data(), bytes.size(), corners.data(), corners.size())
      : meshopt_encodeIndexBuffer(bytes.data(), bytes.size(), corners.data(), corners.size()));
  return { bytes, corners.size(), 2, sequence ? "INDICES" : "TRIANGLES" };
}

}

TEST_F(TestConvertGltf, WhatMeshoptimizerCompressedIsRead)
{
  std::string fallback = "\"byteLength\":1000";
  // The views are in a buffer that does not exist; their compressed bytes are in the first buffer.
  const auto glb = [&](const Compressed& places, const Compressed& corners,
                     int component = gltfFloat, const std::string& name = "EXT_meshopt_compression")
  {
    std::string bytes, views;
    for (const Compressed* view : { &places, &corners })
    {
      bytes.resize((bytes.size() + 3) / 4 * 4);
      const std::string stride = std::to_string(view->stride);
      const bool attributes = view->mode == "ATTRIBUTES";
      views += std::string(views.empty() ? "" : ",") +
               "{\"buffer\":1,\"byteLength\":" + std::to_string(view->count * view->stride) +
               (attributes ? ",\"byteStride\":" + stride : "") + ",\"extensions\":{\"" + name +
               "\":{\"buffer\":0,\"byteOffset\":" + std::to_string(bytes.size()) +
               ",\"byteLength\":" + std::to_string(view->bytes.size()) +
               ",\"byteStride\":" + stride + ",\"count\":" + std::to_string(view->count) +
               ",\"mode\":\"" + view->mode + "\",\"filter\":\"" + view->filter + "\"}}}";
      bytes.append(view->bytes.begin(), view->bytes.end());
    }
    return GlbOf(
      "{\"asset\":{\"version\":\"2.0\"}," + Scene(Part(0, 1), "{\"mesh\":0}") +
        ",\"accessors\":[{\"bufferView\":0,\"componentType\":" + std::to_string(component) +
        ",\"type\":\"VEC3\",\"count\":8},{\"bufferView\":1,\"componentType\":5123,\"type\":"
        "\"SCALAR\",\"count\":36}],\"bufferViews\":[" +
        views + "],\"buffers\":[{\"byteLength\":" + std::to_string(bytes.size()) + "},{" +
        fallback + ",\"extensions\":{\"" + name +
        "\":{\"fallback\":true}}}],\"extensionsRequired\":[\"" + name + "\"]}",
      bytes);
  };
  const std::vector<float> cube = CubePlaces(1.0F);
  const Compressed places = Attributes(cube.data(), 8, 12);
  for (const bool sequence : { false, true })
  {
    this->Expect(glb(places, Corners(sequence)), 8, 12, { -1, -1, -1 }, { 1, 1, 1 }, 8);
  }
  this->Expect(glb(places, Corners(false), gltfFloat, "KHR_meshopt_compression"), 8, 12,
    { -1, -1, -1 }, { 1, 1, 1 }, 8);
  // Floats stored as exponents and mantissas.
  std::vector<unsigned int> powers(24);
#if MESHOPTIMIZER_VERSION >= 190
  meshopt_encodeFilterExp(powers.data(), 8, 12, 15, cube.data(), meshopt_EncodeExpSharedVector);
#else
  meshopt_encodeFilterExp(powers.data(), 8, 12, 15, cube.data());
#endif
  Compressed filtered = Attributes(powers.data(), 8, 12);
  filtered.filter = "EXPONENTIAL";
  this->Expect(glb(filtered, Corners(false)), 8, 12, { -1, -1, -1 }, { 1, 1, 1 }, 8);
  filtered.filter = "ODD";
  this->ExpectGlbError(
    glb(filtered, Corners(false)), "meshoptimizer with an unknown filter: 'ODD'");
  Compressed damaged = places;
  damaged.bytes[0] = 0;
  this->ExpectGlbError(glb(damaged, Corners(false)),
    "mesh 0, part 0: accessor 0 lies in a bufferView that is damaged");
  // The same bytes without compression, for readers that cannot decompress.
  this->WriteText("plain.bin",
    std::string(reinterpret_cast<const char*>(cube.data()), cube.size() * sizeof(float)));
  fallback = "\"byteLength\":96,\"uri\":\"plain.bin\"";
  this->Expect(glb(damaged, Corners(false)), 8, 12, { -1, -1, -1 }, { 1, 1, 1 }, 8);
  fallback = "\"byteLength\":1000";
  Compressed greedy = places;
  greedy.count = 1000000000;
  this->ExpectGlbError(glb(greedy, Corners(false)), "claims 1000000000 compressed elements");
  Compressed cut = Corners(false);
  cut.bytes.resize(cut.bytes.size() / 2);
  this->ExpectGlbError(glb(places, cut), "are not compressed by meshoptimizer");
}

#endif

#ifdef KDSTREAM_HAS_DRACO

TEST_F(TestConvertGltf, WhatDracoCompressedIsRead)
{
  const std::vector<float> cube = CubePlaces(1.0F);
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(12);
  const int position =
    builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int color = builder.AddAttribute(draco::GeometryAttribute::COLOR, 4, draco::DT_UINT8);
  const std::array<std::uint8_t, 4> red{ 255, 0, 0, 255 };
  for (std::uint32_t f = 0; f < 12; ++f)
  {
    const auto at = [&](std::size_t k)
    { return cube.data() + 3 * std::size_t{ cubeCorners[3 * f + k] }; };
    builder.SetAttributeValuesForFace(position, draco::FaceIndex(f), at(0), at(1), at(2));
    builder.SetAttributeValuesForFace(
      color, draco::FaceIndex(f), red.data(), red.data(), red.data());
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  ASSERT_TRUE(mesh);
  draco::Encoder encoder;
  draco::EncoderBuffer encoded;
  ASSERT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &encoded).ok());
  const std::string bytes(encoded.data(), encoded.size());
  const auto glb = [&](const std::string& content, int attribute)
  {
    return GlbOf(
      "{\"asset\":{\"version\":\"2.0\"}," +
        Scene("\"attributes\":{\"POSITION\":0,\"COLOR_0\":2},\"indices\":1,\"extensions\":{\"KHR_"
              "draco_mesh_compression\":{\"bufferView\":0,\"attributes\":{\"POSITION\":" +
                std::to_string(attribute) + ",\"COLOR_0\":1}}}",
          "{\"mesh\":0,\"scale\":[-1,1,1]}") +
        ",\"accessors\":[{\"componentType\":5126,\"type\":\"VEC3\",\"count\":8},{\"componentType\":"
        "5123,\"type\":\"SCALAR\",\"count\":36},{\"componentType\":5121,\"type\":\"VEC4\","
        "\"normalized\":true,\"count\":8}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":" +
        std::to_string(content.size()) +
        "}],\"buffers\":[{\"byteLength\":" + std::to_string(content.size()) +
        "}],\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]}",
      content);
  };
  this->Expect(glb(bytes, 0), 8, 12, { -1, -1, -1 }, { 1, 1, 1 }, 8, "", 1e-3);
  EXPECT_EQ(ValuesOf(this->Last, "RGB")[0], 255);
  EXPECT_EQ(ValuesOf(this->Last, "RGB")[1], 0);
  this->ExpectGlbError(glb(bytes.substr(0, bytes.size() / 2), 0),
    "mesh 0, part 0: is damaged: its " + std::to_string(bytes.size() / 2) +
      " bytes are not compressed by Draco");
  this->ExpectGlbError(
    glb(bytes, 7), "'POSITION' names attribute 7 of what Draco compressed, which is not there");
}

#endif
