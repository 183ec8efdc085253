// SPDX-License-Identifier: BSD-3-Clause
// Measuring: where a tap puts an end of a distance, and how it comes to lie on the original. Step
// "pick" of the pipeline picture.
#pragma once

#include "viewer/session/model/ShownModel.h"
#include "viewer/session/tools/Measurement.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace kdstream
{

// An end is picked on what is shown, with the error of that. The partition around it is fetched as
// the original, before all else; where a triangle there reaches into others, these too. After each
// new surface the end is picked anew, by the same ray, until all corners there are the original's.
//
// In a section an end near the outline is on that, and so on the surface; one within the cap is a
// point of the plane, which is exact.
class MeasureTool
{
public:
  static constexpr std::size_t mostMeasurements = 64;

  explicit MeasureTool(ShownModel& model)
    : Model(model)
  {
  }
  MeasureTool(const MeasureTool&) = delete;

  void Reset(); // another model
  // Oldest first.
  const std::vector<Measurement>& All() const { return this->Measured; }
  // Begins a distance or ends the one that was begun. slack: the tangent of the angle that a finger
  // covers. False where nothing was hit, or there are as many as may be.
  bool MeasureAt(const Ray& ray, double slack);
  // As somebody else measured, in place of these: all points are on the original, to which they
  // come when it is there.
  void Take(const std::vector<std::array<Vec3, 2>>& measured);
  void Name(std::size_t index, const std::string& name);
  void Remove(std::size_t index);
  void DropHalf(); // a distance that was only begun

  // Whether any end waits for the original.
  bool Waits() const { return !this->Ends.empty(); }
  // Which partitions are around the ends that wait, as far as the tree is known; what else is
  // needed, the tree notes as missing. Where something of that has failed an end stays on the
  // level.
  void FollowTree();
  // On the surface that has just been drawn, by the finger of now.
  void FollowSurface(double slack);
  // Appends the partitions that are to be the original.
  void AddTo(std::vector<PieceId>& pieces) const;

private:
  // An end of a measurement that is not on the original yet.
  struct End
  {
    std::size_t measurement = 0;
    bool isSecond = false;
    bool isOfLink = false;              // by a link: the ray begins there, and goes nowhere
    Ray ray;                            // by which it was picked
    std::set<std::uint32_t> partitions; // that are to be the original
    std::vector<Vec3> around;           // places whose partitions are to be, once they are known
  };

  void Add(const std::array<Vec3, 2>& points);
  std::optional<SurfaceHit> EndOn(const Ray& ray, double slack) const;
  std::optional<SurfaceHit> EndAt(const Vec3& point, double error) const;
  MeasuredPoint& PointOf(const End& end);
  bool Settle(End& end, const SurfaceHit& hit);
  bool IsGivenUp(const End& end) const;

  ShownModel& Model;
  std::vector<Measurement> Measured;
  std::size_t Made = 0;
  std::vector<End> Ends; // that wait for the original
};

}
