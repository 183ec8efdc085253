// SPDX-License-Identifier: BSD-3-Clause
// What mouse, fingers and keys do to the window, as a list in Dear ImGui.
#pragma once

namespace kdstream
{

struct PanelFacts;

// A window of widgets, which closes itself.
void DrawHelp(const PanelFacts& facts, bool& isOpen);

}
