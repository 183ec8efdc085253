// Edge collapse: see EdgeCollapse.h.
//   1. The corners of each vertex in a list; edges, boundary, the first candidates.
//   2. Take the cheapest candidate; skip it where an end has changed since.
//   3. Measure how far the surface goes back: where that is dearer put it back at that cost.
//   4. Leave it where topology or normals forbid it.
//   5. Else merge: triangles on the edge go, the others move over to the vertex that stays.
//   6. Candidates anew around it; what neighbours had left is tried again.
#include "filters/core/EdgeCollapse.h"

#include "filters/core/TriangleDistance.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{

constexpr double regularisation = 1e-3; // of the quadric's trace; measured in the prototype
constexpr double flipCosine = 0.2;      // a normal may turn by 78°
constexpr double reach = 2; // how many lengths of the edge the vertex may go from its middle
constexpr double offBoundary = 0.25; // of the error on the edge, for a place beside it
constexpr double lengthCost = 1e-9;  // × length^4: of edges that cost nothing the shortest first
constexpr std::uint8_t mostRetries = 64; // of the edges that a vertex could not collapse

Vec3 NormalOf(const Vec3& a, const Vec3& b, const Vec3& c)
{
  const Vec3 u = Minus(b, a), v = Minus(c, a);
  return { u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0] };
}

bool Has(const Triangle& t, VertexId v)
{
  return t[0] == v || t[1] == v || t[2] == v;
}

}

bool EdgeCollapse::Later::operator()(const Candidate& a, const Candidate& b) const
{
  if (a.cost != b.cost)
  {
    return a.cost > b.cost;
  }
  if (a.u != b.u)
  {
    return a.u > b.u;
  }
  return a.v != b.v ? a.v > b.v : a.stamp > b.stamp;
}

EdgeCollapse::EdgeCollapse(CollapsePart part)
  : Positions(std::move(part.positions))
  , Quadrics(std::move(part.quadrics))
  , Fixed(std::move(part.fixed))
  , Triangles(std::move(part.triangles))
  , Components(part.components)
  , Attributes(std::move(part.attributes))
  , Bounds(part.bounds)
  , KeepTopology(part.keepTopology)
  , AreaPerVertex(part.areaPerVertex)
{
  const std::size_t n = this->Positions.size();
  this->Fixed.resize(n, 0);
  this->DeadTriangle.assign(this->Triangles.size(), 0);
  this->Degree.assign(n, 0);
  this->Boundary.assign(n, 0);
  this->Stamp.assign(n, 0);
  this->FirstRejection.assign(n, none);
  this->Retries.assign(n, 0);
  this->Mark.assign(n, 0);
  this->LiveTriangles = this->Triangles.size();
  this->LinkCorners();
  this->FindEdges();
}

void EdgeCollapse::LinkCorners()
{
  this->FirstCorner.assign(this->Positions.size(), none);
  this->NextCorner.resize(3 * this->Triangles.size());
  for (std::size_t t = this->Triangles.size(); t-- > 0;)
  {
    for (std::size_t k = 3; k-- > 0;)
    {
      const VertexId v = this->Triangles[t][k];
      const auto corner = static_cast<Corner>(3 * t + k);
      this->NextCorner[corner] = this->FirstCorner[v];
      this->FirstCorner[v] = corner;
      ++this->Degree[v];
    }
  }
}

// Calls visit(triangle number) for the live triangles of a vertex.
template <class Visit>
void EdgeCollapse::ForEachTriangle(VertexId v, const Visit& visit) const
{
  for (Corner c = this->FirstCorner[v]; c != none; c = this->NextCorner[c])
  {
    if (!this->DeadTriangle[c / 3])
    {
      visit(c / 3);
    }
  }
}

