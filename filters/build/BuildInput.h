// SPDX-License-Identifier: BSD-3-Clause
// The first step of a build in memory: reads a file into a mesh that a store can hold. Step "read"
// of the pipeline picture.
#pragma once

#include "filters/build/BuildMemory.h"
#include "filters/build/Builder.h"
#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/meshio/MeshReader.h"

namespace kdstream
{

// Checks that building the file of `reader` in memory is certain to stay within options.memory.
// Decided from the header's counts and the file's size, before a point is read (MostBuildMemory).
// Errors: LimitExceeded.
Status CheckInputMemory(const MeshReader& reader, const BuildOptions& options);

// Reads the whole mesh. Errors: those of MeshReader, and with options.strict those of
// Tolerance::Check; LimitExceeded for more triangles than can be numbered; Cancelled.
Result<Mesh> ReadMesh(
  MeshReader& reader, const BuildOptions& options, const Execution& execution = {});

// The size of the mesh that the header claims, if the file is large enough to hold it; else
// nothing.
BlockedSize ClaimedBlocks(const MeshReader& reader);

// Checks that partitions of the mesh that the header claims fit in options.memory when they are
// made out of core. Only certain facts count: not vertices that welding may remove, and only the
// smallest number of triangles that each polygon can have. Errors: LimitExceeded.
Status CheckClaimedPartitions(const MeshReader& reader, const BuildOptions& options);

// Puts point arrays first, as pieces have them. Errors: InvalidInput if the mesh has no vertices,
// or an attribute that no store can hold (CheckAttributes, IsAttributeName).
Status PrepareMesh(Mesh& mesh);

}
