// SPDX-License-Identifier: BSD-3-Clause
// The second phase of a build out of core: a k-d tree over the vertices, or an octree's partitions.
// For ExternalBuilder.cxx and the phases after it.
#pragma once

#include "filters/build/ExternalBuildState.h"
#include "filters/build/PhaseValues.h"

namespace kdstream
{

// Does the phase "tree": the vertices in the order of the leaves, and boxes. Takes the points of
// the phase "mesh". Errors: those of LoadFacts; InvalidInput for no vertices; those of
// BuildExternalTree and PartitionByExternalOctree.
Status MakeTree(ExternalBuildState& build);

// Loads the mesh that the phases up to "tree" have made, without triangles and arrays, and sets
// what `build` has from it. Errors: Damaged; LimitExceeded for a partition that does not fit the
// memory.
Status LoadMesh(ExternalBuildState& build, MeshFacts& facts, MeshBlocks& mesh);

}
