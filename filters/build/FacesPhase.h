// SPDX-License-Identifier: BSD-3-Clause
// The third phase of a build out of core: triangles and arrays by blocks of the tree. For
// ExternalBuilder.cxx.
#pragma once

#include "filters/build/ExternalBuildState.h"
#include "filters/build/PhaseValues.h"

namespace kdstream
{

// Does the phase "faces". Takes triangles and arrays from the phase "mesh". Errors: those of
// LoadMesh; LimitExceeded for a vertex with too many triangles (CheckHubs); InputOutput; Cancelled.
Status MakeFaces(ExternalBuildState& build);

// Loads the mesh that the phases up to "faces" have made. Errors: those of LoadMesh; LimitExceeded
// if its blocks were made with more memory.
Status LoadBlocks(ExternalBuildState& build, MeshFacts& facts, MeshBlocks& mesh);

}
