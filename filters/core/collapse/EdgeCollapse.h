// SPDX-License-Identifier: BSD-3-Clause
// Quadric-error edge collapse of one part of a mesh, recorded merge by merge: part of step "levels"
// of the pipeline picture. Only for the makers of levels.
//
// Source: Garland and Heckbert, "Surface simplification using quadric error metrics", 1997; the
// link condition: Dey et al., "Topology preserving edge contraction", 1999. Ours: parts whose
// border vertices are fixed, and the attributes' share of the cost.
#pragma once

#include "filters/core/Types.h"
#include "filters/core/collapse/ColorQuadric.h"
#include "filters/core/collapse/EdgeCandidates.h"
#include "filters/core/collapse/MergedStar.h"
#include "filters/core/collapse/Quadric.h"
#include "filters/core/collapse/VertexStars.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace kdstream
{

// The mesh to collapse. Positions are relative to the origin of the quadrics.
struct CollapsePart
{
  std::vector<Vec3> positions;
  // For each vertex: the sum of the quadrics of its triangles and boundary edges. The quadrics and
  // attributes of fixed vertices are not used.
  std::vector<Quadric> quadrics;
  // For each vertex the sum of its triangles' area vectors, 0 if unknown; empty: all unknown. Known
  // sums restrict how triangles may face: see EdgeCollapse.
  std::vector<Vec3> normals;
  // 1: the vertex does not move, and other parts may have further triangles of it (a vertex on the
  // part's border). Empty: no vertex is fixed.
  std::vector<std::uint8_t> fixed;
  std::vector<Triangle> triangles; // three different vertices each
  // Values in which merging vertices should agree, `components` for each vertex, in model units: a
  // difference of 1 costs as much as a distance of 1. Each value is weighted with the trace of the
  // vertex's quadric.
  std::size_t components = 0;
  std::vector<float> attributes;
  // For each vertex the sum of its triangles' colour quadrics; empty: no colours. Those of fixed
  // vertices are ignored.
  std::vector<ColorQuadric> colorQuadrics;
  Box bounds; // vertices stay inside
  // The cost of an edge is at least this, times the squared distance by which the surface retreats
  // there.
  double areaPerVertex = 0;
  bool keepTopology = true; // false: ignore the link condition
};

// Vertex `from` has become part of `to`, which lies at `position` from now on.
struct Merge
{
  // The largest cost (area × squared distance) of this and all earlier merges. So the merges below
  // a threshold come first in the list.
  double error;
  VertexId from;
  VertexId to;
  Vec3 position;
};

// Merges the ends of edges. The cheapest edge is first; of edges with equal costs, the one with the
// lowest vertices.
//
// Position of the merged vertex: where the sum of both quadrics is least, or the best position on
// the edge. If one end is on the boundary, the merged vertex stays there. A boundary edge has a
// single triangle, and not both ends are fixed. The quadrics include colours, so edges between
// colours stay. Plane quadrics do not notice when the tip of a limb retreats along the limb; so the
// distance of the old vertices from the new triangles has a price too (areaPerVertex).
//
// Fold-over: where normals are known, a triangle faces the wrong way if it opposes the sum of its
// corners' normals. A triangle that faces the right way must keep doing so; one that faces the
// wrong way may turn. In parts with fixed vertices, edges between vertices of triangles that face
// the wrong way are cheaper.
//
// Refused merges: those that would turn the normal of a triangle by more than about 80°, change the
// topology (link condition) or pinch the boundary. A refused edge is tried again when a neighbour
// has changed:
// - a bounded number of times for each vertex;
// - in total, until the work is several times that for an ordinary surface. From then on a merge is
//   refused at the first triangle whose normal it would turn. If hardly any edge that is checked
//   can merge, Run stops and returns false. So a tangle of triangles, where most edges can never
//   collapse, takes linear time too.
//
// Any triangles are allowed: duplicates, folds and edges with many triangles only keep their
// neighbourhood from collapsing. If the ends of an edge have more than mostTriangles together, as
// at the hub of a fan, the edge waits until collapses around it have left fewer.
//
// Complexity: O(m log m) for m merges and edges of ordinary surfaces. For arbitrary triangles: an
// edge is checked when it is found and when an end has merged, and each check visits at most
// mostTriangles triangles. That is linear in the size, but up to hundreds of times slower than a
// surface where vertices have hundreds of triangles. Memory about 350 bytes a vertex, with colours
// 530. The same bits on every machine.
class EdgeCollapse
{
public:
  static constexpr std::size_t any = std::numeric_limits<std::size_t>::max();
  // An edge collapses only if both ends together have at most this number of triangles. Ordinary
  // edges have about ten.
  static constexpr std::uint32_t mostTriangles = 256;

  explicit EdgeCollapse(CollapsePart part);

  // Merges until at most `vertices` vertices and at most `triangles` triangles are left. Vertices
  // that are fixed or touch no triangle do not count. Returns false if no edge can collapse any
  // more, or too few can.
  bool Run(std::size_t vertices, std::size_t triangles = any);
  // Continues until a merge has cost more than `error`, or at most `vertices` vertices are left.
  // Returns false as Run does.
  bool RunBeyond(double error, std::size_t vertices);
  // Fixes a vertex from now on. It can still count as a boundary vertex.
  void Fix(VertexId v) { this->Fixed[v] = 1; }

  std::size_t VertexCount() const { return this->Vertices; }
  std::size_t TriangleCount() const { return this->Stars.TriangleCount(); }
  const std::vector<Merge>& Merges() const { return this->Record; }
  // The number of triangles, edges and list entries visited so far; the time is proportional to it.
  std::uint64_t Steps() const { return this->Looked + this->Stars.Steps(); }

private:
  static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

  // An edge that could not collapse, in the list of one of its ends.
  struct Rejection
  {
    VertexId other;
    std::uint32_t stamp;
    std::uint32_t next;
  };
  using Edge = std::array<VertexId, 2>; // the lower one first

  void FindEdges();
  std::vector<Edge> FindBoundary();
  bool Place(VertexId u, VertexId v, double& cost, Vec3& position) const;
  Quadric SumOf(VertexId u, VertexId v) const;
  double LastingCost(VertexId u, VertexId v) const;
  double AttributeCost(VertexId u, VertexId v) const;
  bool Take(std::size_t vertices, std::size_t triangles, double error);
  void Push(VertexId u, VertexId v);
  void PushWaiting();
  void PushAt(const Edge& edge, double cost);
  bool IsCurrent(const EdgeCandidate& edge) const;
  bool IsHopeless() const;
  bool IsFoldedOver(VertexId u, VertexId v) const;
  bool KeepsFacing(VertexId u, VertexId v, const Vec3& position);
  bool TurnsAny(VertexId u, VertexId v, const Vec3& position);
  bool KeepsTopology(VertexId u, VertexId v);
  bool ShareAnEdgeOpposite(std::uint32_t facing) const;
  bool MayTryAgain() const { return this->Steps() <= this->MostStepsOfRetries; }
  void Reject(const EdgeCandidate& edge);
  void Collapse(VertexId u, VertexId v, const Vec3& position, double cost);
  void MergeAttributes(VertexId u, VertexId v);
  void PushAround(VertexId u);

  std::vector<Vec3> Facing;             // FacingOf each vertex's normal; empty if Normals is
  std::vector<std::uint8_t> FoldedOver; // whether a triangle around the vertex faced the wrong way
  std::vector<Vec3> Positions;
  std::vector<Quadric> Quadrics;
  std::vector<Vec3> Normals;
  bool FoldsOverAfter = false; // the same for a triangle around the merged vertex
  std::vector<std::uint8_t> Fixed;
  std::size_t Components;
  std::vector<float> Attributes;
  std::vector<ColorQuadric> ColorQuadrics;
  Box Bounds;
  bool KeepTopology;
  double AreaPerVertex;

  VertexStars Stars;
  EdgeCandidates Candidates;
  std::vector<std::uint8_t> Boundary;
  std::vector<std::uint32_t> Stamp; // how often the vertex has changed
  std::vector<std::uint32_t> FirstRejection;
  std::vector<std::uint16_t> Retries; // of each vertex: edges tried again
  std::vector<Rejection> Rejections;
  std::vector<std::uint32_t> Mark;
  std::uint32_t LastMark = 0;
  std::vector<Merge> Record;
  // The triangles around the current edge.
  EdgeStar Star;
  MergedStar Merged;
  std::array<Edge, Lanes::count> Waiting; // to be placed together
  std::size_t WaitingCount = 0;
  double Largest = 0;
  std::size_t Vertices = 0;
  std::uint64_t Looked = 0;
  std::uint64_t MostStepsOfRetries;
};

}
