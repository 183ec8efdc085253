// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/collapse/VertexStars.h"

namespace kdstream
{

VertexStars::VertexStars(std::vector<Triangle> triangles, std::size_t vertices)
  : Triangles(std::move(triangles))
  , First(vertices, none)
  , Next(3 * this->Triangles.size())
  , Degrees(vertices, 0)
  , Live(this->Triangles.size())
{
  for (std::size_t t = this->Triangles.size(); t-- > 0;)
  {
    for (std::size_t k = 3; k-- > 0;)
    {
      const VertexId v = this->Triangles[t][k];
      const auto corner = static_cast<Corner>(3 * t + k);
      this->Next[corner] = this->First[v];
      this->First[v] = corner;
      ++this->Degrees[v];
    }
  }
}

void VertexStars::Gather(VertexId u, VertexId v, EdgeStar& star) const
{
  star.sides.clear();
  star.facing.clear();
  this->ForEachSide(u,
    [&](const StarSide& side)
    {
      const std::uint32_t place = side.corner % 3;
      const Corner triangle = side.corner - place;
      if (side.first == v)
      {
        star.facing.push_back({ side.second, triangle + (place == 0 ? 2 : place - 1) });
      }
      else if (side.second == v)
      {
        star.facing.push_back({ side.first, triangle + (place == 2 ? 0 : place + 1) });
      }
      else
      {
        star.sides.push_back(side);
      }
    });
  star.ofU = star.sides.size();
  this->ForEachSide(v,
    [&](const StarSide& side)
    {
      if (side.first != u && side.second != u)
      {
        star.sides.push_back(side);
      }
    });
}

// Removes a corner of a removed triangle from its vertex's list.
void VertexStars::Unlink(VertexId v, Corner corner)
{
  const std::uint32_t left = --this->Degrees[v];
  if (left >= manyTriangles)
  {
    if (left == manyTriangles)
    {
      this->DropGone(v);
    }
    return;
  }
  Corner* at = &this->First[v];
  while (*at != corner)
  {
    ++this->Passed;
    at = &this->Next[*at];
  }
  *at = this->Next[corner];
}

void VertexStars::DropGone(VertexId v)
{
  Corner* end = &this->First[v];
  for (Corner corner = this->First[v]; corner != none; corner = this->Next[corner])
  {
    ++this->Passed;
    if (!IsGone(this->SideAt(corner)))
    {
      *end = corner;
      end = &this->Next[corner];
    }
  }
  *end = none;
}

}
