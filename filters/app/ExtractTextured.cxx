// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. Piece by piece: add vertices, triangles, and their materials; turn a lossy tile into a
//    picture.
// 2. For each picture of a lossless input: collect its texels from all tiles that have some.
#include "filters/app/ExtractTextured.h"

#include "filters/app/TilePictures.h"
#include "filters/codec/TextureTile.h"
#include "filters/texture/Picture.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <tuple>
#include <unordered_map>

namespace kdstream
{
namespace
{

using Rgba = std::array<std::uint8_t, 4>;

struct TiledPiece
{
  Piece piece;
  TextureTile tile;
};

class TexturedExtraction
{
public:
  TexturedExtraction(
    const Store& store, const std::vector<PieceId>& pieces, const Execution& execution)
    : Source(store)
    , Pieces(pieces)
    , Exec(execution)
  {
    Mesh& mesh = this->Out.mesh;
    mesh.scalarType = store.Info().grid.scalarType;
    const bool areLevels = !pieces.empty() && !pieces.front().resolution.IsOriginal();
    const std::vector<AttributeInfo>& all = store.Info().attributes;
    for (const AttributeInfo& attribute : areLevels ? ArraysOfLevels(all) : all)
    {
      if ((!areLevels || !IsScalar(attribute) || store.Info().scalars.Find(attribute.name)) &&
          attribute.association == AttributeAssociation::Point &&
          RoleOf(attribute) != AttributeRole::Colors)
      {
        mesh.attributes.push_back({ attribute, {} });
      }
    }
  }

  Result<TexturedMesh> Extract()
  {
    for (std::size_t i = 0; i < this->Pieces.size(); ++i)
    {
      KDSTREAM_TRY(this->Exec.Report("pieces", double(i) / double(this->Pieces.size())));
      const Result<TiledPiece> read = this->Read(this->Pieces[i]);
      KDSTREAM_TRY(read);
      KDSTREAM_TRY(this->Add(*read));
    }
    for (const auto& [number, used] : this->Sources)
    {
      KDSTREAM_TRY(this->Restore(number, used));
    }
    return std::move(this->Out);
  }

private:
  // A picture of the input, parts of which are in tiles.
  struct SourcePicture
  {
    std::uint32_t width = 1, height = 1;
    std::uint32_t picture = 0;            // index in Out
    std::vector<PieceId> pieces;          // the pieces that have a part of this picture
    std::vector<std::uint32_t> materials; // indices in Out
  };

  protocol::BlobId TextureOf(PieceId piece) const
  {
    return TextureOfPiece(piece, this->Source.Info().depths);
  }

  Result<TiledPiece> Read(PieceId id) const
  {
    Result<Piece> piece = this->Source.ReadPiece(id);
    KDSTREAM_TRY(piece);
    const auto blob = this->Source.Read(this->TextureOf(id));
    KDSTREAM_TRY(blob);
    Result<TextureTile> tile = DecodeTextureTile(*blob, piece->triangles, piece->positions);
    if (!tile)
    {
      return Error{ ErrorCode::Damaged,
        BlobName(this->TextureOf(id)) + ": " + tile.GetError().message };
    }
    return TiledPiece{ std::move(*piece), std::move(*tile) };
  }

