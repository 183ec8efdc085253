// SPDX-License-Identifier: BSD-3-Clause
// The window's panels about colours: what can be chosen, and what the colours mean.
#pragma once

#include "filters/model/ModelDescription.h"
#include "viewer/session/appearance/Coloring.h"

namespace kdstream
{

struct PanelFacts;

// Call this between Begin and End of an ImGui window.
void DrawColorChoice(const PanelFacts& facts, ColorChoice& colors);

// Draws the legend at the right edge, above the lowest `below` pixels; draws nothing if no
// attribute is shown. The legend is in ImGui's background, so it is also part of the pictures that
// are written.
void DrawColorLegend(const PanelFacts& facts, const ColorChoice& colors, double below);

// Cycles through the choices of colours: the model's own, then each of its arrays of numbers, then
// its own again. model: null if none is open.
ColorChoice NextColors(const ColorChoice& colors, const ModelDescription* model);

}
