// SPDX-License-Identifier: BSD-3-Clause
// The drawing rule, part by part: see SurfaceParts.h.
//   1. Find the cut's pieces (Cut.h), and where the cut shows their vertices (ShownVertices.h).
//   2. For each piece that has changed, find the points that it shows: own vertices in the cut.
//   3. Draw each of its triangles whose finest corner is one of these points. The other corners
//      move up to the nodes of the cut above them, mostly points of other pieces (borrowed points).
#include "filters/core/drawing/SurfaceParts.h"

#include "filters/core/SortTriangles.h"
#include "filters/core/drawing/ParentSurface.h"
#include "filters/core/drawing/ShownVertices.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

namespace kdstream
{
namespace
{

constexpr auto stayed = static_cast<std::size_t>(-1);

// The triangles in ascending order, without duplicates. A triangle has its lowest index first, and
// few triangles share this index. So there is a bucket for each lowest index, in which only two or
// three triangles must be sorted. O(triangles + points), unless some points have very many
// triangles.
std::vector<Triangle> SortedWithoutRepeats(
  const std::vector<Triangle>& triangles, std::size_t points)
{
  std::vector<std::size_t> begin(points + 1, 0);
  for (const Triangle& t : triangles)
  {
    ++begin[t[0] + 1];
  }
  for (std::size_t v = 0; v < points; ++v)
  {
    begin[v + 1] += begin[v];
  }
  std::vector<std::uint64_t> others(triangles.size()); // second and third index
  std::vector<std::size_t> next = begin;
  for (const Triangle& t : triangles)
  {
    others[next[t[0]]++] = std::uint64_t{ t[1] } << 32 | t[2];
  }
  std::vector<Triangle> sorted;
  sorted.reserve(triangles.size());
  for (std::size_t v = 0; v < points; ++v)
  {
    std::uint64_t* const first = others.data() + begin[v];
    std::uint64_t* const last = others.data() + begin[v + 1];
    std::sort(first, last);
    std::for_each(first, std::unique(first, last),
      [&sorted, v](std::uint64_t pair)
      {
        sorted.push_back({ static_cast<VertexId>(v), static_cast<VertexId>(pair >> 32),
          static_cast<VertexId>(pair & 0xFFFFFFFFU) });
      });
  }
  return sorted;
}

// Draws the part of one piece.
class PartDrawer
{
public:
  PartDrawer(ShownVertices& view, std::size_t number, bool keepsCorners)
    : View(view)
    , Number(number)
    , P(*view.Pieces()[number])
    , KeepsCorners(keepsCorners)
  {
  }

  // Null if the piece shows nothing.
  std::shared_ptr<const SurfacePart> Draw()
  {
    this->Part.piece = this->P.id;
    this->AddOwnPoints();
    if (this->Part.own.empty())
    {
      return nullptr;
    }
    const std::vector<Triangle> drawn = this->DrawnTriangles();
    this->AddBorrowedPoints(drawn);
    this->AddTriangles(drawn);
    if (this->KeepsCorners)
    {
      this->AddCorners();
    }
    this->AddAttributes();
    return std::make_shared<const SurfacePart>(std::move(this->Part));
  }

private:
  void AddOwnPoints()
  {
    this->PointOf.assign(this->P.VertexCount(), noVertex);
    this->Part.surface.points.reserve(this->P.VertexCount());
    this->Part.surface.sources.reserve(this->P.VertexCount());
    for (std::uint32_t v = 0; v < this->P.ownVertices; ++v)
    {
      if (this->View.IsInCut(this->Number, v))
      {
        this->PointOf[v] = static_cast<VertexId>(this->Part.own.size());
        this->Part.own.push_back(v);
        this->AddPoint(this->P, v);
      }
    }
  }

  void AddPoint(const Piece& piece, std::uint32_t vertex)
  {
    this->Part.surface.points.push_back(piece.positions[vertex]);
    this->Part.surface.sources.push_back({ piece.id.resolution, piece.keys[vertex] });
  }

  // The triangles to draw, with the numbers of the piece's vertices. The corners that are in the
  // cut themselves are the finest ones. Pieces that own the other corners have triangles with the
  // same image too.
  std::vector<Triangle> DrawnTriangles() const
  {
    std::vector<Triangle> drawn;
    drawn.reserve(this->P.triangles.size());
    for (const Triangle& t : this->P.triangles)
    {
      std::uint32_t lowest = noVertex;
      for (const VertexId corner : t)
      {
        if (this->View.IsInCut(this->Number, corner) &&
            (lowest == noVertex || this->P.keys[corner] < this->P.keys[lowest]))
        {
          lowest = corner;
        }
      }
      if (lowest < this->P.ownVertices)
      {
        drawn.push_back(t);
      }
    }
    return drawn;
  }

