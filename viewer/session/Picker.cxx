// SPDX-License-Identifier: BSD-3-Clause
// Finds what is under a finger: step "pick" of the pipeline picture.
//
// T. Möller, B. Trumbore: Fast, Minimum Storage Ray/Triangle Intersection, 1997. A point of the
// triangle is a + u (b - a) + v (c - a); setting it equal to o + t d gives three equations for t, u
// and v, solved by Cramer.
#include "viewer/session/Picker.h"

#include "filters/core/TriangleDistance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kdstream
{
namespace
{

// How much boxes are enlarged, so that rounding loses no hit. A point found in the box of a
// triangle is in every box around that triangle if the box is enlarged by twice this margin.
double MarginOf(const Box& box, const Ray& ray)
{
  double reach = 0, origin = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    origin = std::max(origin, std::abs(ray.origin[k]));
    reach =
      std::max({ reach, std::abs(box.lo[k] - ray.origin[k]), std::abs(box.hi[k] - ray.origin[k]) });
  }
  return 1e-9 * reach + 1e-15 * origin;
}

// The parameter t of the ray where it meets the triangle, in front of the origin.
std::optional<double> Meet(
  const Ray& ray, const Vec3& a, const Vec3& b, const Vec3& c, double margin)
{
  const Vec3 ab = b - a, ac = c - a;
  const Vec3 p = Cross(ray.direction, ac);
  const double determinant = Dot(ab, p);
  if (!(determinant > 0 || determinant < 0))
  {
    return std::nullopt; // parallel to the ray, or degenerate
  }
  const Vec3 toOrigin = ray.origin - a;
  const double u = Dot(toOrigin, p) / determinant;
  if (!(u >= 0 && u <= 1))
  {
    return std::nullopt;
  }
  const Vec3 q = Cross(toOrigin, ab);
  const double v = Dot(ray.direction, q) / determinant;
  const double t = Dot(ac, q) / determinant;
  if (!(v >= 0 && u + v <= 1) || !(t > 0) || !std::isfinite(t))
  {
    return std::nullopt;
  }
  const Vec3 point = ray.origin + ray.direction * t;
  for (std::size_t k = 0; k < 3; ++k)
  {
    if (point[k] < std::min({ a[k], b[k], c[k] }) - margin ||
        point[k] > std::max({ a[k], b[k], c[k] }) + margin)
    {
      return std::nullopt;
    }
  }
  return t;
}

std::optional<double> Meet(
  const Ray& ray, const Surface& surface, std::size_t triangle, double margin)
{
  const Triangle& t = surface.triangles[triangle];
  return Meet(ray, surface.points[t[0]], surface.points[t[1]], surface.points[t[2]], margin);
}

constexpr double never = std::numeric_limits<double>::infinity();

// How far along a ray a box begins, if the box is enlarged by a margin; `never` if the ray misses
// the box.
double EntryOf(const Ray& ray, const Box& box, double margin)
{
  double begin = 0, end = never;
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double lo = box.lo[k] - margin - ray.origin[k], hi = box.hi[k] + margin - ray.origin[k];
    const double d = ray.direction[k];
    if (d == 0)
    {
      if (lo > 0 || hi < 0)
      {
        return never;
      }
      continue;
    }
    begin = std::max(begin, std::min(lo / d, hi / d));
    end = std::min(end, std::max(lo / d, hi / d));
  }
  return begin <= end ? begin : never;
}

// A cone around the ray: points whose distance from the ray is at most `slack` times their distance
// along it. Returns a lower bound of how far along the ray the points are that box and cone share;
// infinity if they can share none. Uses the sphere around the box.
double EntryOfCone(const Ray& ray, const Box& box, double slack, double margin)
{
  const Vec3 middle = box.lo * 0.5 + box.hi * 0.5 - ray.origin;
  const double radius = Length(box.hi * 0.5 - box.lo * 0.5) + margin;
  const double t = Dot(middle, ray.direction);
  const double aside = Length(middle - ray.direction * t);
  return t + radius > 0 && aside - radius <= slack * (t + radius) ? std::max(t - radius, 0.0)
                                                                  : never;
}

// How far along the ray a point is; nothing if it is too far from the ray.
std::optional<double> MeetPoint(const Ray& ray, const Vec3& point, double slack)
{
  const Vec3 toPoint = point - ray.origin;
  const double t = Dot(toPoint, ray.direction);
  const Vec3 aside = toPoint - ray.direction * t;
  return t > 0 && Dot(aside, aside) <= slack * t * (slack * t) ? std::optional(t) : std::nullopt;
}

// Keeps the nearest of the offered hits; among equals the one with the lowest number.
struct Nearest
{
  double begin = 0; // nearer hits do not count
  std::optional<SurfaceHit> hit{};

  void Offer(std::optional<double> t, std::size_t number, const Vec3& point)
  {
    const bool isNearer = t && *t >= this->begin &&
                          (!this->hit || *t < this->hit->distance ||
                            (*t == this->hit->distance && number < this->hit->triangle));
    if (isNearer)
    {
      this->hit = SurfaceHit{ point, number, *t };
    }
  }
  double Distance() const { return this->hit ? this->hit->distance : never; }
};

// The target of a ray: a triangle, or a point of a cloud.
class Target
{
public:
  Target(const Surface& surface, const Box& bounds, const Ray& ray, double slack)
    : Of(surface)
    , Along(ray)
    , Slack(slack)
    , Margin(MarginOf(bounds, ray))
  {
  }

