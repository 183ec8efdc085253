// SPDX-License-Identifier: BSD-3-Clause
// Ear clipping (G. H. Meisters, "Polygons have ears", 1975). Steps:
// 1. Make a fan, if that is good enough.
// 2. Project the corners onto a plane.
// 3. Put the corners that turn against the polygon (dents) into a k-d tree.
// 4. Cut ears, in rounds: a corner whose triangle holds a dent waits until the dent is gone. Only
//    dents need to be tested: if a part of the polygon reaches into the triangle of a convex
//    corner, the corner of this part that is farthest from the cut is a dent.
#include "filters/core/CutPolygon.h"

#include "filters/core/VectorMath.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{

constexpr std::uint32_t none = 0xffffffff;
constexpr std::size_t leafCorners = 8;
constexpr double smallestDent = 1e-6; // of the polygon's area

// Twice the area vector of the fan's triangle that ends at corner i.
Vec3 FanPart(std::span<const Vec3> corners, std::size_t i)
{
  return Cross(Minus(corners[i - 1], corners[0]), Minus(corners[i], corners[0]));
}

Vec3 NewellNormal(std::span<const Vec3> corners)
{
  Vec3 normal{};
  for (std::size_t i = 2; i < corners.size(); ++i)
  {
    normal = Plus(normal, FanPart(corners, i));
  }
  return normal;
}

// Whether a fan is good enough: its triangles all face the way that the polygon does, up to
// smallestDent; or the polygon has no normal.
bool FanServes(std::span<const Vec3> corners, const Vec3& normal)
{
  const double area = Dot(normal, normal);
  if (!std::isfinite(area) || area == 0)
  {
    return true;
  }
  double against = 0;
  for (std::size_t i = 2; i < corners.size(); ++i)
  {
    against -= std::min(0.0, Dot(FanPart(corners, i), normal));
  }
  return against <= smallestDent * area;
}

}

std::span<const Triangle> PolygonCutter::Cut(std::span<const Vec3> corners)
{
  this->Triangles.clear();
  this->Fan = corners.size() <= 3 || !this->Project(corners);
  if (this->Fan)
  {
    this->AddFan(corners.size());
  }
  else
  {
    this->CutEars();
  }
  return this->Triangles;
}

void PolygonCutter::AddFan(std::size_t count)
{
  for (std::size_t i = 2; i < count; ++i)
  {
    this->Triangles.push_back({ 0, static_cast<VertexId>(i - 1), static_cast<VertexId>(i) });
  }
}

// Projects the corners onto a plane of two axes, which keeps the orientation, and is exact for
// polygons in a plane of this kind. Returns false if a fan is good enough.
bool PolygonCutter::Project(std::span<const Vec3> corners)
{
  const Vec3 normal = NewellNormal(corners);
  if (FanServes(corners, normal))
  {
    return false;
  }
  std::size_t k = 0;
  for (std::size_t other = 1; other < 3; ++other)
  {
    k = std::abs(normal[other]) > std::abs(normal[k]) ? other : k;
  }
  std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
  if (normal[k] < 0)
  {
    std::swap(i, j);
  }
  const double slopeI = normal[i] / normal[k], slopeJ = normal[j] / normal[k];
  this->Points.clear();
  for (const Vec3& corner : corners)
  {
    const Vec3 p = Minus(corner, corners[0]);
    this->Points.push_back({ p[i] - slopeI * p[k], p[j] - slopeJ * p[k] });
  }
  return true;
}

namespace
{

// Twice the area of the triangle a, b, c; above 0 if it is counter-clockwise.
template <class Point>
double AreaOf(const Point& a, const Point& b, const Point& c)
{
  return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
}

}

void PolygonCutter::CutEars()
{
  this->Start();
  for (const Rule rule : { Rule::Clear, Rule::Inside, Rule::Any })
  {
    std::uint32_t corner = this->Some;
    for (std::size_t i = 0; i < this->Left; ++i, corner = this->Next[corner])
    {
      this->Queue(corner);
    }
    this->CutQueued(rule);
  }
  this->FanRest();
}

void PolygonCutter::Start()
{
  const std::size_t count = this->Points.size();
  this->Left = count;
  this->Some = 0;
  this->Previous.resize(count);
  this->Next.resize(count);
  for (std::size_t i = 0; i < count; ++i)
  {
    this->Previous[i] = static_cast<std::uint32_t>(i == 0 ? count - 1 : i - 1);
    this->Next[i] = static_cast<std::uint32_t>(i + 1 == count ? 0 : i + 1);
  }
  this->BatchNumber = 0;
  this->TouchedIn.assign(count, none);
  this->Queued.assign(count, false);
  this->NextBatch.clear();
  this->FirstWaiting.assign(count, none);
  this->Waitings.clear();
  this->BuildTree();
}

