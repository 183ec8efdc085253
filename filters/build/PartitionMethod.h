// SPDX-License-Identifier: BSD-3-Clause
// The interface between the builder and the methods that cut a mesh into partitions: the k-d tree
// here, the paper's baselines in filters/baselines/stores. Step "tree" of the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/tree/KdTree.h"

#include <string_view>

namespace kdstream
{

class ExternalMethod; // ExternalMethod.h

struct PartitionTree
{
  KdTree tree;
  std::uint64_t partitions = 1; // nodes 2^P … 2^P + partitions - 1; 2^P for a k-d tree
};

// Objects of this class exist as long as the program.
class PartitionMethod
{
public:
  virtual ~PartitionMethod() = default;
  virtual std::string_view Name() const = 0; // as in kdstream-build's option: "kdtree"
  // Whether the store has levels; if not, it has only partitions.
  virtual bool HasLevels() const = 0;
  // Partitions a mesh in memory. Of the options, every method uses verticesPerPartition or
  // partitions.
  virtual Result<PartitionTree> Partition(
    const Mesh& mesh, const KdTreeOptions& options, const Execution& execution) const = 0;
  // The method out of core. Errors: LimitExceeded if it works only in memory.
  virtual Result<const ExternalMethod*> External() const = 0;
};

// The balanced k-d tree. Errors and complexity: BuildKdTree; BuildExternalTree.
const PartitionMethod& KdTreeMethod();

}
