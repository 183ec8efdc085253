// SPDX-License-Identifier: BSD-3-Clause
// Distances that the user measures: see Measurement.h.
#include "viewer/session/tools/Measurement.h"

#include "filters/core/VectorMath.h"

#include <cmath>

namespace kdstream
{

// Rounding moves a point by half a step along each axis at most.
double ErrorOf(Resolution resolution, const ModelDescription& model)
{
  const bool isLevel = !resolution.IsOriginal() && resolution.Depth() < model.levels.size();
  const ResolutionDescription& shown = isLevel ? model.levels[resolution.Depth()] : model.original;
  const double step = model.grid.Lossless() ? 0 : model.grid.step * shown.spacing;
  return (isLevel ? shown.geometricError : 0) + std::sqrt(3.0) / 2 * step;
}

double Measurement::Distance() const
{
  return this->to ? Length(Minus(this->to->point, this->from.point)) : 0;
}

double Measurement::Height(const Vec3& up) const
{
  return this->to ? Dot(Minus(this->to->point, this->from.point), up) : 0;
}

double Measurement::Horizontal(const Vec3& up) const
{
  return this->to
           ? Length(Minus(Minus(this->to->point, this->from.point), Times(up, this->Height(up))))
           : 0;
}

double Measurement::Error() const
{
  return this->from.error + (this->to ? this->to->error : 0);
}

bool Measurement::IsExact() const
{
  return this->to && this->from.resolution.IsOriginal() && this->to->resolution.IsOriginal();
}

}
