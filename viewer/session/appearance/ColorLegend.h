// SPDX-License-Identifier: BSD-3-Clause
// What the colours of an attribute mean: for the legends of all viewers. Step "draw" of the
// pipeline picture.
#pragma once

#include "viewer/session/appearance/Coloring.h"

#include <cstdint>
#include <string>
#include <vector>

namespace kdstream
{

struct ColorLegend
{
  // For a measure: colours from the low end to the high one, evenly spaced; and round numbers with
  // their places, 0 … 1 from the low end, ascending. If all values are the same number: only this
  // number and its colour.
  struct Tick
  {
    double share = 0;
    double value = 0;
  };
  std::vector<Color> colors{};
  std::vector<Tick> ticks{};
  // For classes: the mostClasses most frequent, ascending.
  struct Class
  {
    double value = 0;
    std::uint64_t vertices = 0;
    Color color{};
    std::string name{}; // empty if the class has no name
  };
  std::vector<Class> classes{};
  static constexpr std::size_t mostClasses = 20;
};

// The legend is empty if the surface is not coloured by an attribute. scalars: those of the model.
ColorLegend LegendOf(const Coloring& coloring, const ScalarDescriptions& scalars);

// Whether the class `each` is among the ColorLegend::mostClasses most frequent of `all`. O(all).
bool IsInLegend(
  const ScalarDescription::Class& each, const std::vector<ScalarDescription::Class>& all);

// About five round numbers from `low` to `high`: multiples of 1, 2 or 5 times a power of ten. If
// there are no round numbers between them, because they differ too little: only `low` and `high`.
// REQUIRES: low < high, and their difference is finite.
std::vector<double> RoundNumbers(double low, double high);

}
