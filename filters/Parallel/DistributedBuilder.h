// SPDX-License-Identifier: BSD-3-Clause
// Step "build" on several ranks: from a mesh file that all ranks can read, or from each rank's part
// of a mesh, to a store that rank 0 writes (doc/decisions/0009-parallel.md).
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/build/Builder.h"
#include "filters/core/Execution.h"

#include <filesystem>

namespace kdstream
{

// Builds `store` from `input`: the same content as BuildStore makes, for any number of ranks. Every
// rank calls this with the same options (AgreeOnOptions of RankAgreement.h). If one rank has an
// error, all ranks return it, and it names the rank. Only rank 0 writes the store. The report's
// counts of bytes and passes are those of the calling rank. options.memory: of one rank; the
// smallest limit of all ranks decides how much each step may use. The ranks check that they all
// have the same input. A rank keeps its share of the mesh and of the levels in files of its own, in
// options.temporaryFolder or beside the store. stepMemory: for tests, bytes for each step; 0: as
// options.memory allows. Errors: those of BuildStore; Unsupported for baselines and options.resume;
// LimitExceeded for less than leastMemory (ExternalBuilder.h); InvalidInput if ranks have different
// files. Throws BrokenGroup.
Result<BuildReport> BuildStoreCollectively(MpiGroup& group, const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution = {},
  std::uint64_t stepMemory = 0);

// The same for a mesh in the ranks' memory. The mesh is the points and triangles of rank 0, then
// those of rank 1, …; corners of triangles are numbers of points of the whole mesh. The content is
// the same as if BuildStore built this mesh. All ranks must have the same arrays and the same
// scalar type. No rank holds the whole mesh or its levels, only its own share. Later the share is
// in files beside the store; or, if a rank other than the first cannot write there, in the system's
// folder for temporary files. options.inputName is the name of the input. All ranks call this with
// the same options except memory and temporaryFolder. Errors: as above.
Result<BuildReport> BuildStoreOfShares(MpiGroup& group, Mesh share,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution = {});

}
