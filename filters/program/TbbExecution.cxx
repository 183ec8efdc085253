// SPDX-License-Identifier: BSD-3-Clause
#include "filters/program/TbbExecution.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <memory>

namespace kdstream
{

Execution MakeTbbExecution(unsigned threads)
{
  // The control allows as many threads as are asked for, also more than there are cores.
  struct Threads
  {
    tbb::global_control allowed;
    tbb::task_arena arena;
  };
  const int concurrency =
    threads == 0 ? tbb::info::default_concurrency() : static_cast<int>(threads);
  const auto shared = std::shared_ptr<Threads>(
    new Threads{ tbb::global_control(tbb::global_control::max_allowed_parallelism,
                   static_cast<std::size_t>(concurrency)),
      tbb::task_arena(concurrency) });
  Execution execution;
  execution.parallelFor = [shared](
                            std::size_t count, std::size_t grain, const Execution::Body& body)
  {
    shared->arena.execute(
      [&]()
      {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain),
          [&](const tbb::blocked_range<std::size_t>& range) { body(range.begin(), range.end()); });
      });
  };
  return execution;
}

}
