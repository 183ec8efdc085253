// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/Testing/SmpBackend.h"

#include <vtkSMPTools.h>

namespace kdstream::testing
{

bool UseSmpBackend(const std::string& name, int threads)
{
  if (!vtkSMPTools::SetBackend(name.c_str()))
  {
    return false;
  }
  vtkSMPTools::Initialize(threads);
  return true;
}

}
