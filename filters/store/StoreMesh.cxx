// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/StoreMesh.h"

#include "filters/core/pieces/Glue.h"
#include "filters/store/UnusedList.h"

#include <map>
#include <utility>

namespace kdstream
{

namespace
{

// The pieces of a store that were read so far.
class LoadedPieces
{
public:
  LoadedPieces(const PieceSource& source, const Execution& execution)
    : From(source)
    , Runs(execution)
  {
  }

  Status Load(std::span<const PieceId> ids)
  {
    Result<std::vector<Piece>> read = this->From.ReadPieces(ids, this->Runs);
    KDSTREAM_TRY(read);
    for (Piece& piece : *read)
    {
      this->Pieces.emplace(piece.id, std::move(piece));
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
  Result<Surface> Draw(const Cut& cut)
  {
    KDSTREAM_TRY(this->Load(MissingPieces(cut, this->Lookup())));
    return DrawSurface(cut, this->Lookup(), this->Runs);
  }
  Result<Mesh> DrawMesh(const Cut& cut)
  {
    Result<Surface> surface = this->Draw(cut);
    KDSTREAM_TRY(surface);
    return Mesh{ std::move(surface->points), std::move(surface->triangles),
      this->From.Info().grid.scalarType, std::move(surface->attributes) };
  }

private:
  const PieceSource& From;
  const Execution& Runs;
  std::map<PieceId, Piece> Pieces;
};

}

Result<Mesh> DrawStoreMesh(const PieceSource& store, const Cut& cut, const Execution& execution)
{
  KDSTREAM_TRY(CheckCut(cut));
  return LoadedPieces(store, execution).DrawMesh(cut);
}

Result<Surface> DrawStoreSurface(
  const PieceSource& store, const Cut& cut, const Execution& execution)
{
  KDSTREAM_TRY(CheckCut(cut));
  return LoadedPieces(store, execution).Draw(cut);
}

Result<Mesh> DrawStorePieces(const PieceSource& store, Resolution base,
  std::span<const PieceId> wanted, const Execution& execution)
{
  Cut cut{ store.Info().depths, base };
  KDSTREAM_TRY(CheckCut(cut));
  LoadedPieces loaded(store, execution);
  KDSTREAM_TRY(loaded.Load(MissingPieces(cut, loaded.Lookup())));
  for (;;)
  {
    Closure closure = MakeClosure(cut.depths, base, wanted, loaded.Lookup());
    if (closure.missing.empty())
    {
      cut.active = std::move(closure.pieces);
      return loaded.DrawMesh(cut);
    }
    KDSTREAM_TRY(loaded.Load(closure.missing));
  }
}

Result<Mesh> GlueStoreMesh(
  const PieceSource& store, std::span<const std::uint32_t> partitions, const Execution& execution)
{
  std::vector<PieceId> ids;
  ids.reserve(partitions.size());
  for (const std::uint32_t p : partitions)
  {
    ids.push_back({ Resolution::Original(), NodeOfPartition(p, store.Info().depths) });
  }
  const Result<std::vector<Piece>> pieces = store.ReadPieces(ids, execution);
  KDSTREAM_TRY(pieces);
  return GluePartitions(*pieces, store.Info().grid.scalarType);
}

Status AddUnused(const Store& store, Mesh& mesh)
{
  const std::uint64_t parts = UnusedPartCount(store.Info());
  for (std::uint32_t part = 0; part < parts; ++part)
  {
    const Result<Piece> piece = store.ReadUnused(part);
    KDSTREAM_TRY(piece);
    if (mesh.points.size() + piece->positions.size() >= noVertex)
    {
      return Error{ ErrorCode::LimitExceeded, "has more vertices than 4294967294" };
    }
    mesh.points.insert(mesh.points.end(), piece->positions.begin(), piece->positions.end());
    for (Attribute& array : mesh.attributes)
    {
      if (array.association == AttributeAssociation::Point)
      {
        const Attribute& added = *FindAttribute(piece->attributes, array.Info());
        array.values.insert(array.values.end(), added.values.begin(), added.values.end());
      }
    }
  }
  return {};
}

}
