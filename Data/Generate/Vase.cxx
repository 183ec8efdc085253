// SPDX-License-Identifier: BSD-3-Clause
// A painted vase: see Vase.h.
#include "Data/Generate/Vase.h"

#include "Data/Generate/Noise.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

namespace kdstream::generate
{
namespace
{

using Paint = std::array<double, 3>; // red, green, blue: 0-255

constexpr Paint cream{ 238, 229, 207 }, cobalt{ 30, 58, 138 }, madder{ 176, 48, 38 },
  leaf{ 62, 112, 74 }, gold{ 214, 164, 60 }, celadon{ 148, 186, 166 }, clay{ 178, 108, 70 };

Paint Mix(const Paint& a, const Paint& b, double part)
{
  Paint mixed{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    mixed[k] = a[k] + part * (b[k] - a[k]);
  }
  return mixed;
}

// 0 below `low`, 1 above `high`, and smooth between them.
double Step(double low, double high, double x)
{
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

// 1 between `low` and `high`, 0 outside them, with soft edges of width `soft`.
double Between(double low, double high, double x, double soft)
{
  return Step(low - soft, low + soft, x) * (1.0 - Step(high - soft, high + soft, x));
}

// ---- the outline

struct OutlinePoint
{
  double radius = 0.0, height = 0.0;
  double outwardRadius = 0.0, outwardHeight = 0.0; // the outline's normal
  bool outside = false;                            // false: inside the vase
};

// The outline from the middle of the inner floor over the lip to the middle of the foot, as
// (radius, height).
constexpr std::array<std::array<double, 2>, 22> corners{ { { 0.0, 0.14 }, { 0.16, 0.145 },
  { 0.33, 0.22 }, { 0.47, 0.42 }, { 0.545, 0.72 }, { 0.50, 1.0 }, { 0.36, 1.24 }, { 0.235, 1.42 },
  { 0.215, 1.58 }, { 0.275, 1.72 }, { 0.35, 1.79 }, { 0.378, 1.80 }, { 0.372, 1.775 },
  { 0.305, 1.70 }, { 0.25, 1.57 }, { 0.27, 1.43 }, { 0.395, 1.25 }, { 0.54, 1.01 }, { 0.59, 0.72 },
  { 0.50, 0.38 }, { 0.27, 0.10 }, { 0.31, 0.0 } } };
constexpr std::size_t lip = 11; // index of the highest corner

// A Catmull-Rom curve through the corners, and a straight line along the ground, by length.
class Outline
{
public:
  Outline()
  {
    constexpr int steps = 64; // between two corners
    for (std::size_t i = 0; i + 1 < corners.size(); ++i)
    {
      for (int s = 0; s < steps; ++s)
      {
        this->Add(Between4(i, static_cast<double>(s) / steps), i >= lip);
      }
    }
    this->Add(corners.back(), true);
    for (int s = 1; s <= steps; ++s)
    {
      this->Add({ corners.back()[0] * (1.0 - static_cast<double>(s) / steps), 0.0 }, true);
    }
  }

  // The point at this share of the length, 0-1.
  OutlinePoint At(double along) const
  {
    const double length = along * this->Lengths.back();
    const auto above = std::upper_bound(this->Lengths.begin() + 1, this->Lengths.end() - 1, length);
    const auto i = static_cast<std::size_t>(above - this->Lengths.begin()) - 1;
    const double part =
      std::clamp((length - this->Lengths[i]) / (this->Lengths[i + 1] - this->Lengths[i]), 0.0, 1.0);
    const auto& a = this->Points[i];
    const auto& b = this->Points[i + 1];
    const double run = b[0] - a[0], rise = b[1] - a[1];
    const double size = std::hypot(run, rise);
    return { a[0] + part * run, a[1] + part * rise, -rise / size, run / size, this->Outside[i] };
  }

private:
  static std::array<double, 2> Between4(std::size_t i, double t)
  {
    // The outline is continued in mirror image beyond the middle of the floor.
    const std::array<double, 2> before =
      i > 0 ? corners[i - 1] : std::array<double, 2>{ -corners[1][0], corners[1][1] };
    const std::array<double, 2> after = i + 2 < corners.size() ? corners[i + 2] : corners[i + 1];
    std::array<double, 2> point{};
    for (std::size_t k = 0; k < 2; ++k)
    {
      const double p = before[k], q = corners[i][k], r = corners[i + 1][k], s = after[k];
      point[k] =
        0.5 * (2 * q + t * (r - p + t * (2 * p - 5 * q + 4 * r - s + t * (3 * q - p - 3 * r + s))));
    }
    return point;
  }

  void Add(const std::array<double, 2>& point, bool outside)
  {
    const double step = this->Points.empty() ? 0.0
                                             : std::hypot(point[0] - this->Points.back()[0],
                                                 point[1] - this->Points.back()[1]);
    this->Lengths.push_back(this->Lengths.empty() ? 0.0 : this->Lengths.back() + step);
    this->Points.push_back(point);
    this->Outside.push_back(outside);
  }

  std::vector<std::array<double, 2>> Points;
  std::vector<double> Lengths;
  std::vector<bool> Outside;
};

// ---- relief and colours

struct Place
{
  double height = 0.0, turn = 0.0; // turn: 0-1 around the vase
  double along = 0.0;              // share of the outline's length
  bool outside = false;
};

// The finish of a place: how high it stands out, and its colour.
struct Finish
{
  double relief = 0.0;
  Paint paint = cream;

  void Lay(const Paint& other, double part, double raised = 0.0)
  {
    this->paint = Mix(this->paint, other, part);
    this->relief += raised * part;
  }
};

// Sixteen rosettes with six petals each, between leaves.
void LayFrieze(Finish& finish, const Place& place)
{
  constexpr double middle = 0.74, half = 0.17;
  const double cell = place.turn * 16.0;
  const double x = (cell - std::floor(cell) - 0.5) * 0.235; // scaled to the length on the belly
  const double y = place.height - middle;
  if (std::abs(y) > half)
  {
    return;
  }
  const double radius = std::hypot(x, y), angle = std::atan2(y, x);
  const double petal = 0.062 + 0.022 * std::cos(6.0 * angle);
  // Two stems that wind from rosette to rosette, with leaves.
  const double wave = 0.085 * std::cos(2.0 * std::numbers::pi * cell);
  for (const double side : { -1.0, 1.0 })
  {
    const double off = std::abs(y - side * (0.05 - wave * 0.5 + 0.02));
    finish.Lay(leaf, 1.0 - Step(0.006, 0.010, off), 0.002);
    const double lx = std::abs(std::abs(x) - 0.085), ly = std::abs(std::abs(y) - 0.115);
    finish.Lay(leaf, 1.0 - Step(0.8, 1.0, std::hypot(lx / 0.018, ly / 0.034)), 0.003);
  }
  finish.Lay(madder, 1.0 - Step(petal - 0.006, petal, radius), 0.007);
  finish.Lay(cream, Between(0.026, 0.031, radius, 0.002), -0.003);
  finish.Lay(gold, 1.0 - Step(0.019, 0.024, radius), 0.006);
}

// A Greek key, 24 times around.
void LayMeander(Finish& finish, const Place& place)
{
  static constexpr std::array<std::string_view, 7> key{ "########", "#.......", "#.#####.",
    "#.#...#.", "#.#.#.#.", "#...#.#.", "#####.##" };
  constexpr double low = 1.03, high = 1.13;
  const double y = (high - place.height) / (high - low) * 7.0;
  if (y >= 0.0 && y < 7.0)
  {
    const double x = place.turn * 24.0;
    const auto column = static_cast<std::size_t>((x - std::floor(x)) * 8.0);
    const bool painted = key[static_cast<std::size_t>(y)][std::min<std::size_t>(column, 7)] == '#';
    finish.Lay(cobalt, painted ? 1.0 : 0.0, 0.003);
  }
}

void LayBands(Finish& finish, const Place& place)
{
  for (const auto& [low, high] : { std::pair{ 0.535, 0.56 }, { 0.925, 0.95 }, { 1.0, 1.012 },
         { 1.148, 1.16 }, { 1.36, 1.40 }, { 1.62, 1.64 } })
  {
    finish.Lay(cobalt, Between(low, high, place.height, 0.002), 0.003);
  }
  finish.Lay(gold, Between(0.945, 1.005, place.height, 0.002) * 0.85);
  finish.Lay(gold, Step(1.752, 1.758, place.height));
}

Finish FinishOutside(const Place& place)
{
  Finish finish;
  const double turn = 2.0 * std::numbers::pi * place.turn;
  const double gadroons = Between(0.17, 0.50, place.height, 0.03);
  finish.relief += 0.022 * gadroons * (std::abs(std::sin(12.0 * turn)) - 0.4);
  finish.Lay(cobalt, gadroons * (1.0 - Step(0.15, 0.30, std::abs(std::sin(12.0 * turn)))) * 0.9);
  const double rope = Between(1.47, 1.55, place.height, 0.008);
  const double strand = std::sin(18.0 * turn + 130.0 * place.height);
  finish.relief += 0.012 * rope * (1.0 + 0.8 * strand);
  finish.Lay(gold, rope * Step(-0.3, 0.1, strand));
  LayFrieze(finish, place);
  LayMeander(finish, place);
  LayBands(finish, place);
  finish.Lay(clay, 1.0 - Step(0.045, 0.055, place.height));
  return finish;
}

}

ColoredSurface MakeVase(std::uint64_t seed)
{
  return [seed, outline = Outline()](double along, double around)
  {
    const OutlinePoint at = outline.At(along);
    const Place place{ at.height, around, along, at.outside };
    Finish finish = place.outside ? FinishOutside(place) : Finish{ 0.0, celadon };
    // Grain, marks of the wheel and uneven glaze fade out at the poles, because a pole is a single
    // point.
    const double fade = Step(0.0, 0.1, at.radius);
    const auto noise = [&](double turns, double length, std::uint64_t layer)
    {
      return SmoothNoise(
        around * turns, along * length, static_cast<std::int64_t>(turns), seed * 16 + layer);
    };
    finish.relief += 0.0022 * noise(40, 70, 1) + 0.0009 * noise(220, 400, 2);
    const double glaze = 1.0 + fade * (0.05 * noise(24, 40, 3) + 0.035 * noise(300, 520, 4));
    const double radius = at.radius + fade * finish.relief * at.outwardRadius;
    const double turn = 2.0 * std::numbers::pi * around;
    ColoredPoint point;
    point.position = { radius * std::cos(turn), at.height + fade * finish.relief * at.outwardHeight,
      -radius * std::sin(turn) };
    for (std::size_t k = 0; k < 3; ++k)
    {
      point.color[k] =
        static_cast<std::uint8_t>(std::clamp(std::round(glaze * finish.paint[k]), 0.0, 255.0));
    }
    return point;
  };
}

}
