// SPDX-License-Identifier: BSD-3-Clause
// What the window says of colours: which there are to choose from, and what they mean.
#pragma once

#include "filters/model/ModelDescription.h"
#include "viewer/session/look/Coloring.h"

namespace kdstream
{

struct PanelFacts;

// Between Begin and End of a panel of ImGui.
void DrawColorChoice(const PanelFacts& facts, ColorChoice& colors);

// At the right edge, above what takes `below` pixels at the lower one; nothing where no attribute
// is shown. Behind the panels, so it is in pictures that are written, too.
void DrawColorLegend(const PanelFacts& facts, const ColorChoice& colors, double below);

// The model's own colours, by each of its arrays of numbers, and its own again. model: null without
// one.
ColorChoice NextColors(const ColorChoice& colors, const ModelDescription* model);

}
