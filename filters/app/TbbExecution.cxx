#include "filters/app/TbbExecution.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <memory>

namespace kdstream
{

Execution MakeTbbExecution(unsigned threads)
{
  const auto arena = std::make_shared<tbb::task_arena>(
    threads == 0 ? tbb::task_arena::automatic : static_cast<int>(threads));
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
