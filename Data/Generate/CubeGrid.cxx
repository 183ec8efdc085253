// SPDX-License-Identifier: BSD-3-Clause
// The surface of a cube, computed from indices: see CubeGrid.h.
#include "Data/Generate/CubeGrid.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace kdstream::generate
{

Result<CubeGrid> CubeGrid::Of(std::uint64_t points)
{
  const double wanted = static_cast<double>(points - std::min<std::uint64_t>(points, 2)) / 6;
  constexpr std::uint64_t most = std::uint64_t{ 1 } << 32;
  CubeGrid grid{ static_cast<std::uint64_t>(std::llround(std::sqrt(wanted))) };
  if (points <= most && grid.Points() > most)
  {
    --grid.side;
  }
  if (points < 8 || points > most)
  {
    return Error{ ErrorCode::InvalidArgument,
      std::to_string(points) + " vertices: a closed surface has 8 to 2^32" };
  }
  return grid;
}

// The first and the last layer are squares of points; the layers between them are rings around a
// square.
CubeGrid::Place CubeGrid::PlaceOf(std::uint64_t point) const
{
  const std::uint64_t m = this->side, row = m + 1, square = row * row, ring = 4 * m;
  const std::uint64_t last = square + (m - 1) * ring;
  if (point < square)
  {
    return { point % row, point / row, 0 };
  }
  if (point >= last)
  {
    return { (point - last) % row, (point - last) / row, m };
  }
  const std::uint64_t z = 1 + (point - square) / ring, along = (point - square) % ring;
  switch (along / m)
  {
    case 0:
      return { along, 0, z };
    case 1:
      return { m, along - m, z };
    case 2:
      return { 3 * m - along, m, z };
    default:
      return { 0, 4 * m - along, z };
  }
}

std::uint64_t CubeGrid::PointAt(const Place& place) const
{
  const auto [x, y, z] = place;
  const std::uint64_t m = this->side, row = m + 1, square = row * row, ring = 4 * m;
  if (z == 0 || z == m)
  {
    return (z == 0 ? 0 : square + (m - 1) * ring) + y * row + x;
  }
  const std::uint64_t along = y == 0 && x < m   ? x
                              : x == m && y < m ? m + y
                              : y == m && x > 0 ? 3 * m - x
                                                : 4 * m - y;
  return square + (z - 1) * ring + along;
}

std::array<std::uint64_t, 3> CubeGrid::CornersOf(std::uint64_t triangle) const
{
  const std::uint64_t m = this->side, square = triangle / 2;
  const std::uint64_t face = square / (m * m), row = square / m % m, column = square % m;
  // On the far side of an axis, the next two axes in order turn counter-clockwise; on the near side
  // they turn clockwise.
  const std::size_t axis = face / 2;
  std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
  const bool far = face % 2 == 1;
  if (!far)
  {
    std::swap(u, v);
  }
  const auto at = [&](std::uint64_t du, std::uint64_t dv)
  {
    Place place{};
    place[axis] = far ? m : 0;
    place[u] = column + du;
    place[v] = row + dv;
    return this->PointAt(place);
  };
  if (triangle % 2 == 0)
  {
    return { at(0, 0), at(1, 0), at(1, 1) };
  }
  return { at(0, 0), at(1, 1), at(0, 1) };
}

}
