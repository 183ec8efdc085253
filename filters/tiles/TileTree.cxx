// SPDX-License-Identifier: BSD-3-Clause
#include "filters/tiles/TileTree.h"

#include "filters/codec/CoordinateGrid.h"
#include "filters/codec/TextureTile.h"
#include "filters/codec/TreePage.h"
#include "filters/core/VectorMath.h"
#include "filters/core/tree/PieceDepth.h"
#include "filters/model/JsonWriter.h"
#include "filters/model/Units.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

namespace kdstream
{
namespace
{

// The maximum number of depths of nodes between a tile and its children. With this, all children
// together leave room for other tiles in a tileset.
constexpr unsigned mostDepthsOfStep = 7;

// How wrong the lighting and colours of a piece may be, because they are interpolated between its
// vertices; as a part of the distance between vertices. For clouds and coloured surfaces it is the
// whole distance. Textures of levels show colours between vertices.
double TilePartOfSpacing(const ModelDescription& model)
{
  const bool colored = std::any_of(model.attributes.begin(), model.attributes.end(),
    [](const AttributeInfo& array) { return RoleOf(array) == AttributeRole::Colors; });
  const bool texturedOriginal = model.textures && !model.textures->levels;
  return colored || texturedOriginal || model.primitive == PrimitiveType::Points ? 1 : 1.0 / 3;
}

// Includes the places that vertices may be rounded to, because skirts are not on the lattice.
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

// The largest power of two that does not exceed a value.
double PowerOfTwoBelow(double value)
{
  int exponent = 0;
  std::frexp(value, &exponent);
  return std::ldexp(1, exponent - 1);
}

// Adds groups of partitions, if a piece of the finest level has many partitions below it.
void AddGroupsOfTiles(std::vector<TileStepShape>& all, unsigned partitionDepth)
{
  const unsigned from = all.back().depth, gap = partitionDepth - from;
  const unsigned steps = (gap + mostDepthsOfStep - 1) / mostDepthsOfStep;
  for (unsigned step = 1; step < steps; ++step)
  {
    const unsigned depth = from + gap * step / steps;
    all.push_back({ Resolution::Original(), depth, std::uint64_t{ 1 } << depth, true });
  }
}

// Divides the tree into tilesets. A tile begins a new tileset if another step would make the
// current one too large.
void ChooseTilesets(std::vector<TileStepShape>& all)
{
  const auto tilesBelow = [&](std::size_t root, std::size_t s)
  { return std::uint64_t{ 1 } << (all[s].depth - all[root].depth); };
  all[0].begins = true;
  std::size_t root = 0;
  std::uint64_t tiles = 1; // in the tileset, up to this step
  for (std::size_t s = 1; s < all.size(); ++s)
  {
    if (tiles + tilesBelow(root, s) > TileTree::mostTilesOfTileset || all[s - 1].isGroup)
    {
      all[s - 1].begins = true;
      root = s - 1;
      tiles = 1;
    }
    tiles += tilesBelow(root, s);
  }
}

}

std::vector<TileStepShape> TileTree::ShapesOf(const ModelDescription& model, ModelDetail detail)
{
  std::vector<TileStepShape> all;
  const unsigned first = PreviewLevel(model.depths);
  for (unsigned level = first; level < model.levels.size(); ++level)
  {
    const unsigned depth = PieceDepth(Resolution::Level(level), model.depths);
    all.push_back({ Resolution::Level(level), depth, std::uint64_t{ 1 } << depth });
  }
  const std::size_t levels = all.size();
  AddGroupsOfTiles(all, model.depths.partition);
  all.push_back({ Resolution::Original(), model.depths.partition, model.partitions });
  ChooseTilesets(all);
  const std::size_t wanted = detail == ModelDetail::Preview  ? 1
                             : detail == ModelDetail::Levels ? levels
                                                             : all.size();
  all.erase(all.begin() + std::ptrdiff_t(wanted), all.end());
  return all;
}

TileTree::TileTree(const ModelDescription& model, ModelDetail detail)
  : Info(model)
{
  for (std::size_t k = 0; k < 3; ++k)
  {
    const CoordinateGrid& grid = this->Info.grid;
    const double middle = this->Info.box.lo[k] + (this->Info.box.hi[k] - this->Info.box.lo[k]) / 2;
    this->Frame.origin[k] =
      grid.Lossless()
        ? middle
        : grid.origin[k] + std::round((middle - grid.origin[k]) / grid.step) * grid.step;
  }
  // In glTF content y is up; clients rotate it so that y becomes z.
  this->Frame.axes = { Vec3{ 1, 0, 0 }, Vec3{ 0, 0, 1 }, Vec3{ 0, -1, 0 } };
  this->Frame.scale = MetresOfUnit(this->Info.unit).value_or(1);
  this->Frame.copyright = this->Info.credit;
  for (const TileStepShape& shape : ShapesOf(model, detail))
  {
    TileStep step{ shape, "", {} };
    step.folder =
      shape.resolution.IsOriginal() ? "original" : std::to_string(shape.resolution.Depth());
    step.tiles.resize(shape.count);
    this->All.push_back(std::move(step));
  }
}

std::uint64_t TileTree::CountTiles(const ModelDescription& model, ModelDetail detail)
{
  std::uint64_t count = 0;
  for (const TileStepShape& shape : ShapesOf(model, detail))
  {
    count += shape.isGroup ? 0 : shape.count;
  }
  return count;
}

// The tiles of the next step below a tile: the number of the first one, and the end.
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

// Calls visit(piece, its facts, the box of its node) for the pieces of all pages.
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
  std::vector<double> leastSides(this->All.size(), std::numeric_limits<double>::infinity());
  KDSTREAM_TRY(this->VisitFacts(source,
    [&](PieceId piece, const PieceFacts& facts, const Box& box)
    {
      const auto found = std::find_if(this->All.begin(), this->All.end(),
        [&](const TileStep& step) { return step.resolution == piece.resolution && !step.isGroup; });
      if (found == this->All.end())
      {
        return;
      }
      if (const double side = LongestSideOf(box); side > 0)
      {
        double& least = leastSides[static_cast<std::size_t>(found - this->All.begin())];
        least = std::min(least, side);
      }
      if (piece.resolution.IsOriginal())
      {
        return;
      }
      const Vec3 s = box.Empty() ? Vec3{} : Minus(box.hi, box.lo);
      const double area = s[0] * s[1] + s[1] * s[2] + s[2] * s[0];
      const auto vertices =
        double(this->Info.levels[piece.resolution.Depth()].vertices) / double(found->tiles.size());
      found->tiles[piece.node - found->NodeOf(0)].error =
        std::max(double(facts.most), part * std::sqrt(area / std::max(vertices, 1.0)));
    }));
  this->ChooseLattices(leastSides);
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

// Chooses one lattice for all tiles of a step, so that they meet in the same points: the store's
// grid if coordinates are on it. leastSides: for each step, the longest side of the box of its
// smallest piece.
void TileTree::ChooseLattices(const std::vector<double>& leastSides)
{
  constexpr double finestPart = 1.0 / 65536;
  constexpr double smallest = 1e-290; // models smaller than this have no lattice
  // If there is no grid, vertices of levels may be slightly outside.
  const double longest = LongestSideOf(this->Info.box) * (this->Info.grid.Lossless() ? 2 : 1);
  for (std::size_t s = 0; s < this->All.size(); ++s)
  {
    TileStep& step = this->All[s];
    const bool isLevel = !step.resolution.IsOriginal();
    if (!this->Info.grid.Lossless())
    {
      step.latticeStep =
        this->Info.grid.step * (isLevel ? this->Info.levels[step.resolution.Depth()].spacing : 1);
    }
    else if (longest >= smallest)
    {
      const double least = std::min(leastSides[s], longest) * finestPart;
      step.latticeStep = PowerOfTwoBelow(std::max(least, longest / mostLatticeSteps));
    }
    while (step.latticeStep > 0 && longest / step.latticeStep > mostLatticeSteps)
    {
      step.latticeStep *= 2;
    }
  }
}

TileFrame TileTree::FrameOf(const TileStep& step) const
{
  TileFrame frame = this->Frame;
  const CoordinateGrid& grid = this->Info.grid;
  frame.latticeStep = step.latticeStep;
  frame.finestStep = grid.Lossless() ? step.latticeStep : grid.step;
  frame.latticeOrigin = grid.Lossless() ? frame.origin : grid.origin;
  return frame;
}

// The tile itself; for a group, the tile above it, which is shown instead.
const TileFacts& TileTree::ShownBy(std::size_t s, std::size_t t) const
{
  while (this->All[s].isGroup)
  {
    t >>= this->All[s].depth - this->All[s - 1].depth;
    --s;
  }
  return this->All[s].tiles[t];
}

// The depth of the skirt: the error of the tile that is shown here while its children are not
// loaded. A neighbour is mostly of this level, or of the next coarser one.
double TileTree::SkirtDepth(std::size_t s, std::size_t t) const
{
  const unsigned below = s == 0 ? 0 : this->All[s].depth - this->All[s - 1].depth;
  return s == 0 ? 0 : this->ShownBy(s - 1, t >> below).error;
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
    auto decoded = DecodeTextureTile(*blob, piece->triangles, piece->positions);
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
  // Skirts hang below ghosts, in any direction.
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
  const TileFacts& root = this->ShownBy(s, t);
  json.Member("geometricError", s == 0 ? this->Diagonal() : this->ErrorOf(root));
  json.Key("root");
  this->PutTile(json, s, t, s, options, up);
  json.EndObject();
  return json.Text();
}

// The diagonal of the whole model, in metres: the error if nothing is shown. It is at least the
// error of the root.
double TileTree::Diagonal() const
{
  const TileFacts& root = this->All[0].tiles[0];
  return std::max(Length(Minus(root.box.hi, root.box.lo)) * this->Frame.scale, this->ErrorOf(root));
}

// A group has the box and the error of the tile above it, which is shown instead. So clients that
// look below that tile also look below the group, and never stop where nothing is shown.
//
// root: the step of the tileset's root. up: the path from the tileset's folder to the folder of all
// tiles.
void TileTree::PutTile(JsonWriter& json, std::size_t s, std::size_t t, std::size_t root,
  const TilesOptions& options, const std::string& up) const
{
  const TileFacts& tile = this->All[s].tiles[t];
  const bool isElsewhere = s > root && this->All[s].begins;
  json.BeginObject();
  this->PutBox(json, this->ShownBy(s, t).box);
  json.Member("geometricError", this->ErrorOf(this->ShownBy(s, t)));
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

// Enlarges the box a little, and rounds it outward to decimal numbers with few digits. So no side
// has length 0, nothing that is rounded is outside, and tilesets are short.
void TileTree::PutBox(JsonWriter& json, const Box& box) const
{
  constexpr double least = 1e6; // units along the whole model
  constexpr double mostOfMetre = 1e20;
  const double whole = this->Info.box.Empty()
                         ? 0
                         : Length(Minus(this->Info.box.hi, this->Info.box.lo)) * this->Frame.scale;
  double units = 1; // per metre
  while (units * whole < least && units < mostOfMetre)
  {
    units *= 10;
  }
  while (units * whole >= 10 * least)
  {
    units /= 10;
  }
  std::vector<double> numbers;
  Vec3 half{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double toUnits = this->Frame.scale * units, origin = this->Frame.origin[k];
    const double low = std::floor((box.lo[k] - origin) * toUnits - 0.5);
    const double high = std::ceil((box.hi[k] - origin) * toUnits + 0.5);
    numbers.push_back((low + high) / 2 / units + 0.0); // avoids -0
    half[k] = (high - low) / 2 / units;
  }
  for (std::size_t k = 0; k < 3; ++k)
  {
    Vec3 axis{};
    axis[k] = half[k];
    numbers.insert(numbers.end(), axis.begin(), axis.end());
  }
  json.Key("boundingVolume").BeginObject().Member("box", numbers).EndObject();
}

// Maps metres around the middle of the model to its place: z up, its front towards -y.
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
