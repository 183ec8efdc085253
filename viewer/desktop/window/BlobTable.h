// SPDX-License-Identifier: BSD-3-Clause
// What is shown, in numbers, and what came of it, a row a blob (paper, Tables 4-6).
#pragma once

#include "viewer/session/SessionTypes.h"

#include <deque>

namespace kdstream
{

struct PanelFacts;

// Both in Dear ImGui, within a window, and how wide this has to be so that nothing is cut off,
// pixels: known in the second frame.
float DrawFacts(const PanelFacts& facts);
// The newest first. ratio: pixels a point.
float DrawBlobTable(const std::deque<BlobStatistics>& blobs, double ratio);

}
