// SPDX-License-Identifier: BSD-3-Clause
// How far the eye may move: see FreeWay.h.
#include "viewer/session/camera/FreeWay.h"

#include <algorithm>
#include <limits>

namespace kdstream
{
namespace
{

constexpr double mostOfTheWay = 0.9; // to the obstacle ahead
// The least distance that is kept from the obstacle, larger than rounding errors.
constexpr double leastInDiagonals = 1e-5;

// The distance to the surface, or to the box if no surface is shown; infinity if nothing is ahead.
double DistanceToObstacle(const ShownModel& model, const Ray& ray, double slack)
{
  constexpr double none = std::numeric_limits<double>::infinity();
  if (!model.surface.IsEmpty())
  {
    const auto hit = model.Pick(ray, slack);
    return hit ? hit->distance : none;
  }
  const Box& box = model.open->description.box;
  double enters = 0, leaves = none;
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double a = (box.lo[k] - ray.origin[k]) / ray.direction[k];
    const double b = (box.hi[k] - ray.origin[k]) / ray.direction[k];
    if (ray.direction[k] != 0)
    {
      enters = std::max(enters, std::min(a, b));
      leaves = std::min(leaves, std::max(a, b));
    }
    else if (ray.origin[k] < box.lo[k] || ray.origin[k] > box.hi[k])
    {
      return none;
    }
  }
  return enters <= leaves ? enters : none;
}

}

double FreePart(const ShownModel& model, const Camera& from, const Camera& to, double slack)
{
  const Vec3 way = to.Eye() - from.Eye();
  const double length = Length(way);
  if (length == 0 || to.DistanceTo(model.open->description.box) > 0)
  {
    return 1;
  }
  const double ahead = DistanceToObstacle(model, { from.Eye(), way * (1 / length) }, slack);
  const Box& box = model.open->description.box;
  const double least = leastInDiagonals * Length(box.hi - box.lo);
  const double most = std::max(0.0, std::min(mostOfTheWay * ahead, ahead - least));
  return std::min(1.0, most / length);
}

void KeepInSight(const ShownModel& model, Camera& camera)
{
  if (const auto nearest =
        NearestOnSurface(model.Drawn(), camera.Focal(), camera.Reach(), model.Plane()))
  {
    camera.KeepInSight(nearest->point);
  }
}

bool IsInside(const ShownModel& model, const Camera& camera)
{
  const SectionPlane* section = model.Plane();
  return camera.DistanceTo(model.open->description.box) == 0 &&
         !(section && section->CutsAway(camera.Eye())) && IsAround(model.Drawn(), camera.Eye());
}

}
