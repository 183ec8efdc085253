// SPDX-License-Identifier: BSD-3-Clause
// A section's outline as a drawing, for other programs and for paper.
#pragma once

#include "viewer/session/section/SurfaceSection.h"

#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// The lines as SVG 1.1, one path, as one sees them who looks against the plane's normal. One unit
// of the drawing is one of the model; where that is mm, cm, m or in, the drawing has its true size
// on paper (a browser takes metres as 1000 mm). title, note: any text; the note tells how exact it
// is. O(n).
std::string SectionDrawing(const std::vector<SectionLine>& lines, const SectionPlane& plane,
  std::string_view unit, std::string_view title, std::string_view note);

}