double PolygonCutter::Turn(std::uint32_t corner) const
{
  return AreaOf(
    this->Points[this->Previous[corner]], this->Points[corner], this->Points[this->Next[corner]]);
}

void PolygonCutter::Queue(std::uint32_t corner)
{
  if (!this->Queued[corner])
  {
    this->Queued[corner] = true;
    this->NextBatch.push_back(corner);
  }
}

// A round visits every corner once, but not the neighbours of corners that it has cut. They are
// visited in the next round, so that triangles grow evenly instead of becoming slivers.
void PolygonCutter::CutQueued(Rule rule)
{
  while (!this->NextBatch.empty() && this->Left > 3)
  {
    std::swap(this->Batch, this->NextBatch);
    this->NextBatch.clear();
    for (const std::uint32_t corner : this->Batch)
    {
      this->Queued[corner] = false;
    }
    ++this->BatchNumber;
    for (const std::uint32_t corner : this->Batch)
    {
      if (this->Next[corner] == none || this->Left <= 3)
      {
        continue; // this corner was cut off already
      }
      if (this->TouchedIn[corner] == this->BatchNumber)
      {
        this->Queue(corner);
      }
      else if (this->IsEar(corner, rule))
      {
        this->CutOff(corner);
      }
    }
  }
  for (const std::uint32_t corner : this->NextBatch)
  {
    this->Queued[corner] = false;
  }
  this->NextBatch.clear();
}

bool PolygonCutter::IsEar(std::uint32_t corner, Rule rule)
{
  const double turn = this->Turn(corner);
  if (turn == 0 && rule != Rule::Clear)
  {
    return true; // its triangle has no area
  }
  if (!(turn > 0) || rule == Rule::Any)
  {
    return turn > 0;
  }
  const std::uint32_t dent =
    this->FindDent({ this->Previous[corner], corner, this->Next[corner] }, rule == Rule::Clear);
  if (dent != none)
  {
    this->Waitings.push_back({ corner, this->FirstWaiting[dent] });
    this->FirstWaiting[dent] = static_cast<std::uint32_t>(this->Waitings.size() - 1);
  }
  return dent == none;
}

void PolygonCutter::CutOff(std::uint32_t corner)
{
  const std::uint32_t before = this->Previous[corner], after = this->Next[corner];
  this->Triangles.push_back({ before, corner, after });
  this->Next[before] = after;
  this->Previous[after] = before;
  this->Next[corner] = none;
  this->RemoveDent(corner);
  this->Some = after;
  --this->Left;
  for (const std::uint32_t neighbour : { before, after })
  {
    this->TouchedIn[neighbour] = this->BatchNumber;
    this->Queue(neighbour);
    if (this->Turn(neighbour) > 0)
    {
      this->RemoveDent(neighbour);
    }
  }
}

// Makes a fan of the rest, which no rule cuts: three corners, or a polygon without area.
void PolygonCutter::FanRest()
{
  std::uint32_t second = this->Next[this->Some];
  for (std::size_t i = 2; i < this->Left; ++i)
  {
    const std::uint32_t third = this->Next[second];
    this->Triangles.push_back({ this->Some, second, third });
    second = third;
  }
}

// --- The tree of dents ---------------------------------------------------------------------------

void PolygonCutter::BuildTree()
{
  const std::size_t count = this->Points.size();
  this->Dents.clear();
  this->PlaceOf.assign(count, none);
  for (std::size_t i = 0; i < count; ++i)
  {
    if (!(this->Turn(static_cast<std::uint32_t>(i)) > 0))
    {
      this->Dents.push_back(static_cast<std::uint32_t>(i));
    }
  }
  std::size_t nodes = 2;
  for (std::size_t leaf = this->Dents.size(); leaf > leafCorners; leaf = (leaf + 1) / 2)
  {
    nodes *= 2;
  }
  this->Nodes.assign(nodes, {});
  this->BuildNode(1, 0, this->Dents.size());
  for (std::size_t i = 0; i < this->Dents.size(); ++i)
  {
    this->PlaceOf[this->Dents[i]] = static_cast<std::uint32_t>(i);
  }
}

