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

// What is collapsed. Positions are relative to the origin of the quadrics.
struct CollapsePart
{
  std::vector<Vec3> positions;
  // For each vertex: the sum of the quadrics of its triangles and boundary edges. Those of fixed
  // vertices are not used, and neither are their attributes.
  std::vector<Quadric> quadrics;
  // For each vertex the sum of its triangles' area vectors, 0 if unknown; empty: all unknown.
  // Where they are known they decide how triangles may face: see EdgeCollapse.
  std::vector<Vec3> normals;
  // 1: the vertex does not move, and other parts may have more of its triangles (the vertices of a
  // part's border). Empty: none.
  std::vector<std::uint8_t> fixed;
  std::vector<Triangle> triangles; // three different vertices each
  // Values in which merging vertices should agree, `components` for each vertex, in model units: a
  // difference of 1 costs as much as a distance of 1. Each is weighted with the trace of the
  // vertex's quadric.
  std::size_t components = 0;
  std::vector<float> attributes;
  // For each vertex the sum of its triangles' colour quadrics; empty: no colours. Those of fixed
  // vertices are not used.
  std::vector<ColorQuadric> colorQuadrics;
  Box bounds; // vertices stay inside
  // An edge also costs at least this, times the squared distance by which the surface retreats
  // there.
  double areaPerVertex = 0;
  bool keepTopology = true; // false: collapse whatever the link condition says
};

// Vertex `from` has become part of `to`, which lies at `position` from now on.
struct Merge
{
  // The largest cost (area × squared distance) of this and all earlier merges. So the merges below
  // a threshold are the first ones of a list.
  double error;
  VertexId from;
  VertexId to;
  Vec3 position;
};

// Merges the ends of edges: the cheapest edge first; of edges of equal cost, the one with the
// lowest vertices.
//
// Place of the merged vertex: where the sum of both quadrics is least, or the best place on the
// edge. If one end is on the boundary, the merged vertex stays there. A boundary edge has a single
// triangle, and not both ends are fixed. The quadrics include colours, so edges between colours
// stay. Plane quadrics do not notice when the tip of a limb retreats along the limb; so the
// distance of the old vertices from the new triangles has a price too (areaPerVertex).
//
// Fold-over: where normals are known, a triangle faces the wrong way if it opposes the sum of its
// corners' normals. A triangle that faces the right way must continue to; one that does not may
// turn. In parts with fixed vertices, edges between vertices of wrong triangles are cheaper.
//
// Refused merges: those that would turn the normal of a triangle by more than about 80°, change the
// topology (link condition) or pinch the boundary. A refused edge is tried again when a neighbour
// has changed:
// - a bounded number of times for each vertex;
// - in all, until the work done is several times that for an ordinary surface. From then on a merge
//   is refused at the first triangle whose normal it would turn. If hardly any edge that is checked
//   can merge, Run stops and returns false. So tangled triangles, most of whose edges can never
//   collapse, take linear time too.
//
// Any triangles are allowed: duplicates, folds and edges of many triangles only keep their
// neighbourhood from collapsing. An edge whose ends have more than mostTriangles together, as at
// the hub of a fan, waits until collapses around it have left fewer.
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
  // The most triangles at both ends of an edge that may collapse; ordinary edges have about ten.
  static constexpr std::uint32_t mostTriangles = 256;

  explicit EdgeCollapse(CollapsePart part);

  // Merges until at most `vertices` vertices and at most `triangles` triangles are left. Vertices
  // that are fixed or touch no triangle do not count. False: no edge can collapse any more, or too
  // few can.
  bool Run(std::size_t vertices, std::size_t triangles = any);
  // Continues until a merge has cost more than `error`, or at most `vertices` vertices are left.
  // False as for Run.
  bool RunBeyond(double error, std::size_t vertices);
  // Fixes a vertex from now on, though it may be on the boundary still.
  void Fix(VertexId v) { this->Fixed[v] = 1; }

  std::size_t VertexCount() const { return this->Vertices; }
  std::size_t TriangleCount() const { return this->Stars.TriangleCount(); }
  const std::vector<Merge>& Merges() const { return this->Record; }
  // Triangles, edges and entries of lists looked at so far: what the time goes with.
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

  std::vector<Vec3> Facing;             // of each vertex, of Normals: FacingOf; empty if they are
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
  std::vector<std::uint16_t> Retries; // edges tried again
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