void EdgeCollapse::FindEdges()
{
  std::vector<std::uint32_t> uses(this->Positions.size(), 0);
  this->Heap.reserve(this->Triangles.size() * 2);
  for (VertexId u = 0; u < this->Positions.size(); ++u)
  {
    if (this->Fixed[u])
    {
      continue;
    }
    this->Vertices += this->Degree[u] > 0;
    this->Scratch.clear();
    this->ForEachTriangle(u,
      [&](std::uint32_t t)
      {
        for (const VertexId w : this->Triangles[t])
        {
          if (w != u && uses[w]++ == 0)
          {
            this->Scratch.push_back(w);
          }
        }
      });
    for (const VertexId w : this->Scratch)
    {
      if (uses[w] == 1)
      {
        this->Boundary[u] = this->Boundary[w] = 1;
      }
      uses[w] = 0;
    }
  }
  // Boundary vertices are all known only now; they decide where a merged vertex goes.
  for (VertexId u = 0; u < this->Positions.size(); ++u)
  {
    if (!this->Fixed[u])
    {
      this->CollectEdges(u);
      for (const VertexId w : this->Scratch)
      {
        if (w > u)
        {
          this->Push(u, w);
        }
      }
    }
  }
  std::make_heap(this->Heap.begin(), this->Heap.end(), Later{});
}

// The neighbours of a vertex into Scratch, each once.
void EdgeCollapse::CollectEdges(VertexId u)
{
  this->Scratch.clear();
  const std::uint32_t mark = ++this->LastMark;
  this->ForEachTriangle(u,
    [&](std::uint32_t t)
    {
      for (const VertexId w : this->Triangles[t])
      {
        if (w != u && this->Mark[w] != mark)
        {
          this->Mark[w] = mark;
          this->Scratch.push_back(w);
        }
      }
    });
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

// The best place on the edge itself.
Vec3 EdgeCollapse::LeastOnEdge(const Quadric& quadric, const Vec3& a, const Vec3& b) const
{
  const Vec3 middle{ (a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2 };
  // A parabola through the errors at the ends and in the middle.
  const double atA = quadric.At(a), atB = quadric.At(b), atMiddle = quadric.At(middle);
  const double curvature = atA + atB - 2 * atMiddle;
  const double t = curvature > 0 ? 0.5 + (atA - atB) / (4 * curvature) : 0.5;
  const Vec3 best = t > 0 && t < 1 ? Vec3{ a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]),
    a[2] + t * (b[2] - a[2]) }
                                   : middle;
  const double least = quadric.At(best);
  return least < atA && least < atB ? best : atA <= atB ? a : b;
}

