// SPDX-License-Identifier: BSD-3-Clause
#include "server/tiles/TileKeeper.h"

#include "filters/codec/PieceCodec.h"
#include "filters/core/tree/PieceDepth.h"
#include "filters/tiles/TileTree.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

namespace kdstream
{

namespace
{

TilesOptions OptionsOfServedTiles()
{
  TilesOptions options;
  options.compression = HasMeshoptCompression() ? TileCompression::Meshopt : TileCompression::None;
  return options;
}

TileInput SourceOf(const ServedModel& model)
{
  TileInput source;
  source.readPiece = [&model, codec = model.Description().Codec()](PieceId id) -> Result<Piece>
  {
    const auto blob = BlobOfPiece(id, codec.depths);
    const auto bytes = model.ReadBlob(blob);
    KDSTREAM_TRY(bytes);
    auto piece = DecodePiece(**bytes, id, codec);
    if (!piece)
    {
      return Error{ ErrorCode::Damaged, BlobName(blob) + ": " + piece.GetError().message };
    }
    return piece;
  };
  source.readBlob = [&model](const protocol::BlobId& blob) -> Result<std::vector<std::uint8_t>>
  {
    const auto bytes = model.ReadBlob(blob);
    KDSTREAM_TRY(bytes);
    return **bytes;
  };
  return source;
}

// What neighbouring pieces need to know of a piece: which keys it owns, and the normals on its
// border.
struct PieceBorder
{
  VertexKey first = 0;
  std::uint64_t own = 0;
  std::vector<BorderNormal> normals;

  static BlobBytes BytesOf(const Piece& piece)
  {
    const auto normals = BorderNormalsOf(piece);
    const std::array<std::uint64_t, 2> head{ piece.ownVertices > 0 ? piece.keys[0] : 0,
      piece.ownVertices };
    std::vector<std::uint8_t> bytes(sizeof(head) + normals.size() * sizeof(BorderNormal));
    std::memcpy(bytes.data(), head.data(), sizeof(head));
    if (!normals.empty())
    {
      std::memcpy(
        bytes.data() + sizeof(head), normals.data(), normals.size() * sizeof(BorderNormal));
    }
    return std::make_shared<const std::vector<std::uint8_t>>(std::move(bytes));
  }
  // REQUIRES: BytesOf has written the bytes.
  static PieceBorder Of(const std::vector<std::uint8_t>& bytes)
  {
    PieceBorder border;
    std::memcpy(&border.first, bytes.data(), sizeof(border.first));
    std::memcpy(&border.own, bytes.data() + sizeof(border.first), sizeof(border.own));
    const std::size_t begin = sizeof(border.first) + sizeof(border.own);
    border.normals.resize((bytes.size() - begin) / sizeof(BorderNormal));
    if (!border.normals.empty())
    {
      std::memcpy(border.normals.data(), bytes.data() + begin, bytes.size() - begin);
    }
    return border;
  }
};

// Where a name's tile is among the tiles of a model: the step, and the index in the step.
struct TilePlace
{
  std::size_t step = 0, tile = 0;
};

// Nothing if the model has no such tile.
std::optional<TilePlace> PlaceOfTile(
  const std::vector<TileStepShape>& shapes, const protocol::TileName& tile)
{
  if (tile.isRoot)
  {
    return TilePlace{};
  }
  for (std::size_t s = 0; s < shapes.size(); ++s)
  {
    const TileStepShape& shape = shapes[s];
    const bool isWanted = tile.isOriginal
                            ? shape.resolution.IsOriginal() && shape.isGroup == tile.isTileset
                            : shape.resolution == Resolution::Level(tile.level);
    const std::uint64_t first = shape.isGroup ? shape.NodeOf(0) : 0; // groups are numbered by node
    if (isWanted && tile.number >= first && tile.number - first < shape.count &&
        (!tile.isTileset || (s > 0 && shape.begins)))
    {
      return TilePlace{ s, static_cast<std::size_t>(tile.number - first) };
    }
  }
  return std::nullopt;
}

}

Result<protocol::BlobId> PieceOfTile(const ModelDescription& model, const protocol::TileName& tile)
{
  if (!model.HasLevels())
  {
    return Error{ ErrorCode::NotFound, model.id + " has no levels, so it has no tileset" };
  }
  const TreeDepths& depths = model.depths;
  if (TileTree::CountTiles(model, ModelDetail::Regions) > TileKeeper::mostTiles ||
      std::uint64_t{ 1 } << depths.partition > TileKeeper::mostTiles)
  {
    return Error{ ErrorCode::Unsupported,
      model.id + " has too many pieces for a tileset on request: export one with kdstream-store" };
  }
  const auto shapes = TileTree::ShapesOf(model, ModelDetail::Regions);
  const auto place = PlaceOfTile(shapes, tile);
  if (!place)
  {
    return Error{ ErrorCode::NotFound, model.id + " has no tile " + NameOfTile(tile) };
  }
  const TileStepShape& shape = shapes[place->step];
  return shape.resolution.IsOriginal()
           ? protocol::BlobId::Partition(static_cast<std::uint32_t>(
               place->tile << (depths.partition - shape.depth))) // the first partition of a group
           : protocol::BlobId::LevelPiece(
               static_cast<std::uint8_t>(shape.resolution.Depth()), shape.NodeOf(place->tile));
}

// What is known about the tiles of one version of a model. Requests that use it keep it alive.
class TileKeeper::ModelTiles
{
public:
  ModelTiles(
    std::string version, std::shared_ptr<BlobCache> files, std::shared_ptr<BlobCache> borders)
    : Version(std::move(version))
    , Files(std::move(files))
    , Borders(std::move(borders))
    , Glbs(this->Files->AddModel())
    , OfPieces(this->Borders->AddModel())
  {
    for (auto& tilesets : this->Tilesets)
    {
      tilesets = this->Files->AddModel();
    }
  }
  ModelTiles(const ModelTiles&) = delete;
  ModelTiles& operator=(const ModelTiles&) = delete;
  ~ModelTiles()
  {
    this->Files->RemoveModel(this->Glbs);
    this->Borders->RemoveModel(this->OfPieces);
    for (const auto tilesets : this->Tilesets)
    {
      this->Files->RemoveModel(tilesets);
    }
  }

