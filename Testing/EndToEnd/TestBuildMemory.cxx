// SPDX-License-Identifier: BSD-3-Clause
// A build in memory keeps --memory, or refuses the mesh.
#include "Testing/EndToEnd/ProgramsTest.h"
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/Sanitized.h"

#include <nlohmann/json.hpp>

#include <malloc.h>

#include <functional>
#include <utility>

using namespace kdstream;
using namespace kdstream::fixtures;
using Json = nlohmann::json;

namespace
{

class BuildMemory : public ProgramsTest
{
};

// With that many floats for each point and for each triangle, in arrays of four at most.
Mesh WithManyBytes(Mesh mesh, std::size_t forPoints, std::size_t forCells)
{
  for (const auto association : { AttributeAssociation::Point, AttributeAssociation::Cell })
  {
    const bool points = association == AttributeAssociation::Point;
    for (std::size_t left = points ? forPoints : forCells; left > 0;)
    {
      const std::size_t components = std::min<std::size_t>(left, 4);
      Attribute attribute{ { "a" + std::to_string(left), AttributeType::Float32, association,
                             static_cast<std::uint8_t>(components) },
        {} };
      attribute.values.resize(
        attribute.TupleSize() * (points ? mesh.points.size() : mesh.triangles.size()));
      mesh.attributes.push_back(std::move(attribute));
      left -= components;
    }
  }
  return mesh;
}

}

TEST_F(BuildMemory, RefusesWhatDoesNotFitTheMemory)
{
  this->Write("in.ply", DisplacedSphere(5));
  const Outcome outcome = this->Build({ "in.ply", "-o", "m.kds", "--memory", "1M" });
  EXPECT_EQ(outcome.exitCode, 1);
  EXPECT_EQ(outcome.err.rfind("kdstream-build: error: in.ply: needs about ", 0), 0U) << outcome.err;
  EXPECT_NE(outcome.err.find("the limit is 1 MiB"), std::string::npos);
  EXPECT_EQ(this->Files(), (std::set<std::string>{ "in.ply" }));
}

TEST_F(BuildMemory, StaysBelowTheMemoryLimit)
{
  if (fixtures::sanitized)
  {
    GTEST_SKIP() << "a sanitizer's own memory would count";
  }
  // A build that accepts a limit keeps it (64 MiB are for the programs themselves), measured from
  // outside. The meshes are freed before the programs start, because a child's peak includes its
  // parent's memory at the fork.
  const auto dense = []
  {
    Mesh mesh = Torus(500, 300);
    const std::vector<Triangle> once = mesh.triangles;
    for (unsigned i = 0; i < 5; ++i)
    {
      mesh.triangles.insert(mesh.triangles.end(), once.begin(), once.end());
    }
    return mesh;
  };
  const auto cloud = []
  {
    Mesh mesh = Torus(1000, 600);
    mesh.triangles.clear();
    return mesh;
  };
  const auto unused = []
  {
    Mesh mesh = Torus(300, 200);
    const std::vector<Vec3> others = Torus(1000, 600).points;
    mesh.points.insert(mesh.points.begin() + 7, others.begin(), others.end());
    for (Triangle& triangle : mesh.triangles)
    {
      for (VertexId& corner : triangle)
      {
        corner += corner < 7 ? 0 : static_cast<VertexId>(others.size());
      }
    }
    return mesh;
  };
  const std::pair<const char*, std::function<Mesh()>> meshes[] = { { "torus", []
                                                                     { return Torus(1000, 600); } },
    { "shuffled torus", [] { return Shuffled(Torus(1000, 600), 1); } }, { "cloud", cloud },
    { "soup", [] { return Soup(200000, 1); } },
    { "attributes", [] { return WithManyBytes(Torus(500, 300), 6, 3); } },
    { "wide attributes", [] { return WithManyBytes(Torus(150, 100), 500, 100); } },
    { "each face six times", dense }, { "most vertices unused", unused } };
  for (const auto& [name, make] : meshes)
  {
    this->Write("in.ply", make());
    ::malloc_trim(0);
    for (const char* cell : { "8", "1" })
    {
      SCOPED_TRACE(std::string(name) + ", cells of " + cell);
      unsigned accepted = 0, refused = 0;
      for (std::uint64_t limit = 32; limit <= 1024; limit += limit / 4)
      {
        const Outcome outcome = this->Build({ "in.ply", "-o", "m.kds", "--memory",
          std::to_string(limit) + "M", "--cell-vertices", cell });
        (outcome.exitCode == 0 ? accepted : refused) += 1;
        EXPECT_LE(outcome.peakBytes, (limit + 64) << 20) << "limit " << limit << " MiB";
        if (outcome.exitCode != 0)
        {
          EXPECT_NE(outcome.err.find(" of memory"), std::string::npos) << outcome.err;
        }
        else
        {
          EXPECT_LE(limit << 20, 4 * outcome.peakBytes)
            << "far more memory than needed was asked for";
          break;
        }
      }
      EXPECT_EQ(accepted, 1U);
      EXPECT_GT(refused, 0U);
    }
  }
}

TEST_F(BuildMemory, OfAnStlWhatWeldingLeavesDecidesTheMemory)
{
  if (fixtures::sanitized)
  {
    GTEST_SKIP() << "a sanitizer's own memory would count";
  }
  const auto temporaryBytes = [&](const Mesh& mesh)
  {
    this->Write("in.stl", mesh);
    constexpr std::uint64_t limit = 80;
    const Outcome outcome = this->Build(
      { "in.stl", "-o", "m.kds", "--memory", std::to_string(limit) + "M", "--stats", "s.json" });
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    EXPECT_LE(outcome.peakBytes, (limit + 64) << 20);
    return Json::parse(ReadWhole(this->Folder / "s.json"))["temp_bytes"].get<std::uint64_t>();
  };
  EXPECT_EQ(temporaryBytes(Torus(500, 300)), 0U) << "it fits, once it is welded";
  EXPECT_GT(temporaryBytes(Soup(200000, 1)), 0U) << "nothing is welded";
}
