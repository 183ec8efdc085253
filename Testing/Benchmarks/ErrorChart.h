// SPDX-License-Identifier: BSD-3-Clause
// Curves of errors against what they cost as a PNG: the pictures of BenchLevels and BenchView.
#pragma once

#include "filters/core/Result.h"

#include <string>
#include <vector>

namespace kdstream::bench
{

struct ErrorCurve
{
  std::string name;
  std::vector<double> costs;  // x
  std::vector<double> errors; // y, one an x; none of either 0
};

struct ErrorPanel
{
  std::string title;
  std::string xTitle, yTitle;
  std::vector<ErrorCurve> curves;
};

// Draws charts in rows, on logarithmic axes, off screen into a PNG file. Curves of the same name
// have the same colour in all charts; the last chart of a row has the legend. Errors: those of
// MakeOffscreenWindow and WritePng.
Status WriteErrorCharts(const std::vector<std::vector<ErrorPanel>>& rows, const std::string& file);

}
