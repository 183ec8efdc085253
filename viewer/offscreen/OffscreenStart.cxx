// SPDX-License-Identifier: BSD-3-Clause
// kdstream_enable_offscreen links this into a program: if the environment variable
// KDSTREAM_OFFSCREEN is set, the program's windows draw without a screen, without changes to the
// program.
#include "viewer/offscreen/vtkKdOffscreenRendering.h"

namespace
{

[[maybe_unused]] const bool started = vtkKdOffscreenRendering::UseEnvironment();

}
