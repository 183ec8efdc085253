// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/StoreMesh.h"

#include "filters/core/pieces/Glue.h"

#include <map>
#include <utility>

namespace kdstream
{

namespace
{

// Pieces of a store that have been read.
class LoadedPieces
{
public:
  explicit LoadedPieces(const Store& store)
    : From(store)
  {
  }

  Status Load(std::span<const PieceId> ids)
  {
    for (const PieceId id : ids)
    {
      Result<Piece> piece = this->From.ReadPiece(id);
      KDSTREAM_TRY(piece);
      this->Pieces.emplace(id, std::move(*piece));
    }
    return {};
  }
  PieceLookup Lookup() const
  {
    return [this](PieceId id) -> const Piece*
    {
      const auto found = this->Pieces.find(id);
      return found == this->Pieces.end() ? nullptr : &found->second;
    };
  }
  Result<Mesh> Draw(const Cut& cut)
  {
    KDSTREAM_TRY(this->Load(MissingPieces(cut, this->Lookup())));
    Result<Surface> surface = DrawSurface(cut, this->Lookup());
    KDSTREAM_TRY(surface);
    return Mesh{ std::move(surface->points), std::move(surface->triangles),
      this->From.Info().grid.scalarType, std::move(surface->attributes) };
  }

private:
  const Store& From;
  std::map<PieceId, Piece> Pieces;
};

}

Result<Mesh> DrawStoreMesh(const Store& store, const Cut& cut)
{
  KDSTREAM_TRY(CheckCut(cut));
  return LoadedPieces(store).Draw(cut);
}

Result<Mesh> DrawStorePieces(const Store& store, Resolution base, std::span<const PieceId> wanted)
{
  Cut cut{ store.Info().depths, base };
  KDSTREAM_TRY(CheckCut(cut));
  LoadedPieces loaded(store);
  KDSTREAM_TRY(loaded.Load(MissingPieces(cut, loaded.Lookup())));
  for (;;)
  {
    Closure closure = MakeClosure(cut.depths, base, wanted, loaded.Lookup());
    if (closure.missing.empty())
    {
      cut.active = std::move(closure.pieces);
      return loaded.Draw(cut);
    }
    KDSTREAM_TRY(loaded.Load(closure.missing));
  }
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
