// SPDX-License-Identifier: BSD-3-Clause
// A build respects --memory: it works in memory if this certainly suffices, else in files; or it
// refuses the mesh.
#include "Testing/EndToEnd/ProgramsTest.h"
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/Sanitized.h"

#include <nlohmann/json.hpp>

#include <malloc.h>

#include <functional>

using namespace kdstream;
using namespace kdstream::fixtures;
using Json = nlohmann::json;

namespace
{

class BuildMemory : public ProgramsTest
{
protected:
  // A build that accepts a limit respects it, measured from outside (64 MiB are for the programs
  // themselves). The mesh is freed before the programs start, because a child's peak includes
  // its parent's memory at the fork.
  void ExpectBelowLimits(const char* name, const std::function<Mesh()>& make, const char* cell)
  {
    if (fixtures::sanitized) // a sanitizer's own memory would count
    {
      return;
    }
    SCOPED_TRACE(std::string(name) + ", cells of " + cell);
    this->Write("in.ply", make());
    ::malloc_trim(0);
    unsigned inFiles = 0, refused = 0;
    for (std::uint64_t limit = 32; limit <= 4096; limit *= 2)
    {
      const Outcome outcome = this->Build({ "in.ply", "-o", "m.kds", "--memory",
        std::to_string(limit) + "M", "--cell-vertices", cell, "--stats", "s.json" });
      EXPECT_LE(outcome.peakBytes, (limit + 64) << 20) << "limit " << limit << " MiB";
      if (outcome.exitCode != 0)
      {
        EXPECT_NE(outcome.err.find(" of memory"), std::string::npos) << outcome.err;
        ++refused;
        continue;
      }
      if (Json::parse(ReadWhole(this->Folder / "s.json"))["temp_bytes"] == 0)
      {
        EXPECT_LE(limit << 20, 12 * outcome.peakBytes)
          << "far more memory than needed was asked for";
        break;
      }
      ++inFiles;
    }
    EXPECT_GT(inFiles + refused, 0U);
  }
};

// Adds this number of floats for each point and for each triangle, in arrays of at most four
// components.
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
  EXPECT_EQ(outcome.err.rfind("kdstream-build: error: in.ply: ", 0), 0U) << outcome.err;
  EXPECT_NE(outcome.err.find("the limit is 1 MiB"), std::string::npos);
  EXPECT_EQ(this->Files(), (std::set<std::string>{ "in.ply" }));
}

// Two meshes of different needs; all others are tested below.
TEST_F(BuildMemory, StaysBelowTheMemoryLimit)
{
  this->ExpectBelowLimits(
    "soup", [] { return Soup(200000, 1); }, "1"); // gives the most nodes
  this->ExpectBelowLimits(
    "attributes", [] { return WithManyBytes(Torus(500, 300), 6, 3); }, "8");
}

TEST_F(BuildMemory, StaysBelowTheMemoryLimitWhateverTheMesh)
{
  const auto torus = [] { return Torus(1000, 600); };
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
  this->ExpectBelowLimits("torus", torus, "1");
  this->ExpectBelowLimits("torus", torus, "8");
  this->ExpectBelowLimits(
    "shuffled torus", [] { return Shuffled(Torus(1000, 600), 1); }, "8");
  this->ExpectBelowLimits("cloud", cloud, "8");
  this->ExpectBelowLimits(
    "soup", [] { return Soup(200000, 1); }, "8");
  this->ExpectBelowLimits(
    "wide attributes", [] { return WithManyBytes(Torus(150, 100), 500, 100); }, "8");
  this->ExpectBelowLimits("each face six times", dense, "8");
  this->ExpectBelowLimits("most vertices unused", unused, "8");
}

TEST_F(BuildMemory, OfAnStlWhatWeldingMayLeaveDecides)
{
  if (fixtures::sanitized)
  {
    GTEST_SKIP() << "a sanitizer's own memory would count";
  }
  const auto build = [&](std::uint64_t limit, std::uint64_t& temporaryBytes)
  {
    const Outcome outcome = this->Build(
      { "in.stl", "-o", "m.kds", "--memory", std::to_string(limit) + "M", "--stats", "s.json" });
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    EXPECT_LE(outcome.peakBytes, (limit + 64) << 20);
    const Json stats = Json::parse(ReadWhole(this->Folder / "s.json"));
    temporaryBytes = stats["temp_bytes"].get<std::uint64_t>();
    return stats["digest"].get<std::string>();
  };
  for (const bool welds : { true, false })
  {
    this->Write("in.stl", welds ? Torus(500, 300) : Soup(300000, 1));
    std::uint64_t little = 0, much = 0;
    EXPECT_EQ(build(80, little), build(1024, much));
    EXPECT_GT(little, 0U);
    EXPECT_EQ(much, 0U);
  }
}
