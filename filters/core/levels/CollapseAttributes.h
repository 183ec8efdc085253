// SPDX-License-Identifier: BSD-3-Clause
// What vertex colours and normals cost when clusters merge. Only for the makers of levels.
//
// A level has the colours of the mesh's first array of colours (RoleOf), red, green and blue, as
// the viewers draw it. The finest level has the means of its clusters, which part along the
// colours' edges. Each coarser level's colours come from those of the level below: so neither files
// nor other processes need to know more of a level than what is shown of it. Noise of the colours
// is evened out on the way instead of being held on to, as it would be if quadrics of the original
// were added up.
#pragma once

#include "filters/core/Attribute.h"
#include "filters/core/Types.h"
#include "filters/core/collapse/EdgeCollapse.h"
#include "filters/core/levels/ClusterLevels.h"
#include "filters/core/levels/ClusterSum.h"

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace kdstream
{

// A value for each component of each cluster, in model units: see CollapsePart::attributes.
struct CollapseAttributes
{
  std::size_t components = 0;
  std::vector<float> values;
};

// The share of the model's diagonal that a normal's turn by 60° (a difference of length 1) costs as
// a distance, and a full change of one channel of the colour (from 0 to 255).
// Measured on the coloured vase (doc/benchmarks.md#colours): twice the share of colour takes a
// little off the pictures' error at 16,000 triangles and a seventh at 4,000, and adds a sixth to
// the surface's at both.
inline constexpr double normalScale = 1.0 / 4096;
inline constexpr double colorScale = 1.0 / 330;

// Neighbours that differ by more than this in a channel are on either side of an edge of the
// colours. Half or twice as much changes hardly anything (measured).
inline constexpr int colorEdge = 32;

// Of a box.
double DiagonalOf(const Box& box);

// The means of the mesh's normals over the original vertices of each finest cluster. clusterOf:
// noVertex for vertices that are left out. NaN counts as 0, a component beyond 1 as 1. O(n).
CollapseAttributes MeanAttributes(const Mesh& mesh, std::span<const VertexId> clusterOf,
  std::span<const ClusterSum> clusters, double diagonal);

// Those of the next coarser level: means weighted with the traces of the clusters' quadrics.
// parents: of each cluster, `count` in all.
CollapseAttributes MeanOverChildren(const CollapseAttributes& children,
  std::span<const ClusterSum> clusters, std::span<const VertexId> parents, std::size_t count);

// The array of a mesh's vertex colours, or null.
const Attribute* FindVertexColors(std::span<const Attribute> attributes);

// The same of arrays that stand one after the other in a tuple: at which byte of it.
std::optional<std::size_t> PlaceOfVertexColors(std::span<const AttributeInfo> attributes);

// Whether two points are on either side of an edge of the colours.
bool IsColorEdge(const Attribute& vertexColors, std::size_t a, std::size_t b);

// The finest level's colours: means over the vertices of each cluster, as AttributeSums rounds
// them. clusterOf as MeanAttributes. Empty where the mesh has no colours.
std::vector<VertexColor> MeanVertexColors(
  const Mesh& mesh, std::span<const VertexId> clusterOf, std::size_t clusters);

// Replaces red, green and blue of the vertex colours among a level's means; nothing where
// vertexColors is empty. REQUIRES: else a colour a tuple.
void PutVertexColors(std::span<const VertexColor> vertexColors, std::span<Attribute> means);

// Model units of a grey value, where `diagonal` is the model's.
double GreyValue(double diagonal);

// Whether all corners of triangles have one colour: then the part is as one without colours.
bool IsOfOneColor(std::span<const Triangle> triangles, std::span<const VertexColor> colors);

// What colours cost around the first `own` vertices of a part; nothing where it is of one colour.
// colors: of all of its vertices, or none. REQUIRES: the part's triangles and positions are known.
void AddColorQuadrics(
  std::span<const VertexColor> colors, std::size_t own, double greyValue, CollapsePart& part);

// What a triangle of a level with vertex colours says about colours, in model units.
ColorQuadric ColorQuadricOf(const Triangle& t, const std::array<Vec3, 3>& corners,
  std::span<const VertexColor> colors, double greyValue);

}
