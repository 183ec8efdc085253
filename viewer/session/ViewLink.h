// SPDX-License-Identifier: BSD-3-Clause
// Links to views, by which one viewer gives its view to another. Step "navigate" of the pipeline
// picture.
//
//   model=dragon&digest=76cfa554&view=AX9…&turning=free&detail=level&region=1234.2
//
// is the text after the # of a viewer's URL (doc/viewing.md#links-to-views).
#pragma once

#include "filters/core/Result.h"
#include "viewer/session/Camera.h"
#include "viewer/session/SessionTypes.h"
#include "viewer/session/appearance/RakingLight.h"
#include "viewer/session/section/SectionPlane.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

struct ViewLink
{
  struct Region
  {
    NodeId cell = 1;
    unsigned rings = 1;
    bool operator==(const Region&) const = default;
  };

  std::string model;                // its id
  std::string digest;               // beginning of the model's digest; empty: any
  std::optional<CameraPlace> place; // the camera's; nothing: the first view
  Turning turning = Turning::Upright;
  DetailMode detail = DetailMode::View;
  std::optional<Region> region; // shown as the original
  // The ends of measured distances, in the units of CameraPlace; at most mostMeasurements.
  std::vector<std::array<Vec3, 2>> measurements;
  std::optional<SectionPlane> section; // its offset is in the units of CameraPlace
  std::optional<RakingLight> lights;
  std::string colors, light; // as in session files; empty: the defaults
  bool operator==(const ViewLink&) const = default;

  static constexpr std::size_t digestDigits = 8;
  static constexpr std::size_t mostMeasurements = 16;
  static constexpr std::size_t longest = 2048; // characters
};

// The camera's numbers are rounded to less than a hundredth of a pixel. O(size).
std::string FormatViewLink(const ViewLink& link);

// Only the light, as links and session files write it; "standard" if there is none.
std::string FormatLights(const std::optional<RakingLight>& lights);
// The inverse of FormatLights. Errors: InvalidInput for any other text.
Result<std::optional<RakingLight>> ParseLights(std::string_view text);

// Parses any text. Unknown keys are skipped, so links of later versions open as far as possible.
// Errors: InvalidInput if the text is longer than ViewLink::longest, names no model, or has a value
// that its key cannot have.
Result<ViewLink> ParseViewLink(std::string_view text);

}
