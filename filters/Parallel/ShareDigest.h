// SPDX-License-Identifier: BSD-3-Clause
// Which mesh the ranks have together: the digest that InputDigest.h makes of a mesh in memory.
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <string>

namespace kdstream
{

// By all ranks, which have the same arrays. On rank 0 what InputDigestOf tells of the mesh whose
// points and triangles are those of rank 0, then those of rank 1, …: rank 0 gets all their bytes
// once, and holds 4 MiB of them. On others a text of no use. Errors: MpiGroup's.
Result<std::string> DigestOfShares(MpiGroup& group, const Mesh& share);

}
