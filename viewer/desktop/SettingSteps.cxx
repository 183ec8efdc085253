// SPDX-License-Identifier: BSD-3-Clause
// Settings of the display as steps of a session file: see SettingSteps.h.
#include "viewer/desktop/SettingSteps.h"

#include <optional>
#include <string>

namespace kdstream
{
namespace
{

using Kind = SessionStep::Kind;

}

const char* NameOf(DetailMode detail)
{
  return detail == DetailMode::Level ? "level" : detail == DetailMode::Full ? "full" : "view";
}

SessionStep ColorsStep(const ColorChoice& colors)
{
  return { Kind::Colors, {}, FormatColors(colors) };
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
  link.colors = settings.colors == ColorChoice{} ? "" : FormatColors(settings.colors);
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
  const auto colors = step.kind == Kind::Colors ? ParseColors(step.name) : std::nullopt;
  settings.colors = colors ? *colors : settings.colors;
}

}
