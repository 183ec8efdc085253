// SPDX-License-Identifier: BSD-3-Clause
// The interface between algorithms and their callers: threads, progress, cancelling.
//
// Core uses no thread library. VTK modules fill in vtkSMPTools, programs TBB; the default runs
// serially and reports nothing. Every algorithm that takes an Execution gives the same bits with
// any of them.
#pragma once

#include "filters/core/Result.h"

#include <cstddef>
#include <functional>
#include <string_view>

namespace kdstream
{

struct Execution
{
  using Body = std::function<void(std::size_t begin, std::size_t end)>;

  // Calls body on disjoint ranges that cover [0, count), on any threads, and returns when all are
  // done. Each range has at least `grain` items, if there are that many.
  std::function<void(std::size_t count, std::size_t grain, const Body& body)> parallelFor =
    [](std::size_t count, std::size_t, const Body& body)
  {
    if (count > 0)
    {
      body(0, count);
    }
  };

  // Called from the thread that called the algorithm, with the name of the step and the fraction of
  // that step that is done (0-1). Returns false to stop: the algorithm then returns
  // ErrorCode::Cancelled.
  std::function<bool(std::string_view step, double fraction)> progress = [](std::string_view,
                                                                           double) { return true; };

  Status Report(std::string_view step, double fraction) const
  {
    if (this->progress(step, fraction))
    {
      return {};
    }
    return Error{ ErrorCode::Cancelled, "cancelled" };
  }
};

}
