// SPDX-License-Identifier: BSD-3-Clause
// What colours mean, where they are those of an attribute: for the legends of all viewers. Step
// "draw" of the pipeline picture.
#pragma once

#include "viewer/session/look/Coloring.h"

#include <cstdint>
#include <string>
#include <vector>

namespace kdstream
{

struct ColorLegend
{
  // Of a measure: colours from the low end to the high one, evenly spread; and round numbers with
  // where they are, 0 … 1 from the low end, ascending. Where all is one number, that and its colour
  // alone.
  struct Tick
  {
    double share = 0;
    double value = 0;
  };
  std::vector<Color> colors{};
  std::vector<Tick> ticks{};
  // Of classes: the mostClasses most frequent, ascending.
  struct Class
  {
    double value = 0;
    std::uint64_t vertices = 0;
    Color color{};
    std::string name{}; // empty where it has none
  };
  std::vector<Class> classes{};
  static constexpr std::size_t mostClasses = 20;
};

// Nothing where the coloring is none by an attribute. scalars: of the model.
ColorLegend LegendOf(const Coloring& coloring, const ScalarDescriptions& scalars);

// Whether it is among the ColorLegend::mostClasses most frequent. O(all).
bool IsInLegend(
  const ScalarDescription::Class& each, const std::vector<ScalarDescription::Class>& all);

// The multiples of 1, 2 or 5 times a power of ten between them, about five; both ends where there
// is nothing round between numbers that hardly differ. REQUIRES: low < high, and their difference
// is finite.
std::vector<double> RoundNumbers(double low, double high);

}
