// SPDX-License-Identifier: BSD-3-Clause
// A closed surface with fine relief: see Relief.h.
#include "Data/Generate/Relief.h"

#include "Data/Generate/Hash.h"
#include "Data/Generate/Noise.h"
#include "filters/meshio/OutputFile.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>

namespace kdstream::generate
{
namespace
{

constexpr double longestWave = 1.0,
                 waveHeight = 0.06;  // of the longest wave; the ball's radius is 1
constexpr double heightRatio = 0.47; // of each wave to the previous one, which is twice as long
constexpr double shortestWave = 5.0; // in edges
constexpr double grainHeight = 0.08; // in edges

constexpr std::size_t pointBytes = 12, triangleBytes = 13;

void PutLittleEndian(std::uint32_t value, char* bytes)
{
  for (std::size_t i = 0; i < 4; ++i)
  {
    bytes[i] = static_cast<char>(value >> (8 * i));
  }
}

// Writes `count` records of `size` bytes each, one block at a time. fill(i, bytes) makes record
// number i.
template <class Fill>
Status WriteRecords(OutputFile& output, std::uint64_t count, std::size_t size, const char* step,
  const Execution& execution, const Fill& fill)
{
  constexpr std::size_t block = std::size_t{ 1 } << 20; // records
  std::string bytes;
  for (std::uint64_t first = 0; first < count; first += block)
  {
    const auto now = static_cast<std::size_t>(std::min<std::uint64_t>(block, count - first));
    bytes.resize(now * size);
    execution.parallelFor(now, block / 64,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = begin; i < end; ++i)
        {
          fill(first + i, bytes.data() + i * size);
        }
      });
    output.Write(bytes);
    const double done = static_cast<double>(first + now) / static_cast<double>(count);
    KDSTREAM_TRY(execution.Report(step, done));
  }
  return {};
}

std::string HeaderOf(const CubeGrid& grid)
{
  return "ply\nformat binary_little_endian 1.0\ncomment made by kdstream-generate\nelement "
         "vertex " +
         std::to_string(grid.Points()) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
         std::to_string(grid.Triangles()) +
         "\nproperty list uchar uint vertex_indices\nend_header\n";
}

}

Relief::Relief(const CubeGrid& grid, const ReliefOptions& options)
  : Grid(grid)
  , Seed(options.seed)
  , Octaves(0)
{
  const double side = options.detail > 0 ? std::sqrt(static_cast<double>(options.detail) / 6)
                                         : static_cast<double>(grid.side);
  const double edge = 1.5 / side; // one side of the cube is a sixth of the ball
  for (double wave = longestWave; wave >= shortestWave * edge; wave /= 2)
  {
    ++this->Octaves;
  }
  this->Grain = options.detail > 0 ? 0 : std::min(grainHeight * edge, waveHeight);
}

Vec3 Relief::At(std::uint64_t point) const
{
  // Maps the cube to the ball so that squares keep about the same size (P. Nowell, "Mapping a cube
  // to a sphere", 2005).
  const CubeGrid::Place place = this->Grid.PlaceOf(point);
  Vec3 cube{}, square{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    cube[k] = 2.0 * static_cast<double>(place[k]) / static_cast<double>(this->Grid.side) - 1.0;
    square[k] = cube[k] * cube[k];
  }
  Vec3 ball{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double a = square[(k + 1) % 3], b = square[(k + 2) % 3];
    ball[k] = cube[k] * std::sqrt(1.0 - a / 2 - b / 2 + a * b / 3);
  }
  double radius = 1.0, height = waveHeight, frequency = 1.0 / longestWave;
  for (int octave = 0; octave < this->Octaves; ++octave)
  {
    const std::uint64_t layer = this->Seed * 64 + static_cast<std::uint64_t>(octave);
    radius +=
      height * SmoothNoise(ball[0] * frequency, ball[1] * frequency, ball[2] * frequency, layer);
    height *= heightRatio;
    frequency *= 2;
  }
  radius += this->Grain * NoiseOf(Hash(point + (this->Seed << 32)));
  return { radius * ball[0], radius * ball[1], radius * ball[2] };
}

Status WriteRelief(const CubeGrid& grid, const ReliefOptions& options,
  const std::filesystem::path& file, const Execution& execution)
{
  OutputFile output;
  KDSTREAM_TRY(output.Open(file));
  output.Write(HeaderOf(grid));
  const Relief relief(grid, options);
  const Permutation points(grid.Points(), 2 * options.seed);
  const Permutation triangles(grid.Triangles(), 2 * options.seed + 1);
  KDSTREAM_TRY(WriteRecords(output, grid.Points(), pointBytes, "vertices", execution,
    [&](std::uint64_t i, char* bytes)
    {
      const Vec3 p = relief.At(options.shuffledPoints ? points(i) : i);
      for (std::size_t k = 0; k < 3; ++k)
      {
        PutLittleEndian(std::bit_cast<std::uint32_t>(static_cast<float>(p[k])), bytes + 4 * k);
      }
    }));
  KDSTREAM_TRY(WriteRecords(output, grid.Triangles(), triangleBytes, "triangles", execution,
    [&](std::uint64_t i, char* bytes)
    {
      const auto corners = grid.CornersOf(options.shuffledTriangles ? triangles(i) : i);
      bytes[0] = 3;
      for (std::size_t k = 0; k < 3; ++k)
      {
        PutLittleEndian(static_cast<std::uint32_t>(
                          options.shuffledPoints ? points.Inverse(corners[k]) : corners[k]),
          bytes + 1 + 4 * k);
      }
    }));
  return output.Finish();
}

}
