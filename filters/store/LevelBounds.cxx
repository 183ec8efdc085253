// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/LevelBounds.h"

#include "filters/core/tree/PieceDepth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::size_t mostKept = 6; // pieces of a level that stay decoded
// What is looked at as a whole: clusters of the finest level that are no larger than so many of its
// spacings (few are), and what is smaller than a part of a level's spacing. Models of fewer
// vertices than these are measured more closely.
constexpr double leastOfSpacing = 3;
constexpr double mostOfSpacing = 0.4;
constexpr double largeModel = 1e6;

float RoundedDown(double value)
{
  const auto rounded = static_cast<float>(value);
  return rounded > value ? std::nextafter(rounded, -std::numeric_limits<float>::infinity())
                         : rounded;
}

double SquaredToExtent(
  const std::array<float, 3>& lo, const std::array<float, 3>& hi, const Vec3& place)
{
  double squared = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double away = std::max({ double(lo[k]) - place[k], place[k] - double(hi[k]), 0.0 });
    squared += away * away;
  }
  return squared;
}

void Raise(std::atomic<double>& most, double value)
{
  double known = most.load();
  while (known < value && !most.compare_exchange_weak(known, value))
  {
  }
}

NodeId FirstNode(unsigned depth, const TreeDepths& depths)
{
  return NodeId{ 1 } << PieceDepth(Resolution::Level(depth), depths);
}

// Those of points where a surface has none.
void AddPoints(VertexId count, std::vector<Triangle>& triangles)
{
  for (VertexId v = 0; v < count; ++v)
  {
    triangles.push_back({ v, v, v });
  }
}

}

LevelBounds::LevelBounds(const ModelDescription& model, ReadBlob read)
  : Codec(model.Codec())
  , Primitive(model.primitive)
  , Closeness(std::sqrt(std::min(1.0, double(model.vertices) / largeModel)))
  , Read(std::move(read))
  , Levels(model.levels.size())
  , Farthest(model.levels.size())
{
  this->Codec.clusters = {}; // not counted yet
  for (unsigned depth = 0; depth < this->Levels.size(); ++depth)
  {
    Extent none;
    none.lo.fill(std::numeric_limits<float>::infinity());
    none.hi.fill(-std::numeric_limits<float>::infinity());
    this->Levels[depth].extents.assign(FirstNode(depth, this->Codec.depths), none);
  }
}

void LevelBounds::AddLevelPiece(const Piece& piece)
{
  const unsigned depth = piece.id.resolution.Depth();
  const CoordinateGrid grid = this->Codec.GridOf(piece.id.resolution);
  Box box;
  for (const Vec3& p : piece.positions)
  {
    box.Add(grid.Snap(p));
  }
  Extent& extent =
    this->Levels[depth].extents[piece.id.node - FirstNode(depth, this->Codec.depths)];
  for (std::size_t k = 0; k < 3; ++k)
  {
    extent.lo[k] = RoundedDown(box.lo[k]);
    extent.hi[k] = -RoundedDown(-box.hi[k]);
  }
}

void LevelBounds::FinishLevel(unsigned depth, bool hasTriangles, double least)
{
  this->Levels[depth].hasTriangles = hasTriangles;
  this->Farthest[depth].store(least);
}

Status LevelBounds::Measure(const Piece& original)
{
  const auto partition =
    original.id.node - (NodeId{ 1 } << PieceDepth(original.id.resolution, this->Codec.depths));
  const auto finest = static_cast<unsigned>(this->Levels.size()) - 1;
  const Result<Part> clusters = this->LoadOf(finest, partition);
  KDSTREAM_TRY(clusters);
  std::vector<Triangle> points;
  if (this->Primitive == PrimitiveType::Points)
  {
    AddPoints(original.ownVertices, points);
  }
  OriginalPart from =
    this->PartOfOriginal(original, points.empty() ? original.triangles : points, **clusters);
  double bound = 0;
  for (unsigned depth = finest + 1; depth-- > 0;)
  {
    const Result<Part> near = this->LoadOf(depth, partition);
    KDSTREAM_TRY(near);
    const std::vector<VertexId> guesses = depth < this->Codec.depths.stitch
                                            ? std::vector<VertexId>{}
                                            : RepresentativesOf(from.keys, **near);
    const double cluster = this->Closeness * leastOfSpacing * (*clusters)->spacing;
    const double group = this->Closeness * mostOfSpacing * (*near)->spacing;
    const LevelSurface to{ (*near)->surface,
      [&](const Vec3& place, double& squared)
      { return this->LookFarther(depth, (*near)->node, place, squared); },
      std::max(cluster, group), group, guesses };
    bound = std::max(bound, this->Farthest[depth].load());
    const Result<double> farthest = FarthestPoint(from.clusters, to, bound);
    KDSTREAM_TRY(farthest);
    bound = *farthest;
    Raise(this->Farthest[depth], bound);
  }
  this->Measured.store(true);
  return {};
}

std::vector<double> LevelBounds::Bounds() const
{
  // Rounding has moved the original's vertices by half a step along each axis at most.
  const double rounded =
    this->Codec.grid.Lossless() ? 0 : std::sqrt(3.0) / 2 * this->Codec.grid.step;
  std::vector<double> bounds(this->Levels.size());
  double bound = 0;
  for (std::size_t depth = bounds.size(); depth-- > 0;)
  {
    bound = std::max(bound, this->Farthest[depth].load());
    bounds[depth] = bound + rounded;
  }
  return bounds;
}