  // Corners that are not own points move up to the nodes above them. If only finer vertices are
  // shown there, there is no such node, and the triangle is not drawn.
  void AddBorrowedPoints(const std::vector<Triangle>& drawn)
  {
    std::vector<std::uint64_t> nodes(this->P.VertexCount(), noNode); // of each vertex
    for (const Triangle& t : drawn)
    {
      for (const VertexId corner : t)
      {
        if (this->PointOf[corner] == noVertex && nodes[corner] == noNode)
        {
          nodes[corner] = this->NodeOf(corner);
        }
      }
    }
    this->Lent = nodes;
    std::sort(this->Lent.begin(), this->Lent.end());
    this->Lent.erase(std::unique(this->Lent.begin(), this->Lent.end()), this->Lent.end());
    if (!this->Lent.empty() && this->Lent.back() == noNode)
    {
      this->Lent.pop_back();
    }
    const auto first = static_cast<VertexId>(this->Part.own.size());
    for (const std::uint64_t node : this->Lent)
    {
      const Piece& piece = this->LenderOf(node);
      this->Part.borrowed.push_back({ piece.id, static_cast<std::uint32_t>(node) });
      this->AddPoint(piece, static_cast<std::uint32_t>(node));
    }
    for (std::uint32_t v = 0; v < nodes.size(); ++v)
    {
      if (nodes[v] != noNode)
      {
        const auto place = std::lower_bound(this->Lent.begin(), this->Lent.end(), nodes[v]);
        this->PointOf[v] = first + static_cast<VertexId>(place - this->Lent.begin());
      }
    }
  }

  // The node that shows a vertex: the number of the node's piece, then of its own vertex there, so
  // that nodes are ordered by pieces. If the node is one of this part's own points, sets PointOf
  // and returns noNode, because nothing is borrowed.
  std::uint64_t NodeOf(VertexId corner)
  {
    const auto node = this->View.NodeAbove(this->Number, corner);
    if (!node || !this->View.IsInCut(node->piece, node->vertex))
    {
      return noNode; // not in the cut: only if pieces contradict each other
    }
    if (node->piece == this->Number)
    {
      this->PointOf[corner] = this->PointOf[node->vertex];
      return noNode;
    }
    return std::uint64_t{ node->piece } << 32 | node->vertex;
  }

  const Piece& LenderOf(std::uint64_t node) const { return *this->View.Pieces()[node >> 32]; }

  // Adds the triangles with their corners moved up: no degenerate ones, and only one of triangles
  // that coincide.
  void AddTriangles(const std::vector<Triangle>& drawn)
  {
    std::vector<Triangle> triangles;
    triangles.reserve(drawn.size());
    for (const Triangle& t : drawn)
    {
      const Triangle moved{ this->PointOf[t[0]], this->PointOf[t[1]], this->PointOf[t[2]] };
      const bool whole = moved[0] != noVertex && moved[1] != noVertex && moved[2] != noVertex;
      if (whole && moved[0] != moved[1] && moved[1] != moved[2] && moved[2] != moved[0])
      {
        triangles.push_back(RotateLowestFirst(moved));
      }
    }
    this->Part.surface.triangles =
      SortedWithoutRepeats(triangles, this->Part.surface.points.size());
  }

  // Finds for each triangle of the piece the triangle of the part that it has become.
  void AddCorners()
  {
    const std::vector<Triangle>& all = this->Part.surface.triangles; // ascending
    this->Part.corners.assign(all.size(), 0);
    std::vector<bool> isKnown(all.size(), false);
    for (std::size_t i = 0; i < this->P.triangles.size(); ++i)
    {
      const Triangle& t = this->P.triangles[i];
      const Triangle moved{ this->PointOf[t[0]], this->PointOf[t[1]], this->PointOf[t[2]] };
      const Triangle rotated = RotateLowestFirst(moved);
      const auto place = std::lower_bound(all.begin(), all.end(), rotated);
      const auto number = static_cast<std::size_t>(place - all.begin());
      if (place != all.end() && *place == rotated && !isKnown[number])
      {
        isKnown[number] = true;
        const auto first = std::find(moved.begin(), moved.end(), rotated[0]) - moved.begin();
        this->Part.corners[number] =
          static_cast<std::uint32_t>(3 * i) + static_cast<std::uint32_t>(first);
      }
    }
  }

  // Adds the point arrays that all pieces with points in this part have, with tuples in the order
  // of the points.
  void AddAttributes()
  {
    for (const Attribute& array : this->P.attributes)
    {
      Attribute values{ array.Info(), {} };
      if (array.association == AttributeAssociation::Point && this->AppendValues(values, array))
      {
        this->Part.surface.attributes.push_back(std::move(values));
      }
    }
  }

