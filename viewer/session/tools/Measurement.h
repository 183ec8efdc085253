// SPDX-License-Identifier: BSD-3-Clause
// Distances that the user measures between two points of the surface. Step "pick" of the pipeline
// picture.
#pragma once

#include "filters/core/Types.h"
#include "filters/core/pieces/Piece.h"
#include "filters/model/ModelDescription.h"

#include <optional>
#include <string>

namespace kdstream
{

struct MeasuredPoint
{
  Vec3 point{};          // model units
  Resolution resolution; // the coarsest among the corners that were picked
  // How far the point may be from the mesh that the store was built of; for a level an estimate
  // (ErrorOf).
  double error = 0;   // model units
  bool waits = false; // waits for the original, which has been requested
  bool operator==(const MeasuredPoint&) const = default;
};

// How far a point of a resolution's surface may be from the input's, in model units. For the
// original, this is an upper bound, the rounding to the grid: 0 for a lossless store. For a level,
// the geometric error is added, and this is an estimate: the geometric error bounds how far the
// original is from the level, not how far the level is from the original.
double ErrorOf(Resolution resolution, const ModelDescription& model);

struct Measurement
{
  std::string name;
  MeasuredPoint from;
  std::optional<MeasuredPoint> to; // nothing while there is only one end
  bool operator==(const Measurement&) const = default;

  // The next three are 0 as long as there is no `to`.
  double Distance() const;                 // model units, straight
  double Height(const Vec3& up) const;     // its part along `up`, of length 1; below 0: downwards
  double Horizontal(const Vec3& up) const; // horizontal part of the distance
  // The distance in the input mesh differs from Distance() by at most this.
  double Error() const;
  // Whether both ends are on the original.
  bool IsExact() const;
};

}
