// SPDX-License-Identifier: BSD-3-Clause
// Whether a build is made in memory or in files is decided before a point is read, in every format.
// Exactly at the limit it is made in memory, just below the limit in files, and both make the same
// store.
#include "Testing/Fixtures/Meshes.h"
#include "filters/build/BuildInput.h"
#include "filters/build/Testing/ExternalBuilderTest.h"

#include <functional>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

std::string CoordinatesText(const Vec3& point)
{
  std::string text;
  for (const double value : point)
  {
    text += " " + std::to_string(value);
  }
  return text;
}

std::string TextPly(const Mesh& mesh)
{
  std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(mesh.points.size()) +
                     "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                     std::to_string(mesh.triangles.size()) +
                     "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vec3& point : mesh.points)
  {
    text += CoordinatesText(point).substr(1) + "\n";
  }
  for (const Triangle& t : mesh.triangles)
  {
    text +=
      "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\n";
  }
  return text;
}

std::string TextOff(const Mesh& mesh)
{
  const std::string ply = TextPly(mesh);
  return "OFF\n" + std::to_string(mesh.points.size()) + " " +
         std::to_string(mesh.triangles.size()) + " 0\n" +
         ply.substr(ply.find("end_header\n") + std::string_view("end_header\n").size());
}

std::string TextStl(const Mesh& mesh)
{
  std::string text = "solid\n";
  for (const Triangle& triangle : mesh.triangles)
  {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const VertexId corner : triangle)
    {
      text += "vertex" + CoordinatesText(mesh.points[corner]) + "\n";
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid\n";
}

// With a normal for each vertex, to which every corner refers.
std::string ObjWithNormals(const Mesh& mesh)
{
  std::string text;
  for (const Vec3& point : mesh.points)
  {
    text += "v" + CoordinatesText(point) + "\nvn" + CoordinatesText(point) + "\n";
  }
  for (const Triangle& triangle : mesh.triangles)
  {
    text += "f";
    for (const VertexId corner : triangle)
    {
      const std::string number = std::to_string(corner + 1);
      text += " " + number + "//" + number;
    }
    text += "\n";
  }
  return text;
}

class MemoryChoice : public ExternalBuilderTest
{
protected:
  struct Format
  {
    const char* file;
    std::function<std::string(const Mesh&)> text; // null: as WriteMesh writes it
  };
  static std::vector<Format> Formats()
  {
    return { { "binary.ply", nullptr }, { "text.ply", TextPly }, { "binary.stl", nullptr },
      { "text.stl", TextStl }, { "plain.obj", nullptr }, { "normals.obj", ObjWithNormals },
      { "text.off", TextOff } };
  }

  std::filesystem::path Write(const Format& format, const Mesh& mesh) const
  {
    const std::filesystem::path file = this->Folder / format.file;
    if (format.text)
    {
      std::ofstream(file, std::ios::binary) << format.text(mesh);
      return file;
    }
    const Status status = WriteMesh(file, mesh);
    EXPECT_TRUE(status) << status.GetError().message;
    return file;
  }

  // The smallest limit with which the file is built in memory.
  std::uint64_t LeastLimit(const std::filesystem::path& file) const
  {
    const auto reader = MeshReader::Open(file);
    EXPECT_TRUE(reader) << reader.GetError().message;
    std::uint64_t below = 1, enough = std::uint64_t{ 1 } << 40;
    BuildOptions options = this->Options;
    while (enough - below > 1)
    {
      options.memory = (below + enough) / 2;
      (CheckInputMemory(**reader, options) ? enough : below) = options.memory;
    }
    return enough;
  }

  // Returns whether the build used files; sets the store's digest.
  bool TakesFiles(const std::filesystem::path& file, std::uint64_t limit, std::string& digest)
  {
    BuildOptions options = this->Options;
    options.memory = limit;
    const auto report = BuildStore(file, this->Store(), options);
    EXPECT_TRUE(report) << report.GetError().message;
    digest = report ? report->info.digest : std::string();
    return report && report->temporaryBytes > 0;
  }
};

}

TEST_F(MemoryChoice, TheLimitDecidesAndTheStoreIsTheSame)
{
  this->Options.tree.verticesPerPartition = 2000;
  const Mesh mesh = Torus(400, 200);
  for (const Format& format : Formats())
  {
    SCOPED_TRACE(format.file);
    const std::filesystem::path file = this->Write(format, mesh);
    const std::uint64_t limit = this->LeastLimit(file);
    ASSERT_GT(limit, leastMemory);
    std::string inMemory, inFiles;
    EXPECT_FALSE(this->TakesFiles(file, limit, inMemory));
    EXPECT_TRUE(this->TakesFiles(file, limit - 1, inFiles));
    EXPECT_EQ(inMemory, inFiles);
  }
}

