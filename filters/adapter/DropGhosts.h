// SPDX-License-Identifier: BSD-3-Clause
// Points of others that no triangle needs any more.
#pragma once

#include "filters/core/Types.h"

#include <vector>

namespace kdstream
{

// Drops the points that are ghosts and that no triangle uses, with their tuples, and renumbers the
// rest. O(size). REQUIRES: a flag for each point.
void DropUnusedGhosts(Mesh& mesh, const std::vector<bool>& isGhost);

}