  const std::string Version;

  // The bytes that the trees take.
  std::size_t Bytes() const
  {
    const std::lock_guard lock(this->Mutex);
    std::size_t bytes = sizeof(*this);
    const auto add = [&bytes](const std::shared_ptr<const TileTree>& tree)
    {
      for (std::size_t s = 0; tree && s < tree->Steps().size(); ++s)
      {
        bytes += tree->Steps()[s].tiles.size() * sizeof(TileFacts);
      }
    };
    for (const auto& tree : this->Placed)
    {
      add(tree);
    }
    if (this->Erring != this->Placed[std::size_t(ModelDetail::Regions)])
    {
      add(this->Erring);
    }
    return bytes;
  }

  BlobBytes Find(const Wanted& wanted) const
  {
    return this->Files->Find(this->NumberOf(wanted), KeyOf(wanted.tile));
  }

  Result<BlobBytes> Get(const ServedModel& model, const Wanted& wanted)
  {
    return this->Files->Get(this->NumberOf(wanted), KeyOf(wanted.tile),
      [&]
      {
        return wanted.tile.isTileset ? this->MakeTileset(model, wanted)
                                     : this->MakeGlb(model, wanted.tile);
      });
  }

private:
  BlobCache::Model NumberOf(const Wanted& wanted) const
  {
    return wanted.tile.isTileset ? this->Tilesets[std::size_t(wanted.detail)] : this->Glbs;
  }
  // The file's key in the cache of files, which holds no blobs under these ids.
  static protocol::BlobId KeyOf(const protocol::TileName& tile)
  {
    return tile.isRoot       ? protocol::BlobId::TreePage(0)
           : tile.isOriginal ? protocol::BlobId::Partition(tile.number)
                             : protocol::BlobId::LevelPiece(tile.level, tile.number);
  }
  // REQUIRES: PieceOfTile has found the tile.
  static TilePlace PlaceOf(const ServedModel& model, const protocol::TileName& tile)
  {
    return *PlaceOfTile(TileTree::ShapesOf(model.Description(), ModelDetail::Regions), tile);
  }

  Result<BlobBytes> MakeTileset(const ServedModel& model, const Wanted& wanted)
  {
    const auto tree = this->PlacedTree(model, wanted.detail);
    KDSTREAM_TRY(tree);
    const auto [step, tile] = PlaceOf(model, wanted.tile);
    if (step >= (*tree)->Steps().size() || !(*tree)->Steps()[step].tiles[tile].stays)
    {
      return Error{ ErrorCode::NotFound, "there is nothing below this tile" };
    }
    return BytesOfText((*tree)->TilesetOf(
      step, tile, OptionsOfServedTiles(), wanted.tile.isRoot ? this->Version + "/" : "../"));
  }

