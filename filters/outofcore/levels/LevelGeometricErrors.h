// SPDX-License-Identifier: BSD-3-Clause
// The geometric errors of levels in files, one number for each level.
#pragma once

#include "filters/core/tree/KdTree.h"
#include "filters/outofcore/levels/BlockGroup.h"
#include "filters/outofcore/levels/ExternalLevels.h"

#include <vector>

namespace kdstream
{

// GeometricErrorBins::Most99 of each level; every process gets the same numbers. Reads the clusters
// of each level in files once. Memory: 64 KiB and a batch of records. group: each process has the
// clusters of its own blocks; the first process also has those of the levels up to S. Errors:
// InputOutput.
Result<std::vector<double>> GeometricErrorsOfLevels(
  const ExternalLevels& levels, const TreeDepths& depths, BlockGroup* group = nullptr);

}
