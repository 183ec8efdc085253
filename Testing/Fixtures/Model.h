// SPDX-License-Identifier: BSD-3-Clause
// A mesh taken through core, from points to pieces: what most tests of later steps start from.
#pragma once

#include "filters/core/drawing/Surface.h"
#include "filters/core/levels/Levels.h"
#include "filters/core/pieces/VertexTree.h"

#include <map>
#include <memory>

namespace kdstream::fixtures
{

// Keeps its parts in place: pieces and lookups refer to them.
struct Model
{
  Mesh mesh;
  KdTree tree;
  VertexTree vertexTree;
  std::map<PieceId, Piece> pieces;

  PieceLookup Lookup() const
  {
    return [this](PieceId id) -> const Piece*
    {
      const auto found = this->pieces.find(id);
      return found == this->pieces.end() ? nullptr : &found->second;
    };
  }
};

// onePiece: levels up to this are one piece each (TreeDepths); with a smaller value a small mesh
// has levels of many pieces coarser than S. REQUIRES: a mesh with vertices and valid options.
std::unique_ptr<Model> MakeModel(const Mesh& mesh, const KdTreeOptions& tree = {},
  const LevelOptions& levels = {}, const Execution& execution = {},
  unsigned onePiece = TreeDepths{}.onePiece);

// The cut of a resolution with some pieces in it that are shown whole (MakeClosure).
Cut CutShowing(const Model& model, Resolution base, const std::vector<PieceId>& wanted);

// For each (numbered) original vertex the node of the cut above it, found in the whole vertex tree,
// not in pieces.
std::vector<Surface::Source> CutOfVertices(const Model& model, const Cut& cut);

}
