// SPDX-License-Identifier: BSD-3-Clause
// A statue for textures from photographs: see Statue.h. The steps:
// 1. its shape
// 2. its colour
// 3. charts: the part of the surface that each one shows, and its place in a picture
// 4. pictures, and then the mesh.
#include "Data/Generate/Statue.h"

#include "Data/Generate/Noise.h"
#include "filters/core/VectorMath.h"
#include "filters/meshio/OutputFile.h"
#include "filters/texture/WritePicture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace kdstream::generate
{
namespace
{

constexpr double wholeTurn = 6.283185307179586;
constexpr std::size_t quarters = 4;

struct Profile
{
  double along, height, radius;
};
constexpr std::array<Profile, 14> profile{ { { 0, 0, 0 }, { 0.06, 0.02, 0.6 }, { 0.14, 0.2, 0.6 },
  { 0.17, 0.23, 0.5 }, { 0.23, 0.34, 0.33 }, { 0.31, 0.52, 0.37 }, { 0.44, 0.82, 0.56 },
  { 0.52, 0.97, 0.48 }, { 0.6, 1.08, 0.21 }, { 0.66, 1.18, 0.19 }, { 0.75, 1.34, 0.31 },
  { 0.85, 1.55, 0.34 }, { 0.94, 1.73, 0.22 }, { 1, 1.8, 0 } } };

Profile ProfileAt(double along)
{
  const auto* const next = std::find_if(
    profile.begin() + 1, profile.end() - 1, [along](const Profile& p) { return p.along >= along; });
  const Profile& before = *(next - 1);
  const double t = (along - before.along) / (next->along - before.along);
  // The outline is perpendicular to the axis at both ends, except at the flat foot; the head is
  // round.
  const double share = next->radius == 0    ? 1 - std::sqrt(1 - t * t)
                       : before.radius == 0 ? t
                                            : Ease(t);
  return { along, before.height + t * (next->height - before.height),
    before.radius + share * (next->radius - before.radius) };
}

// A bump of height 1 around a place on the surface.
double Bump(double along, double around, double atAlong, double atAround, double width)
{
  const double across = around - atAround - std::round(around - atAround); // the short way round
  const double up = along - atAlong;
  return std::exp(-(up * up + across * across) / (width * width));
}

double Layers(const Vec3& p, double scale, int count, std::uint64_t seed)
{
  double sum = 0, weight = 0.5;
  for (int k = 0; k < count; ++k)
  {
    sum += weight * SmoothNoise(p[0] * scale, p[1] * scale, p[2] * scale,
                      seed + static_cast<std::uint64_t>(k));
    scale *= 2;
    weight /= 2;
  }
  return sum;
}

Vec3 ShapeAt(double along, double around, std::uint64_t seed)
{
  const Profile at = ProfileAt(std::clamp(along, 0.0, 1.0));
  const double head = Ease(std::clamp((along - 0.62) / 0.1, 0.0, 1.0));
  const double face =
    0.09 * Bump(along, around, 0.77, 0.25, 0.02) + 0.05 * Bump(along, around, 0.72, 0.25, 0.025) -
    0.03 * Bump(along, around, 0.8, 0.21, 0.018) - 0.03 * Bump(along, around, 0.8, 0.29, 0.018);
  const double folds = 0.02 * (1 - head) * Ease(std::clamp((along - 0.25) / 0.1, 0.0, 1.0)) *
                       std::sin(wholeTurn * (9 * around + 2 * along));
  const double radius = at.radius * (1 + folds) + face;
  const double angle = wholeTurn * around;
  Vec3 p{ radius * std::cos(angle), at.height, radius * std::sin(angle) * (0.75 + 0.25 * head) };
  const double rough = 0.006 * Layers(p, 14, 4, seed) * std::min(1.0, 8 * at.radius);
  p[0] *= 1 + rough;
  p[2] *= 1 + rough;
  return p;
}

// sRGB, 0-255.
std::array<double, 3> StoneAt(const Vec3& p, double around, std::uint64_t seed)
{
  const double warp = Layers(p, 3, 3, seed + 20);
  const double band = 0.5 + 0.5 * std::sin(26 * p[1] + 9 * warp);
  const double vein = std::pow(1 - std::abs(Layers(p, 5, 4, seed + 40)), 14);
  const double grain = Layers(p, 260, 3, seed + 60);
  // Two lines of strokes like letters around the foot.
  const double line = (p[1] - 0.06) / 0.045;
  const double letter = std::floor(around * 90);
  const double within = around * 90 - letter;
  const bool carved =
    line > 0 && line < 2 && line - std::floor(line) < 0.6 && within < 0.7 &&
    NoiseAt(static_cast<std::int64_t>(letter) * 4 + static_cast<std::int64_t>(within * 5),
      static_cast<std::int64_t>(line * 5), seed + 80) > -0.1;
  const double dirt = std::clamp(0.6 - p[1], 0.0, 1.0) * (0.5 + 0.5 * warp);
  std::array<double, 3> color{ 178 + 44 * band, 160 + 40 * band, 128 + 34 * band };
  for (std::size_t k = 0; k < 3; ++k)
  {
    color[k] *= (1 - 0.55 * vein) * (1 - 0.5 * dirt) * (1 + 0.3 * grain) * (carved ? 0.3 : 1);
  }
  return color;
}

std::uint8_t ByteOf(double value)
{
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

// How the charts of a picture are arranged: in a square of slots.
struct ChartLayout
{
  std::size_t perSide = 2;
  double gutter = 8; // texels around each chart
  bool isMosaic = false;

  std::size_t Count() const { return this->perSide * this->perSide; }
  std::size_t SlotOf(std::size_t number) const
  {
    return this->isMosaic ? (number * 7919 + 13) % this->Count() : number;
  }
};

ChartLayout LayoutOf(const StatueOptions& options)
{
  return options.charts == StatueCharts::Small ? ChartLayout{ 24, 3, true } : ChartLayout{};
}

// The part of the surface that a chart shows: intervals of levels and columns.
struct Chart
{
  ChartLayout layout;
  std::size_t quarter = 0, number = 0;
  bool turned = false;
  std::uint64_t firstLevel = 0, lastLevel = 0, firstColumn = 0, lastColumn = 0;

  double Slot(std::size_t k) const
  {
    const std::size_t slot = this->layout.SlotOf(this->number);
    return double(k == 0 ? slot % this->layout.perSide : slot / this->layout.perSide);
  }

  // Where in the picture a place of the chart's part of the surface is. Places are 0-1 each way;
  // the result is 0-1 from the left and from below.
  std::array<double, 2> InPicture(double across, double up, double side) const
  {
    const auto perSide = double(this->layout.perSide);
    const double edge = perSide * this->layout.gutter / side;
    const double x = edge + (1 - 2 * edge) * (this->turned ? 1 - across : across);
    const double y = edge + (1 - 2 * edge) * (this->turned ? 1 - up : up);
    return { (this->Slot(0) + x) / perSide, (this->Slot(1) + y) / perSide };
  }
  // The inverse of InPicture; also for places in the gutter.
  std::array<double, 2> OnSurface(double x, double y, double side) const
  {
    const auto perSide = double(this->layout.perSide);
    const double edge = perSide * this->layout.gutter / side;
    const double across = (perSide * x - this->Slot(0) - edge) / (1 - 2 * edge);
    const double up = (perSide * y - this->Slot(1) - edge) / (1 - 2 * edge);
    return this->turned ? std::array<double, 2>{ 1 - across, 1 - up }
                        : std::array<double, 2>{ across, up };
  }
};

Chart ChartOf(
  const ClosedGrid& grid, const ChartLayout& layout, std::size_t quarter, std::size_t number)
{
  // With few charts, each is a band around its quarter of the statue; a mosaic also divides the
  // bands.
  const std::size_t across = layout.isMosaic ? layout.perSide : 1;
  const std::size_t bands = layout.Count() / across, band = number / across;
  const std::size_t column = quarter * across + number % across, columns = quarters * across;
  const bool turned = (layout.isMosaic ? number / 2 + band : number) % 2 == 1;
  return { layout, quarter, number, turned, (grid.rings + 1) * band / bands,
    (grid.rings + 1) * (band + 1) / bands, grid.columns * column / columns,
    grid.columns * (column + 1) / columns };
}

Picture PhotographOf(const ClosedGrid& grid, const StatueOptions& options, std::size_t quarter,
  const Execution& execution)
{
  const std::size_t side = options.pictureSide;
  Picture picture{ side, side, 3, std::vector<std::uint8_t>(side * side * 3) };
  const double exposure = 1 + 0.04 * (double(quarter) - 1.5);
  const ChartLayout layout = LayoutOf(options);
  std::vector<Chart> charts(layout.Count()); // by slot
  for (std::size_t number = 0; number < layout.Count(); ++number)
  {
    charts[layout.SlotOf(number)] = ChartOf(grid, layout, quarter, number);
  }
  const auto rows = [&](std::size_t begin, std::size_t end)
  {
    for (std::size_t i = begin * side; i < end * side; ++i)
    {
      const double x = (double(i % side) + 0.5) / double(side);
      const double y = 1 - (double(i / side) + 0.5) / double(side);
      const auto perSide = double(layout.perSide);
      const Chart& chart =
        charts[std::size_t(x * perSide) + layout.perSide * std::size_t(y * perSide)];
      const auto [across, up] = chart.OnSurface(x, y, double(side));
      const double along =
        (double(chart.firstLevel) + up * double(chart.lastLevel - chart.firstLevel)) /
        double(grid.rings + 1);
      const double around =
        (double(chart.firstColumn) + across * double(chart.lastColumn - chart.firstColumn)) /
        double(grid.columns);
      const std::array<double, 3> color =
        StoneAt(ShapeAt(along, around, options.seed), around, options.seed);
      for (std::size_t k = 0; k < 3; ++k)
      {
        picture.texels[3 * i + k] = ByteOf(color[k] * exposure);
      }
    }
  };
  execution.parallelFor(side, 16, rows);
  return picture;
}

std::string PictureName(const std::filesystem::path& obj, std::size_t quarter)
{
  return obj.stem().string() + "-" + std::to_string(quarter) + (quarter % 2 == 0 ? ".jpg" : ".png");
}

Status WriteBytes(const std::filesystem::path& file, std::string_view bytes)
{
  OutputFile output;
  KDSTREAM_TRY(output.Open(file));
  output.Write(bytes);
  return output.Finish();
}

Status WritePictures(const ClosedGrid& grid, const StatueOptions& options,
  const std::filesystem::path& obj, const Execution& execution)
{
  std::string materials = "# made by kdstream-generate\n";
  for (std::size_t quarter = 0; quarter < quarters; ++quarter)
  {
    KDSTREAM_TRY(execution.Report("pictures", double(quarter) / quarters));
    const std::vector<std::uint8_t> bytes =
      EncodePicture(PhotographOf(grid, options, quarter, execution),
        quarter % 2 == 0 ? PictureType::Jpeg : PictureType::Png);
    const std::string name = PictureName(obj, quarter);
    KDSTREAM_TRY(WriteBytes(
      obj.parent_path() / name, { reinterpret_cast<const char*>(bytes.data()), bytes.size() }));
    materials +=
      "newmtl photo" + std::to_string(quarter) + "\nKd 0.7 0.65 0.55\nmap_Kd " + name + "\n";
  }
  std::filesystem::path library = obj;
  return WriteBytes(library.replace_extension(".mtl"), materials);
}

// Writes the mesh as text: the vertices, and then, chart by chart, its coordinates and faces.
class StatueWriter
{
public:
  StatueWriter(const ClosedGrid& grid, const StatueOptions& options)
    : Grid(grid)
    , Options(options)
  {
  }

  Status Write(const std::filesystem::path& obj, const Execution& execution)
  {
    KDSTREAM_TRY(this->Output.Open(obj));
    std::filesystem::path library = obj;
    this->Output.Write("# made by kdstream-generate\nmtllib " +
                       library.replace_extension(".mtl").filename().string() + "\n");
    this->WriteVertex(0, 0);
    for (std::uint64_t level = 1; level <= this->Grid.rings; ++level)
    {
      KDSTREAM_TRY(execution.Report("vertices", double(level) / double(this->Grid.rings)));
      for (std::uint64_t column = 0; column < this->Grid.columns; ++column)
      {
        this->WriteVertex(level, column);
      }
    }
    this->WriteVertex(this->Grid.rings + 1, 0);
    const ChartLayout layout = LayoutOf(this->Options);
    const std::size_t charts = quarters * layout.Count();
    for (std::size_t i = 0; i < charts; ++i)
    {
      KDSTREAM_TRY(execution.Report("triangles", double(i) / double(charts)));
      this->WriteChart(ChartOf(this->Grid, layout, i / layout.Count(), i % layout.Count()));
    }
    return this->Output.Finish();
  }

private:
  void WriteVertex(std::uint64_t level, std::uint64_t column)
  {
    const Vec3 p = ShapeAt(double(level) / double(this->Grid.rings + 1),
      double(column) / double(this->Grid.columns), this->Options.seed);
    std::array<char, 100> line{};
    std::snprintf(line.data(), line.size(), "v %.6f %.6f %.6f\n", p[0], p[1], p[2]);
    this->Output.Write(line.data());
  }

  void WriteChart(const Chart& chart)
  {
    if (chart.number == 0)
    {
      this->Output.Write("usemtl photo" + std::to_string(chart.quarter) + "\n");
    }
    const std::uint64_t levels = chart.lastLevel - chart.firstLevel;
    const std::uint64_t columns = chart.lastColumn - chart.firstColumn;
    const double beside = this->Options.charts == StatueCharts::Udim ? double(chart.quarter) : 0;
    for (std::uint64_t i = 0; i < (levels + 1) * (columns + 1); ++i)
    {
      const auto [u, v] = chart.InPicture(double(i % (columns + 1)) / double(columns),
        double(i / (columns + 1)) / double(levels), double(this->Options.pictureSide));
      std::array<char, 80> line{};
      std::snprintf(line.data(), line.size(), "vt %.6f %.6f\n", u + beside, v);
      this->Output.Write(line.data());
    }
    for (std::uint64_t i = 0; i < levels * columns; ++i)
    {
      const std::uint64_t level = i / columns, column = i % columns;
      const auto corner = [&](std::uint64_t up, std::uint64_t across)
      {
        return " " +
               std::to_string(
                 this->Vertex(chart.firstLevel + level + up, chart.firstColumn + column + across)) +
               "/" +
               std::to_string(this->Coordinates + (level + up) * (columns + 1) + column + across);
      };
      const std::uint64_t lowest = chart.firstLevel + level;
      if (lowest > 0)
      {
        this->Output.Write("f" + corner(0, 0) + corner(1, 1) + corner(0, 1) + "\n");
      }
      if (lowest < this->Grid.rings)
      {
        this->Output.Write("f" + corner(0, 0) + corner(1, 0) + corner(1, 1) + "\n");
      }
    }
    this->Coordinates += (levels + 1) * (columns + 1);
  }

  // The number of a vertex, counted from 1.
  std::uint64_t Vertex(std::uint64_t level, std::uint64_t column) const
  {
    return level == 0 ? 1
           : level == this->Grid.rings + 1
             ? this->Grid.Vertices()
             : 2 + (level - 1) * this->Grid.columns + column % this->Grid.columns;
  }

  const ClosedGrid& Grid;
  const StatueOptions& Options;
  OutputFile Output;
  std::uint64_t Coordinates = 1; // the number of the next chart's first coordinates
};

}

ColoredSurface MakeStatue(std::uint64_t seed)
{
  return [seed](double along, double around)
  {
    const Vec3 p = ShapeAt(along, around, seed);
    const std::array<double, 3> color = StoneAt(p, around, seed);
    return ColoredPoint{ p, { ByteOf(color[0]), ByteOf(color[1]), ByteOf(color[2]) } };
  };
}

Status WriteStatue(
  const StatueOptions& options, const std::filesystem::path& obj, const Execution& execution)
{
  constexpr double columnsPerRing = 1.2;
  const Result<ClosedGrid> grid = ClosedGrid::Of(options.vertices, columnsPerRing);
  KDSTREAM_TRY(grid);
  const ChartLayout layout = LayoutOf(options);
  const std::size_t across = layout.isMosaic ? layout.perSide : 1;
  if (grid->rings + 1 < layout.Count() / across || grid->columns < quarters * across)
  {
    return Error{ ErrorCode::InvalidArgument, std::to_string(options.vertices) +
                                                " vertices: a statue has some " +
                                                (layout.isMosaic ? "8000" : "20") + " at least" };
  }
  if (double(options.pictureSide) < 3 * layout.gutter * double(layout.perSide))
  {
    return Error{ ErrorCode::InvalidArgument,
      std::to_string(options.pictureSide) +
        " texels: too few for small charts with their gutters" };
  }
  KDSTREAM_TRY(WritePictures(*grid, options, obj, execution));
  return StatueWriter(*grid, options).Write(obj, execution);
}

}
