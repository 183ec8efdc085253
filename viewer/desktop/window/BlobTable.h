// SPDX-License-Identifier: BSD-3-Clause
// What is shown, in numbers, and what came of it, a row a blob (paper, Tables 4-6).
#pragma once

#include "viewer/session/SessionTypes.h"

#include <deque>

namespace kdstream
{

struct PanelFacts;

// Both in Dear ImGui, within a window.
void DrawFacts(const PanelFacts& facts);
// The newest first. ratio: pixels a point.
void DrawBlobTable(const std::deque<BlobStatistics>& blobs, double ratio);

}
