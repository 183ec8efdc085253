// SPDX-License-Identifier: BSD-3-Clause
// Tools for looking: sides, turning by itself, distances and links, in Dear ImGui.
#pragma once

#include "viewer/session/tools/Measurement.h"

#include <string>

namespace kdstream
{

struct PanelFacts;
struct PanelWishes;

// A window of widgets, which closes itself. top: where it appears, pixels.
void DrawToolsPanel(const PanelFacts& facts, PanelWishes& wishes, bool& isOpen, float top);
// The distances as lines over the picture.
void DrawDistances(const PanelFacts& facts);
// Title, credit and licence in front of all, at the top, on their own ground. Returns the height
// that they take, pixels; 0 where there is nothing to say.
int DrawCaption(const PanelFacts& facts, int width);

// "12.35 ± 0.01 mm, height 3.2 mm, across 11.9 mm": as many digits as the error leaves, six where
// there is none. up: of length 1.
std::string DescribeMeasurement(
  const Measurement& measurement, const Vec3& up, const std::string& unit);

}
