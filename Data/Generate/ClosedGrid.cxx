// SPDX-License-Identifier: BSD-3-Clause
// A closed surface of any size, written as a stream: see ClosedGrid.h.
#include "Data/Generate/ClosedGrid.h"

#include "filters/meshio/OutputFile.h"

#include <cmath>
#include <string>

namespace kdstream::generate
{
namespace
{

void WritePoint(OutputFile& output, const ColoredPoint& point)
{
  for (const double coordinate : point.position)
  {
    output.WriteLittleEndian(static_cast<float>(coordinate));
  }
  for (const std::uint8_t channel : point.color)
  {
    output.WriteLittleEndian(channel);
  }
}

void WriteTriangle(OutputFile& output, std::uint64_t a, std::uint64_t b, std::uint64_t c)
{
  output.WriteLittleEndian(std::uint8_t{ 3 });
  for (const std::uint64_t corner : { a, b, c })
  {
    output.WriteLittleEndian(static_cast<std::uint32_t>(corner));
  }
}

std::string HeaderOf(const ClosedGrid& grid)
{
  std::string header = "ply\nformat binary_little_endian 1.0\ncomment made by kdstream-generate\n";
  header += "element vertex " + std::to_string(grid.Vertices()) + "\n";
  for (const char* name :
    { "float x", "float y", "float z", "uchar red", "uchar green", "uchar blue" })
  {
    header += std::string("property ") + name + "\n";
  }
  header += "element face " + std::to_string(grid.Triangles()) + "\n";
  return header + "property list uchar uint vertex_indices\nend_header\n";
}

}

Result<ClosedGrid> ClosedGrid::Of(std::uint64_t vertices, double columnsPerRing)
{
  ClosedGrid grid;
  const double rings = std::sqrt(static_cast<double>(vertices) / columnsPerRing);
  grid.rings = static_cast<std::uint64_t>(std::llround(rings));
  grid.columns =
    grid.rings == 0 ? 0 : (vertices - std::min<std::uint64_t>(vertices, 2)) / grid.rings;
  if (grid.rings < 3 || grid.columns < 3 || grid.Vertices() > std::uint64_t{ 1 } << 32)
  {
    return Error{ ErrorCode::InvalidArgument,
      std::to_string(vertices) + " vertices: a closed surface has some 20 to 2^32" };
  }
  return grid;
}

Status WritePly(
  const ClosedGrid& grid, const ColoredSurface& surface, const std::filesystem::path& file)
{
  OutputFile output;
  KDSTREAM_TRY(output.Open(file));
  output.Write(HeaderOf(grid));
  WritePoint(output, surface(0.0, 0.0));
  for (std::uint64_t ring = 0; ring < grid.rings; ++ring)
  {
    const double along = static_cast<double>(ring + 1) / static_cast<double>(grid.rings + 1);
    for (std::uint64_t column = 0; column < grid.columns; ++column)
    {
      WritePoint(
        output, surface(along, static_cast<double>(column) / static_cast<double>(grid.columns)));
    }
  }
  WritePoint(output, surface(1.0, 0.0));

  const auto at = [&grid](std::uint64_t ring, std::uint64_t column)
  { return 1 + ring * grid.columns + column % grid.columns; };
  const std::uint64_t last = grid.Vertices() - 1;
  for (std::uint64_t column = 0; column < grid.columns; ++column)
  {
    WriteTriangle(output, 0, at(0, column), at(0, column + 1));
  }
  for (std::uint64_t ring = 0; ring + 1 < grid.rings; ++ring)
  {
    for (std::uint64_t column = 0; column < grid.columns; ++column)
    {
      WriteTriangle(output, at(ring, column), at(ring + 1, column), at(ring + 1, column + 1));
      WriteTriangle(output, at(ring, column), at(ring + 1, column + 1), at(ring, column + 1));
    }
  }
  for (std::uint64_t column = 0; column < grid.columns; ++column)
  {
    WriteTriangle(output, at(grid.rings - 1, column), last, at(grid.rings - 1, column + 1));
  }
  return output.Finish();
}

}
