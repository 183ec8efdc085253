// SPDX-License-Identifier: BSD-3-Clause
// The tools that a user may choose, and what fingers do with them: distances, a section, raking
// light. Steps "navigate" and "draw" of the pipeline picture.
#pragma once

#include "viewer/session/GestureRecognizer.h"
#include "viewer/session/ViewLink.h"
#include "viewer/session/appearance/RakingLight.h"
#include "viewer/session/model/ShownModel.h"
#include "viewer/session/tools/MeasureTool.h"

#include <optional>
#include <string>

namespace kdstream
{

// One tool is in hand at a time. What any tool has made stays until another model is selected.
class Tools
{
public:
  explicit Tools(ShownModel& model)
    : Model(model)
    , Measures(model)
  {
  }
  Tools(const Tools&) = delete;

  void Reset(); // another model; the tool stays in hand
  // An unfinished measurement is dropped.
  void TakeInHand(Tool tool);
  Tool InHand() const { return this->Hand; }
  // Whether the chosen tool uses a gesture. Then the gesture does not move the camera, except for
  // the zoom of a pinch.
  bool Take(const Gesture& gesture, const Camera& camera);

  // The surface has changed.
  void FollowSurface(const Camera& camera)
  {
    this->Measures.FollowSurface(camera.TangentOf(fingerPoints));
  }

  MeasureTool& Measuring() { return this->Measures; }
  const MeasureTool& Measuring() const { return this->Measures; }
  const std::optional<RakingLight>& Light() const { return this->Raking; }
  // Nothing: the standard light. Values out of range are clamped.
  void SetLight(const std::optional<RakingLight>& light);

  // Writes measurements, section and light into a link, relative to the camera's fitted box.
  void PutInto(ViewLink& link, const Camera& camera) const;
  void TakeFrom(const ViewLink& link, const Camera& camera);

private:
  void DragSection(double dx, double dy, const Camera& camera);
  void TurnSection(double dx, double dy, const Camera& camera);
  void ShineFrom(double x, double y, const Viewport& window);

  ShownModel& Model;
  MeasureTool Measures;
  std::optional<RakingLight> Raking;
  Tool Hand = Tool::None;
};

// The section's outline as SVG (SectionDrawing); empty without a section.
std::string SectionOutline(const ShownModel& model);

}
