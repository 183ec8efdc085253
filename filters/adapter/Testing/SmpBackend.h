// SPDX-License-Identifier: BSD-3-Clause
// Selects the backend and threads of vtkSMPTools, for tests: a C++17 source, see
// filters/adapter/SmpFor.h.
#pragma once

#include <string>
#include <vector>

namespace kdstream::testing
{

// The backends that VTK may have.
inline const std::vector<std::string> smpBackends{ "Sequential", "STDThread", "TBB" };

// Whether this VTK has the backend; if so, it is used from now on, with this number of threads.
bool UseSmpBackend(const std::string& name, int threads);

}
