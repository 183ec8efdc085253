// SPDX-License-Identifier: BSD-3-Clause
// Attributes in the order of the tree, and of blocks, compared with the arrays of the mesh in
// memory.
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/outofcore/Testing/BlockTools.h"
#include "filters/outofcore/mesh/BlockTuples.h"
#include "filters/outofcore/mesh/RankTuples.h"

#include <algorithm>

using namespace kdstream;
using namespace kdstream::fixtures;
using namespace kdstream::testing;

namespace
{

void CheckTuples(const TreeBlock& block, const Mesh& mesh)
{
  ASSERT_EQ(block.mesh.attributes.size(), mesh.attributes.size());
  for (std::size_t a = 0; a < mesh.attributes.size(); ++a)
  {
    const Attribute &expected = mesh.attributes[a], &found = block.mesh.attributes[a];
    ASSERT_EQ(found.Info(), expected.Info());
    const std::vector<std::uint32_t>& elements =
      found.association == AttributeAssociation::Point ? block.ids : block.numbers;
    ASSERT_EQ(found.TupleCount(), elements.size()) << found.name;
    for (std::size_t i = 0; i < elements.size(); ++i)
    {
      const std::size_t size = found.TupleSize();
      const auto tuple = found.values.begin() + std::ptrdiff_t(i * size);
      ASSERT_TRUE(std::equal(tuple, tuple + std::ptrdiff_t(size),
        expected.values.begin() + std::ptrdiff_t(elements[i] * size)))
        << found.name << " of element " << elements[i];
    }
  }
}

// Enough for all ranks at once; for sections; for sections of a few vertices.
constexpr std::uint64_t memories[] = { 1U << 20, 20000U, 1000U };

void CheckAllBlocks(const NamedMesh& named)
{
  SCOPED_TRACE(named.name);
  SpilledTree<double> spilled(named.mesh, memories[0]);
  const VertexFiles& vertices = spilled.vertices;
  SpillFile tuples;
  for (std::size_t i = 0; vertices.tupleBytes > 0 && i < std::size(memories); ++i)
  {
    Result<SpillFile> sorted = SortTuplesByRank(
      spilled.folder, vertices.tuples, vertices.tupleBytes, spilled.ranks, memories[i]);
    ASSERT_TRUE(sorted) << sorted.GetError().message;
    EXPECT_EQ(sorted->Size(), vertices.tuples.Size());
    if (tuples.IsOpen())
    {
      EXPECT_EQ(ReadBack<std::byte>(*sorted), ReadBack<std::byte>(tuples)) << memories[i];
    }
    tuples = std::move(*sorted);
  }
  const unsigned partition = spilled.tree.depths.partition;
  for (const unsigned depth : { 0U, std::min(2U, partition), partition })
  {
    const auto cells = spilled.Cells(depth, memories[0]);
    for (std::size_t cell = 0; cell < cells.BucketCount(); ++cell)
    {
      Result<TreeBlock> block = spilled.Block(cells, depth, cell);
      ASSERT_TRUE(block);
      const Status status = LoadBlockTuples(spilled.attributes, tuples, spilled.cellTuples, *block);
      ASSERT_TRUE(status) << status.GetError().message;
      CheckTuples(*block, spilled.mesh);
    }
  }
}

// Only the arrays of one association.
Mesh Only(Mesh mesh, AttributeAssociation association)
{
  std::erase_if(mesh.attributes,
    [association](const Attribute& array) { return array.association != association; });
  return mesh;
}

}

TEST(BlockTuples, AsInMemory)
{
  for (const NamedMesh& named : AllMeshes())
  {
    CheckAllBlocks({ named.name, WithAttributes(named.mesh, 11) });
  }
}

TEST(BlockTuples, OfOneAssociationOrNone)
{
  const Mesh torus = Shuffled(WithAttributes(Torus(40, 20), 3), 5);
  CheckAllBlocks({ "points", Only(torus, AttributeAssociation::Point) });
  CheckAllBlocks({ "cells", Only(torus, AttributeAssociation::Cell) });
  CheckAllBlocks({ "none", Shuffled(Torus(40, 20), 5) });
}

// The tuples are of one byte, and most are far apart. Those near each other must be read in one go,
// together with the bytes between them; other bytes must not be read.
TEST(BlockTuples, ReadsWhatItNeeds)
{
  SpillFolder folder = MakeSpillFolder();
  std::vector<std::uint8_t> values(1 << 22);
  for (std::size_t i = 0; i < values.size(); ++i)
  {
    values[i] = static_cast<std::uint8_t>(i * 7 >> 3);
  }
  const SpillFile file = Spilled(folder, values);
  TreeBlock block;
  for (std::uint32_t i = 0; i < 1 << 21; i += 1 + i / 7)
  {
    block.ranks.push_back((1 << 22) - 1 - i);
  }
  const std::vector<AttributeInfo> one{ { "value", AttributeType::UInt8,
    AttributeAssociation::Point, 1 } };
  const std::uint64_t before = folder.Counts().bytesRead;
  ASSERT_TRUE(LoadBlockTuples(one, file, {}, block));
  const std::uint64_t read = folder.Counts().bytesRead - before;
  EXPECT_LT(read, 1U << 18);
  EXPECT_GT(read, 1U << 16) << "what is between those near each other, instead of one by one";
  for (std::size_t i = 0; i < block.ranks.size(); ++i)
  {
    ASSERT_EQ(block.mesh.attributes[0].values[i], values[block.ranks[i]]);
  }
  const SpillFile shorter = Spilled(folder, std::vector<std::uint8_t>(1000));
  const Status status = LoadBlockTuples(one, shorter, {}, block);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.GetError().code, ErrorCode::InputOutput);
}

TEST(SortTuplesByRank, StopsWhenAsked)
{
  SpilledTree<double> spilled(WithAttributes(Torus(40, 20), 3), 1 << 20);
  Execution execution;
  execution.progress = [](std::string_view, double fraction) { return fraction < 0.6; };
  for (const std::uint64_t memory : { 1U, 1U << 20 })
  {
    const auto sorted = SortTuplesByRank(spilled.folder, spilled.vertices.tuples,
      spilled.vertices.tupleBytes, spilled.ranks, memory, execution);
    ASSERT_FALSE(sorted);
    EXPECT_EQ(sorted.GetError().code, ErrorCode::Cancelled);
  }
}
