// SPDX-License-Identifier: BSD-3-Clause
// Identifies the mesh that the ranks have together: the digest that InputDigest.h makes of a mesh
// in memory.
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <string>

namespace kdstream
{

// Called by all ranks, which have the same arrays. Returns on rank 0 what InputDigestOf returns for
// the mesh of rank 0's points and triangles, then rank 1's, …. Rank 0 receives all bytes once, and
// holds 4 MiB of them. The text on other ranks has no meaning. Errors: those of MpiGroup.
Result<std::string> DigestOfShares(MpiGroup& group, const Mesh& share);

}
