// SPDX-License-Identifier: BSD-3-Clause
// What must be the same on all ranks of a job before any of them works: the program, the options
// that shape the store, the input's bytes. A difference ends the job, and names the rank and its
// host.
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/build/Builder.h"
#include "filters/core/Result.h"
#include "filters/meshio/MeshReader.h"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{

// Names as a user knows them, and values.
using NamedValues = std::vector<std::pair<std::string, std::string>>;

// The first exchange of a job. Throws BrokenGroup for an error, since a rank that takes no part
// cannot get one.
Status AgreeOnProgram(MpiGroup& group);

// Called by all ranks. options: everything that decides what is in the store; more: what else must
// be the same. Ranks may differ in memory, threads and the folder of temporary files. Errors:
// InvalidArgument, the same on all ranks: what differs, and on which.
Status AgreeOnOptions(MpiGroup& group, const BuildOptions& options, const NamedValues& more);

// Called by all ranks, each with its own path. Compares the file's extension, its size, and a hash
// of the first and the last MB and of 16 more between them. Errors: InvalidInput as above; those of
// ByteSource on any rank.
Status AgreeOnInput(MpiGroup& group, const std::filesystem::path& input);

// Collective: compares the header that each rank has read. Errors: InvalidInput as above.
Status AgreeOnHeader(MpiGroup& group, const MeshFileInfo& info);

}