  void Offer(std::size_t i, Nearest& nearest) const
  {
    if (this->IsCloud())
    {
      const Vec3& point = this->Of.points[i];
      nearest.Offer(MeetPoint(this->Along, point, this->Slack), i, point);
      return;
    }
    const auto t = Meet(this->Along, this->Of, i, this->Margin);
    nearest.Offer(t, i, this->Along.origin + this->Along.direction * t.value_or(0));
  }
  double Entry(const Box& box) const
  {
    return this->IsCloud() ? EntryOfCone(this->Along, box, this->Slack, 2 * this->Margin)
                           : EntryOf(this->Along, box, 2 * this->Margin);
  }
  // The most by which rounding can make a hit nearer than the box of its triangle.
  double Tolerance() const { return 4 * this->Margin; }

private:
  bool IsCloud() const { return this->Of.triangles.empty(); }

  const Surface& Of;
  const Ray& Along;
  double Slack, Margin;
};

}

std::optional<SurfaceHit> PickSurface(const Surface& surface, const Ray& ray, double slack)
{
  const Target target(surface, BoundsOf(surface), ray, slack);
  const std::size_t count =
    surface.triangles.empty() ? surface.points.size() : surface.triangles.size();
  Nearest nearest;
  for (std::size_t i = 0; i < count; ++i)
  {
    target.Offer(i, nearest);
  }
  return nearest.hit;
}

std::optional<SurfaceHit> PickSurface(
  const DrawnSurface& surface, const Ray& ray, double slack, std::size_t* visited, double begin)
{
  std::optional<SurfaceHit> best;
  for (const DrawnSurface::Part& each : surface.Parts())
  {
    const Surface& part = each.part->surface;
    if (part.triangles.empty() && surface.TriangleCount() > 0)
    {
      continue; // points without triangles are not drawn
    }
    const Target target(part, each.part->Bounds(), ray, slack);
    Nearest nearest{ begin };
    const double sofar = best ? best->distance : never;
    const auto enter = [&](const Box& box)
    {
      const double entry = target.Entry(box);
      return entry - target.Tolerance() > std::min(sofar, nearest.Distance()) ? never : entry;
    };
    if (enter(each.part->Bounds()) == never)
    {
      continue;
    }
    each.part->Tree().Walk(enter,
      [&](std::size_t i)
      {
        target.Offer(i, nearest);
        if (visited)
        {
          ++*visited;
        }
      });
    if (nearest.Distance() < sofar)
    {
      best = nearest.hit;
      best->part = static_cast<std::size_t>(&each - surface.Parts().data());
    }
  }
  return best;
}

std::optional<SurfaceHit> NearestOnSurface(
  const DrawnSurface& surface, const Vec3& point, double enough, const SectionPlane* section)
{
  SurfaceHit nearest{ {}, 0, never };
  const auto enter = [&](const Box& box)
  {
    const double entry = DistanceTo(box, point);
    const bool isGone = section && section->CutsAwayAllOf(box);
    return nearest.distance <= enough || entry >= nearest.distance || isGone ? never : entry;
  };
  const auto isGone = [section](const Vec3& place) { return section && section->CutsAway(place); };
  for (const DrawnSurface::Part& each : surface.Parts())
  {
    const Surface& part = each.part->surface;
    if ((part.triangles.empty() && surface.TriangleCount() > 0) ||
        enter(each.part->Bounds()) == never)
    {
      continue;
    }
    each.part->Tree().Walk(enter,
      [&](std::size_t i)
      {
        const Triangle t = part.triangles.empty() ? Triangle{} : part.triangles[i];
        const Vec3 found = part.triangles.empty() ? part.points[i]
                                                  : NearestOnTriangle(point, part.points[t[0]],
                                                      part.points[t[1]], part.points[t[2]]);
        const double distance = Length(found - point);
        const bool isLeft =
          part.triangles.empty()
            ? !isGone(found)
            : !std::all_of(t.begin(), t.end(), [&](VertexId v) { return isGone(part.points[v]); });
        if (distance < nearest.distance && isLeft)
        {
          const auto number = static_cast<std::size_t>(&each - surface.Parts().data());
          nearest = { found, i, distance, number };
        }
      });
  }
  return nearest.distance < never ? std::optional(nearest) : std::nullopt;
}

bool IsAround(const DrawnSurface& surface, const Vec3& point)
{
  const auto isOdd = [&](const Vec3& direction)
  {
    const Ray ray{ point, direction };
    bool odd = false;
    for (const DrawnSurface::Part& each : surface.Parts())
    {
      const Surface& part = each.part->surface;
      if (part.triangles.empty())
      {
        continue;
      }
      const double margin = MarginOf(each.part->Bounds(), ray);
      const auto enter = [&](const Box& box) { return EntryOf(ray, box, 2 * margin); };
      if (enter(each.part->Bounds()) == never)
      {
        continue;
      }
      each.part->Tree().Walk(
        enter, [&](std::size_t i) { odd = odd != Meet(ray, part, i, margin).has_value(); });
    }
    return odd;
  };
  // Directions that edges of models hardly ever have.
  const bool first = isOdd({ 0.6, 0.64, 0.48 }), second = isOdd({ -0.48, 0.36, 0.8 });
  return first == second ? first : isOdd({ 0.36, -0.8, 0.48 });
}

}
