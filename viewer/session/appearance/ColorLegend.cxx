// SPDX-License-Identifier: BSD-3-Clause
// What colours mean: see ColorLegend.h.
#include "viewer/session/appearance/ColorLegend.h"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace kdstream
{
namespace
{

constexpr std::size_t shades = 33;
constexpr double mostTicks = 6;

// What LAS 1.4 calls its classes.
constexpr std::array<std::string_view, 19> lasNames{ "never classified", "unclassified", "ground",
  "low vegetation", "medium vegetation", "high vegetation", "building", "low point (noise)",
  "key point", "water", "rail", "road", "overlap", "wire guard", "wire conductor", "tower",
  "wire connector", "bridge deck", "high noise" };

std::string NameOfLasClass(double value)
{
  return value >= 0 && value < static_cast<double>(lasNames.size())
           ? std::string(lasNames[static_cast<std::size_t>(value)])
           : std::string();
}

// Exact on all platforms, unlike std::pow.
double PowerOfTen(int exponent)
{
  double power = 1;
  for (int i = 0; i < exponent; ++i)
  {
    power *= 10;
  }
  return power;
}

std::vector<ColorLegend::Class> ClassesOf(const Coloring& coloring, const ScalarDescription& scalar)
{
  std::vector<ColorLegend::Class> classes;
  for (const ScalarDescription::Class& each : scalar.classes)
  {
    if (IsInLegend(each, scalar.classes))
    {
      classes.push_back({ each.value, each.vertices, coloring.Of(each.value),
        coloring.isLas ? NameOfLasClass(each.value) : std::string() });
    }
  }
  return classes;
}

}

bool IsInLegend(
  const ScalarDescription::Class& each, const std::vector<ScalarDescription::Class>& all)
{
  const auto before = std::count_if(all.begin(), all.end(),
    [&each](const ScalarDescription::Class& other)
    {
      return other.vertices > each.vertices ||
             (other.vertices == each.vertices && other.value < each.value);
    });
  return static_cast<std::size_t>(before) < ColorLegend::mostClasses;
}

std::vector<double> RoundNumbers(double low, double high)
{
  const double span = high - low;
  int exponent = 0; // of the step
  while (exponent < 307 && span / PowerOfTen(exponent) > 10 * mostTicks)
  {
    ++exponent;
  }
  while (exponent > -300 && span * PowerOfTen(-exponent) < mostTicks)
  {
    --exponent;
  }
  const double scale = PowerOfTen(std::abs(exponent));
  for (const double digit : { 1.0, 2.0, 5.0, 10.0, 20.0, 50.0 })
  {
    // A whole number divided by a power of ten is rounded only once, so it prints as expected.
    const auto value = [&](double i)
    { return exponent < 0 ? i * digit / scale : i * digit * scale; };
    const double first = std::ceil(low / value(1)), last = std::floor(high / value(1));
    if (last - first >= mostTicks)
    {
      continue;
    }
    std::vector<double> numbers;
    // One more at each end, in case `first` or `last` was rounded.
    for (double i = first - 1; i <= last + 1 && std::abs(i) < 0x1p50; ++i)
    {
      numbers.push_back(value(i) + 0.0); // no -0
    }
    std::erase_if(numbers, [&](double number) { return number < low || number > high; });
    return numbers.size() < 2 ? std::vector<double>{ low, high } : numbers;
  }
  return { low, high };
}

ColorLegend LegendOf(const Coloring& coloring, const ScalarDescriptions& scalars)
{
  ColorLegend legend;
  if (coloring.kind != SurfaceColoring::Attribute)
  {
    return legend;
  }
  if (coloring.hasClasses)
  {
    const ScalarDescription* scalar = scalars.Find(coloring.attribute);
    legend.classes = scalar ? ClassesOf(coloring, *scalar) : legend.classes;
    return legend;
  }
  if (coloring.low == coloring.high)
  {
    legend.colors.assign(2, coloring.Of(coloring.low));
    legend.ticks = { { 0.5, coloring.low } };
    return legend;
  }
  for (std::size_t i = 0; i < shades; ++i)
  {
    legend.colors.push_back(
      ColorOf(coloring.map, static_cast<double>(i) / static_cast<double>(shades - 1)));
  }
  const bool hasTicks = std::isfinite(coloring.high - coloring.low);
  for (const double value :
    hasTicks ? RoundNumbers(coloring.low, coloring.high) : std::vector<double>())
  {
    legend.ticks.push_back({ (value - coloring.low) / (coloring.high - coloring.low), value });
  }
  return legend;
}

}
