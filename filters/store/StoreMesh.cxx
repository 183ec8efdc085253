// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/StoreMesh.h"

#include "filters/core/pieces/Glue.h"

#include <map>

namespace kdstream
{

Result<Mesh> DrawStoreMesh(const Store& store, const Cut& cut)
{
  KDSTREAM_TRY(CheckCut(cut));
  std::map<PieceId, Piece> loaded;
  const PieceLookup lookup = [&](PieceId id) -> const Piece*
  {
    const auto found = loaded.find(id);
    return found == loaded.end() ? nullptr : &found->second;
  };
  // What a split needs is known only once the pieces that split are there.
  for (;;)
  {
    const std::vector<PieceId> missing = MissingPieces(cut, lookup);
    if (missing.empty())
    {
      break;
    }
    for (const PieceId id : missing)
    {
      Result<Piece> piece = store.ReadPiece(id);
      KDSTREAM_TRY(piece);
      loaded.emplace(id, std::move(*piece));
    }
  }
  Result<Surface> surface = DrawSurface(cut, lookup);
  KDSTREAM_TRY(surface);
  return Mesh{ std::move(surface->points), std::move(surface->triangles),
    store.Info().grid.scalarType, std::move(surface->attributes) };
}

Result<Mesh> GlueStoreMesh(const Store& store, std::span<const std::uint32_t> partitions)
{
  std::vector<Piece> pieces;
  pieces.reserve(partitions.size());
  for (const std::uint32_t p : partitions)
  {
    Result<Piece> piece =
      store.ReadPiece({ Resolution::Original(), NodeOfPartition(p, store.Info().depths) });
    KDSTREAM_TRY(piece);
    pieces.push_back(std::move(*piece));
  }
  return GluePartitions(pieces, store.Info().grid.scalarType);
}

}
