// SPDX-License-Identifier: BSD-3-Clause
// Linked into a program by kdstream_enable_offscreen: the environment variable KDSTREAM_OFFSCREEN
// makes its windows draw without a screen, without changes to the program.
#include "viewer/offscreen/vtkKdOffscreenRendering.h"

namespace
{

[[maybe_unused]] const bool started = vtkKdOffscreenRendering::UseEnvironment();

}
