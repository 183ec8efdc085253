// SPDX-License-Identifier: BSD-3-Clause
// vtkSMPTools behind a plain function. With g++ 12, vtkSMPTools.h of VTK 9.1 does not compile as
// C++20; so only one source, which is C++17, includes it.
#pragma once

#include <cstddef>
#include <functional>

namespace kdstream
{

// Calls `body` on disjoint ranges that cover [0, count), on the threads of VTK's current SMP
// backend, and returns when all are done. Each range has about `grain` items or more.
void SmpFor(std::size_t count, std::size_t grain,
  const std::function<void(std::size_t begin, std::size_t end)>& body);

}
