// SPDX-License-Identifier: BSD-3-Clause
// Settings of a look as steps of a session file: see SettingSteps.h.
#include "viewer/desktop/SettingSteps.h"

#include <array>
#include <string>

namespace kdstream
{
namespace
{

using Kind = SessionStep::Kind;

constexpr std::array<SurfaceColoring, 4> allColorings{ SurfaceColoring::Own, SurfaceColoring::Stone,
  SurfaceColoring::Partition, SurfaceColoring::Resolution };

}

const char* NameOf(SurfaceColoring coloring)
{
  switch (coloring)
  {
    case SurfaceColoring::Stone:
      return "none";
    case SurfaceColoring::Partition:
      return "partition";
    case SurfaceColoring::Resolution:
      return "resolution";
    case SurfaceColoring::Own:
      break;
  }
  return "own";
}

const char* NameOf(DetailMode detail)
{
  return detail == DetailMode::Level ? "level" : detail == DetailMode::Full ? "full" : "view";
}

SessionStep ColoringStep(SurfaceColoring coloring)
{
  return { Kind::Colors, {}, NameOf(coloring) };
}

SessionStep LightStep(bool occlusion)
{
  return { Kind::Light, {}, occlusion ? "relief" : "plain" };
}

SessionStep BoxesStep(bool boxes)
{
  return { Kind::Boxes, {}, boxes ? "on" : "off" };
}

SessionStep DetailStep(DetailMode detail)
{
  return { Kind::Detail, {}, NameOf(detail) };
}

SessionStep RingsStep(unsigned rings)
{
  SessionStep step{ Kind::Rings, {} };
  step.rings = rings;
  return step;
}

SessionStep BudgetsStep(std::uint64_t triangles, std::uint64_t memory)
{
  SessionStep step{ Kind::Budgets, {} };
  step.triangles = triangles;
  step.memory = memory;
  return step;
}

std::string LinkTo(const ViewerSession& session, const SceneSettings& settings)
{
  ViewLink link = session.Link();
  link.colors = settings.coloring == SurfaceColoring::Own ? "" : NameOf(settings.coloring);
  link.light = settings.occlusion ? "" : "plain";
  return FormatViewLink(link);
}

void Perform(const SessionStep& step, SceneSettings& settings)
{
  if (step.kind == Kind::Light)
  {
    settings.occlusion = step.name == "relief";
  }
  if (step.kind == Kind::Boxes)
  {
    settings.boxes = step.name == "on";
  }
  for (const SurfaceColoring coloring : allColorings)
  {
    if (step.kind == Kind::Colors && step.name == NameOf(coloring))
    {
      settings.coloring = coloring;
    }
  }
}

}
