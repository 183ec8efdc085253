// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/HardPoints.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>

namespace kdstream::fixtures
{
namespace
{

// Random numbers that do not depend on the C++ library's distributions.
class Random
{
public:
  explicit Random(std::uint64_t seed)
    : Engine(seed)
  {
  }
  double Unit() { return double(this->Engine() >> 11) / 9007199254740992.0; }
  std::uint64_t Below(std::uint64_t end) { return this->Engine() % end; }

private:
  std::mt19937_64 Engine;
};

struct Kind
{
  const char* name;
  // Returns point number i of n.
  std::function<Vec3(std::size_t i, std::size_t n, Random& random)> point;
};

Vec3 Each(const std::function<double()>& number)
{
  Vec3 p;
  for (double& coordinate : p)
  {
    coordinate = number();
  }
  return p;
}

std::vector<Kind> Kinds()
{
  return {
    { "uniform", [](std::size_t, std::size_t, Random& random)
      { return Each([&] { return random.Unit(); }); } },
    { "uniform floats around zero", [](std::size_t, std::size_t, Random& random)
      { return Each([&] { return double(float(random.Unit() - 0.5)); }); } },
    { "all equal",
      [](std::size_t, std::size_t, Random&) {
        return Vec3{ 1.5, -2, 0.1 };
      } },
    { "two places",
      [](std::size_t, std::size_t, Random& random) {
        return Vec3{ random.Below(10) < 9 ? 1.0 : 2.0, 0, 0 };
      } },
    { "tied integers", [](std::size_t, std::size_t, Random& random)
      { return Each([&] { return double(random.Below(7)) - 3; }); } },
    { "zeros of both signs",
      [](std::size_t, std::size_t, Random& random) {
        return Each([&] { return random.Below(3) == 0 ? 1e-9 : (random.Below(2) ? 0.0 : -0.0); });
      } },
    { "skewed",
      [](std::size_t, std::size_t, Random& random)
      {
        return Each(
          [&]
          {
            const double u = random.Unit();
            return std::ldexp(u, -int(random.Below(60)));
          });
      } },
    { "one far away",
      [](std::size_t i, std::size_t, Random& random) {
        return i == 0 ? Vec3{ 1e30, -1e30, 1e30 } : Each([&] { return random.Unit(); });
      } },
    { "sorted",
      [](std::size_t i, std::size_t n, Random&) {
        return Vec3{ double(i) / double(n), 0.25, double(i / 3) / double(n) };
      } },
    { "reversed",
      [](std::size_t i, std::size_t n, Random&) {
        return Vec3{ double(n - i), double(n - i) / 7, 0 };
      } },
    { "up and down",
      [](std::size_t i, std::size_t n, Random&) {
        return Vec3{ 0, double(i < n / 2 ? i : n - i), 1 };
      } },
    { "huge offset", [](std::size_t, std::size_t, Random& random)
      { return Each([&] { return 5e6 + random.Unit(); }); } },
    { "huge and tiny",
      [](std::size_t, std::size_t, Random& random)
      {
        return Each(
          [&]
          {
            const double sign = random.Below(2) ? -1 : 1;
            return sign * std::ldexp(1 + random.Unit(), int(random.Below(1148)) - 1022);
          });
      } },
  };
}

}

std::vector<HardPoints> AllHardPoints(const std::vector<std::size_t>& counts)
{
  std::vector<HardPoints> all;
  std::uint64_t seed = 1;
  for (const Kind& kind : Kinds())
  {
    for (const std::size_t count : counts)
    {
      Random random(seed++);
      HardPoints hard{ kind.name, {}, true };
      hard.points.reserve(count);
      for (std::size_t i = 0; i < count; ++i)
      {
        const Vec3 p = kind.point(i, count, random);
        for (const double coordinate : p)
        {
          hard.fitFloats = hard.fitFloats && std::fabs(coordinate) < 3e38 &&
                           double(float(coordinate)) == coordinate;
        }
        hard.points.push_back(p);
      }
      all.push_back(std::move(hard));
    }
  }
  return all;
}

}
