// SPDX-License-Identifier: BSD-3-Clause
// Measuring: picks the ends of a distance by taps, and moves them to the original. Step "pick" of
// the pipeline picture.
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

// An end is picked on the shown surface, with the error of the resolution there. The partition
// around it is then fetched as the original, before everything else. If the hit triangle reaches
// into other partitions, these are fetched too. After each new surface the end is picked again, by
// the same ray, until all corners of the hit triangle are the original's.
//
// In a section, an end near the outline is on the outline, and so on the surface; an end within the
// cap is a point of the plane, which is exact.
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
  // Begins a distance, or ends the one that was begun. slack: the tangent of the angle that a
  // finger covers. False if nothing was hit, or if there are already as many distances as allowed.
  bool MeasureAt(const Ray& ray, double slack);
  // Replaces the distances by those of another user. Their ends are points of the original, and are
  // moved to it when it has arrived.
  void Take(const std::vector<std::array<Vec3, 2>>& measured);
  void Name(std::size_t index, const std::string& name);
  void Remove(std::size_t index);
  void DropHalf(); // drops a distance that was only begun

  // Whether any end waits for the original.
  bool Waits() const { return !this->Ends.empty(); }
  // Finds which partitions are around the waiting ends, as far as the tree is known; the tree
  // records as missing what else is needed. If some of that has failed, the end stays on the level.
  void FollowTree();
  // Picks the waiting ends again, on the surface that has just been drawn. slack: as in MeasureAt,
  // for the current camera.
  void FollowSurface(double slack);
  // Appends the partitions that must be shown as the original.
  void AddTo(std::vector<PieceId>& pieces) const;

private:
  // An end of a measurement that is not on the original yet.
  struct End
  {
    std::size_t measurement = 0;
    bool isSecond = false;
    bool isOfLink = false; // from a link: the ray's origin is the point, its direction is 0
    Ray ray;               // the ray of the pick
    std::set<std::uint32_t> partitions; // that must be shown as the original
    std::vector<Vec3> around;           // places whose partitions will be known later
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
  std::vector<End> Ends; // all of them wait for the original
};

}
