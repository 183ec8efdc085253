// SPDX-License-Identifier: BSD-3-Clause
// What colours mean: see ColorLegend.h.
#include "viewer/session/look/ColorLegend.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{

constexpr std::size_t shades = 33;
constexpr double mostTicks = 6;

// What the library's is would round differently from platform to platform.
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
    classes.push_back({ each.value, each.vertices, coloring.Of(each.value),
      coloring.isLas ? std::string(LasClassName(each.value)) : std::string() });
  }
  std::stable_sort(classes.begin(), classes.end(),
    [](const auto& a, const auto& b) { return a.vertices > b.vertices; });
  classes.resize(std::min(classes.size(), ColorLegend::mostClasses));
  return classes;
}

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
    // Whole numbers over a power of ten are rounded once, so they read as they should.
    const auto value = [&](double i)
    { return exponent < 0 ? i * digit / scale : i * digit * scale; };
    const double first = std::ceil(low / value(1)), last = std::floor(high / value(1));
    if (last - first >= mostTicks)
    {
      continue;
    }
    std::vector<double> numbers;
    for (double i = first; i <= last && std::abs(i) < 0x1p50; ++i)
    {
      numbers.push_back(value(i) + 0.0); // no -0
    }
    std::erase_if(numbers, [&](double number) { return number < low || number > high; });
    return numbers.size() < 2 ? std::vector<double>{ low, high } : numbers;
  }
  return { low, high };
}

ColorLegend LegendOf(const Coloring& coloring, const std::vector<ScalarDescription>* scalars)
{
  ColorLegend legend;
  if (coloring.kind != SurfaceColoring::Attribute || !scalars)
  {
    return legend;
  }
  if (coloring.hasClasses)
  {
    for (const ScalarDescription& scalar : *scalars)
    {
      legend.classes =
        scalar.name == coloring.attribute ? ClassesOf(coloring, scalar) : legend.classes;
    }
    return legend;
  }
  for (std::size_t i = 0; i < shades; ++i)
  {
    legend.colors.push_back(
      ColorOf(coloring.map, static_cast<double>(i) / static_cast<double>(shades - 1)));
  }
  for (const double value : RoundNumbers(coloring.low, coloring.high))
  {
    legend.ticks.push_back({ (value - coloring.low) / (coloring.high - coloring.low), value });
  }
  return legend;
}

}
