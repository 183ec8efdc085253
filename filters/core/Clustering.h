// Any clustering of a mesh's vertices: what partitioners other than the k-d tree give, and what
// cluster simplification takes.
#pragma once

#include <cstdint>
#include <vector>

namespace kdstream
{

// clusterOf: one entry a vertex, each below `clusters`. Every cluster has at least one vertex.
struct Clustering
{
  std::vector<std::uint32_t> clusterOf;
  std::uint32_t clusters = 0;
};

}
