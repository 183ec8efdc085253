// SPDX-License-Identifier: BSD-3-Clause
// What all ranks of a job must have alike before any of them works: the program, the options that
// shape the store, the input's bytes. A difference ends the job, and names the rank and its host.
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

// The first exchange of a job. Errors, which cannot be told to a rank that takes no part, leave as
// a BrokenGroup.
Status AgreeOnProgram(MpiGroup& group);

// By all ranks. options: all that decides what is in the store; more: what else must be the same.
// How much memory and how many threads a rank has, and where its temporary files go, is its own
// affair. Errors: InvalidArgument, the same on all ranks: what differs, and on which.
Status AgreeOnOptions(MpiGroup& group, const BuildOptions& options, const NamedValues& more);

// By all ranks, each with its own path: the ending, the size, and a hash of the first and the last
// MB and of 16 more between. Errors: InvalidInput as above; those of ByteSource on any rank.
Status AgreeOnInput(MpiGroup& group, const std::filesystem::path& input);

// By all ranks: what the reader has found before it reads elements. Errors: InvalidInput as above.
Status AgreeOnHeader(MpiGroup& group, const MeshFileInfo& info);

}
