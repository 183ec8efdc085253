// SPDX-License-Identifier: BSD-3-Clause
// Hierarchical face clustering: see FaceClustering.h. Steps:
// 1. Make a node for each triangle, and a link between any two that share an edge.
// 2. In rounds: price links, match the cheapest, contract.
// 3. Number the clusters.
#include "filters/baselines/FaceClustering.h"

#include "filters/core/VectorMath.h"

#include <algorithm>
#include <numbers>
#include <numeric>
#include <tuple>

namespace kdstream
{
namespace
{

// The compactness if it is not defined, or very large.
constexpr double worstCompactness = 100;

double Distance(const Vec3& a, const Vec3& b)
{
  return Length(Minus(a, b));
}

// A cluster of triangles.
struct Node
{
  std::uint32_t triangles = 1;
  double area = 0;
  double perimeter = 0;
};

// Two clusters that share edges.
struct Link
{
  std::uint32_t a, b; // a < b
  double length;      // of the shared edges
  double cost = 0;
};

Node NodeOf(const Vec3& p, const Vec3& q, const Vec3& r)
{
  const double a = Distance(p, q), b = Distance(q, r), c = Distance(r, p);
  return { 1, Length(Cross(Minus(q, p), Minus(r, p))) / 2, a + b + c };
}

Node Joined(const Node& a, const Node& b, double shared)
{
  return { a.triangles + b.triangles, a.area + b.area,
    std::max(0.0, a.perimeter + b.perimeter - 2 * shared) };
}

double CompactnessOf(const Node& node)
{
  const double compactness = node.perimeter * node.perimeter / (4 * std::numbers::pi * node.area);
  return compactness < worstCompactness ? compactness : worstCompactness; // also for NaN
}

// Combines links between the same two clusters, and adds up their lengths.
void Unite(std::vector<Link>& links)
{
  std::sort(links.begin(), links.end(),
    [](const Link& x, const Link& y)
    { return std::tie(x.a, x.b, x.length) < std::tie(y.a, y.b, y.length); });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < links.size(); ++i)
  {
    if (kept > 0 && links[kept - 1].a == links[i].a && links[kept - 1].b == links[i].b)
    {
      links[kept - 1].length += links[i].length;
    }
    else
    {
      links[kept++] = links[i];
    }
  }
  links.resize(kept);
}

// Triangles around an edge are linked in a row. So the number of links at an edge is not the square
// of the number of triangles.
std::vector<Link> LinksOf(std::span<const Vec3> points, std::span<const Triangle> triangles)
{
  struct Edge
  {
    VertexId a, b;
    std::uint32_t triangle;
    bool operator<(const Edge& other) const
    {
      return std::tie(this->a, this->b, this->triangle) <
             std::tie(other.a, other.b, other.triangle);
    }
  };
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      const auto [a, b] = std::minmax(triangles[i][k], triangles[i][(k + 1) % 3]);
      edges.push_back({ a, b, static_cast<std::uint32_t>(i) });
    }
  }
  std::sort(edges.begin(), edges.end());
  std::vector<Link> links;
  for (std::size_t i = 1; i < edges.size(); ++i)
  {
    const Edge& x = edges[i - 1];
    const Edge& y = edges[i];
    if (x.a == y.a && x.b == y.b && x.triangle != y.triangle)
    {
      links.push_back({ x.triangle, y.triangle, Distance(points[x.a], points[x.b]) });
    }
  }
  Unite(links);
  return links;
}

