// SPDX-License-Identifier: BSD-3-Clause
// What a store says about the bytes that it was built from: the same for all builds of these bytes.
#include "Testing/Fixtures/Meshes.h"
#include "filters/baselines/stores/Baselines.h"
#include "filters/build/InputDigest.h"
#include "filters/build/Testing/ExternalBuilderTest.h"
#include "filters/model/ModelJson.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>

using namespace kdstream;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

class InputDigests : public ExternalBuilderTest
{
protected:
  // The description in a store that was built in memory.
  ModelDescription Built(const BuildOptions& options)
  {
    const auto report = BuildStore(this->Input(), this->Store(), options);
    EXPECT_TRUE(report) << report.GetError().message;
    return (*kdstream::Store::Open(this->Store()))->Info();
  }
};

}

TEST_F(InputDigests, AreXxh3OfAllBytes)
{
  const auto abc = this->Temporary.Write("abc", "abc"), ab = this->Temporary.Write("ab", "ab"),
             c = this->Temporary.Write("c", "c");
  EXPECT_EQ(*InputDigest({ abc }).Take(), "06b05ab6733a618578af5f94892f3950"); // as of xxhsum -H2
  EXPECT_EQ(*InputDigest({ ab, c }).Take(), *InputDigest({ abc }).Take());
  EXPECT_NE(*InputDigest({ c, ab }).Take(), *InputDigest({ abc }).Take());
  // Several blocks.
  std::string text(5'000'000, 'x');
  std::set<std::string> digests;
  for (const std::size_t place : { 0u, 1u << 20, 4'999'999u })
  {
    text[place] = 'y';
    digests.insert(*InputDigest({ this->Temporary.Write("large", text) }).Take());
  }
  EXPECT_EQ(digests.size(), 3u);
  const auto missing = InputDigest({ abc, this->Folder / "none" }).Take();
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.GetError().code, ErrorCode::NotFound);
  EXPECT_EQ(missing.GetError().file, (this->Folder / "none").string());
}

TEST_F(InputDigests, AreTheSameWhateverTheOptions)
{
  this->Write(Shuffled(Torus(60, 40), 2));
  const std::string expected = *InputDigest({ this->Input() }).Take();
  std::set<std::string> digests;
  BuildOptions options;
  const auto check = [&](const BuildOptions& with)
  {
    const auto info = this->Built(with);
    EXPECT_EQ(info.inputDigest, expected);
    digests.insert(info.digest);
    EXPECT_EQ(WriteModel(info).find(expected), std::string::npos) << "servers do not tell it";
  };
  check(options);
  options.title = "another title";
  check(options);
  EXPECT_EQ(digests.size(), 1u);
  options.bits = 12;
  check(options);
  options.bits = 0;
  options.tree.verticesPerPartition = 300;
  check(options);
  options.partitioner = &OctreeMethod();
  check(options);
  EXPECT_EQ(digests.size(), 4u);
  this->Temporary.Write("other", "of another format");
  options.inputFiles = { this->Folder / "other" };
  EXPECT_EQ(this->Built(options).inputDigest, *InputDigest({ this->Folder / "other" }).Take());
}

TEST_F(InputDigests, AreTheSameOutOfCoreAndWhereABuildIsResumed)
{
  this->Write(Shuffled(Torus(96, 48), 2));
  const std::string expected = *InputDigest({ this->Input() }).Take();
  ASSERT_TRUE(this->External());
  EXPECT_EQ((*kdstream::Store::Open(this->Store()))->Info().inputDigest, expected);
  this->Take();
  std::vector<std::size_t> phases;
  (void)this->CountSteps(phases);
  this->Take();
  ASSERT_TRUE(this->BuildAndKill(phases.back() + 1));
  this->Options.resume = true;
  const auto report = this->External();
  ASSERT_TRUE(report) << report.GetError().message;
  EXPECT_GT(report->resumedPhases, 0u);
  EXPECT_EQ(report->info.inputDigest, expected);
}

// For a mesh that is not from a file, the digest covers the mesh, whatever the options of the
// build.
TEST_F(InputDigests, OfMeshesInMemory)
{
  const Mesh mesh = Torus(20, 10);
  const auto digestOf = [this](Mesh of, const BuildOptions& options)
  {
    const auto report = BuildStore(std::move(of), "mesh", this->Store(), options);
    EXPECT_TRUE(report) << report.GetError().message;
    return report->info.inputDigest;
  };
  BuildOptions options;
  const auto expected = digestOf(mesh, options);
  EXPECT_TRUE(IsDigest(expected));
  options.bits = 10;
  options.title = "another";
  EXPECT_EQ(digestOf(mesh, options), expected);
  std::set<std::string> digests{ expected };
  Mesh other = mesh;
  other.points[7][1] += 1e-12;
  digests.insert(digestOf(other, options));
  other = mesh;
  std::swap(other.triangles[3], other.triangles[4]);
  digests.insert(digestOf(other, options));
  other = mesh;
  Attribute kind;
  kind.name = "kind";
  kind.type = AttributeType::UInt8;
  kind.components = 1;
  kind.values.assign(mesh.points.size(), 5);
  other.attributes.push_back(kind);
  digests.insert(digestOf(other, options));
  other.attributes[0].values[0] = 6;
  digests.insert(digestOf(other, options));
  EXPECT_EQ(digests.size(), 5u);
}
