// SPDX-License-Identifier: BSD-3-Clause
// The paper's baselines for the builder: octree and k-means as partition methods, the medians by
// Torben's method and by sorting, and lookup of all methods by the names in kdstream-build's
// options. Step "tree" of the pipeline picture.
#pragma once

#include "filters/build/PartitionMethod.h"
#include "filters/outofcore/tree/MedianSearch.h"

#include <string_view>

namespace kdstream
{

// The paper's baselines have only partitions: no levels, and no cells below partitions (P = S = L,
// see TreeOfClustering). The octree gives about the wanted number of partitions. k-means gives
// exactly this number, and works only in memory. Errors and complexity: ClusterByOctree,
// PartitionByExternalOctree; ClusterByKMeans.
const PartitionMethod& OctreeMethod();
const PartitionMethod& KMeansMethod();

// The paper's baseline (section 4.2.1): bisects between the smallest and the largest key. Number of
// passes: at most the bits of the ratio between the extent and the smallest difference; at worst
// 2,000 for doubles.
Result<KeyRange> FindMedianByTorben(KeySource& keys, const MedianSearch& search, SpillFolder&);
// External merge sort. Number of passes: 1 + log of the number of runs, to the base of the fan-in.
Result<KeyRange> FindMedianBySort(KeySource& keys, const MedianSearch& search, SpillFolder& folder);

// For "kdtree", "octree", "kmeans"; null for other names.
const PartitionMethod* PartitionMethodOfName(std::string_view name);

// For "auto" (same as "histogram"), "heaps", "torben", "sort", "histogram"; null for other names.
MedianMethod MedianMethodOfName(std::string_view name);

}
