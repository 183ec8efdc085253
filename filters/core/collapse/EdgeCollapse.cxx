// SPDX-License-Identifier: BSD-3-Clause
// Edge collapse: see EdgeCollapse.h.
//   1. Find the triangles around each vertex, the edges, the boundary and the first candidates.
//   2. Take the cheapest candidate; skip it if an end has changed since.
//   3. Measure how far the surface would retreat; if this makes the merge more expensive, put the
//      candidate back with the new cost.
//   4. Refuse the merge if topology or normals forbid it.
//   5. Otherwise merge: remove the triangles on the edge, and move the others to the vertex that
//      stays.
//   6. Add new candidates around it; retry edges of its neighbours that were refused.
#include "filters/core/collapse/EdgeCollapse.h"

#include "filters/core/VectorMath.h"
#include "filters/core/collapse/EdgePlacement.h"

#include <algorithm>

namespace kdstream
{
namespace
{

// A place beside a boundary edge must have less than this share of the error on the edge.
constexpr double offBoundary = 0.25;
constexpr double lengthCost = 1e-9; // × length^4: among edges without cost, the shortest is first
// For edges between vertices of folds: the factors on the costs of their merges and of their
// retreat. Measured.
constexpr double costOfFoldOvers = 0.01, retreatOfFoldOvers = 0.1;
// For parts with vertex colours: a factor on the price of a retreat. Colours make other merges more
// expensive; without this factor the outline would retreat more instead. Measured on the vase.
constexpr double retreatOfColored = 4;
// The most retries of each vertex, for edges that could not collapse. Without this limit a tangled
// mesh, whose vertices have hundreds of edges each, would spend most of its time on edges that
// never collapse.
constexpr std::size_t mostRetries = 256;
// After this number of steps for each vertex and triangle of the part there are no more retries.
// Surfaces take up to 10 steps in large parts, and up to 70 in noisy parts of a few hundred
// vertices: hence the constant leastStepsOfRetries. Parts of a triangle soup took 100 to 400 steps,
// denser parts more. Retries took most of these, and led to hardly any merges.
constexpr std::uint64_t stepsOfRetries = 16, leastStepsOfRetries = std::uint64_t{ 1 } << 16;
// From then on, the part is given up if merges have taken more than this number of steps on
// average. Surfaces take 30 to 60. Parts where most edges are refused took 5,000 to 30,000, for one
// merge of thirty vertices. Tangles that can still become coarser take 500; they are grouped by
// cells instead, which is fast and looks no worse.
constexpr std::uint64_t mostStepsOfMerge = 256;

// Surfaces have two triangles for each vertex. More triangles than this for each vertex do not
// allow more steps.
constexpr std::size_t mostTrianglesOfVertex = 3;
// In parts of a triangle soup with more triangles for each vertex than this, nearly every edge is
// refused, after an expensive check of all triangles around it. There no edge is tried, unless the
// part has at most fewTriangles triangles.
constexpr std::size_t hopelessTrianglesOfVertex = 8, fewTriangles = 4096;

std::uint64_t MostStepsOfRetriesOf(std::size_t vertices, std::size_t triangles)
{
  return leastStepsOfRetries +
         stepsOfRetries * (vertices + std::min(triangles, mostTrianglesOfVertex * vertices));
}

bool IsTangle(std::size_t vertices, std::size_t triangles)
{
  return triangles > std::max(fewTriangles, hopelessTrianglesOfVertex * vertices);
}

// For two edges, side by side: the sum of the quadrics of both ends.
QuadraticForm<Lanes> SumsOf(
  const Quadric& a0, const Quadric& b0, const Quadric& a1, const Quadric& b1)
{
  QuadraticForm<Lanes> sums;
  for (std::size_t k = 0; k < 6; ++k)
  {
    sums.a[k] = Lanes(a0.a[k], a1.a[k]) + Lanes(b0.a[k], b1.a[k]);
  }
  for (std::size_t k = 0; k < 3; ++k)
  {
    sums.b[k] = Lanes(a0.b[k], a1.b[k]) + Lanes(b0.b[k], b1.b[k]);
  }
  sums.c = Lanes(a0.c, a1.c) + Lanes(b0.c, b1.c);
  return sums;
}

// The direction in which the triangles of each vertex face; empty if unknown.
std::vector<Vec3> FacingOfVertices(const CollapsePart& part)
{
  std::vector<Vec3> facing(part.normals.size());
  std::transform(
    part.normals.begin(), part.normals.end(), part.quadrics.begin(), facing.begin(), FacingOf);
  return facing;
}

// For each vertex whether a triangle around it faces the wrong way; empty if edges at folds are not
// made cheaper.
std::vector<std::uint8_t> FoldedOverVertices(const CollapsePart& part, std::span<const Vec3> facing)
{
  if (facing.empty() || part.fixed.empty())
  {
    return {};
  }
  std::vector<std::uint8_t> foldedOver(part.positions.size(), 0);
  for (const auto& [a, b, c] : part.triangles)
  {
    const Vec3 normal = Cross(
      Minus(part.positions[b], part.positions[a]), Minus(part.positions[c], part.positions[a]));
    if (Dot(normal, Plus(Plus(facing[a], facing[b]), facing[c])) < 0)
    {
      foldedOver[a] = foldedOver[b] = foldedOver[c] = 1;
    }
  }
  return foldedOver;
}

}

EdgeCollapse::EdgeCollapse(CollapsePart part)
  : Facing(FacingOfVertices(part))
  , FoldedOver(FoldedOverVertices(part, this->Facing))
  , Positions(std::move(part.positions))
  , Quadrics(std::move(part.quadrics))
  , Normals(std::move(part.normals))
  , Fixed(std::move(part.fixed))
  , Components(part.components)
  , Attributes(std::move(part.attributes))
  , ColorQuadrics(std::move(part.colorQuadrics))
  , Bounds(part.bounds)
  , KeepTopology(part.keepTopology)
  , AreaPerVertex(part.areaPerVertex * (this->ColorQuadrics.empty() ? 1 : retreatOfColored))
  , Stars(std::move(part.triangles), this->Positions.size())
  , MostStepsOfRetries(MostStepsOfRetriesOf(this->Positions.size(), this->Stars.TriangleCount()))
{
  const std::size_t n = this->Positions.size();
  this->Fixed.resize(n, 0);
  this->Boundary.assign(n, 0);
  this->Stamp.assign(n, 0);
  this->FirstRejection.assign(n, none);
  this->Retries.assign(n, 0);
  this->Mark.assign(n, 0);
  for (VertexId v = 0; v < n; ++v)
  {
    this->Vertices += !this->Fixed[v] && this->Stars.Degree(v) > 0;
  }
  if (!IsTangle(n, this->Stars.TriangleCount()))
  {
    this->FindEdges();
  }
}

// Whether both ends touch triangles that face the wrong way. Edges of this kind are cheaper in
// parts of fine levels, so that most folds disappear there. When a whole level collapses at once,
// this would remove the tips of limbs.
bool EdgeCollapse::IsFoldedOver(VertexId u, VertexId v) const
{
  return !this->FoldedOver.empty() && this->FoldedOver[u] != 0 && this->FoldedOver[v] != 0;
}

void EdgeCollapse::FindEdges()
{
  // All boundary vertices must be known first: they decide where a merged vertex goes.
  const std::vector<Edge> edges = this->FindBoundary();
  this->Candidates.Reserve(edges.size());
  for (const Edge& edge : edges)
  {
    this->Push(edge[0], edge[1]);
  }
  this->PushWaiting();
}

// Marks the vertices of the boundary; returns the edges without a fixed end.
std::vector<EdgeCollapse::Edge> EdgeCollapse::FindBoundary()
{
  std::vector<Edge> edges;
  edges.reserve(3 * this->Positions.size());
  std::vector<std::uint32_t> uses(this->Positions.size(), 0);
  std::vector<VertexId> neighbours;
  for (VertexId u = 0; u < this->Positions.size(); ++u)
  {
    if (this->Fixed[u])
    {
      continue;
    }
    neighbours.clear();
    const auto use = [&](VertexId w)
    {
      if (uses[w]++ == 0)
      {
        neighbours.push_back(w);
      }
    };
    this->Stars.ForEachSide(u,
      [&](const StarSide& side)
      {
        use(side.first);
        use(side.second);
      });
    for (const VertexId w : neighbours)
    {
      if (uses[w] == 1)
      {
        this->Boundary[u] = this->Boundary[w] = 1;
      }
      uses[w] = 0;
      if (w > u && !this->Fixed[w])
      {
        edges.push_back({ u, w });
      }
    }
  }
  return edges;
}

double EdgeCollapse::AttributeCost(VertexId u, VertexId v) const
{
  const double wu = this->Quadrics[u].Trace(), wv = this->Quadrics[v].Trace();
  if (this->Components == 0 || !(wu + wv > 0))
  {
    return 0;
  }
  double squares = 0;
  for (std::size_t k = 0; k < this->Components; ++k)
  {
    const double d = double(this->Attributes[u * this->Components + k]) -
                     double(this->Attributes[v * this->Components + k]);
    squares += d * d;
  }
  return wu * wv / (wu + wv) * squares;
}

// The sum of both ends' quadrics: of their planes, and of their colours.
Quadric EdgeCollapse::SumOf(VertexId u, VertexId v) const
{
  Quadric quadric = this->Quadrics[u];
  quadric.Add(this->Quadrics[v]);
  if (!this->ColorQuadrics.empty())
  {
    ColorQuadric sum = this->ColorQuadrics[u];
    sum.Add(this->ColorQuadrics[v]);
    quadric.Add(sum.Residual());
  }
  return quadric;
}

// The part of an edge's cost that does not depend on where the merged vertex goes.
double EdgeCollapse::LastingCost(VertexId u, VertexId v) const
{
  const Vec3 edge = Minus(this->Positions[v], this->Positions[u]);
  const double squaredLength = Dot(edge, edge);
  return this->AttributeCost(u, v) + lengthCost * squaredLength * squaredLength;
}

// Finds where the merged vertex goes, and the cost of that. Returns false if the cost is not a
// finite number.
bool EdgeCollapse::Place(VertexId u, VertexId v, double& cost, Vec3& position) const
{
  const Vec3 &a = this->Positions[u], &b = this->Positions[v];
  const Quadric quadric = this->SumOf(u, v);
  if (this->Boundary[u] != this->Boundary[v])
  {
    position = this->Boundary[u] ? a : b;
    cost = quadric.At(position);
  }
  else
  {
    // A merged vertex leaves a straight boundary only if the error is then much less: the surface
    // inside must not pull the boundary away.
    const PlacedVertex<double> placed =
      PlaceVertex<double>({ a, b, quadric, this->Boundary[u] ? offBoundary : 1 }, this->Bounds);
    position = placed.position;
    cost = placed.cost;
  }
  cost = (this->IsFoldedOver(u, v) ? costOfFoldOvers : 1) * (cost + this->LastingCost(u, v));
  return cost <= std::numeric_limits<double>::max();
}

// Makes an edge a candidate, now or when PushWaiting is called.
void EdgeCollapse::Push(VertexId u, VertexId v)
{
  if (this->Fixed[u] || this->Fixed[v] ||
      this->Stars.Degree(u) + this->Stars.Degree(v) > mostTriangles)
  {
    return;
  }
  ++this->Looked;
  if (u > v)
  {
    std::swap(u, v);
  }
  if (this->Boundary[u] != this->Boundary[v])
  {
    double cost = 0;
    Vec3 position;
    this->Place(u, v, cost, position);
    this->PushAt({ u, v }, cost);
    return;
  }
  this->Waiting[this->WaitingCount++] = { u, v };
  if (this->WaitingCount == this->Waiting.size())
  {
    this->PushWaiting();
  }
}

// Places the waiting edges together, and makes them candidates.
void EdgeCollapse::PushWaiting()
{
  if (this->WaitingCount == 0)
  {
    return;
  }
  const auto [u0, v0] = this->Waiting[0];
  const auto [u1, v1] = this->Waiting[this->WaitingCount - 1];
  EdgeToPlace<Lanes> edges;
  for (std::size_t k = 0; k < 3; ++k)
  {
    edges.a[k] = Lanes(this->Positions[u0][k], this->Positions[u1][k]);
    edges.b[k] = Lanes(this->Positions[v0][k], this->Positions[v1][k]);
  }
  edges.quadric =
    this->ColorQuadrics.empty()
      ? SumsOf(this->Quadrics[u0], this->Quadrics[v0], this->Quadrics[u1], this->Quadrics[v1])
      : SideBySide(this->SumOf(u0, v0), this->SumOf(u1, v1));
  edges.beside = Lanes(this->Boundary[u0] ? offBoundary : 1, this->Boundary[u1] ? offBoundary : 1);
  const PlacedVertex<Lanes> placed = PlaceVertex(edges, this->Bounds);
  for (std::size_t i = 0; i < this->WaitingCount; ++i)
  {
    const auto [u, v] = this->Waiting[i];
    this->PushAt({ u, v }, (this->IsFoldedOver(u, v) ? costOfFoldOvers : 1) *
                             (placed.cost[i] + this->LastingCost(u, v)));
  }
  this->WaitingCount = 0;
}

void EdgeCollapse::PushAt(const Edge& edge, double cost)
{
  if (cost <= std::numeric_limits<double>::max())
  {
    const auto [u, v] = edge;
    if (this->Candidates.IsFull())
    {
      this->Candidates.MakeRoom([&](const EdgeCandidate& other) { return this->IsCurrent(other); });
    }
    this->Candidates.Push({ cost, u, v, this->Stamp[u] + this->Stamp[v], false });
  }
}

bool EdgeCollapse::Run(std::size_t vertices, std::size_t triangles)
{
  return this->Take(vertices, triangles, std::numeric_limits<double>::infinity());
}

bool EdgeCollapse::RunBeyond(double error, std::size_t vertices)
{
  return this->Take(vertices, any, error);
}

// Both stamps only grow: an equal sum means that neither end has changed.
bool EdgeCollapse::IsCurrent(const EdgeCandidate& edge) const
{
  return this->Stamp[edge.u] + this->Stamp[edge.v] == edge.stamp && !this->Fixed[edge.u] &&
         !this->Fixed[edge.v];
}

// Whether nearly all of the checked edges cannot collapse.
bool EdgeCollapse::IsHopeless() const
{
  return !this->MayTryAgain() && this->Steps() > mostStepsOfMerge * this->Record.size();
}

// Takes candidates while there are too many vertices or triangles, and no merge has cost more than
// `error`.
bool EdgeCollapse::Take(std::size_t vertices, std::size_t triangles, double error)
{
  const auto isCurrent = [&](const EdgeCandidate& edge) { return this->IsCurrent(edge); };
  while ((this->Vertices > vertices || this->Stars.TriangleCount() > triangles) &&
         this->Largest <= error)
  {
    EdgeCandidate edge;
    if (this->IsHopeless() || !this->Candidates.Pop(edge, isCurrent))
    {
      return false;
    }
    double cost = 0;
    Vec3 position;
    this->Place(edge.u, edge.v, cost, position);
    if (!this->MayTryAgain() && this->TurnsAny(edge.u, edge.v, position))
    {
      continue; // never allowed, so its cost is not computed
    }
    this->Stars.Gather(edge.u, edge.v, this->Star);
    this->Merged.Set(this->Positions, this->Star, edge.u, edge.v, position);
    this->Looked += this->Star.sides.size() + this->Star.facing.size();
    if (!edge.measured && this->AreaPerVertex > 0)
    {
      const double scale =
        this->AreaPerVertex * (this->IsFoldedOver(edge.u, edge.v) ? retreatOfFoldOvers : 1);
      const double retreat = scale * this->Merged.SquaredRetreat(this->Positions, this->Star,
                                       edge.u, edge.v, scale, edge.cost);
      if (retreat > edge.cost)
      {
        this->Candidates.Push({ retreat, edge.u, edge.v, edge.stamp, true });
        continue;
      }
    }
    if (this->KeepsFacing(edge.u, edge.v, position) &&
        (!this->KeepTopology || this->KeepsTopology(edge.u, edge.v)))
    {
      this->Collapse(edge.u, edge.v, position, edge.cost);
    }
    else if (this->MayTryAgain())
    {
      this->Reject(edge);
    }
  }
  return true;
}

// Whether only triangles that faced the wrong way before turn their normals, and no triangle faces
// the wrong way that did not before.
bool EdgeCollapse::KeepsFacing(VertexId u, VertexId v, const Vec3& position)
{
  if (this->Normals.empty())
  {
    return this->Merged.KeepsNormals();
  }
  const bool keeps = this->Merged.KeepsNormals();
  this->FoldsOverAfter = false;
  for (std::size_t i = 0; i < this->Star.sides.size(); ++i)
  {
    const StarSide& side = this->Star.sides[i];
    const VertexId end = i < this->Star.ofU ? u : v;
    const Vec3 &p = this->Positions[end], &q = this->Positions[side.first],
               &r = this->Positions[side.second];
    if (!keeps && !MergedStar::TurnsNormal(p, q, r, position))
    {
      continue;
    }
    // Where the triangle should face: the sum of the known directions of its corners.
    const Vec3 reference =
      Plus(Plus(this->Facing[end], this->Facing[side.first]), this->Facing[side.second]);
    const bool rightAfter = Dot(Cross(Minus(q, position), Minus(r, position)), reference) >= 0;
    if (keeps && rightAfter)
    {
      continue; // most edges do
    }
    this->FoldsOverAfter |= !rightAfter;
    const bool wrongBefore = Dot(Cross(Minus(q, p), Minus(r, p)), reference) < 0;
    if (!wrongBefore || (!keeps && !rightAfter))
    {
      return false;
    }
  }
  return true;
}

// Whether the merge would turn the normal of any triangle; stops at the first.
bool EdgeCollapse::TurnsAny(VertexId u, VertexId v, const Vec3& position)
{
  const auto turnsAround = [&](VertexId end, VertexId other)
  {
    return this->Stars.AnySide(end,
      [&](const StarSide& side)
      {
        ++this->Looked;
        return side.first != other && side.second != other &&
               MergedStar::TurnsNormal(this->Positions[end], this->Positions[side.first],
                 this->Positions[side.second], position);
      });
  };
  return turnsAround(u, v) || turnsAround(v, u);
}

// The link condition: vertices and edges linked to both ends must be linked to the edge itself.
bool EdgeCollapse::KeepsTopology(VertexId u, VertexId v)
{
  if (this->Boundary[u] && this->Boundary[v] && this->Star.facing.size() != 1)
  {
    return false; // the collapse would pinch the boundary
  }
  const std::uint32_t nextToU = ++this->LastMark, facing = ++this->LastMark;
  for (std::size_t i = 0; i < this->Star.ofU; ++i)
  {
    this->Mark[this->Star.sides[i].first] = this->Mark[this->Star.sides[i].second] = nextToU;
  }
  for (const EdgeStar::Facing& corner : this->Star.facing)
  {
    this->Mark[corner.vertex] = facing;
  }
  for (std::size_t i = this->Star.ofU; i < this->Star.sides.size(); ++i)
  {
    const StarSide& side = this->Star.sides[i];
    if (this->Mark[side.first] == nextToU || this->Mark[side.second] == nextToU)
    {
      return false;
    }
  }
  return !this->ShareAnEdgeOpposite(facing);
}

// Whether some edge is in a triangle with u and in another triangle with v, and neither triangle
// holds both u and v. Both ends of such an edge face the edge u v, and are marked with `facing`.
// Mostly there are no edges of this kind, otherwise few.
bool EdgeCollapse::ShareAnEdgeOpposite(std::uint32_t facing) const
{
  const auto& sides = this->Star.sides;
  for (std::size_t i = 0; i < this->Star.ofU; ++i)
  {
    const auto [a, b, corner] = sides[i];
    if (this->Mark[a] != facing || this->Mark[b] != facing)
    {
      continue;
    }
    for (std::size_t k = this->Star.ofU; k < sides.size(); ++k)
    {
      if ((sides[k].first == a && sides[k].second == b) ||
          (sides[k].first == b && sides[k].second == a))
      {
        return true;
      }
    }
  }
  return false;
}

void EdgeCollapse::Reject(const EdgeCandidate& edge)
{
  const auto add = [&](VertexId v, VertexId other)
  {
    for (std::uint32_t i = this->FirstRejection[v]; i != none; i = this->Rejections[i].next)
    {
      ++this->Looked;
      if (this->Rejections[i].other == other)
      {
        this->Rejections[i].stamp = edge.stamp;
        return;
      }
    }
    this->Rejections.push_back({ other, edge.stamp, this->FirstRejection[v] });
    this->FirstRejection[v] = static_cast<std::uint32_t>(this->Rejections.size() - 1);
  };
  add(edge.u, edge.v);
  add(edge.v, edge.u);
}

void EdgeCollapse::Collapse(VertexId u, VertexId v, const Vec3& position, double cost)
{
  this->Largest = std::max(this->Largest, cost);
  this->Record.push_back({ this->Largest, v, u, position });
  this->MergeAttributes(u, v);
  this->Positions[u] = position;
  this->Quadrics[u].Add(this->Quadrics[v]);
  if (!this->ColorQuadrics.empty())
  {
    this->ColorQuadrics[u].Add(this->ColorQuadrics[v]);
  }
  if (!this->Normals.empty())
  {
    this->Normals[u] = Plus(this->Normals[u], this->Normals[v]);
    this->Facing[u] = FacingOf(this->Normals[u], this->Quadrics[u]);
    if (!this->FoldedOver.empty())
    {
      this->FoldedOver[u] = this->FoldsOverAfter ? 1 : 0;
    }
  }
  this->Boundary[u] |= this->Boundary[v];
  this->Retries[u] = std::max(this->Retries[u], this->Retries[v]);
  ++this->Stamp[u];
  ++this->Stamp[v];
  this->FirstRejection[u] = this->FirstRejection[v] = none;
  --this->Vertices;
  this->Stars.Merge(
    u, v, this->Star, [&](VertexId loose) { this->Vertices -= !this->Fixed[loose]; });
  this->PushAround(u);
}

void EdgeCollapse::MergeAttributes(VertexId u, VertexId v)
{
  const double wu = this->Quadrics[u].Trace(), wv = this->Quadrics[v].Trace();
  for (std::size_t k = 0; wu + wv > 0 && k < this->Components; ++k)
  {
    float& a = this->Attributes[u * this->Components + k];
    a = static_cast<float>(
      (wu * double(a) + wv * double(this->Attributes[v * this->Components + k])) / (wu + wv));
  }
}

// Adds candidates for the edges of a vertex that has just been merged, and for edges of its
// neighbours that could not collapse before.
void EdgeCollapse::PushAround(VertexId u)
{
  const std::uint32_t mark = ++this->LastMark;
  const auto visit = [&](VertexId w)
  {
    if (this->Mark[w] == mark)
    {
      return;
    }
    this->Mark[w] = mark;
    this->Push(u, w);
    if (this->FirstRejection[w] == none || this->Retries[w] >= mostRetries || !this->MayTryAgain())
    {
      return;
    }
    std::uint32_t next = this->FirstRejection[w];
    this->FirstRejection[w] = none;
    std::size_t retried = this->Retries[w];
    for (; next != none; next = this->Rejections[next].next)
    {
      ++retried;
      const Rejection rejected = this->Rejections[next];
      if (rejected.other != u && this->Stamp[w] + this->Stamp[rejected.other] == rejected.stamp)
      {
        this->Push(w, rejected.other);
      }
    }
    this->Retries[w] = static_cast<std::uint16_t>(std::min(mostRetries, retried));
  };
  for (const StarSide& side : this->Star.sides)
  {
    visit(side.first);
    visit(side.second);
  }
  this->PushWaiting();
}

}