// As it is stored, in clusters of the finest level.
LevelBounds::OriginalPart LevelBounds::PartOfOriginal(
  const Piece& piece, std::span<const Triangle> triangles, const LevelPart& finest) const
{
  std::vector<Vec3> points(piece.positions.size());
  std::transform(piece.positions.begin(), piece.positions.end(), points.begin(),
    [&](const Vec3& p) { return this->Codec.grid.Snap(p); });
  // A triangle belongs to its lowest vertex: that may be of a partition before.
  std::vector<std::int32_t> clusterOf(points.size(), -1);
  const auto ghosts = piece.keys.begin() + piece.ownVertices;
  const auto behind = std::lower_bound(ghosts, piece.keys.end(), piece.keys.front());
  std::fill(clusterOf.begin() + (behind - piece.keys.begin()), clusterOf.end(),
    std::numeric_limits<std::int32_t>::max());
  // The clusters of a partition are intervals of its vertices.
  const auto first =
    std::upper_bound(finest.keys.begin(), finest.keys.end(), piece.keys.front()) - 1;
  auto next = first;
  std::vector<Vec3> centres;
  for (VertexId v = 0; v < piece.ownVertices; ++v)
  {
    for (; next != finest.keys.end() && *next <= piece.keys[v]; ++next)
    {
      centres.push_back(finest.surface.At(static_cast<VertexId>(next - finest.keys.begin())));
    }
    clusterOf[v] = static_cast<std::int32_t>(centres.size()) - 1;
  }
  return { { std::move(points), triangles, std::move(clusterOf), centres }, { first, next } };
}

// Of each cluster of the finest level the vertex that stands for it in a level from S on, where a
// triangle of the level has it.
std::vector<VertexId> LevelBounds::RepresentativesOf(
  std::span<const VertexKey> clusters, const LevelPart& level)
{
  std::vector<VertexId> vertices;
  vertices.reserve(clusters.size());
  auto next = std::upper_bound(level.keys.begin(), level.keys.end(), clusters.front());
  for (const VertexKey key : clusters)
  {
    while (next != level.keys.end() && *next <= key)
    {
      ++next;
    }
    const auto vertex = static_cast<VertexId>(next - level.keys.begin()) - 1;
    vertices.push_back(level.used[vertex] != 0 ? vertex : SearchedPart::none);
  }
  return vertices;
}

Result<LevelBounds::Part> LevelBounds::LoadOf(unsigned depth, std::uint32_t partition)
{
  return this->Load(
    depth, PieceOfPartition(Resolution::Level(depth), partition, this->Codec.depths).node);
}

Result<LevelBounds::Part> LevelBounds::Load(unsigned depth, NodeId node)
{
  const std::lock_guard<std::mutex> lock(this->Loading);
  std::map<NodeId, KeptPart>& kept = this->Levels[depth].kept;
  auto found = kept.find(node);
  if (found == kept.end())
  {
    const Result<Part> part = this->Decode(depth, node);
    KDSTREAM_TRY(part);
    if (kept.size() == mostKept)
    {
      kept.erase(std::min_element(kept.begin(), kept.end(),
        [](const auto& a, const auto& b) { return a.second.asked < b.second.asked; }));
    }
    found = kept.emplace(node, KeptPart{ *part }).first;
  }
  found->second.asked = ++this->Asked;
  return found->second.part;
}

Result<LevelBounds::Part> LevelBounds::Decode(unsigned depth, NodeId node) const
{
  const PieceId id{ Resolution::Level(depth), node };
  const Result<std::vector<std::uint8_t>> blob = this->Read(id);
  KDSTREAM_TRY(blob);
  Result<Piece> piece = DecodePiece(*blob, id, this->Codec);
  KDSTREAM_TRY(piece);
  if (!this->Levels[depth].hasTriangles)
  {
    AddPoints(piece->ownVertices, piece->triangles);
  }
  std::vector<std::uint8_t> used(piece->VertexCount(), 0);
  for (const Triangle& t : piece->triangles)
  {
    used[t[0]] = used[t[1]] = used[t[2]] = 1;
  }
  piece->keys.resize(piece->ownVertices);
  LevelPart part{ node, { std::move(piece->positions), std::move(piece->triangles) },
    std::move(piece->keys), std::move(used) };
  part.spacing = part.surface.Spacing();
  return std::make_shared<const LevelPart>(std::move(part));
}

Status LevelBounds::LookFarther(unsigned depth, NodeId except, const Vec3& place, double& squared)
{
  const std::vector<Extent>& extents = this->Levels[depth].extents;
  const NodeId first = FirstNode(depth, this->Codec.depths);
  std::vector<std::pair<double, NodeId>> nearer;
  for (NodeId i = 0; i < extents.size(); ++i)
  {
    const double away = SquaredToExtent(extents[i].lo, extents[i].hi, place);
    if (away < squared && first + i != except)
    {
      nearer.emplace_back(away, first + i);
    }
  }
  std::sort(nearer.begin(), nearer.end());
  for (const auto& [away, node] : nearer)
  {
    if (away >= squared)
    {
      break;
    }
    const Result<Part> part = this->Load(depth, node);
    KDSTREAM_TRY(part);
    (*part)->surface.Nearest(place, 0, squared);
  }
  return {};
}

}
