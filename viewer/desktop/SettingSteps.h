// SPDX-License-Identifier: BSD-3-Clause
// Records settings of the display as steps of a session file, so that a recording is played with
// the same settings. The session performs steps about what is shown; the steps about how it is
// drawn are performed here.
#pragma once

#include "viewer/rendering/SurfaceScene.h"
#include "viewer/session/SessionFile.h"
#include "viewer/session/ViewerSession.h"
#include "viewer/session/appearance/Coloring.h"

#include <cstdint>
#include <string>

namespace kdstream
{

// How a scene is drawn: settings that a session does not know.
struct SceneSettings
{
  ColorChoice colors;
  bool occlusion = true;
  bool boxes = false;     // boxes around the region's partitions
  bool legend = false;    // for the colours of an array
  bool distances = false; // the distances that were measured
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

// Returns a link to the current view, in the format of ViewLink.h.
std::string LinkTo(const ViewerSession& session, const SceneSettings& settings);

// Changes the settings as a step about light, boxes or colours says; other steps change nothing.
void Perform(const SessionStep& step, SceneSettings& settings);

}
