// SPDX-License-Identifier: BSD-3-Clause
// How good a partitioning is: the paper's compactness (eq. 1), areas, and how far sizes spread.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/tree/Clustering.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

struct PartitionMeasure
{
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;    // triangles that touch the partition
  std::uint64_t ownTriangles = 0; // triangles that no lower partition touches
  double boundaryLength = 0;      // p of eq. (1), in the unit of the coordinates
  double area = 0;                // w of eq. (1)
  // c = p^2 / (4 pi w): 1 for a disc, 1.27 for a square, more for longer or more jagged shapes. NaN
  // if there is no area (degenerate triangles) or no boundary (whole closed components).
  double compactness = 0;
};

// The spread of one number over all partitions; all 0 without partitions.
struct Spread
{
  double minimum = 0;
  double maximum = 0;
  double mean = 0;
  double standardDeviation = 0; // of all partitions, not of a sample
  // maximum / minimum; infinite if only the minimum is 0.
  double ratio = 0;
};

struct PartitionMeasures
{
  std::vector<PartitionMeasure> partitions; // one a cluster
  Spread vertices;
  Spread triangles;
  Spread compactness;       // of the partitions that have a compactness
  std::size_t measured = 0; // the number of partitions that have a compactness
};

Spread SpreadOf(std::span<const double> values);

// Measures the partitions of a surface that a clustering of its vertices makes. A partition is
// measured as it is stored and streamed: with every triangle that touches one of its vertices, so a
// triangle between partitions counts in each of them (paper 4.2.4: "we added vertices on the
// boundary to both partitions"). Its boundary consists of the edges that only one of these
// triangles has, including open edges of the mesh: it is the perimeter of the patch that a viewer
// gets. It passes through vertices on one side of the cut, so it is about a tenth longer than the
// cut itself: a square patch has a compactness of 1.5 instead of 1.27. The values are of the same
// magnitude as those in the paper's Table 2. (We also tried giving each triangle to only one
// partition: boundaries then zigzag, and compactness is 3 to 7 and measures the zigzag.) Partitions
// of few triangles appear larger than they are. Vertices in the same place count as one for edges,
// so that repeated vertices make no slits. Triangles with two corners in one place are counted, but
// have no area and no edges. Input: points are finite, triangles name points. Complexity: O(n + t
// log t); memory about 50 bytes a triangle. Serial. Errors: InvalidArgument if the clustering does
// not have one entry for each vertex, or an entry is not a cluster; Cancelled. Source: paper 4.1,
// eq. (1), and 4.1.1, Table 2.
Result<PartitionMeasures> MeasurePartitions(std::span<const Vec3> points,
  std::span<const Triangle> triangles, const Clustering& clustering,
  const Execution& execution = {});

}
