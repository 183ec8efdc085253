// SPDX-License-Identifier: BSD-3-Clause
// A panel of tools, in Dear ImGui: standard views, automatic turning, distances and links.
#pragma once

#include "viewer/session/tools/Measurement.h"

#include <string>

namespace kdstream
{

struct PanelFacts;
struct PanelWishes;

// Draws a window of widgets with a button that closes it. top: where the window first appears,
// pixels.
void DrawToolsPanel(const PanelFacts& facts, PanelWishes& wishes, bool& isOpen, float top);
// Draws the distances as lines over the picture.
void DrawDistances(const PanelFacts& facts);
// Draws title, credit and licence at the upper edge, on top of everything and on a background of
// their own. Returns their height in pixels; 0 if there is no text.
int DrawCaption(const PanelFacts& facts, int width);

// Returns "12.35 ± 0.01 mm, height 3.2 mm, across 11.9 mm", with as many digits as are certain with
// the error, six if the error is 0. up: of length 1.
std::string DescribeMeasurement(
  const Measurement& measurement, const Vec3& up, const std::string& unit);

}
