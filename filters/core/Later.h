// SPDX-License-Identifier: BSD-3-Clause
// Marks what a page needs only after its first picture (viewer/mobile/web/later.txt names it): the
// page's WebAssembly is parted there, so it must stay a function of its own.
#pragma once

#ifdef __EMSCRIPTEN__
#define KDSTREAM_LATER __attribute__((noinline))
#else
#define KDSTREAM_LATER
#endif
