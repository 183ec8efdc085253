// SPDX-License-Identifier: BSD-3-Clause
// The drawing rule, part by part: see SurfaceParts.h.
//   1. The pieces that take part (Cut.h), and where the cut shows their vertices (ShownVertices.h).
//   2. Of each piece that differs from before, the points that it shows: own vertices in the cut.
//   3. Each of its triangles: where its finest corner is one of these points it is drawn, and the
//   other corners move up to their nodes of the cut, points of other pieces mostly: borrowed ones.
#include "filters/core/drawing/SurfaceParts.h"

#include "filters/core/SortTriangles.h"
#include "filters/core/drawing/ShownVertices.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

namespace kdstream
{
namespace
{

// Draws the part of one piece.
class PartDrawer
{
public:
  PartDrawer(ShownVertices& view, std::size_t number)
    : View(view)
    , Number(number)
    , P(*view.Pieces()[number])
  {
  }

  // Null where the piece shows nothing.
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
    this->AddAttributes();
    return std::make_shared<const SurfacePart>(std::move(this->Part));
  }

private:
  void AddOwnPoints()
  {
    this->PointOf.assign(this->P.VertexCount(), noVertex);
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

  // By the numbers of the piece's vertices. The corners that are in the cut themselves are the
  // finest ones; in the pieces that own the others there are triangles of the same image.
  std::vector<Triangle> DrawnTriangles() const
  {
    std::vector<Triangle> drawn;
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

  // Corners that are no own points go up to the nodes above them. Nowhere, if only what is finer is
  // shown there: such triangles are not drawn.
  void AddBorrowedPoints(const std::vector<Triangle>& drawn)
  {
    std::vector<std::pair<SurfacePart::Borrowed, VertexId>> corners; // and vertices of the piece
    std::vector<std::uint8_t> met(this->P.VertexCount(), 0);
    for (const Triangle& t : drawn)
    {
      for (const VertexId corner : t)
      {
        if (this->PointOf[corner] == noVertex && !std::exchange(met[corner], 1))
        {
          this->AddCorner(corner, corners);
        }
      }
    }
    std::sort(corners.begin(), corners.end());
    const Piece* piece = nullptr;
    for (const auto& [node, corner] : corners)
    {
      if (this->Part.borrowed.empty() || this->Part.borrowed.back() != node)
      {
        piece = piece && piece->id == node.piece ? piece : this->Lenders.at(node.piece);
        this->Part.borrowed.push_back(node);
        this->AddPoint(*piece, node.vertex);
      }
      this->PointOf[corner] = static_cast<VertexId>(this->Part.surface.points.size()) - 1;
    }
  }

  void AddCorner(VertexId corner, std::vector<std::pair<SurfacePart::Borrowed, VertexId>>& corners)
  {
    const auto node = this->View.NodeAbove(this->Number, corner);
    if (!node || !this->View.IsInCut(node->piece, node->vertex))
    {
      return; // the latter where pieces contradict each other
    }
    if (node->piece == this->Number)
    {
      this->PointOf[corner] = this->PointOf[node->vertex];
      return;
    }
    const Piece& piece = *this->View.Pieces()[node->piece];
    this->Lenders[piece.id] = &piece;
    corners.push_back({ { piece.id, node->vertex }, corner });
  }

  // Moved, without those that have become degenerate, one of each that fall together.
  void AddTriangles(const std::vector<Triangle>& drawn)
  {
    std::vector<Triangle>& triangles = this->Part.surface.triangles;
    for (const Triangle& t : drawn)
    {
      const Triangle moved{ this->PointOf[t[0]], this->PointOf[t[1]], this->PointOf[t[2]] };
      const bool whole = moved[0] != noVertex && moved[1] != noVertex && moved[2] != noVertex;
      if (whole && moved[0] != moved[1] && moved[1] != moved[2] && moved[2] != moved[0])
      {
        triangles.push_back(RotateLowestFirst(moved));
      }
    }
    SortTriangles(triangles, this->Part.surface.points.size(), true);
  }

  // The point arrays that all pieces have whose points are here, tuples in the order of the points.
  void AddAttributes()
  {
    for (const Attribute& array : this->P.attributes)
    {
      Attribute values{ array.Info(), {} };
      const bool all = array.association == AttributeAssociation::Point &&
                       std::all_of(this->Lenders.begin(), this->Lenders.end(),
                         [&](const auto& lender)
                         { return FindAttribute(lender.second->attributes, values) != nullptr; });
      if (all)
      {
        this->AppendValues(values, array);
        this->Part.surface.attributes.push_back(std::move(values));
      }
    }
  }

  void AppendValues(Attribute& values, const Attribute& own) const
  {
    values.values.reserve(this->Part.surface.points.size() * values.TupleSize());
    for (const std::uint32_t vertex : this->Part.own)
    {
      values.Append(own, vertex);
    }
    const Attribute* lent = nullptr;
    PieceId lender;
    for (const auto& [piece, vertex] : this->Part.borrowed)
    {
      if (!lent || piece != lender)
      {
        lender = piece;
        lent = FindAttribute(this->Lenders.at(piece)->attributes, values);
      }
      values.Append(*lent, vertex);
    }
  }

  ShownVertices& View;
  const std::size_t Number;
  const Piece& P;
  SurfacePart Part;
  std::vector<VertexId> PointOf; // of each vertex of the piece, or noVertex
  std::map<PieceId, const Piece*> Lenders;
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

// The numbers of parts' points in the whole surface.
class PointNumbers
{
public:
  explicit PointNumbers(const SurfacePartList& parts)
  {
    VertexId first = 0;
    for (const auto& part : parts)
    {
      this->Parts[part->piece] = { part.get(), first };
      first += static_cast<VertexId>(part->own.size());
    }
  }

  // Of each point of a part; noVertex where its owner does not show it, which is so only where
  // pieces contradict each other.
  std::vector<VertexId> Of(const SurfacePart& part) const
  {
    const VertexId first = this->Parts.at(part.piece).first;
    std::vector<VertexId> numbers(part.own.size());
    for (std::size_t i = 0; i < numbers.size(); ++i)
    {
      numbers[i] = first + static_cast<VertexId>(i);
    }
    for (const auto& [piece, vertex] : part.borrowed)
    {
      numbers.push_back(this->Find(piece, vertex));
    }
    return numbers;
  }

private:
  struct Numbered
  {
    const SurfacePart* part = nullptr;
    VertexId first = 0;
  };

  VertexId Find(PieceId piece, std::uint32_t vertex) const
  {
    const auto owner = this->Parts.find(piece);
    if (owner == this->Parts.end())
    {
      return noVertex;
    }
    const auto& own = owner->second.part->own;
    const auto place = std::lower_bound(own.begin(), own.end(), vertex);
    return place != own.end() && *place == vertex
             ? owner->second.first + static_cast<VertexId>(place - own.begin())
             : noVertex;
  }

  std::map<PieceId, Numbered> Parts;
};

// The arrays that all parts have, tuples of own points.
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

struct SurfaceParts::State
{
  ShownVertices view;
  std::map<PieceId, std::shared_ptr<const SurfacePart>> parts; // null: shows nothing
};

SurfaceParts::SurfaceParts()
  : Known(std::make_unique<State>())
{
}

SurfaceParts::~SurfaceParts() = default;
SurfaceParts::SurfaceParts(SurfaceParts&&) noexcept = default;
SurfaceParts& SurfaceParts::operator=(SurfaceParts&&) noexcept = default;

Status SurfaceParts::GoTo(const Cut& cut, const PieceLookup& lookup)
{
  auto pieces = FindPieces(cut, lookup);
  KDSTREAM_TRY(pieces);
  ShownVertices& view = this->Known->view;
  view.GoTo(cut, std::move(*pieces));
  auto before = std::exchange(this->Known->parts, {});
  this->All.clear();
  this->Drawn = 0;
  for (std::size_t i = 0; i < view.Pieces().size(); ++i)
  {
    const PieceId id = view.Pieces()[i]->id;
    auto& part = this->Known->parts[id];
    if (view.HasChanged(i))
    {
      part = PartDrawer(view, i).Draw();
      ++this->Drawn;
    }
    else
    {
      part = std::move(before[id]);
    }
    if (part)
    {
      this->All.push_back(part);
    }
  }
  return {};
}

Surface MergeParts(const SurfacePartList& parts)
{
  Surface whole;
  if (parts.empty())
  {
    return whole;
  }
  const PointNumbers numbers(parts);
  for (const auto& part : parts)
  {
    const auto count = static_cast<std::ptrdiff_t>(part->own.size());
    const Surface& surface = part->surface;
    whole.points.insert(whole.points.end(), surface.points.begin(), surface.points.begin() + count);
    whole.sources.insert(
      whole.sources.end(), surface.sources.begin(), surface.sources.begin() + count);
    const std::vector<VertexId> of = numbers.Of(*part);
    for (const Triangle& t : surface.triangles)
    {
      const Triangle moved{ of[t[0]], of[t[1]], of[t[2]] };
      if (moved[0] != noVertex && moved[1] != noVertex && moved[2] != noVertex)
      {
        whole.triangles.push_back(RotateLowestFirst(moved));
      }
    }
  }
  SortTriangles(whole.triangles, whole.points.size(), true);
  whole.attributes = MergeAttributes(parts);
  return whole;
}

}
