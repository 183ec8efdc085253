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
// Draws title, credit and licence on top of everything, at the upper edge, on a background of their
// own. Returns their height in pixels; 0 if there is no text.
int DrawCaption(const PanelFacts& facts, int width);

// "12.35 ± 0.01 mm, height 3.2 mm, across 11.9 mm": with as many digits as the error allows, six if
// there is no error. up: of length 1.
std::string DescribeMeasurement(
  const Measurement& measurement, const Vec3& up, const std::string& unit);

}
