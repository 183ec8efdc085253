// SPDX-License-Identifier: BSD-3-Clause
// Takes a mesh through core, from points to pieces: most tests of later steps start from this.
#pragma once

#include "filters/core/drawing/Surface.h"
#include "filters/core/levels/Levels.h"
#include "filters/core/pieces/VertexTree.h"

#include <map>
#include <memory>

namespace kdstream::fixtures
{

// Its parts do not move, because pieces and lookups refer to them.
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

// onePiece: levels up to this depth have one piece each (TreeDepths). With a smaller value even a
// small mesh has levels of many pieces coarser than S. REQUIRES: the mesh has vertices, and the
// options are valid.
std::unique_ptr<Model> MakeModel(const Mesh& mesh, const KdTreeOptions& tree = {},
  const LevelOptions& levels = {}, const Execution& execution = {},
  unsigned onePiece = TreeDepths{}.onePiece);

// A cut of this resolution in which the wanted pieces are shown completely (MakeClosure).
Cut CutShowing(const Model& model, Resolution base, const std::vector<PieceId>& wanted);

// For each (numbered) original vertex, the node of the cut above it. It is found in the whole
// vertex tree, not in pieces.
std::vector<Surface::Source> CutOfVertices(const Model& model, const Cut& cut);

}