void PolygonCutter::BuildNode(std::size_t node, std::size_t begin, std::size_t end)
{
  Node& made = this->Nodes[node];
  made.dents = static_cast<std::uint32_t>(end - begin);
  if (begin == end)
  {
    return;
  }
  made.lo = made.hi = this->Points[this->Dents[begin]];
  for (std::size_t i = begin; i < end; ++i)
  {
    const Point& p = this->Points[this->Dents[i]];
    made.lo = { std::min(made.lo.u, p.u), std::min(made.lo.v, p.v) };
    made.hi = { std::max(made.hi.u, p.u), std::max(made.hi.v, p.v) };
  }
  if (2 * node >= this->Nodes.size())
  {
    return;
  }
  const bool wide = made.hi.u - made.lo.u >= made.hi.v - made.lo.v;
  const std::size_t middle = begin + (end - begin + 1) / 2;
  const auto at = [this](std::size_t i)
  { return this->Dents.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(std::min(middle, end - 1)), at(end),
    [&](std::uint32_t a, std::uint32_t b)
    {
      const Point &p = this->Points[a], &q = this->Points[b];
      return wide ? p.u < q.u : p.v < q.v;
    });
  this->BuildNode(2 * node, begin, middle);
  this->BuildNode(2 * node + 1, middle, end);
}

// The corners that this dent kept from being ears are examined again.
void PolygonCutter::RemoveDent(std::uint32_t corner)
{
  const std::uint32_t place = this->PlaceOf[corner];
  if (place == none)
  {
    return;
  }
  this->PlaceOf[corner] = none;
  std::size_t begin = 0, end = this->Dents.size();
  for (std::size_t node = 1; node < this->Nodes.size();)
  {
    --this->Nodes[node].dents;
    const std::size_t middle = begin + (end - begin + 1) / 2;
    const bool second = place >= middle;
    (second ? begin : end) = middle;
    node = 2 * node + (second ? 1 : 0);
  }
  for (std::uint32_t i = this->FirstWaiting[corner]; i != none; i = this->Waitings[i].next)
  {
    if (this->Next[this->Waitings[i].corner] != none)
    {
      this->Queue(this->Waitings[i].corner);
    }
  }
  this->FirstWaiting[corner] = none;
}

// Whether the node's box and the triangle can have a point in common.
bool PolygonCutter::IsOver(const Node& node, const std::array<Point, 3>& triangle) const
{
  if (node.dents == 0)
  {
    return false;
  }
  const auto& [a, b, c] = triangle;
  if (std::max({ a.u, b.u, c.u }) < node.lo.u || std::min({ a.u, b.u, c.u }) > node.hi.u ||
      std::max({ a.v, b.v, c.v }) < node.lo.v || std::min({ a.v, b.v, c.v }) > node.hi.v)
  {
    return false;
  }
  for (std::size_t i = 0; i < 3; ++i)
  {
    const Point &p = triangle[i], &q = triangle[(i + 1) % 3];
    // The box's corner that is farthest to the side's left, where the triangle is.
    const Point farthest{ q.v > p.v ? node.lo.u : node.hi.u, q.u > p.u ? node.hi.v : node.lo.v };
    if (AreaOf(p, q, farthest) < 0)
    {
      return false;
    }
  }
  return true;
}

std::uint32_t PolygonCutter::FindDent(
  const std::array<std::uint32_t, 3>& triangle, bool onBorder) const
{
  const std::array<Point, 3> corners{ this->Points[triangle[0]], this->Points[triangle[1]],
    this->Points[triangle[2]] };
  const auto forbids = [&](std::uint32_t dent)
  {
    const Point& p = this->Points[dent];
    if (this->PlaceOf[dent] == none ||
        std::find(corners.begin(), corners.end(), p) != corners.end())
    {
      return false; // in the same place, for example where a bridge to a hole ends
    }
    const double least = std::min({ AreaOf(corners[0], corners[1], p),
      AreaOf(corners[1], corners[2], p), AreaOf(corners[2], corners[0], p) });
    return onBorder ? least >= 0 : least > 0;
  };
  struct Range
  {
    std::size_t node, begin, end;
  };
  std::array<Range, 64> stack;
  std::size_t depth = 0;
  stack[depth++] = { 1, 0, this->Dents.size() };
  while (depth > 0)
  {
    const Range range = stack[--depth];
    if (!this->IsOver(this->Nodes[range.node], corners))
    {
      continue;
    }
    if (2 * range.node < this->Nodes.size())
    {
      const std::size_t middle = range.begin + (range.end - range.begin + 1) / 2;
      stack[depth++] = { 2 * range.node + 1, middle, range.end };
      stack[depth++] = { 2 * range.node, range.begin, middle };
      continue;
    }
    for (std::size_t i = range.begin; i < range.end; ++i)
    {
      if (forbids(this->Dents[i]))
      {
        return this->Dents[i];
      }
    }
  }
  return none;
}

}