// Where the merged vertex goes, and what that costs. False where no number comes out.
bool EdgeCollapse::Evaluate(VertexId u, VertexId v, double& cost, Vec3& position) const
{
  const Vec3 &a = this->Positions[u], &b = this->Positions[v];
  Quadric quadric = this->Quadrics[u];
  quadric.Add(this->Quadrics[v]);
  const Vec3 edge = Minus(b, a);
  const double squaredLength = Dot(edge, edge);
  if (this->Boundary[u] != this->Boundary[v])
  {
    position = this->Boundary[u] ? a : b;
    cost = quadric.At(position);
  }
  else
  {
    position = this->LeastOnEdge(quadric, a, b);
    cost = quadric.At(position);
    const Vec3 middle{ (a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2 };
    Vec3 least = quadric.Minimum(middle, regularisation);
    for (std::size_t k = 0; k < 3; ++k)
    {
      least[k] = std::clamp(least[k], this->Bounds.lo[k], this->Bounds.hi[k]);
    }
    const Vec3 moved = Minus(least, middle);
    const double error = quadric.At(least);
    // A straight boundary is left only for much less error: what lies inside must not pull at it.
    if (Dot(moved, moved) <= reach * reach * squaredLength &&
        error < (this->Boundary[u] ? offBoundary * cost : cost))
    {
      position = least;
      cost = error;
    }
  }
  cost += this->AttributeCost(u, v) + lengthCost * squaredLength * squaredLength;
  return cost <= std::numeric_limits<double>::max();
}

void EdgeCollapse::Push(VertexId u, VertexId v)
{
  if (this->Fixed[u] || this->Fixed[v])
  {
    return;
  }
  if (u > v)
  {
    std::swap(u, v);
  }
  double cost = 0;
  Vec3 position;
  if (this->Evaluate(u, v, cost, position))
  {
    this->Heap.push_back({ cost, u, v, this->Stamp[u] + this->Stamp[v], false });
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

// Takes candidates while there are too many vertices or triangles, and none has cost more than
// `error`.
bool EdgeCollapse::Take(std::size_t vertices, std::size_t triangles, double error)
{
  while ((this->Vertices > vertices || this->LiveTriangles > triangles) && this->Largest <= error)
  {
    if (this->Heap.empty())
    {
      return false;
    }
    std::pop_heap(this->Heap.begin(), this->Heap.end(), Later{});
    const Candidate edge = this->Heap.back();
    this->Heap.pop_back();
    // Both stamps only grow: an equal sum means that neither end has changed.
    if (this->Stamp[edge.u] + this->Stamp[edge.v] != edge.stamp || this->Fixed[edge.u] ||
        this->Fixed[edge.v])
    {
      continue;
    }
    double cost = 0;
    Vec3 position;
    this->Evaluate(edge.u, edge.v, cost, position);
    if (!edge.measured && this->AreaPerVertex > 0)
    {
      const double retreat = this->RetreatCost(edge.u, edge.v, position, edge.cost);
      if (retreat > edge.cost)
      {
        this->Heap.push_back({ retreat, edge.u, edge.v, edge.stamp, true });
        std::push_heap(this->Heap.begin(), this->Heap.end(), Later{});
        continue;
      }
    }
    if (this->KeepsNormals(edge.u, edge.v, position) &&
        this->KeepsNormals(edge.v, edge.u, position) &&
        (!this->KeepTopology || this->KeepsTopology(edge.u, edge.v)))
    {
      this->Collapse(edge.u, edge.v, position, edge.cost);
    }
    else
    {
      this->Reject(edge);
    }
  }
  return true;
}

// The link condition: what both ends are linked to must be linked to the edge itself.
bool EdgeCollapse::KeepsTopology(VertexId u, VertexId v)
{
  // Vertices next to u, those next to both, and those that face the edge.
  const std::uint32_t nextToU = ++this->LastMark, nextToBoth = ++this->LastMark,
                      facing = ++this->LastMark;
  std::size_t common = 0, faces = 0, opposite = 0;
  this->ForEachTriangle(u,
    [&](std::uint32_t t)
    {
      for (const VertexId w : this->Triangles[t])
      {
        this->Mark[w] = nextToU;
      }
    });
  this->ForEachTriangle(v,
    [&](std::uint32_t t)
    {
      for (const VertexId w : this->Triangles[t])
      {
        if (w != u && w != v && this->Mark[w] == nextToU)
        {
          this->Mark[w] = nextToBoth;
          ++common;
        }
      }
    });
  this->ForEachTriangle(u,
    [&](std::uint32_t t)
    {
      const Triangle& triangle = this->Triangles[t];
      if (!Has(triangle, v))
      {
        return;
      }
      ++faces;
      for (const VertexId w : triangle)
      {
        if (w != u && w != v && this->Mark[w] != facing)
        {
          this->Mark[w] = facing;
          ++opposite;
        }
      }
    });
  const bool pinches = this->Boundary[u] && this->Boundary[v] && faces != 1;
  return common == opposite && !pinches && !this->ShareAnEdgeOpposite(u, v);
}

// Whether some edge makes a triangle with u and one with v, neither of which holds both.
bool EdgeCollapse::ShareAnEdgeOpposite(VertexId u, VertexId v)
{
  // The edges opposite u with both ends next to v too: few, mostly none.
  const std::uint32_t nextToV = ++this->LastMark;
  this->ForEachTriangle(v,
    [&](std::uint32_t t)
    {
      if (!Has(this->Triangles[t], u))
      {
        for (const VertexId w : this->Triangles[t])
        {
          this->Mark[w] = nextToV;
        }
      }
    });
  bool shared = false;
  this->ForEachTriangle(u,
    [&](std::uint32_t t)
    {
      const Triangle& triangle = this->Triangles[t];
      std::size_t marked = 0;
      VertexId ends[2] = { none, none };
      for (const VertexId w : triangle)
      {
        if (w != u && this->Mark[w] == nextToV && marked < 2)
        {
          ends[marked++] = w;
        }
      }
      if (shared || marked < 2 || Has(triangle, v))
      {
        return;
      }
      this->ForEachTriangle(v,
        [&](std::uint32_t other) {
          shared |= Has(this->Triangles[other], ends[0]) && Has(this->Triangles[other], ends[1]);
        });
    });
  return shared;
}

// Whether the triangles of v, but for those with `other`, keep their normals when v moves.
bool EdgeCollapse::KeepsNormals(VertexId v, VertexId other, const Vec3& position) const
{
  for (Corner c = this->FirstCorner[v]; c != none; c = this->NextCorner[c])
  {
    const Triangle& t = this->Triangles[c / 3];
    if (this->DeadTriangle[c / 3] || Has(t, other))
    {
      continue;
    }
    const Vec3 &p = this->Positions[v], &q = this->Positions[t[(c % 3 + 1) % 3]],
               &r = this->Positions[t[(c % 3 + 2) % 3]];
    const Vec3 before = NormalOf(p, q, r), after = NormalOf(position, q, r);
    const double squaredBefore = Dot(before, before);
    const double cosine = Dot(before, after); // × both lengths
    if (squaredBefore > 0 && !(cosine > 0 && cosine * cosine > flipCosine * flipCosine *
                                                                 squaredBefore * Dot(after, after)))
    {
      return false;
    }
  }
  return true;
}

// The price of how far the ends of an edge, and the vertices that face it, are from the triangles
// that will be around the merged vertex: what planes do not see when the tip of a limb goes back
// along it. Where no triangle is left it is the longest side of those that go. `enough`: a price of
// at most so much need not be exact.
double EdgeCollapse::RetreatCost(VertexId u, VertexId v, const Vec3& position, double enough)
{
  this->Scratch.assign({ u, v });
  double longest = 0;
  this->ForEachTriangle(u,
    [&](std::uint32_t t)
    {
      const Triangle& triangle = this->Triangles[t];
      for (std::size_t k = 0; k < 3 && Has(triangle, v); ++k)
      {
        const Vec3 side =
          Minus(this->Positions[triangle[k]], this->Positions[triangle[(k + 1) % 3]]);
        longest = std::max(longest, Dot(side, side));
        if (triangle[k] != u && triangle[k] != v)
        {
          this->Scratch.push_back(triangle[k]);
        }
      }
    });
  // The triangles' other corners, those that stay where they are.
  this->Ring.clear();
  for (const auto& [own, other] : { std::pair(u, v), std::pair(v, u) })
  {
    for (Corner c = this->FirstCorner[own]; c != none; c = this->NextCorner[c])
    {
      const Triangle& t = this->Triangles[c / 3];
      if (!this->DeadTriangle[c / 3] && !Has(t, other))
      {
        this->Ring.emplace_back(t[(c % 3 + 1) % 3], t[(c % 3 + 2) % 3]);
      }
    }
  }
  double farthest = 0;
  for (const VertexId from : this->Scratch)
  {
    const Vec3& p = this->Positions[from];
    double nearest = longest;
    // What is near enough, or nearer than what was found before, changes nothing any more.
    const auto matters = [&]
    { return nearest > farthest && this->AreaPerVertex * nearest > enough; };
    const auto measure = [&](const std::pair<VertexId, VertexId>& side)
    {
      nearest = std::min(nearest,
        SquaredToTriangle(p, position, this->Positions[side.first], this->Positions[side.second]));
    };
    // A vertex that faces the edge is mostly a corner of one of them.
    for (std::size_t i = 0; i < this->Ring.size() && from != u && from != v && matters(); ++i)
    {
      if (this->Ring[i].first == from || this->Ring[i].second == from)
      {
        measure(this->Ring[i]);
      }
    }
    for (std::size_t i = 0; i < this->Ring.size() && matters(); ++i)
    {
      measure(this->Ring[i]);
    }
    farthest = std::max(farthest, nearest);
  }
  return this->AreaPerVertex * farthest;
}

void EdgeCollapse::Reject(const Candidate& edge)
{
  const auto add = [&](VertexId v, VertexId other)
  {
    for (std::uint32_t i = this->FirstRejection[v]; i != none; i = this->Rejections[i].next)
    {
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
  this->Boundary[u] |= this->Boundary[v];
  this->Retries[u] = std::max(this->Retries[u], this->Retries[v]);
  ++this->Stamp[u];
  ++this->Stamp[v];
  this->FirstRejection[u] = this->FirstRejection[v] = none;
  this->MergeCorners(u, v);
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

// Drops the triangles on the edge and hands the others of v to u.
void EdgeCollapse::MergeCorners(VertexId u, VertexId v)
{
  this->ForEachTriangle(v,
    [&](std::uint32_t t)
    {
      if (Has(this->Triangles[t], u))
      {
        this->DropTriangle(t);
      }
    });
  // v's list in front of u's, without its dead corners.
  Corner* end = &this->FirstCorner[v];
  while (*end != none)
  {
    const Corner c = *end;
    if (this->DeadTriangle[c / 3])
    {
      *end = this->NextCorner[c];
      continue;
    }
    this->Triangles[c / 3][c % 3] = u;
    end = &this->NextCorner[c];
  }
  *end = this->FirstCorner[u];
  while (*end != none)
  {
    if (this->DeadTriangle[*end / 3])
    {
      *end = this->NextCorner[*end];
    }
    else
    {
      end = &this->NextCorner[*end];
    }
  }
  this->FirstCorner[u] = this->FirstCorner[v];
  this->FirstCorner[v] = none;
  this->Vertices -= this->Degree[v] > 0; // 0 where v's last triangles were on the edge
  if (this->Degree[u] == 0 && this->Degree[v] > 0)
  {
    ++this->Vertices; // u had no other triangles: it has v's now
  }
  this->Degree[u] += this->Degree[v];
  this->Degree[v] = 0;
}

void EdgeCollapse::DropTriangle(std::uint32_t t)
{
  this->DeadTriangle[t] = 1;
  --this->LiveTriangles;
  for (const VertexId w : this->Triangles[t])
  {
    if (--this->Degree[w] == 0)
    {
      this->Vertices -= !this->Fixed[w];
    }
  }
}

// Candidates for the edges of a vertex that has changed, and for what its neighbours had left.
void EdgeCollapse::PushAround(VertexId u)
{
  this->CollectEdges(u);
  const auto push = [&](VertexId a, VertexId b)
  {
    const std::size_t before = this->Heap.size();
    this->Push(a, b);
    if (this->Heap.size() > before)
    {
      std::push_heap(this->Heap.begin(), this->Heap.end(), Later{});
    }
  };
  for (const VertexId w : this->Scratch)
  {
    push(u, w);
    if (this->FirstRejection[w] == none || this->Retries[w] >= mostRetries)
    {
      continue;
    }
    ++this->Retries[w];
    std::uint32_t next = this->FirstRejection[w];
    this->FirstRejection[w] = none;
    for (; next != none; next = this->Rejections[next].next)
    {
      const Rejection rejected = this->Rejections[next];
      if (rejected.other != u && this->Stamp[w] + this->Stamp[rejected.other] == rejected.stamp)
      {
        push(w, rejected.other);
      }
    }
  }
}

}