  Result<BlobBytes> MakeGlb(const ServedModel& model, const protocol::TileName& tile)
  {
    const auto tree = this->ErringTree(model);
    KDSTREAM_TRY(tree);
    const auto [step, number] = PlaceOf(model, tile);
    TileInput source = SourceOf(model);
    const auto piece = source.readPiece((*tree)->Steps()[step].PieceOf(number));
    KDSTREAM_TRY(piece);
    source.readPiece = [&piece](PieceId) { return piece; }; // so it is read only once
    const TilesOptions options = OptionsOfServedTiles();
    std::vector<BorderNormal> borders;
    if ((*tree)->NeedsBorders(step, options))
    {
      auto found = this->BordersOf(model, (*tree)->Steps()[step], *piece);
      KDSTREAM_TRY(found);
      borders = std::move(*found);
    }
    const auto made = (*tree)->MakeTile(source, step, number, options, borders);
    KDSTREAM_TRY(made);
    if (made->bytes.empty())
    {
      return Error{ ErrorCode::NotFound, "the tile shows nothing" };
    }
    return BytesOfText(made->bytes);
  }

  // ---- trees: if two threads make the same tree at the same time, only time is wasted

  // The tree with the errors of all tiles.
  Result<std::shared_ptr<const TileTree>> ErringTree(const ServedModel& model)
  {
    {
      const std::lock_guard lock(this->Mutex);
      if (this->Erring)
      {
        return this->Erring;
      }
    }
    auto tree = std::make_shared<TileTree>(model.Description());
    KDSTREAM_TRY(tree->FindErrors(SourceOf(model)));
    const std::lock_guard lock(this->Mutex);
    this->Erring = std::move(tree);
    return this->Erring;
  }

  // The tree with the boxes, too, of all tiles that this detail includes.
  Result<std::shared_ptr<const TileTree>> PlacedTree(const ServedModel& model, ModelDetail detail)
  {
    auto& place = this->Placed[std::size_t(detail)];
    {
      const std::lock_guard lock(this->Mutex);
      if (place)
      {
        return place;
      }
    }
    auto tree = std::make_shared<TileTree>(model.Description(), detail);
    const TileInput source = SourceOf(model);
    KDSTREAM_TRY(tree->FindErrors(source));
    for (std::size_t s = tree->Steps().size(); s-- > 0;)
    {
      for (std::size_t t = 0; t < tree->Steps()[s].tiles.size(); ++t)
      {
        if (tree->Steps()[s].isGroup)
        {
          tree->Place(s, t, {});
          continue;
        }
        const auto piece = source.readPiece(tree->Steps()[s].PieceOf(t));
        KDSTREAM_TRY(piece);
        tree->Place(s, t, tree->ReachOf(*piece, s, t));
      }
    }
    const std::lock_guard lock(this->Mutex);
    place = std::move(tree);
    if (detail == ModelDetail::Regions)
    {
      this->Erring = place;
    }
    return place;
  }

  // ---- borders

  Result<BlobBytes> BorderBytes(const ServedModel& model, PieceId id)
  {
    return this->Borders->Get(this->OfPieces, BlobOfPiece(id, model.Description().depths),
      [&]() -> Result<BlobBytes>
      {
        const auto piece = SourceOf(model).readPiece(id);
        KDSTREAM_TRY(piece);
        return PieceBorder::BytesOf(*piece);
      });
  }
  Result<PieceBorder> BorderOf(const ServedModel& model, PieceId id)
  {
    const auto bytes = this->BorderBytes(model, id);
    KDSTREAM_TRY(bytes);
    return PieceBorder::Of(**bytes);
  }

