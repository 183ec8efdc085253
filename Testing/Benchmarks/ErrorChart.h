// SPDX-License-Identifier: BSD-3-Clause
// Draws curves of errors against costs as a PNG: the pictures of BenchLevels and BenchView.
#pragma once

#include "filters/core/Result.h"

#include <string>
#include <vector>

namespace kdstream::bench
{

struct ErrorCurve
{
  std::string name;
  std::vector<double> costs;  // x coordinates
  std::vector<double> errors; // y coordinates, one for each cost; no error or cost is 0
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