  // False if a piece that owns a borrowed point has no such array.
  bool AppendValues(Attribute& values, const Attribute& own) const
  {
    values.values.reserve(this->Part.surface.points.size() * values.TupleSize());
    for (const std::uint32_t vertex : this->Part.own)
    {
      values.Append(own, vertex);
    }
    const Piece* lender = nullptr;
    const Attribute* lent = nullptr;
    for (const std::uint64_t node : this->Lent)
    {
      if (lender != &this->LenderOf(node))
      {
        lender = &this->LenderOf(node);
        lent = FindAttribute(lender->attributes, values);
      }
      if (!lent)
      {
        return false;
      }
      values.Append(*lent, static_cast<std::uint32_t>(node));
    }
    return true;
  }

  static constexpr std::uint64_t noNode = ~std::uint64_t{ 0 };

  ShownVertices& View;
  const std::size_t Number;
  const Piece& P;
  const bool KeepsCorners;
  SurfacePart Part;
  std::vector<VertexId> PointOf;   // of each vertex of the piece, or noVertex
  std::vector<std::uint64_t> Lent; // NodeOf each borrowed point
};

Result<std::vector<const Piece*>> FindPieces(const Cut& cut, const PieceLookup& lookup)
{
  KDSTREAM_TRY(CheckCut(cut));
  std::vector<const Piece*> pieces;
  std::size_t missing = 0;
  for (const PieceId id : PiecesOf(cut))
  {
    pieces.push_back(lookup(id));
    missing += pieces.back() == nullptr;
  }
  if (missing > 0)
  {
    return Error{ ErrorCode::NotFound, std::to_string(missing) + " pieces are not loaded" };
  }
  return pieces;
}

// The numbers that the points of parts have in the whole surface.
class PointNumbers
{
public:
  explicit PointNumbers(const SurfacePartList& parts)
    : Parts(parts)
  {
    VertexId first = 0;
    for (const auto& part : parts)
    {
      this->First.push_back(first);
      first += static_cast<VertexId>(part->own.size());
    }
  }

  // For each point of a part; noVertex if its owner does not show it, which happens only if pieces
  // contradict each other.
  std::vector<VertexId> Of(std::size_t number) const
  {
    const SurfacePart& part = *this->Parts[number];
    std::vector<VertexId> numbers(part.own.size());
    std::iota(numbers.begin(), numbers.end(), this->First[number]);
    for (const auto& [piece, vertex] : part.borrowed)
    {
      numbers.push_back(this->Find(piece, vertex));
    }
    return numbers;
  }

private:
  VertexId Find(PieceId piece, std::uint32_t vertex) const
  {
    const auto owner = FindPart(this->Parts, piece);
    if (owner == this->Parts.end())
    {
      return noVertex;
    }
    const auto& own = (*owner)->own;
    const auto place = std::lower_bound(own.begin(), own.end(), vertex);
    return place != own.end() && *place == vertex
             ? this->First[static_cast<std::size_t>(owner - this->Parts.begin())] +
                 static_cast<VertexId>(place - own.begin())
             : noVertex;
  }

