// SPDX-License-Identifier: BSD-3-Clause
// What the window says of colours: which there are to choose from, and what they mean.
#pragma once

#include "filters/model/ModelDescription.h"
#include "viewer/session/appearance/Coloring.h"

namespace kdstream
{

struct PanelFacts;

// Between Begin and End of a panel of ImGui.
void DrawColorChoice(const PanelFacts& facts, ColorChoice& colors);

// Draws the legend at the right edge, above the lowest `below` pixels; nothing if no attribute is
// shown. It is in the background, so that it appears in pictures that are written, too.
void DrawColorLegend(const PanelFacts& facts, const ColorChoice& colors, double below);

// The next choice of colours: the model's own, then each of its arrays of numbers, then its own
// again. model: null if none is open.
ColorChoice NextColors(const ColorChoice& colors, const ModelDescription* model);

}
