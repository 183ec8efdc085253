// SPDX-License-Identifier: BSD-3-Clause
// A section's outline as SVG: see SurfaceSection.h.
#include "viewer/session/section/SurfaceSection.h"

#include "filters/model/JsonWriter.h"

#include <algorithm>
#include <array>

namespace kdstream
{
namespace
{

std::string Escaped(std::string_view text)
{
  std::string escaped;
  for (const char letter : text)
  {
    escaped += letter == '<'                                ? "&lt;"
               : letter == '&'                              ? "&amp;"
               : static_cast<unsigned char>(letter) < 0x20U ? " " // SVG has no control characters
                                                            : std::string(1, letter);
  }
  return escaped;
}

// The unit on paper, and how many of it one model unit is; an empty name for unknown units.
struct PaperUnit
{
  std::string_view name;
  double factor = 1;
};
PaperUnit OnPaper(std::string_view unit)
{
  return unit == "mm" || unit == "cm" || unit == "in" ? PaperUnit{ unit, 1 }
         : unit == "m"                                ? PaperUnit{ "mm", 1000 }
                                                      : PaperUnit{};
}

std::string PathOf(const SectionLine& line, const SectionAxes& axes)
{
  std::string path;
  for (const Vec3& point : line.points)
  {
    const auto [x, y] = axes.To(point);
    path += (path.empty() ? "M" : "L") + JsonNumber(x) + "," + JsonNumber(-y);
  }
  return path + (line.closed ? "Z" : "");
}

}

std::string SectionDrawing(const std::vector<SectionLine>& lines, const SectionPlane& plane,
  std::string_view unit, std::string_view title, std::string_view note)
{
  constexpr double border = 0.02; // of the longer side
  const SectionAxes axes(plane, lines.empty() ? Vec3{} : lines.front().points.front());
  Box box;
  std::string paths;
  for (const SectionLine& line : lines)
  {
    for (const Vec3& point : line.points)
    {
      const auto [x, y] = axes.To(point);
      box.Add(Vec3{ x, -y, 0 });
    }
    paths += PathOf(line, axes) + "\n";
  }
  const Vec3 size = box.Empty() ? Vec3{} : box.hi - box.lo;
  const double longer = std::max(size[0], size[1]);
  const double around = longer > 0 ? border * longer : 1;
  const std::array<double, 2> sides{ size[0] + 2 * around, size[1] + 2 * around };
  const PaperUnit paper = OnPaper(unit);
  const auto length = [&](double side)
  { return "\"" + JsonNumber(side * paper.factor) + std::string(paper.name) + "\""; };
  const Vec3 corner = box.Empty() ? Vec3{} : box.lo;
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
         "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\"" +
         (paper.name.empty() ? std::string()
                             : " width=" + length(sides[0]) + " height=" + length(sides[1])) +
         " viewBox=\"" + JsonNumber(corner[0] - around) + " " + JsonNumber(corner[1] - around) +
         " " + JsonNumber(sides[0]) + " " + JsonNumber(sides[1]) + "\">\n<title>" + Escaped(title) +
         "</title>\n<desc>" + Escaped(note) +
         "</desc>\n<path fill=\"none\" stroke=\"black\" stroke-width=\"" +
         JsonNumber(0.002 * (longer > 0 ? longer : 1)) + "\" d=\"\n" + paths + "\"/>\n</svg>\n";
}

}