  // The normals of a piece's ghosts, which come from the pieces that own these vertices.
  Result<std::vector<BorderNormal>> BordersOf(
    const ServedModel& model, const TileStep& step, const Piece& piece)
  {
    std::vector<BorderNormal> found;
    PieceBorder owner; // the owner of the previous ghosts
    std::optional<std::size_t> ownerTile;
    const TreeDepths& depths = model.Description().depths;
    const bool byPartition =
      step.resolution.IsOriginal() || step.resolution.Depth() >= depths.stitch;
    for (std::size_t v = piece.ownVertices; v < piece.keys.size(); ++v)
    {
      const VertexKey key = piece.keys[v];
      std::optional<std::size_t> tile;
      if (byPartition)
      {
        tile = PieceOfPartition(step.resolution, PartitionOfKey(key), depths).node -
               (NodeId{ 1 } << step.depth);
      }
      else if (ownerTile && key >= owner.first && key - owner.first < owner.own)
      {
        tile = ownerTile;
      }
      else
      {
        const auto searched = this->OwnerOf(model, step, key);
        KDSTREAM_TRY(searched);
        tile = *searched;
      }
      if (*tile >= step.tiles.size())
      {
        continue; // the piece is damaged: no tile owns this key
      }
      if (tile != ownerTile)
      {
        auto border = this->BorderOf(model, step.PieceOf(*tile));
        KDSTREAM_TRY(border);
        owner = std::move(*border);
        ownerTile = tile;
      }
      const auto normal = std::lower_bound(owner.normals.begin(), owner.normals.end(), key,
        [](const BorderNormal& border, VertexKey of) { return border.key < of; });
      if (normal != owner.normals.end() && normal->key == key)
      {
        found.push_back(*normal);
      }
    }
    return found;
  }

  // The piece that owns a rank. Ranks ascend from piece to piece, so it is the last piece that
  // begins at the rank or before it.
  Result<std::size_t> OwnerOf(const ServedModel& model, const TileStep& step, VertexKey key)
  {
    std::size_t low = 0, high = step.tiles.size();
    while (high - low > 1)
    {
      const std::size_t middle = low + (high - low) / 2;
      bool isBefore = false; // whether the next piece that owns a vertex begins before it
      std::size_t probe = middle;
      for (bool isFound = false; !isFound && probe < high; probe += isFound ? 0 : 1)
      {
        const auto border = this->BorderOf(model, step.PieceOf(probe));
        KDSTREAM_TRY(border);
        isFound = border->own > 0;
        isBefore = isFound && border->first <= key;
      }
      (isBefore ? low : high) = isBefore ? probe : middle;
    }
    return low;
  }

  const std::shared_ptr<BlobCache> Files, Borders;
  const BlobCache::Model Glbs, OfPieces;
  std::array<BlobCache::Model, 3> Tilesets{};            // by ModelDetail
  mutable std::mutex Mutex;                              // for what follows
  std::shared_ptr<const TileTree> Erring;                // the tree with errors; null at first
  std::array<std::shared_ptr<const TileTree>, 3> Placed; // by ModelDetail: trees with boxes, too
};

TileKeeper::TileKeeper()
  : Files(std::make_shared<BlobCache>(keptBytes))
  , Borders(std::make_shared<BlobCache>(borderBytes))
{
}

TileKeeper::~TileKeeper() = default;

BlobBytes TileKeeper::Find(const Wanted& wanted) const
{
  const auto tiles = this->Of(wanted.version, false);
  return tiles ? tiles->Find(wanted) : nullptr;
}

Result<BlobBytes> TileKeeper::Get(const ServedModel& model, const Wanted& wanted) const
{
  const auto tiles = this->Of(wanted.version, true);
  auto bytes = tiles->Get(model, wanted);
  this->Trim(tiles);
  return bytes;
}

std::shared_ptr<TileKeeper::ModelTiles> TileKeeper::Of(
  const std::string& version, bool isMade) const
{
  const std::lock_guard lock(this->Mutex);
  const auto found = std::find_if(this->Recent.begin(), this->Recent.end(),
    [&](const auto& each) { return each->Version == version; });
  if (found != this->Recent.end())
  {
    this->Recent.splice(this->Recent.begin(), this->Recent, found);
    return this->Recent.front();
  }
  if (isMade)
  {
    this->Recent.push_front(std::make_shared<ModelTiles>(version, this->Files, this->Borders));
    return this->Recent.front();
  }
  return nullptr;
}

// While all trees together take too much memory, forgets models: the least recently requested
// first, but never `last`.
void TileKeeper::Trim(const std::shared_ptr<ModelTiles>& last) const
{
  std::list<std::shared_ptr<ModelTiles>> gone; // destroyed after the mutex is released
  const std::lock_guard lock(this->Mutex);
  std::size_t bytes = 0;
  for (auto each = this->Recent.begin(); each != this->Recent.end();)
  {
    const auto next = std::next(each);
    bytes += (*each)->Bytes();
    if (bytes > treeBytes && *each != last)
    {
      bytes -= (*each)->Bytes();
      gone.splice(gone.end(), this->Recent, each);
    }
    each = next;
  }
}

}
