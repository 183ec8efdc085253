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
  // Of each vertex: its triangles', and its boundary edges'. Of fixed ones anything will do, as of
  // their attributes.
  std::vector<Quadric> quadrics;
  // Of each vertex the sum of its triangles' area vectors, 0 where unknown; empty = of none. Where
  // they are known triangles face as they do: see EdgeCollapse.
  std::vector<Vec3> normals;
  // 1 = stays as it is, and other parts may hold more of its triangles: the vertices of a part's
  // border. Empty = none.
  std::vector<std::uint8_t> fixed;
  std::vector<Triangle> triangles; // three different vertices each
  // Values that merging vertices should agree in, `components` for each vertex, in model units: a
  // difference of 1 costs as much as a distance of 1. Each counts with the trace of its quadric.
  std::size_t components = 0;
  std::vector<float> attributes;
  // Of each vertex the sum of its triangles'; empty = without colours. Of fixed ones anything will
  // do.
  std::vector<ColorQuadric> colorQuadrics;
  Box bounds; // no vertex is moved out of it
  // An edge also costs at least so much × the squared distance by which the surface goes back
  // there.
  double areaPerVertex = 0;
  bool keepTopology = true; // false: collapse whatever the link condition says
};

// Vertex `from` has become part of `to`, which lies at `position` from now on.
struct Merge
{
  // What the merge cost: area × squared distance. Of the merges so far the largest, so that the
  // merges below a threshold are the first ones of a list.
  double error;
  VertexId from;
  VertexId to;
  Vec3 position;
};

// Merges the ends of edges: the cheapest edge first, of equal ones that of the lowest vertices.
//
// Where the merged vertex goes: where the sum of both quadrics is least, or to the best place on
// the edge. An edge between the boundary and the rest goes to its end on the boundary. Boundary
// edges are those of a single triangle, unless both ends are fixed. The quadrics include colours,
// so edges between colours stay. Planes do not see when the tip of a limb goes back along it; so
// the distance of the old vertices from the new triangles has a price too (areaPerVertex).
//
// Fold-over: where normals are known, a triangle faces the wrong way if it opposes the sum of its
// corners' normals. A triangle that faces the right way must continue to; one that does not may
// turn. In parts with fixed vertices, edges between vertices of wrong triangles are cheaper.
//
// Refused merges: those that would turn the normal of a triangle by more than about 80°, change the
// topology (link condition) or pinch the boundary. A refused edge is tried again when a neighbour
// has changed:
// - a bounded number of times for each vertex;
// - in all, until several times as much has been looked at as a surface takes. From then on a merge
//   is refused at the first triangle whose normal it would turn. Where hardly any merge is found
//   for all that is looked at, Run stops and returns false. So tangled triangles, most of whose
//   edges can never collapse, take time in proportion too.
//
// Any triangles are allowed: duplicates, folds and edges of many triangles only keep their
// neighbourhood from collapsing. An edge whose ends have more than mostTriangles together, as at
// the hub of a fan, waits until collapses around it have left fewer.
//
// Complexity: O(m log m) for m merges and edges of ordinary surfaces. For any triangles, an edge is
// looked at when it is found and when an end has merged, and costs at most mostTriangles triangles
// each time: linear in the size, but up to hundreds of times a surface where vertices have hundreds
// of triangles. Memory about 350 bytes a vertex, with colours 530. The same bits on every machine.
class EdgeCollapse
{
public:
  static constexpr std::size_t any = std::numeric_limits<std::size_t>::max();
  // Of both ends of an edge that may collapse; ordinary edges have about ten.
  static constexpr std::uint32_t mostTriangles = 256;

  explicit EdgeCollapse(CollapsePart part);

  // Merges until at most `vertices` vertices and at most `triangles` triangles are left. Vertices
  // that are fixed or touch no triangle do not count. False: no edge can collapse any more, or too
  // few to go on.
  bool Run(std::size_t vertices, std::size_t triangles = any);
  // Goes on until a merge has cost more than `error`, or at most `vertices` vertices are left.
  // False as above.
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
  bool FoldsOverAfter = false; // whether one would around the merged vertex
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
  // Of the edge that is looked at.
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
