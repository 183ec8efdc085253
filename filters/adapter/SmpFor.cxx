// SPDX-License-Identifier: BSD-3-Clause
// Compiled as C++17: see SmpFor.h.
#include "filters/adapter/SmpFor.h"

#include <vtkSMPTools.h>

namespace kdstream
{

void SmpFor(std::size_t count, std::size_t grain,
  const std::function<void(std::size_t begin, std::size_t end)>& body)
{
  if (count == 0)
  {
    return;
  }
  const auto run = [&body](vtkIdType begin, vtkIdType end)
  { body(static_cast<std::size_t>(begin), static_cast<std::size_t>(end)); };
  vtkSMPTools::For(0, static_cast<vtkIdType>(count), static_cast<vtkIdType>(grain), run);
}

}