  const SurfacePartList& Parts;
  std::vector<VertexId> First; // first point of each part
};

// The arrays that all parts have, with the tuples of own points.
std::vector<Attribute> MergeAttributes(const SurfacePartList& parts)
{
  std::vector<Attribute> merged;
  for (const Attribute& array : parts.front()->surface.attributes)
  {
    Attribute values{ array.Info(), {} };
    const bool all = std::all_of(parts.begin(), parts.end(),
      [&values](const auto& part)
      {
        const Attribute* found = FindAttribute(part->surface.attributes, values);
        if (found)
        {
          const auto end = found->values.begin() +
                           static_cast<std::ptrdiff_t>(part->own.size() * found->TupleSize());
          values.values.insert(values.values.end(), found->values.begin(), end);
        }
        return found != nullptr;
      });
    if (all)
    {
      merged.push_back(std::move(values));
    }
  }
  return merged;
}

}

const Box& SurfacePart::Bounds() const
{
  if (!this->KeptBounds)
  {
    this->KeptBounds = BoundsOf(this->surface);
  }
  return *this->KeptBounds;
}

const SurfaceTree& SurfacePart::Tree() const
{
  if (!this->KeptTree)
  {
    this->KeptTree.emplace(this->surface);
  }
  return *this->KeptTree;
}

SurfacePartList::const_iterator FindPart(const SurfacePartList& parts, PieceId piece)
{
  const auto place = std::partition_point(
    parts.begin(), parts.end(), [piece](const auto& part) { return part->piece < piece; });
  return place != parts.end() && (*place)->piece == piece ? place : parts.end();
}

SurfaceParts::SurfaceParts()
  : View(std::make_unique<ShownVertices>())
{
}

SurfaceParts::~SurfaceParts() = default;
SurfaceParts::SurfaceParts(SurfaceParts&&) noexcept = default;
SurfaceParts& SurfaceParts::operator=(SurfaceParts&&) noexcept = default;

Status SurfaceParts::GoTo(const Cut& cut, const PieceLookup& lookup, const Execution& execution)
{
  auto pieces = FindPieces(cut, lookup);
  KDSTREAM_TRY(pieces);
  ShownVertices& view = *this->View;
  view.GoTo(cut, std::move(*pieces));
  const SurfacePartList before = std::exchange(this->All, {});
  std::vector<std::size_t> numbers; // the number of each part's piece; none for parts that stayed
  for (std::size_t i = 0; i < view.Pieces().size(); ++i)
  {
    std::shared_ptr<const SurfacePart> part;
    if (view.HasChanged(i))
    {
      KDSTREAM_TRY(execution.Report("glue", double(i) / double(view.Pieces().size())));
      const bool isOriginal = view.Pieces()[i]->id.resolution.IsOriginal();
      part =
        PartDrawer(view, i, isOriginal ? this->KeepsCorners : this->KeepsCornersOfLevels).Draw();
    }
    else
    {
      const auto place = FindPart(before, view.Pieces()[i]->id);
      part = place == before.end() ? nullptr : *place;
    }
    if (part)
    {
      this->All.push_back(std::move(part));
      numbers.push_back(view.HasChanged(i) ? i : stayed);
    }
  }
  this->ParentsOfParts.clear();
  if (this->Follows)
  {
    this->FindParents(before, cut.depths, numbers);
  }
  return {};
}

// pieces: the number of each part's piece, or `stayed`.
void SurfaceParts::FindParents(
  const SurfacePartList& before, const TreeDepths& depths, const std::vector<std::size_t>& pieces)
{
  const ParentSurface parents(before, depths);
  this->ParentsOfParts.resize(this->All.size());
  for (std::size_t i = 0; i < this->All.size(); ++i)
  {
    const SurfacePart& part = *this->All[i];
    for (std::size_t k = 0; pieces[i] != stayed && k < part.own.size(); ++k)
    {
      this->ParentsOfParts[i].push_back(
        parents.FindAbove(part.surface.sources[k], this->View->LineageOf(pieces[i], part.own[k])));
    }
  }
  for (std::size_t i = 0; i < this->All.size(); ++i)
  {
    for (const auto& [piece, vertex] : this->All[i]->borrowed)
    {
      if (pieces[i] == stayed)
      {
        break;
      }
      const auto owner = FindPart(this->All, piece);
      const auto number = static_cast<std::size_t>(owner - this->All.begin());
      if (owner == this->All.end() || pieces[number] == stayed)
      {
        this->ParentsOfParts[i].push_back(parents.Find(piece, vertex));
        continue;
      }
      const auto& own = (*owner)->own;
      const auto place = std::lower_bound(own.begin(), own.end(), vertex);
      this->ParentsOfParts[i].push_back(
        place != own.end() && *place == vertex
          ? this->ParentsOfParts[number][static_cast<std::size_t>(place - own.begin())]
          : std::nullopt);
    }
  }
}

Surface MergeParts(const SurfacePartList& parts)
{
  Surface whole;
  if (parts.empty())
  {
    return whole;
  }
  const PointNumbers numbers(parts);
  std::vector<Triangle> triangles;
  for (std::size_t i = 0; i < parts.size(); ++i)
  {
    const auto count = static_cast<std::ptrdiff_t>(parts[i]->own.size());
    const Surface& part = parts[i]->surface;
    whole.points.insert(whole.points.end(), part.points.begin(), part.points.begin() + count);
    whole.sources.insert(whole.sources.end(), part.sources.begin(), part.sources.begin() + count);
    const std::vector<VertexId> of = numbers.Of(i);
    for (const Triangle& t : part.triangles)
    {
      const Triangle moved{ of[t[0]], of[t[1]], of[t[2]] };
      if (moved[0] != noVertex && moved[1] != noVertex && moved[2] != noVertex)
      {
        triangles.push_back(RotateLowestFirst(moved));
      }
    }
  }
  whole.triangles = SortedWithoutRepeats(triangles, whole.points.size());
  whole.attributes = MergeAttributes(parts);
  return whole;
}

}
