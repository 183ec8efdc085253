// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/mesh/MeshBlocks.h"

#include "filters/core/tree/PointRecord.h"
#include "filters/outofcore/mesh/BlockTuples.h"

namespace kdstream
{

Result<TreeBlock> MeshBlocks::Load(std::size_t block, BlockOrder order) const
{
  const CellRange range = this->RangeOf(block);
  Result<TreeBlock> loaded =
    this->floats ? LoadBlock<float>(this->records, range, *this->triangles, block, order)
                 : LoadBlock<double>(this->records, range, *this->triangles, block, order);
  if (loaded)
  {
    loaded->mesh.scalarType = this->scalarType;
    KDSTREAM_TRY(LoadBlockTuples(this->attributes, this->pointTuples, this->cellTuples, *loaded));
  }
  return loaded;
}

std::vector<VertexId> MeshBlocks::BlockBegins() const
{
  std::vector<VertexId> begins;
  for (std::size_t block = 0; block < this->BlockCount(); ++block)
  {
    begins.push_back(static_cast<VertexId>(this->RangeOf(block).begin));
  }
  begins.push_back(this->vertexCount);
  return begins;
}

KdTree TreeOfBlock(const MeshBlocks& mesh, const TreeBlock& block)
{
  const auto below = [&](unsigned depth)
  { return depth > mesh.blockDepth ? depth - mesh.blockDepth : 0; };
  KdTree tree;
  tree.depths = { below(mesh.depths.partition), below(mesh.depths.stitch),
    below(mesh.depths.finest) };
  tree.order = block.order;
  const std::size_t cells = std::size_t{ 1 } << tree.depths.finest;
  tree.cellBegin.reserve(cells + 1);
  for (std::size_t c = 0; c < cells; ++c)
  {
    const CellRange cell =
      RangeOfCell(mesh.vertexCount, mesh.depths.finest, block.cell * cells + c);
    tree.cellBegin.push_back(static_cast<VertexId>(cell.begin - block.firstRank));
  }
  tree.cellBegin.push_back(static_cast<VertexId>(block.order.size()));
  return tree;
}

}
