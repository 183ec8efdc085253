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
  Resolution resolution; // the coarsest that had a part in what was picked
  // How far the mesh of which the store was built may be: for a level an estimate, see ErrorOf.
  double error = 0;   // model units
  bool waits = false; // for the original, which is asked for
  bool operator==(const MeasuredPoint&) const = default;
};

// How far a point of a resolution's surface may be from the input's, in model units. For the
// original an upper bound, the grid's rounding: 0 of a lossless store. For a level an estimate, its
// geometric error besides: that bounds how far the original is from the level, not the way back.
double ErrorOf(Resolution resolution, const ModelDescription& model);

struct Measurement
{
  std::string name;
  MeasuredPoint from;
  std::optional<MeasuredPoint> to; // nothing while there is only one end
  bool operator==(const Measurement&) const = default;

  // These three are 0 as long as there is no `to`.
  double Distance() const;                 // model units, straight
  double Height(const Vec3& up) const;     // of that along `up`, of length 1; below 0: downwards
  double Horizontal(const Vec3& up) const; // horizontal part of the distance
  // The distance in the input differs from this one by at most this.
  double Error() const;
  // Both ends are on the original.
  bool IsExact() const;
};

}
