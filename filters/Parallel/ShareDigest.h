// SPDX-License-Identifier: BSD-3-Clause
// Which mesh the ranks have together: the digest that InputDigest.h makes of a mesh in memory.
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <string>

namespace kdstream
{

// Called by all ranks, which have the same arrays. Rank 0 gets what InputDigestOf gives for the
// mesh of rank 0's points and triangles, then rank 1's, …: it receives all their bytes once, and
// holds 4 MiB of them. The text on other ranks has no meaning. Errors: MpiGroup's.
Result<std::string> DigestOfShares(MpiGroup& group, const Mesh& share);

}
