// SPDX-License-Identifier: BSD-3-Clause
// Checks, before any rank works, that the same things are given to all ranks of a job: the program,
// the options that affect the store, the bytes of the input. A difference ends the job, and the
// message names the rank and its host.
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

// Names as the user knows them, and values.
using NamedValues = std::vector<std::pair<std::string, std::string>>;

// The first exchange of a job. Throws BrokenGroup for an error, because a rank of another version
// cannot receive one.
Status AgreeOnProgram(MpiGroup& group);

// Called by all ranks. options: everything that affects the content of the store must be the same;
// more: other values that must be the same. Ranks may differ in memory, threads and the folder of
// temporary files. Errors: InvalidArgument, the same on all ranks: what differs, and on which rank.
Status AgreeOnOptions(MpiGroup& group, const BuildOptions& options, const NamedValues& more);

// Called by all ranks, each with its own path. Compares the file's extension, its size, and a hash
// of the first MB, the last MB, and 16 more between them. Errors: InvalidInput as above; those of
// ByteSource on any rank.
Status AgreeOnInput(MpiGroup& group, const std::filesystem::path& input);

// Called by all ranks: compares the headers that they have read. Errors: InvalidInput as above.
Status AgreeOnHeader(MpiGroup& group, const MeshFileInfo& info);

}
