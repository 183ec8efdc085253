// SPDX-License-Identifier: BSD-3-Clause
#include "filters/tiles/TileTree.h"

#include "filters/codec/TextureTile.h"
#include "filters/codec/TreePage.h"
#include "filters/core/VectorMath.h"
#include "filters/core/tree/PieceDepth.h"
#include "filters/model/JsonWriter.h"
#include "filters/model/Units.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace kdstream
{
namespace
{

// A tileset's file describes this many resolutions; the first one's up to twice as many less one.
constexpr std::size_t stepsOfTileset = 4;

// How far light and colours of a piece may be wrong, since they are interpolated between its
// vertices: of clouds and coloured surfaces all of the distance between these. Textures of levels
// show colours between vertices.
double TilePartOfSpacing(const ModelDescription& model)
{
  const bool colored = std::any_of(model.attributes.begin(), model.attributes.end(),
    [](const AttributeInfo& array) { return RoleOf(array) == AttributeRole::Colors; });
  const bool texturedOriginal = model.textures && !model.textures->levels;
  return colored || texturedOriginal || model.primitive == PrimitiveType::Points ? 1 : 1.0 / 3;
}

// With the places that vertices may be rounded to: skirts hang beside the lattice.
Box BoundsOfTile(const std::vector<Vec3>& points, double latticeStep)
{
  Box box;
  std::for_each(points.begin(), points.end(), [&](const Vec3& point) { box.Add(point); });
  const Vec3 sides = Minus(box.hi, box.lo);
  const double most =
    std::max(*std::max_element(sides.begin(), sides.end()) * mostTileRounding, latticeStep / 2);
  const Box inner = box;
  box.Add(Minus(inner.lo, { most, most, most }));
  box.Add(Plus(inner.hi, { most, most, most }));
  return box;
}

// The resolutions of a model's tiles, and how many each has, coarse to fine.
std::vector<std::pair<Resolution, std::uint64_t>> ResolutionsOfTiles(
  const ModelDescription& model, ModelDetail detail)
{
  std::vector<std::pair<Resolution, std::uint64_t>> all;
  const unsigned first = PreviewLevel(model.depths);
  const std::size_t end = detail == ModelDetail::Preview ? first + 1 : model.levels.size();
  for (unsigned level = first; level < end; ++level)
  {
    const Resolution resolution = Resolution::Level(level);
    all.emplace_back(resolution, std::uint64_t{ 1 } << PieceDepth(resolution, model.depths));
  }
  if (detail == ModelDetail::Regions)
  {
    all.emplace_back(Resolution::Original(), model.partitions);
  }
  return all;
}

}

TileTree::TileTree(const ModelDescription& model, ModelDetail detail)
  : Info(model)
{
  for (std::size_t k = 0; k < 3; ++k)
  {
    this->Frame.origin[k] =
      this->Info.box.lo[k] + (this->Info.box.hi[k] - this->Info.box.lo[k]) / 2;
  }
  // Contents of tiles have y up; clients turn them so that y becomes z.
  this->Frame.axes = { Vec3{ 1, 0, 0 }, Vec3{ 0, 0, 1 }, Vec3{ 0, -1, 0 } };
  this->Frame.scale = MetresOfUnit(this->Info.unit).value_or(1);
  this->Frame.copyright = this->Info.credit;
  for (const auto& [resolution, tiles] : ResolutionsOfTiles(model, detail))
  {
    TileStep step{ resolution, PieceDepth(resolution, model.depths),
      resolution.IsOriginal() ? "original" : std::to_string(resolution.Depth()), {} };
    step.tiles.resize(tiles);
    this->All.push_back(std::move(step));
  }
}

std::uint64_t TileTree::CountTiles(const ModelDescription& model, ModelDetail detail)
{
  std::uint64_t count = 0;
  for (const auto& [resolution, tiles] : ResolutionsOfTiles(model, detail))
  {
    count += tiles;
  }
  return count;
}

// The tiles of the next step that are below one: first and last but one, by number.
std::pair<std::size_t, std::size_t> TileTree::ChildrenOf(std::size_t step, std::size_t tile) const
{
  if (step + 1 == this->All.size())
  {
    return { 0, 0 };
  }
  const unsigned below = this->All[step + 1].depth - this->All[step].depth;
  const std::size_t all = this->All[step + 1].tiles.size();
  return { std::min(tile << below, all), std::min((tile + 1) << below, all) };
}

// Calls visit(piece, its facts, its node's box) for the pieces of all pages.
template <class Visit>
Status TileTree::VisitFacts(const TileInput& source, const Visit& visit) const
{
  std::map<NodeId, Box> around{ { 1, this->Info.box } };
  for (const NodeId page : TreePages(this->Info.depths))
  {
    const auto blob = source.readBlob(protocol::BlobId::TreePage(page));
    KDSTREAM_TRY(blob);
    const auto facts = DecodeTreePage(*blob, page, around[page], this->Info.depths, true);
    if (!facts)
    {
      return Error{ ErrorCode::Damaged,
        BlobName(protocol::BlobId::TreePage(page)) + ": " + facts.GetError().message };
    }
    const auto boxOf = [&](NodeId node) -> const Box&
    { return node == page ? around[page] : facts->BoxOf(node); };
    const std::vector<PieceId> pieces = PiecesOfTreePage(page, this->Info.depths, true);
    for (std::size_t i = 0; i < pieces.size(); ++i)
    {
      visit(pieces[i], facts->facts[i], boxOf(pieces[i].node));
    }
    const unsigned below = DepthsOfTreePage(page, this->Info.depths);
    for (NodeId node = page << below; below > 0 && node < (page + 1) << below; ++node)
    {
      if (IsTreePage(node, this->Info.depths))
      {
        around[node] = facts->BoxOf(node);
      }
    }
  }
  return {};
}

Status TileTree::FindErrors(const TileInput& source)
{
  const double part = TilePartOfSpacing(this->Info);
  const unsigned first = PreviewLevel(this->Info.depths);
  KDSTREAM_TRY(this->VisitFacts(source,
    [&](PieceId piece, const PieceFacts& facts, const Box& box)
    {
      if (piece.resolution.IsOriginal() || piece.resolution.Depth() < first ||
          piece.resolution.Depth() - first >= this->All.size())
      {
        return;
      }
      TileStep& step = this->All[piece.resolution.Depth() - first];
      const Vec3 s = box.Empty() ? Vec3{} : Minus(box.hi, box.lo);
      const double area = s[0] * s[1] + s[1] * s[2] + s[2] * s[0];
      const auto vertices =
        double(this->Info.levels[piece.resolution.Depth()].vertices) / double(step.tiles.size());
      step.tiles[piece.node - (NodeId{ 1 } << step.depth)].error =
        std::max(double(facts.most), part * std::sqrt(area / std::max(vertices, 1.0)));
    }));
  for (std::size_t s = this->All.size() - 1; s-- > 0;)
  {
    for (std::size_t t = 0; t < this->All[s].tiles.size(); ++t)
    {
      double& error = this->All[s].tiles[t].error;
      const auto [begin, end] = this->ChildrenOf(s, t);
      for (std::size_t child = begin; child < end; ++child)
      {
        error = std::max(error, this->All[s + 1].tiles[child].error);
      }
    }
  }
  return {};
}

TileFrame TileTree::FrameOf(const TileStep& step) const
{
  TileFrame frame = this->Frame;
  if (!this->Info.grid.Lossless())
  {
    const bool isLevel = !step.resolution.IsOriginal();
    frame.latticeStep =
      this->Info.grid.step * (isLevel ? this->Info.levels[step.resolution.Depth()].spacing : 1);
    frame.latticeOrigin = this->Info.grid.origin;
  }
  return frame;
}

// As deep as the tile is wrong that stands here where its children are not loaded: a neighbour is
// mostly of this level, or of the one above.
double TileTree::SkirtDepth(std::size_t s, std::size_t t) const
{
  const unsigned below = s == 0 ? 0 : this->All[s].depth - this->All[s - 1].depth;
  return s == 0 ? 0 : this->All[s - 1].tiles[t >> below].error;
}

Result<EncodedTile> TileTree::MakeTile(const TileInput& source, std::size_t s, std::size_t t,
  const TilesOptions& options, std::span<const BorderNormal> borders) const
{
  const TileStep& step = this->All[s];
  const Result<Piece> piece = source.readPiece(step.PieceOf(t));
  KDSTREAM_TRY(piece);
  std::optional<TextureTile> texture;
  if (this->Info.textures && (step.resolution.IsOriginal() || this->Info.textures->levels))
  {
    const protocol::BlobId id = TextureOfPiece(piece->id, this->Info.depths);
    const auto blob = source.readBlob(id);
    KDSTREAM_TRY(blob);
    auto decoded = DecodeTextureTile(*blob, piece->triangles);
    if (!decoded)
    {
      return Error{ ErrorCode::Damaged, BlobName(id) + ": " + decoded.GetError().message };
    }
    texture = std::move(*decoded);
  }
  const TileMesh mesh = CutTileMesh(
    *piece, texture ? &*texture : nullptr, { options.normals, this->SkirtDepth(s, t), borders });
  EncodedTile made;
  if (!mesh.Empty())
  {
    const TileFrame frame = this->FrameOf(step);
    auto bytes = EncodeTileGlb(mesh, frame, options.compression);
    KDSTREAM_TRY(bytes);
    made.bytes = std::move(*bytes);
    made.box = BoundsOfTile(mesh.points, frame.latticeStep);
  }
  return made;
}

Box TileTree::ReachOf(const Piece& piece, std::size_t s, std::size_t t) const
{
  const bool isCloud = piece.primitive == PrimitiveType::Points;
  if (isCloud ? piece.ownVertices == 0 : !ShowsTriangles(piece))
  {
    return {};
  }
  std::vector<Vec3> reached(piece.positions.begin(),
    isCloud ? piece.positions.begin() + std::ptrdiff_t(piece.ownVertices) : piece.positions.end());
  // Skirts hang below ghosts, whichever way that is.
  const double depth = this->SkirtDepth(s, t);
  for (std::size_t v = piece.ownVertices; !isCloud && v < piece.positions.size(); ++v)
  {
    reached.push_back(Minus(piece.positions[v], { depth, depth, depth }));
    reached.push_back(Plus(piece.positions[v], { depth, depth, depth }));
  }
  return BoundsOfTile(reached, this->FrameOf(this->All[s]).latticeStep);
}

void TileTree::Place(std::size_t s, std::size_t t, const Box& box)
{
  TileFacts& tile = this->All[s].tiles[t];
  tile.box = box;
  tile.shows = !box.Empty();
  tile.stays = tile.shows;
  const auto [begin, end] = this->ChildrenOf(s, t);
  for (std::size_t child = begin; child < end; ++child)
  {
    const TileFacts& below = this->All[s + 1].tiles[child];
    tile.box.Add(below.box);
    tile.stays = tile.stays || below.stays;
  }
}

bool TileTree::NeedsBorders(std::size_t s, const TilesOptions& options) const
{
  const TileStep& step = this->All[s];
  return options.normals && step.tiles.size() > 1 &&
         this->Info.primitive == PrimitiveType::Triangles &&
         std::none_of(this->Info.attributes.begin(), this->Info.attributes.end(),
           [](const AttributeInfo& array) { return RoleOf(array) == AttributeRole::Normals; });
}

bool TileTree::BeginsTileset(const ModelDescription& model, std::size_t s)
{
  const std::size_t steps = ResolutionsOfTiles(model, ModelDetail::Regions).size();
  return s == 0 || ((steps - s) % stepsOfTileset == 0 && s >= stepsOfTileset);
}

std::string TileTree::TilesetOf(
  std::size_t s, std::size_t t, const TilesOptions& options, const std::string& up) const
{
  JsonWriter json;
  json.BeginObject().Key("asset").BeginObject().Member("version", "1.1");
  json.Member("tilesetVersion", this->Info.digest);
  if (s == 0)
  {
    json.Key("extras").BeginObject().Member("generator", "KdStream");
    for (const auto& [name, text] : { std::pair{ "title", &this->Info.title },
           { "credit", &this->Info.credit }, { "license", &this->Info.license } })
    {
      if (!text->empty())
      {
        json.Member(name, *text);
      }
    }
    json.EndObject();
  }
  json.EndObject();
  const TileFacts& root = this->All[s].tiles[t];
  json.Member("geometricError", s == 0 ? this->Diagonal() : this->ErrorOf(root));
  json.Key("root");
  this->PutTile(json, s, t, s, options, up);
  json.EndObject();
  return json.Text();
}

// Of the whole, in metres: what is wrong where nothing is shown, at least what the root tells.
double TileTree::Diagonal() const
{
  const TileFacts& root = this->All[0].tiles[0];
  return std::max(Length(Minus(root.box.hi, root.box.lo)) * this->Frame.scale, this->ErrorOf(root));
}

// root: the step of the tileset's root. up: from the tileset's folder to that of all.
void TileTree::PutTile(JsonWriter& json, std::size_t s, std::size_t t, std::size_t root,
  const TilesOptions& options, const std::string& up) const
{
  const TileFacts& tile = this->All[s].tiles[t];
  const bool isElsewhere = s > root && this->BeginsTileset(s);
  json.BeginObject();
  this->PutBox(json, tile.box);
  json.Member("geometricError", this->ErrorOf(tile));
  if (s == root)
  {
    json.Member("refine", "REPLACE");
  }
  if (s == 0)
  {
    this->PutTransform(json, options);
  }
  if (isElsewhere || tile.shows)
  {
    json.Key("content").BeginObject();
    json.Member("uri", up + FileOf(this->All[s], t, isElsewhere ? ".json" : ".glb"));
    json.EndObject();
  }
  const auto [begin, end] = this->ChildrenOf(s, t);
  const auto& next = begin < end ? this->All[s + 1].tiles : this->All[s].tiles;
  if (!isElsewhere &&
      std::any_of(next.begin() + std::ptrdiff_t(begin), next.begin() + std::ptrdiff_t(end),
        [](const TileFacts& child) { return child.stays; }))
  {
    json.Key("children").BeginArray();
    for (std::size_t child = begin; child < end; ++child)
    {
      if (next[child].stays)
      {
        this->PutTile(json, s + 1, child, root, options, up);
      }
    }
    json.EndArray();
  }
  json.EndObject();
}

// A little larger, so that no side has no length, and nothing that is rounded lies outside.
void TileTree::PutBox(JsonWriter& json, const Box& box) const
{
  const double margin = std::max(this->Diagonal() * 1e-7, 1e-9);
  std::vector<double> numbers;
  Vec3 half{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    half[k] = (box.hi[k] - box.lo[k]) / 2;
    numbers.push_back(
      (box.lo[k] - this->Frame.origin[k] + half[k]) * this->Frame.scale + 0.0); // no -0
  }
  for (std::size_t k = 0; k < 3; ++k)
  {
    Vec3 axis{};
    axis[k] = half[k] * this->Frame.scale + margin;
    numbers.insert(numbers.end(), axis.begin(), axis.end());
  }
  json.Key("boundingVolume").BeginObject().Member("box", numbers).EndObject();
}

// From metres around the middle of the model to where it stands: z up, its front to -y.
void TileTree::PutTransform(JsonWriter& json, const TilesOptions& options) const
{
  const Vec3 up = this->Info.homeView.value_or(HomeView{}).up, front = FrontOf(up);
  const std::array<Vec3, 3> axes{ Cross(up, front), Times(front, -1), up };
  const Vec3 middle = Times(this->Frame.origin, this->Frame.scale);
  GlobeMatrix turned{};
  for (std::size_t row = 0; row < 3; ++row)
  {
    for (std::size_t column = 0; column < 3; ++column)
    {
      turned[4 * column + row] = axes[row][column];
    }
    turned[12 + row] = Dot(axes[row], middle);
  }
  turned[15] = 1;
  if (options.origin)
  {
    const GlobeMatrix there = MatrixOfPlace(*options.origin), here = turned;
    for (std::size_t i = 0; i < 16; ++i)
    {
      turned[i] = 0;
      for (std::size_t k = 0; k < 4; ++k)
      {
        turned[i] += there[4 * k + i % 4] * here[i / 4 * 4 + k];
      }
    }
  }
  json.Key("transform").BeginArray();
  for (const double value : turned)
  {
    json.Put(value + 0.0);
  }
  json.EndArray();
}

}
