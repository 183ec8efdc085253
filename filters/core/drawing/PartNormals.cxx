// SPDX-License-Identifier: BSD-3-Clause
// Normals, part by part: see PartNormals.h.
//   1. For each part that differs: sum the triangles' area vectors at its points, including
//      borrowed ones.
//   2. For own points of these parts, and of the parts from which they borrow points: add the sums
//      of all parts.
//   3. Borrowed points get the sums of their owners.
#include "filters/core/drawing/PartNormals.h"

#include "filters/core/VectorMath.h"

#include <algorithm>
#include <utility>

namespace kdstream
{
namespace
{

// Calls visit(piece, begin, end) for each piece from which a part borrows points: [begin, end) of
// part.borrowed.
template <class Visit>
void ForEachLender(const SurfacePart& part, const Visit& visit)
{
  const auto& all = part.borrowed;
  for (std::size_t begin = 0; begin < all.size();)
  {
    const auto end =
      std::partition_point(all.begin() + static_cast<std::ptrdiff_t>(begin), all.end(),
        [&](const SurfacePart::Borrowed& other) { return other.piece <= all[begin].piece; });
    const auto last = static_cast<std::size_t>(end - all.begin());
    visit(all[begin].piece, begin, last);
    begin = last;
  }
}

// Calls visit(own, borrowed) for each point of [begin, end) that `part` borrows and `owner` shows:
// the point's numbers in both parts. Both ascend.
template <class Visit>
void ForEachLent(const SurfacePart& owner, const SurfacePart& part, std::size_t begin,
  std::size_t end, const Visit& visit)
{
  auto place = owner.own.begin();
  for (std::size_t i = begin; i < end; ++i)
  {
    const std::uint32_t vertex = part.borrowed[i].vertex;
    place = std::lower_bound(place, owner.own.end(), vertex);
    if (place != owner.own.end() && *place == vertex)
    {
      visit(static_cast<std::size_t>(place - owner.own.begin()), part.own.size() + i);
    }
  }
}

}

std::vector<Vec3> SumOfNormals(std::span<const Vec3> points, std::span<const Triangle> triangles)
{
  std::vector<Vec3> sums(points.size(), Vec3{});
  for (const Triangle& t : triangles)
  {
    const Vec3& origin = points[t[0]];
    const Vec3 normal = Cross(Minus(points[t[1]], origin), Minus(points[t[2]], origin));
    for (const VertexId corner : t)
    {
      sums[corner] = Plus(sums[corner], normal);
    }
  }
  return sums;
}

void PartNormals::GoTo(const SurfacePartList& parts)
{
  this->TakeParts(parts);
  for (const auto& known : this->Numbered)
  {
    if (known->due)
    {
      SumUp(*known);
    }
  }
  this->All.clear();
  for (const auto& known : this->Numbered)
  {
    this->All.push_back(this->Spread(*known));
  }
  for (std::size_t i = 0; i < this->Numbered.size(); ++i)
  {
    Known& known = *this->Numbered[i];
    known.normals = this->All[i];
    known.own = {};
    known.due = false;
  }
}

// Marks the parts whose sums may change: parts that differ from before, and parts from which these
// borrow points, now or before.
void PartNormals::TakeParts(const SurfacePartList& parts)
{
  std::vector<std::unique_ptr<Known>> before = std::exchange(this->Numbered, {});
  auto next = before.begin(); // both ascend
  std::vector<std::shared_ptr<const SurfacePart>> gone;
  for (const auto& part : parts)
  {
    for (; next != before.end() && (*next)->part->piece < part->piece; ++next)
    {
      gone.push_back((*next)->part);
    }
    if (next != before.end() && (*next)->part == part)
    {
      this->Numbered.push_back(std::move(*next++));
      Known& known = *this->Numbered.back();
      known.isNew = known.due = known.ownChanged = false;
      known.borrowers.clear();
      continue;
    }
    this->Numbered.push_back(std::make_unique<Known>());
    this->Numbered.back()->part = part;
    this->Numbered.back()->given = SumOfNormals(part->surface.points, part->surface.triangles);
  }
  for (; next != before.end(); ++next)
  {
    gone.push_back((*next)->part);
  }
  for (const auto& part : gone)
  {
    this->AskLendersOf(*part);
  }
  for (const auto& known : this->Numbered)
  {
    if (known->isNew)
    {
      this->AskLendersOf(*known->part);
    }
    ForEachLender(*known->part,
      [&](PieceId piece, std::size_t, std::size_t)
      {
        if (Known* lender = this->Find(piece))
        {
          lender->borrowers.push_back(known.get());
        }
      });
  }
}

void PartNormals::AskLendersOf(const SurfacePart& part)
{
  ForEachLender(part,
    [this](PieceId piece, std::size_t, std::size_t)
    {
      if (Known* lender = this->Find(piece))
      {
        lender->due = true;
      }
    });
}

void PartNormals::SumUp(Known& known)
{
  const SurfacePart& part = *known.part;
  std::vector<Vec3> own(
    known.given.begin(), known.given.begin() + static_cast<std::ptrdiff_t>(part.own.size()));
  for (const Known* borrower : known.borrowers)
  {
    const auto& borrowed = borrower->part->borrowed;
    const auto [first, last] =
      std::equal_range(borrowed.begin(), borrowed.end(), SurfacePart::Borrowed{ part.piece, 0 },
        [](const auto& a, const auto& b) { return a.piece < b.piece; });
    ForEachLent(part, *borrower->part, static_cast<std::size_t>(first - borrowed.begin()),
      static_cast<std::size_t>(last - borrowed.begin()),
      [&](std::size_t to, std::size_t from) { own[to] = Plus(own[to], borrower->given[from]); });
  }
  known.ownChanged = known.isNew || !std::equal(own.begin(), own.end(), known.normals->begin());
  known.own = std::move(own);
}

// The normals of all points of a part; the previous object if neither own nor borrowed ones have
// changed.
PartNormals::Normals PartNormals::Spread(const Known& known) const
{
  const SurfacePart& part = *known.part;
  bool changed = known.ownChanged;
  ForEachLender(part,
    [&](PieceId piece, std::size_t, std::size_t)
    {
      const Known* owner = this->Find(piece);
      changed |= owner && owner->ownChanged;
    });
  if (!changed)
  {
    return known.normals;
  }
  std::vector<Vec3> normals(part.surface.points.size(), Vec3{});
  for (std::size_t i = 0; i < part.own.size(); ++i)
  {
    normals[i] = known.SumOf(i);
  }
  ForEachLender(part,
    [&](PieceId piece, std::size_t begin, std::size_t end)
    {
      if (const Known* owner = this->Find(piece))
      {
        ForEachLent(*owner->part, part, begin, end,
          [&](std::size_t from, std::size_t to) { normals[to] = owner->SumOf(from); });
      }
    });
  return known.normals && *known.normals == normals
           ? known.normals
           : std::make_shared<const std::vector<Vec3>>(std::move(normals));
}

PartNormals::Known* PartNormals::Find(PieceId piece) const
{
  const auto place = std::partition_point(this->Numbered.begin(), this->Numbered.end(),
    [piece](const auto& known) { return known->part->piece < piece; });
  return place != this->Numbered.end() && (*place)->part->piece == piece ? place->get() : nullptr;
}

}
