// SPDX-License-Identifier: BSD-3-Clause
// Where a plane meets a surface: the outline, and the cap that fills it. Below step "draw" of the
// pipeline picture.
#pragma once

#include "filters/core/drawing/DrawnSurface.h"
#include "viewer/session/section/SectionPlane.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// Where the plane goes through one triangle. If the triangles of a closed surface turn left around
// their outward normals, the inside is on the left of the way from `from` to `to`, seen against the
// plane's normal.
struct SectionSegment
{
  Vec3 from{}, to{};
  std::uint32_t part = 0, triangle = 0; // as in SurfaceHit
};

// Triangles that only touch the plane from one side have no segment. If two triangles share an
// edge, their segments share an end, bit for bit. O(parts + triangles of the parts that the plane
// meets).
std::vector<SectionSegment> CutSurface(const DrawnSurface& surface, const SectionPlane& plane);

// Segments joined end to end.
struct SectionLine
{
  std::vector<Vec3> points; // two or more; a closed line does not repeat its first point
  bool closed = false;
};
// Joins segments to lines. Each segment is in exactly one line. O(n log n).
std::vector<SectionLine> LinesOf(const std::vector<SectionSegment>& segments);

// Fills the outline with triangles by the even-odd rule. Open lines are closed first, by joining
// each end to the nearest other end. Triangles turn left around the plane's normal. If segments
// cross between their ends, which happens only for a surface that intersects itself, the error is
// smaller than the slab of the plane between two ends. O(n (log n + m)) for n segments, of which up
// to m lie side by side.
//
// A plane sweep (J. Nievergelt, F. P. Preparata: Plane-sweep algorithms for intersecting geometric
// figures, 1982): two neighbouring segments enclose a trapezoid, until one of them ends or another
// one begins between them.
Surface CapOf(const std::vector<SectionSegment>& segments, const SectionPlane& plane);

// The lines as SVG 1.1, one path, seen against the plane's normal. One unit of the drawing is one
// unit of the model. If that is mm, cm, m or in, the drawing has its true size on paper (metres are
// written as 1000 mm, for browsers). title, note: any text; the note says how exact the drawing is.
// O(n).
std::string SectionDrawing(const std::vector<SectionLine>& lines, const SectionPlane& plane,
  std::string_view unit, std::string_view title, std::string_view note);

}
