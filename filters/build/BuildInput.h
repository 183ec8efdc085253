// SPDX-License-Identifier: BSD-3-Clause
// The first step of a build: reads a file into a mesh in memory that a store can hold. Step "read"
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

// Whether a build in memory of the file that `reader` has opened keeps options.memory for certain:
// by counts and by the file's size, before a point is read (MostBuildMemory). Errors:
// LimitExceeded.
Status CheckInputMemory(const MeshReader& reader, const BuildOptions& options);

// Reads all there is. Errors: those of MeshReader, and with options.strict of Tolerance::Check;
// LimitExceeded for more triangles than can be numbered; Cancelled.
Result<Mesh> ReadMesh(
  MeshReader& reader, const BuildOptions& options, const Execution& execution = {});

// What the header claims of the mesh, if the file is large enough to hold it; else nothing.
BlockedSize ClaimedBlocks(const MeshReader& reader);

// Whether partitions of the mesh that the header claims fit options.memory where they are made out
// of core. Only what is certain counts: vertices that welding may leave, and triangles that
// polygons have at least, do not. Errors: LimitExceeded.
Status CheckClaimedPartitions(const MeshReader& reader, const BuildOptions& options);

// Puts point arrays first, as pieces have them. Errors: InvalidInput where the mesh has no vertices
// or an attribute that no store can hold (CheckAttributes, IsAttributeName).
Status PrepareMesh(Mesh& mesh);

}
