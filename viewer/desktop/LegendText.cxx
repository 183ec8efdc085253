// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/desktop/LegendText.h"

#include "filters/program/ProgressReporter.h"

#include <cstdio>

namespace kdstream
{

std::string NumberText(double value)
{
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", value);
  return text;
}

std::string ClassText(const ColorLegend::Class& each)
{
  return NumberText(each.value) + (each.name.empty() ? "" : " " + each.name) + ", " +
         CountText(static_cast<double>(each.vertices));
}

}
