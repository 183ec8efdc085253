// SPDX-License-Identifier: BSD-3-Clause
// The section that the user has put through the model: moving it, and its outline and cap. Below
// the steps "navigate" and "draw" of the pipeline picture.
#pragma once

#include "viewer/session/Picker.h"
#include "viewer/session/section/SurfaceSection.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace kdstream
{

// There is no plane at first. A plane always goes through the model's box, or touches it.
class ShownSection
{
public:
  // Another model: removes the plane.
  void Reset(const Box& box);

  const std::optional<SectionPlane>& Plane() const { return this->Cut; }
  // Sets the plane, or removes it. Its normal may have any length above 0. Values that are not
  // finite change nothing.
  void Set(const std::optional<SectionPlane>& plane);
  // Sets a plane through the middle of the box. "x", "y", "z": across that axis; "view": across the
  // line of sight. The side of the eye is cut away (toEye: the direction from the middle to the
  // eye). "flip": cuts away the other side. "off": removes the plane. For other words: false, and
  // no change.
  bool SetAlong(std::string_view word, const Vec3& toEye);
  // The same across any direction.
  void SetAcross(const Vec3& direction, const Vec3& toEye);
  // How much of the box's length along the normal is cut away: 0-1. 0 without a plane.
  double Depth() const;
  void SetDepth(double depth);
  // Moves the plane along its normal by `length` model units; if that is above 0, more is kept.
  void Move(double length);
  // Turns the plane about its point nearest to the middle of the box. Within 5 degrees of an axis
  // it snaps to the axis, until it is turned further.
  void Turn(const Quaternion& turn);

  // If the plane or the surface has changed, computes the outline and, for a closed surface, the
  // cap. surfaceVersion: the version of `surface`. Complexity: as CutSurface and CapOf.
  void Follow(const DrawnSurface& surface, std::uint64_t surfaceVersion, bool isClosed);
  // The cap that fills the plane where the model is solid; null if there is none. Its version grows
  // whenever it changes.
  const std::shared_ptr<const Surface>& Cap() const { return this->Filling; }
  std::uint64_t CapVersion() const { return this->FillingVersion; }
  const std::vector<SectionSegment>& Outline() const { return this->Segments; }

  // As PickSurface, for what the section leaves: the surface, or the cap if it is nearer.
  std::optional<SurfaceHit> Pick(
    const DrawnSurface& surface, const Ray& ray, double slack = 0) const;
  // The point of the outline nearest to `point`, with its triangle, if it is at most `most` away.
  // O(segments).
  std::optional<SurfaceHit> NearestOnOutline(const Vec3& point, double most) const;

  // SurfaceHit::part of a hit on the cap, which belongs to no part.
  static constexpr std::size_t capPart = static_cast<std::size_t>(-1);

private:
  void Take(const SectionPlane& plane);

  Box Around;
  std::optional<SectionPlane> Cut;
  Vec3 Turned{}; // the normal as fingers have turned it, before it snaps to an axis
  struct Basis
  {
    SectionPlane plane;
    std::uint64_t surface = 0;
    bool isClosed = false;
    bool operator==(const Basis&) const = default;
  };
  std::optional<Basis> Made; // the inputs of the next three members
  std::vector<SectionSegment> Segments;
  std::shared_ptr<const Surface> Filling;
  std::uint64_t FillingVersion = 0;
};

}
