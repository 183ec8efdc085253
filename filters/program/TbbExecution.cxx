// SPDX-License-Identifier: BSD-3-Clause
#include "filters/program/TbbExecution.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cstddef>
#include <memory>
#include <mutex>

namespace kdstream
{
namespace
{

// TBB uses as many threads as there are cores, unless a global_control allows more. That object
// stays until the process ends: if memory runs out, TBB can neither destroy it nor throw.
void AllowThreads(int count)
{
  static std::mutex mutex;
  static int allowed = tbb::info::default_concurrency();
  static tbb::global_control* control = nullptr;
  const std::lock_guard lock(mutex);
  if (count > allowed)
  {
    delete control; // of two, the smaller number would count
    control = nullptr;
    control = new tbb::global_control(
      tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(count));
    allowed = count;
  }
}

}

Execution MakeTbbExecution(unsigned threads)
{
  const int concurrency =
    threads == 0 ? tbb::info::default_concurrency() : static_cast<int>(threads);
  AllowThreads(concurrency);
  const auto arena = std::make_shared<tbb::task_arena>(concurrency);
  Execution execution;
  execution.parallelFor = [arena](std::size_t count, std::size_t grain, const Execution::Body& body)
  {
    arena->execute(
      [&]()
      {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain),
          [&](const tbb::blocked_range<std::size_t>& range) { body(range.begin(), range.end()); });
      });
  };
  return execution;
}

}