TEST_F(MemoryChoice, ItIsMadeBeforeAPointIsRead)
{
  const auto withBadPoint = [](const std::string& text, const std::string& before)
  {
    std::string bad = text;
    bad.replace(text.find(before) + before.size(), 1, "?");
    return bad;
  };
  const Mesh mesh = Torus(30, 20);
  const std::pair<const char*, std::string> files[] = {
    { "text.ply", withBadPoint(TextPly(mesh), "end_header\n") },
    { "text.stl", withBadPoint(TextStl(mesh), "vertex ") },
    { "plain.obj", "v ? 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" },
    { "text.off", withBadPoint(TextOff(mesh), " 0\n") },
    { "binary.ply",
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n0123456" }
  };
  for (const auto& [name, content] : files)
  {
    SCOPED_TRACE(name);
    const std::filesystem::path file = this->Folder / name;
    std::ofstream(file, std::ios::binary) << content;
    BuildOptions options = this->Options;
    options.memory = 1 << 20;
    EXPECT_EQ(BuildStore(file, this->Store(), options).GetError().code, ErrorCode::LimitExceeded);
    options.memory = 0;
    EXPECT_EQ(BuildStore(file, this->Store(), options).GetError().code, ErrorCode::InvalidInput);
  }
}

// The bound must never be below the real number of triangles.
TEST_F(MemoryChoice, BoundsHoldForAllThatAFileCanHave)
{
  const auto trianglesOf = [this](const char* name, const std::string& content)
  {
    const std::filesystem::path file = this->Folder / name;
    std::ofstream(file, std::ios::binary) << content;
    const auto reader = MeshReader::Open(file);
    EXPECT_TRUE(reader) << reader.GetError().message;
    return (*reader)->Info().mostTriangles;
  };
  const Mesh mesh = Torus(30, 20);
  const std::uint64_t triangles = mesh.triangles.size();
  for (const Format& format : Formats())
  {
    SCOPED_TRACE(format.file);
    const auto reader = MeshReader::Open(this->Write(format, mesh));
    ASSERT_TRUE(reader);
    // For these formats the corners are not counted.
    const bool isBound =
      format.file == std::string("text.ply") || format.file == std::string("text.off");
    EXPECT_GE((*reader)->Info().mostTriangles, triangles);
    EXPECT_LE((*reader)->Info().mostTriangles, triangles * (isBound ? 20 : 1));
  }
  EXPECT_EQ(trianglesOf("quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 1 2\n"), 2U);
  EXPECT_EQ(trianglesOf("quad.stl",
              "solid\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\n"
              "vertex 0 1 0\nendloop\nendfacet\nendsolid\n"),
    2U);
}

// All corners are in two faces, and the third has none; so there are more triangles than faces.
TEST_F(MemoryChoice, FacesOfTooFewCornersDoNotHideTriangles)
{
  std::string content = "ply\nformat binary_little_endian 1.0\nelement vertex 5\nproperty char x\n"
                        "property char y\nproperty char z\nelement face 3\n"
                        "property list uchar char vertex_indices\nend_header\n";
  for (const int value : { 0, 0, 0, 1, 0, 0, 2, 1, 0, 1, 2, 0, 0, 1, 0 })
  {
    content += static_cast<char>(value);
  }
  const std::string places = content;
  content += std::string("\5\0\1\2\3\4", 6) + std::string("\4\0\1\2\3", 5) + std::string(1, '\0');
  std::ofstream(this->Input(), std::ios::binary) << content;
  const auto exact = BuildStore(this->Input(), this->Store(), this->Options);
  ASSERT_FALSE(exact) << "five triangles, where three faces of three corners would fit";
  EXPECT_EQ(exact.GetError().code, ErrorCode::InvalidInput);
  // With one more byte in the file, the bound allows these faces.
  std::ofstream(this->Input(), std::ios::binary)
    << places
    << std::string("\5\0\1\2\3\4", 6) + std::string("\4\0\1\2\3", 5) + std::string("\1\0", 2);
  const auto built = BuildStore(this->Input(), this->Store(), this->Options);
  ASSERT_TRUE(built) << built.GetError().message;
  EXPECT_EQ(built->info.triangles, 5U);
}