  Status Add(const TiledPiece& part)
  {
    const ExactTile& exact = part.tile.exact;
    const bool restored = part.tile.isExact && exact.halvings == 0;
    const bool patches = std::any_of(exact.charts.begin(), exact.charts.end(),
      [](const TileChart& chart) { return chart.source == noTileSource; });
    std::optional<Picture> picture;
    if (!restored || patches)
    {
      Result<Picture> decoded = DecodeTileImage(this->TextureOf(part.piece.id), part.tile);
      KDSTREAM_TRY(decoded);
      picture = std::move(*decoded);
    }
    const std::vector<VertexId> vertices = this->AddVertices(part.piece);
    const std::uint32_t own = restored ? 0 : this->AddTileMaterial(part.piece.id, *picture);
    const std::vector<std::uint32_t> ofSources =
      restored ? this->AddSources(part.piece.id, exact) : std::vector<std::uint32_t>();
    for (std::size_t t = 0; t < part.piece.triangles.size(); ++t)
    {
      const Triangle& triangle = part.piece.triangles[t];
      if (!this->Counts(part.piece, triangle))
      {
        continue;
      }
      this->Out.mesh.triangles.push_back(
        { vertices[triangle[0]], vertices[triangle[1]], vertices[triangle[2]] });
      if (!restored)
      {
        this->Out.materialOf.push_back(own);
        this->Out.corners.push_back(CornersInTile(part.tile, t));
        continue;
      }
      const TileChart& chart = exact.charts[exact.chartOf[t]];
      this->Out.materialOf.push_back(
        chart.source == noTileSource
          ? this->MaterialOfColor(TexelAt(*picture,
              std::min<std::int64_t>(std::int64_t(part.tile.corners[t][0][0]), part.tile.width - 1),
              std::min<std::int64_t>(
                std::int64_t(part.tile.corners[t][0][1]), part.tile.height - 1)))
          : ofSources[chart.source]);
      this->Out.corners.push_back(exact.corners[t]);
    }
    return {};
  }

  // Whether a triangle is taken from this piece. A triangle is in the pieces of all its corners. In
  // the original it is taken from the first of the extracted pieces; in a level, from the owner of
  // the lowest key.
  bool Counts(const Piece& piece, const Triangle& triangle) const
  {
    if (!piece.id.resolution.IsOriginal())
    {
      return piece.Owns(triangle);
    }
    NodeId first = piece.id.node;
    for (const VertexId v : triangle)
    {
      const PieceId other = PieceOfPartition(
        Resolution::Original(), PartitionOfKey(piece.keys[v]), this->Source.Info().depths);
      if (other.node < first && std::binary_search(this->Pieces.begin(), this->Pieces.end(), other))
      {
        first = other.node;
      }
    }
    return first == piece.id.node;
  }

  // Adds the vertices of the piece; returns their numbers in the mesh.
  std::vector<VertexId> AddVertices(const Piece& piece)
  {
    Mesh& mesh = this->Out.mesh;
    std::vector<VertexId> numbers;
    for (std::size_t v = 0; v < piece.positions.size(); ++v)
    {
      const auto next = static_cast<VertexId>(mesh.points.size());
      const auto [entry, isNew] = this->VertexOfKey.try_emplace(piece.keys[v], next);
      numbers.push_back(entry->second);
      if (!isNew)
      {
        continue;
      }
      mesh.points.push_back(piece.positions[v]);
      for (Attribute& array : mesh.attributes)
      {
        array.Append(*FindAttribute(piece.attributes, array.Info()), v);
      }
    }
    return numbers;
  }

  static std::array<PictureCoordinate, 3> CornersInTile(const TextureTile& tile, std::size_t t)
  {
    std::array<PictureCoordinate, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      const TileCoordinate& place = tile.corners[t][k];
      corners[k] = { place[0] / float(tile.width), place[1] / float(tile.height) };
    }
    return corners;
  }

  std::uint32_t AddMaterial(TexturedMaterial material)
  {
    this->Out.materials.push_back(std::move(material));
    return static_cast<std::uint32_t>(this->Out.materials.size() - 1);
  }

  std::uint32_t AddTileMaterial(PieceId piece, const Picture& picture)
  {
    const protocol::BlobId blob = this->TextureOf(piece);
    TexturedMaterial material;
    material.name =
      piece.resolution.IsOriginal() ? "partition-" : "level-" + std::to_string(blob.level) + "-";
    material.name += std::to_string(blob.number);
    material.picture = static_cast<std::uint32_t>(this->Out.pictures.size());
    material.wrapU = material.wrapV = TextureWrap::Clamp;
    material.opaque = !HasAlpha(picture);
    PictureSource source;
    source.name = material.name;
    source.bytes = PngOf(picture);
    this->Out.pictures.push_back(std::move(source));
    return this->AddMaterial(std::move(material));
  }

