// SPDX-License-Identifier: BSD-3-Clause
// The drawing rule: see Surface.h.
//   1. The pieces that take part (Cut.h), and where the cut shows their vertices (ShownVertices.h).
//   2. The points they show: own vertices that are in the cut.
//   3. Each triangle of these pieces: drawn if a vertex is in the cut and none above it; the others
//   move up.
#include "filters/core/drawing/Surface.h"

#include "filters/core/SortTriangles.h"
#include "filters/core/drawing/ShownVertices.h"

#include <algorithm>
#include <string>
#include <utility>

namespace kdstream
{
namespace
{

// The triangles in ascending order, each once. The lowest index of a triangle comes first, and few
// triangles share it: so they go into a bucket for each lowest index, and two or three are left to
// sort in a bucket. O(triangles + points), unless some points have very many triangles.
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

class Drawer
{
public:
  explicit Drawer(ShownVertices& view)
    : View(view)
    , ByPiece(view.Pieces().size())
  {
  }

  Surface Draw()
  {
    for (std::size_t i = 0; i < this->ByPiece.size(); ++i)
    {
      this->AddPoints(i);
    }
    for (std::size_t i = 0; i < this->ByPiece.size(); ++i)
    {
      this->AddTriangles(i);
    }
    this->AddAttributes();
    this->Output.triangles =
      SortedWithoutRepeats(this->Output.triangles, this->Output.points.size());
    return std::move(this->Output);
  }

private:
  struct Shown // the points of one piece that the surface shows
  {
    const Piece* piece = nullptr;
    bool any = false;
    std::vector<VertexId> point; // of each own vertex, or noVertex
  };

  void AddPoints(std::size_t i)
  {
    const Piece& piece = *this->View.Pieces()[i];
    Shown& shown = this->ByPiece[i];
    shown.piece = &piece;
    shown.point.assign(piece.ownVertices, noVertex);
    for (std::uint32_t v = 0; v < piece.ownVertices; ++v)
    {
      if (this->View.ShownAt(i, v) == piece.id.resolution)
      {
        shown.point[v] = static_cast<VertexId>(this->Output.points.size());
        shown.any = true;
        this->Output.points.push_back(piece.positions[v]);
        this->Output.sources.push_back({ piece.id.resolution, piece.keys[v] });
      }
    }
  }

  void AddTriangles(std::size_t i)
  {
    const Piece& piece = *this->View.Pieces()[i];
    // Where each vertex of the piece goes: a point, or nowhere because it lies above the cut.
    std::vector<VertexId> target(piece.VertexCount(), noVertex);
    std::vector<std::uint8_t> itself(piece.VertexCount(), 0);
    for (std::uint32_t v = 0; v < piece.VertexCount(); ++v)
    {
      itself[v] = this->View.ShownAt(i, v) == piece.id.resolution;
      if (const auto node = this->View.NodeAbove(i, v))
      {
        target[v] = this->ByPiece[node->piece].point[node->vertex];
      }
    }
    for (const Triangle& t : piece.triangles)
    {
      const Triangle moved{ target[t[0]], target[t[1]], target[t[2]] };
      const bool any = itself[t[0]] || itself[t[1]] || itself[t[2]];
      const bool whole = moved[0] != noVertex && moved[1] != noVertex && moved[2] != noVertex;
      if (any && whole && moved[0] != moved[1] && moved[1] != moved[2] && moved[2] != moved[0])
      {
        this->Output.triangles.push_back(RotateLowestFirst(moved));
      }
    }
  }

  // The point arrays that all pieces with a point have, tuples in the order of the points.
  void AddAttributes()
  {
    std::vector<const Shown*> showing;
    for (const Shown& shown : this->ByPiece)
    {
      if (shown.any)
      {
        showing.push_back(&shown);
      }
    }
    if (showing.empty())
    {
      return;
    }
    for (const Attribute& array : showing.front()->piece->attributes)
    {
      Attribute values{ array.Info(), {} };
      const bool all = array.association == AttributeAssociation::Point &&
                       std::all_of(showing.begin(), showing.end(),
                         [&](const Shown* shown) { return AppendShown(*shown, values); });
      if (all)
      {
        this->Output.attributes.push_back(std::move(values));
      }
    }
  }

  // False where the piece has no such array.
  static bool AppendShown(const Shown& shown, Attribute& values)
  {
    const Attribute* array = FindAttribute(shown.piece->attributes, values);
    for (std::uint32_t v = 0; array && v < shown.piece->ownVertices; ++v)
    {
      if (shown.point[v] != noVertex)
      {
        values.Append(*array, v);
      }
    }
    return array != nullptr;
  }

  ShownVertices& View;
  std::vector<Shown> ByPiece;
  Surface Output;
};

}

Result<Surface> DrawSurface(const Cut& cut, const PieceLookup& lookup)
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
  ShownVertices view(cut, std::move(pieces));
  return Drawer(view).Draw();
}

}
