// SPDX-License-Identifier: BSD-3-Clause
// The price of vertex colours and normals when clusters merge. Only for the makers of levels.
//
// A level has the colours of the mesh's first array of colours (RoleOf), red, green and blue, as
// the viewers draw it. The finest level has the means of its clusters, which do not cross edges
// between colours. Each coarser level gets its colours from the level below. So files and other
// processes need only those data of a level that are shown. This also averages out noise in the
// colours; sums of the original's quadrics would preserve it.
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

// The price of attributes, as a share of the model's diagonal: normalScale for a normal that turns
// by 60° (a difference of length 1), colorScale for a full change of one channel (from 0 to 255).
// Measured on the coloured vase (doc/benchmarks.md#colours): doubling the price of colour makes the
// error of the pictures a little smaller at 16,000 triangles, and a seventh smaller at 4,000, but
// the error of the surface a sixth larger at both.
inline constexpr double normalScale = 1.0 / 4096;
inline constexpr double colorScale = 1.0 / 330;

// Neighbours that differ by more than this in a channel are on different sides of an edge between
// colours. Half or twice this value changes hardly anything (measured).
inline constexpr int colorEdge = 32;

// The diagonal of a box.
double DiagonalOf(const Box& box);

// The means of the mesh's normals over the original vertices of each finest cluster. clusterOf:
// noVertex for vertices that are left out. NaN counts as 0; components are clamped to 1. O(n).
CollapseAttributes MeanAttributes(const Mesh& mesh, std::span<const VertexId> clusterOf,
  std::span<const ClusterSum> clusters, double diagonal);

// The means of the next coarser level, weighted with the traces of the clusters' quadrics. parents:
// the parent of each cluster. count: the number of parents.
CollapseAttributes MeanOverChildren(const CollapseAttributes& children,
  std::span<const ClusterSum> clusters, std::span<const VertexId> parents, std::size_t count);

// The array of a mesh's vertex colours, or null.
const Attribute* FindVertexColors(std::span<const Attribute> attributes);

// Byte offset of the vertex colours in a tuple of these arrays; nothing if there are none.
std::optional<std::size_t> PlaceOfVertexColors(std::span<const AttributeInfo> attributes);

// Whether points a and b are on different sides of an edge between colours.
bool IsColorEdge(const Attribute& vertexColors, std::size_t a, std::size_t b);

// The finest level's colours: means over the vertices of each cluster, as AttributeSums rounds
// them. clusterOf: as in MeanAttributes. The result is empty if the mesh has no colours.
std::vector<VertexColor> MeanVertexColors(
  const Mesh& mesh, std::span<const VertexId> clusterOf, std::size_t clusters);

// Replaces red, green and blue of the vertex colours among a level's means; does nothing if
// vertexColors is empty. REQUIRES: otherwise there is a colour for each tuple.
void PutVertexColors(std::span<const VertexColor> vertexColors, std::span<Attribute> means);

// The distance, in model units, that costs as much as a difference of one grey value (1/255).
// diagonal: of the model.
double GreyValue(double diagonal);

// Whether all corners of the triangles have the same colour: then the part is treated like one
// without colours.
bool IsOfOneColor(std::span<const Triangle> triangles, std::span<const VertexColor> colors);

// Adds the price of colours around the first `own` vertices of a part; adds nothing if the part has
// a single colour. colors: of all vertices of the part; empty: no colours. REQUIRES: the part's
// triangles and positions are set.
void AddColorQuadrics(
  std::span<const VertexColor> colors, std::size_t own, double greyValue, CollapsePart& part);

// The colour quadric of a triangle of a level with vertex colours, in model units.
ColorQuadric ColorQuadricOf(const Triangle& t, const std::array<Vec3, 3>& corners,
  std::span<const VertexColor> colors, double greyValue);

}