  std::uint32_t MaterialOfColor(const Rgba& color)
  {
    const auto [entry, isNew] = this->MaterialOf.try_emplace(color, 0);
    if (isNew)
    {
      TexturedMaterial material;
      material.name = "colour-" + std::to_string(this->MaterialOf.size() - 1);
      for (std::size_t k = 0; k < 3; ++k)
      {
        material.color[k] = LinearOfBytes()[color[k]];
      }
      material.color[3] = color[3] / 255.0;
      material.opaque = color[3] == 255;
      material.transform = upsideDown; // so an OBJ gets the coordinates unchanged
      entry->second = this->AddMaterial(std::move(material));
    }
    return entry->second;
  }

  // Returns the material of each source of a tile.
  std::vector<std::uint32_t> AddSources(PieceId piece, const ExactTile& exact)
  {
    std::vector<std::uint32_t> materials;
    for (const TileSource& source : exact.sources)
    {
      const auto known = std::find_if(this->KnownSources.begin(), this->KnownSources.end(),
        [&](const auto& entry) { return entry.first == source; });
      const std::uint32_t material =
        known != this->KnownSources.end() ? known->second : this->AddSource(source);
      materials.push_back(material);
      std::vector<PieceId>& pieces = this->Sources[source.picture].pieces;
      if (pieces.empty() || pieces.back() != piece)
      {
        pieces.push_back(piece);
      }
    }
    return materials;
  }

  std::uint32_t AddSource(const TileSource& source)
  {
    SourcePicture& picture = this->Sources[source.picture];
    if (picture.materials.empty())
    {
      picture.width = source.width;
      picture.height = source.height;
      picture.picture = static_cast<std::uint32_t>(this->Out.pictures.size());
      PictureSource& bytes = this->Out.pictures.emplace_back();
      bytes.name = "picture-" + std::to_string(source.picture);
    }
    TexturedMaterial material;
    material.name = "material-" + std::to_string(this->KnownSources.size());
    material.picture = picture.picture;
    material.transform = { source.u, source.v };
    material.wrapU = static_cast<TextureWrap>(source.wrap[0]);
    material.wrapV = static_cast<TextureWrap>(source.wrap[1]);
    const std::uint32_t number = this->AddMaterial(std::move(material));
    picture.materials.push_back(number);
    this->KnownSources.emplace_back(source, number);
    return number;
  }

  // ---- pictures of the input

  Status Restore(std::uint32_t number, const SourcePicture& used)
  {
    KDSTREAM_TRY(CheckPictureSize(used.width, used.height, mostPicturePixels));
    Picture canvas = GreyPicture(used.width, used.height);
    for (const PieceId piece : used.pieces)
    {
      KDSTREAM_TRY(this->Exec.Report("textures", 0));
      const Result<TiledPiece> part = this->Read(piece);
      KDSTREAM_TRY(part);
      const Result<Picture> picture = DecodeTileImage(this->TextureOf(piece), part->tile);
      KDSTREAM_TRY(picture);
      PasteTile(number, part->tile, *picture, canvas);
    }
    const bool alpha = HasAlpha(canvas);
    for (const std::uint32_t material : used.materials)
    {
      this->Out.materials[material].opaque = !alpha;
    }
    this->Out.pictures[used.picture].bytes = PngOf(std::move(canvas));
    return {};
  }

  const Store& Source;
  const std::vector<PieceId>& Pieces;
  const Execution& Exec;
  TexturedMesh Out;
  std::unordered_map<VertexKey, VertexId> VertexOfKey;
  std::map<Rgba, std::uint32_t> MaterialOf; // by colour
  std::vector<std::pair<TileSource, std::uint32_t>> KnownSources;
  std::map<std::uint32_t, SourcePicture> Sources; // by the picture's number in the input
};

}

Result<TexturedMesh> ExtractTextured(
  const Store& store, const std::vector<PieceId>& pieces, const Execution& execution)
{
  return TexturedExtraction(store, pieces, execution).Extract();
}

}
