// SPDX-License-Identifier: BSD-3-Clause
// Cuts polygons into triangles. Every reader uses this, whether it reads a file whole or in chunks,
// in memory or out of core. Part of step "read" of the pipeline picture.
#pragma once

#include "filters/core/Types.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Reuses its memory from one polygon to the next. Not for use by two threads at once.
class PolygonCutter
{
public:
  // Cuts a polygon into count - 2 triangles, which have its orientation and name its corners by
  // number (0 to count - 1). A polygon of fewer than three corners gives no triangles. If the
  // polygon is convex, or its dents are below a millionth of its area, the triangles are a fan
  // around corner 0. Otherwise they are ears of the polygon's projection along its normal
  // (Newell's), which fill a concave polygon exactly. The triangles are unspecified if the polygon
  // crosses itself, lies in a line, or has corners that are not finite. The result is valid until
  // the next call. Time: O(count) for a fan, otherwise expected O(count log count). Memory: 100
  // bytes a corner.
  std::span<const Triangle> Cut(std::span<const Vec3> corners);
  // Whether the last polygon became a fan around corner 0.
  bool IsFan() const { return this->Fan; }

private:
  struct Point
  {
    double u = 0, v = 0;
    bool operator==(const Point&) const = default;
  };
  // A node of the tree of dents: the box of its corners, and how many of these are still dents.
  struct Node
  {
    Point lo, hi;
    std::uint32_t dents = 0;
  };
  // A corner that cannot be cut off as an ear while a dent is in its triangle.
  struct Waiting
  {
    std::uint32_t corner = 0, next = 0;
  };
  enum class Rule : std::uint8_t
  {
    Clear,  // no dent is in the triangle, or on its border
    Inside, // no other corner is inside, or the corner is in line with its neighbours
    Any     // the corner is convex
  };

  void AddFan(std::size_t count);
  bool Project(std::span<const Vec3> corners);
  void CutEars();
  void Start();
  bool IsEar(std::uint32_t corner, Rule rule);
  void CutOff(std::uint32_t corner);
  void Queue(std::uint32_t corner);
  void CutQueued(Rule rule);
  void FanRest();

  double Turn(std::uint32_t corner) const;
  // A dent that forbids cutting off the triangle, or `none`.
  std::uint32_t FindDent(const std::array<std::uint32_t, 3>& triangle, bool onBorder) const;
  bool IsOver(const Node& node, const std::array<Point, 3>& triangle) const;
  void BuildTree();
  void BuildNode(std::size_t node, std::size_t begin, std::size_t end);
  void RemoveDent(std::uint32_t corner);

  std::vector<Triangle> Triangles;
  bool Fan = true;
  std::vector<Point> Points; // projected; counter-clockwise
  std::vector<std::uint32_t> Previous, Next;
  std::size_t Left = 0;   // corners in the ring
  std::uint32_t Some = 0; // one of the corners inside

  std::vector<std::uint32_t> Dents;   // corners, in the order of the tree's leaves
  std::vector<std::uint32_t> PlaceOf; // index of a corner in Dents, or `none`
  std::vector<Node> Nodes;            // a heap: 1 is the root, 2 i and 2 i + 1 are children

  std::vector<std::uint32_t> Batch, NextBatch;
  std::vector<std::uint32_t> TouchedIn; // the batch in which a corner got another neighbour
  std::vector<bool> Queued;
  std::uint32_t BatchNumber = 0;
  std::vector<std::uint32_t> FirstWaiting; // of a dent
  std::vector<Waiting> Waitings;
};

}
