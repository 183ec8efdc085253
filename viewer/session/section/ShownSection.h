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

// No plane at first. It goes through the model's box, or touches it.
class ShownSection
{
public:
  // Another model: removes the plane.
  void Reset(const Box& box);

  const std::optional<SectionPlane>& Plane() const { return this->Cut; }
  // Normals of any length but 0; what is not finite changes nothing.
  void Set(const std::optional<SectionPlane>& plane);
  // Sets the section: "x", "y", "z": across that axis; "view": across the line of sight; through
  // the middle of the box. The side of the eye is cut away (toEye: direction from the middle).
  // "flip": cuts away the other side. "off". False, and no change, for other words.
  bool SetAlong(std::string_view word, const Vec3& toEye);
  // The same across any direction.
  void SetAcross(const Vec3& direction, const Vec3& toEye);
  // How much of the box's length along the normal is cut away: 0-1. 0 without a plane.
  double Depth() const;
  void SetDepth(double depth);
  // Along the normal, model units; so that more is kept where `length` is above 0.
  void Move(double length);
  // Turns the plane about its point nearest to the middle of the box. Within 5 degrees of an axis
  // it snaps to the axis, until it is turned further.
  void Turn(const Quaternion& turn);

  // Computes the outline and, if the surface is closed, the cap, if plane or surface have changed.
  // surfaceVersion: of `surface`. As CutSurface and CapOf.
  void Follow(const DrawnSurface& surface, std::uint64_t surfaceVersion, bool isClosed);
  // The cap that fills the plane where the model is solid; null if there is none. Its version grows
  // whenever it changes.
  const std::shared_ptr<const Surface>& Cap() const { return this->Filling; }
  std::uint64_t CapVersion() const { return this->FillingVersion; }
  const std::vector<SectionSegment>& Outline() const { return this->Segments; }

  // As PickSurface, for what the section leaves: the surface, or the cap before it.
  std::optional<SurfaceHit> Pick(
    const DrawnSurface& surface, const Ray& ray, double slack = 0) const;
  // The point of the outline nearest to `point`, with its triangle, if it is at most `most` away.
  // O(segments).
  std::optional<SurfaceHit> NearestOnOutline(const Vec3& point, double most) const;

  // The triangle of a hit on the cap, where there is none.
  static constexpr std::size_t capPart = static_cast<std::size_t>(-1);

private:
  void Take(const SectionPlane& plane);

  Box Around;
  std::optional<SectionPlane> Cut;
  Vec3 Turned{}; // the normal as turned by fingers
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