// Decides which clusters are joined in one round. Returns a leader for each cluster, the same for
// all that become one. links: in ascending order of cost. Stops when `wanted` clusters are left.
std::vector<std::uint32_t> Match(std::size_t nodes, std::span<const Link> links, std::size_t wanted)
{
  constexpr auto alone = static_cast<std::uint32_t>(-1);
  std::vector<std::uint32_t> leader(nodes, alone);
  std::vector<bool> linked(nodes, false);
  std::size_t left = nodes;
  for (const Link& link : links)
  {
    linked[link.a] = linked[link.b] = true;
    if (left > wanted && leader[link.a] == alone && leader[link.b] == alone)
    {
      leader[link.a] = leader[link.b] = link.a;
      --left;
    }
  }
  // In a star only one pair can match in a round. So if few were joined, the others join the pair
  // of their cheapest neighbour, which limits the number of rounds.
  const auto partners = static_cast<std::size_t>(std::count(linked.begin(), linked.end(), true));
  if (nodes - left < partners / 8)
  {
    for (const Link& link : links)
    {
      if (left > wanted && (leader[link.a] == alone) != (leader[link.b] == alone))
      {
        leader[link.a] = leader[link.b] = leader[link.a] == alone ? leader[link.b] : leader[link.a];
        --left;
      }
    }
  }
  for (std::uint32_t i = 0; i < nodes; ++i)
  {
    leader[i] = leader[i] == alone ? i : leader[i];
  }
  return leader;
}

// Does one round. Returns for each cluster the new one that contains it; new ones are numbered by
// their first triangles. Nodes and links become those of the new clusters.
std::vector<std::uint32_t> Contract(
  std::vector<Node>& nodes, std::vector<Link>& links, std::size_t wanted, double meanTriangles)
{
  for (Link& link : links)
  {
    const Node joined = Joined(nodes[link.a], nodes[link.b], link.length);
    link.cost = CompactnessOf(joined) + double(joined.triangles) / meanTriangles;
  }
  std::sort(links.begin(), links.end(),
    [](const Link& x, const Link& y)
    { return std::tie(x.cost, x.a, x.b) < std::tie(y.cost, y.a, y.b); });
  const std::vector<std::uint32_t> leader = Match(nodes.size(), links, wanted);

  constexpr auto unnumbered = static_cast<std::uint32_t>(-1);
  std::vector<std::uint32_t> numberOf(nodes.size(), unnumbered); // of leaders
  std::vector<std::uint32_t> renumbered(nodes.size());
  std::vector<Node> joined;
  for (std::size_t i = 0; i < nodes.size(); ++i)
  {
    std::uint32_t& number = numberOf[leader[i]];
    if (number == unnumbered)
    {
      number = static_cast<std::uint32_t>(joined.size());
      joined.push_back(nodes[i]);
    }
    else
    {
      joined[number] = Joined(joined[number], nodes[i], 0);
    }
    renumbered[i] = number;
  }
  for (Link& link : links)
  {
    std::tie(link.a, link.b) = std::minmax({ renumbered[link.a], renumbered[link.b] });
    if (link.a == link.b)
    {
      joined[link.a].perimeter = std::max(0.0, joined[link.a].perimeter - 2 * link.length);
    }
  }
  nodes = std::move(joined);
  std::erase_if(links, [](const Link& link) { return link.a == link.b; });
  Unite(links);
  return renumbered;
}

}

Result<FaceClustering> ClusterFaces(std::span<const Vec3> points,
  std::span<const Triangle> triangles, std::uint32_t wanted, const Execution& execution)
{
  std::vector<Node> nodes;
  nodes.reserve(triangles.size());
  for (const Triangle& t : triangles)
  {
    nodes.push_back(NodeOf(points[t[0]], points[t[1]], points[t[2]]));
  }
  std::vector<Link> links = LinksOf(points, triangles);
  FaceClustering clustering;
  clustering.clusterOf.resize(triangles.size());
  std::iota(clustering.clusterOf.begin(), clustering.clusterOf.end(), 0U);
  const double mean = double(triangles.size()) / std::max(1.0, double(wanted));
  while (nodes.size() > std::max(wanted, 1U) && !links.empty())
  {
    const std::vector<std::uint32_t> renumbered =
      Contract(nodes, links, std::max(wanted, 1U), mean);
    for (std::uint32_t& cluster : clustering.clusterOf)
    {
      cluster = renumbered[cluster];
    }
    const double done =
      double(triangles.size() - nodes.size()) / double(triangles.size() - std::max(wanted, 1U));
    KDSTREAM_TRY(execution.Report("faces", done));
  }
  clustering.clusters = static_cast<std::uint32_t>(nodes.size());
  return clustering;
}

}
