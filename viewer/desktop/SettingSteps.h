// SPDX-License-Identifier: BSD-3-Clause
// Records settings of the display as steps of a session file, so that a recording is played with
// the same settings. Steps about what is shown go to the session (Perform); how it is drawn is kept
// here.
#pragma once

#include "viewer/rendering/SurfaceScene.h"
#include "viewer/session/SessionFile.h"
#include "viewer/session/ViewerSession.h"
#include "viewer/session/appearance/Coloring.h"

#include <cstdint>
#include <string>

namespace kdstream
{

// How a scene is drawn: what no session knows.
struct SceneSettings
{
  ColorChoice colors;
  bool occlusion = true;
  bool boxes = false;     // of the region's partitions
  bool legend = false;    // whether a legend is shown for an array's colours
  bool distances = false; // that were measured
  bool operator==(const SceneSettings&) const = default;
};

// As the options of kdstream-view name them: "view", "level", "full".
const char* NameOf(DetailMode detail);

SessionStep ColorsStep(const ColorChoice& colors);
SessionStep LightStep(bool occlusion);
SessionStep BoxesStep(bool boxes);
SessionStep DetailStep(DetailMode detail);
SessionStep RingsStep(unsigned rings);
SessionStep BudgetsStep(std::uint64_t triangles, std::uint64_t memory);

// A link to what is seen, as ViewLink.h has it.
std::string LinkTo(const ViewerSession& session, const SceneSettings& settings);

// Does what the step changes of these; nothing where it is of another kind.
void Perform(const SessionStep& step, SceneSettings& settings);

}
