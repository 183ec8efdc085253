// SPDX-License-Identifier: BSD-3-Clause
// A lower bound for the time of kdstream-build: the simplest program that cuts a mesh into
// partitions (doc/benchmarks.md#floors-and-peers). One thread, everything in memory, no checks, no
// levels, no codec. Usage:
//   BenchFloor INPUT.ply OUTPUT [VERTICES_PER_PARTITION]
// The input is written by kdstream-generate (binary little-endian, float x y z, triangles of uint).
// The steps: fread; a k-d tree by std::nth_element on (coordinate, id); bucketing the triangles;
// for each partition its points, the repeated points of others, and the triangles in local indices;
// writing one file, with fdatasync. Prints the seconds of each step as one line of JSON.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

namespace
{

struct Point
{
  std::array<float, 3> p;
  std::uint32_t id;
};
using Triangle = std::array<std::uint32_t, 3>;

struct Mesh
{
  std::vector<std::array<float, 3>> points;
  std::vector<Triangle> triangles;
};

[[noreturn]] void Fail(const char* what)
{
  std::perror(what);
  std::exit(1);
}

double Seconds()
{
  using namespace std::chrono;
  return duration<double>(steady_clock::now().time_since_epoch()).count();
}

Mesh Read(const char* name)
{
  std::FILE* file = std::fopen(name, "rb");
  if (!file)
  {
    Fail(name);
  }
  std::size_t points = 0, triangles = 0;
  char line[256];
  while (std::fgets(line, sizeof(line), file) && std::strcmp(line, "end_header\n") != 0)
  {
    static_cast<void>(std::sscanf(line, "element vertex %zu", &points));
    static_cast<void>(std::sscanf(line, "element face %zu", &triangles));
  }
  Mesh mesh;
  mesh.points.resize(points);
  mesh.triangles.resize(triangles);
  if (std::fread(mesh.points.data(), sizeof(mesh.points[0]), points, file) != points)
  {
    Fail(name);
  }
  constexpr std::size_t record = 13, block = 1 << 16;
  std::vector<char> bytes(record * block);
  for (std::size_t first = 0; first < triangles; first += block)
  {
    const std::size_t now = std::min(block, triangles - first);
    if (std::fread(bytes.data(), record, now, file) != now)
    {
      Fail(name);
    }
    for (std::size_t i = 0; i < now; ++i)
    {
      std::memcpy(&mesh.triangles[first + i], bytes.data() + i * record + 1, 12);
    }
  }
  std::fclose(file);
  return mesh;
}

// Halves [begin, end) along the longest side of its box until each part has at most `most` points.
void Split(std::vector<Point>& points, std::size_t begin, std::size_t end, std::size_t depth,
  std::size_t deepest, std::vector<std::size_t>& partitionBegin)
{
  if (depth == deepest)
  {
    partitionBegin.push_back(begin);
    return;
  }
  auto lo = points[begin].p, hi = lo;
  for (std::size_t i = begin; i < end; ++i)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      lo[k] = std::min(lo[k], points[i].p[k]);
      hi[k] = std::max(hi[k], points[i].p[k]);
    }
  }
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k)
  {
    axis = hi[k] - lo[k] > hi[axis] - lo[axis] ? k : axis;
  }
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::size_t i) { return points.begin() + std::ptrdiff_t(i); };
  std::nth_element(at(begin), at(middle), at(end),
    [axis](const Point& a, const Point& b)
    { return a.p[axis] < b.p[axis] || (a.p[axis] == b.p[axis] && a.id < b.id); });
  Split(points, begin, middle, depth + 1, deepest, partitionBegin);
  Split(points, middle, end, depth + 1, deepest, partitionBegin);
}

struct Buckets
{
  std::vector<std::size_t> begin;
  std::vector<std::uint32_t> triangles;
};

Buckets Bucket(const std::vector<Triangle>& triangles,
  const std::vector<std::uint32_t>& partitionOf, std::size_t partitions)
{
  const auto visit = [&](const Triangle& t, const auto& add)
  {
    const std::uint32_t a = partitionOf[t[0]], b = partitionOf[t[1]], c = partitionOf[t[2]];
    add(a);
    if (b != a)
    {
      add(b);
    }
    if (c != a && c != b)
    {
      add(c);
    }
  };
  Buckets buckets;
  buckets.begin.assign(partitions + 1, 0);
  for (const Triangle& t : triangles)
  {
    visit(t, [&](std::uint32_t p) { ++buckets.begin[p + 1]; });
  }
  for (std::size_t p = 0; p < partitions; ++p)
  {
    buckets.begin[p + 1] += buckets.begin[p];
  }
  buckets.triangles.resize(buckets.begin.back());
  std::vector<std::size_t> next(buckets.begin.begin(), buckets.begin.end() - 1);
  for (std::size_t t = 0; t < triangles.size(); ++t)
  {
    visit(triangles[t],
      [&](std::uint32_t p) { buckets.triangles[next[p]++] = static_cast<std::uint32_t>(t); });
  }
  return buckets;
}

void Write(const char* name, const Mesh& mesh, const std::vector<Point>& points,
  const std::vector<std::size_t>& partitionBegin, const std::vector<std::uint32_t>& partitionOf,
  const Buckets& buckets)
{
  std::FILE* file = std::fopen(name, "wb");
  if (!file)
  {
    Fail(name);
  }
  const std::size_t partitions = partitionBegin.size() - 1;
  std::vector<std::uint32_t> local(mesh.points.size());
  for (std::size_t p = 0; p < partitions; ++p)
  {
    for (std::size_t i = partitionBegin[p]; i < partitionBegin[p + 1]; ++i)
    {
      local[points[i].id] = static_cast<std::uint32_t>(i - partitionBegin[p]);
    }
  }
  std::vector<std::uint32_t> border;
  std::vector<std::array<float, 3>> out;
  std::vector<Triangle> indices;
  for (std::size_t p = 0; p < partitions; ++p)
  {
    const std::size_t begin = buckets.begin[p], end = buckets.begin[p + 1];
    border.clear();
    out.clear();
    indices.clear();
    for (std::size_t i = begin; i < end; ++i)
    {
      for (const std::uint32_t v : mesh.triangles[buckets.triangles[i]])
      {
        if (partitionOf[v] != p)
        {
          border.push_back(v);
        }
      }
    }
    std::sort(border.begin(), border.end());
    border.erase(std::unique(border.begin(), border.end()), border.end());
    for (std::size_t i = partitionBegin[p]; i < partitionBegin[p + 1]; ++i)
    {
      out.push_back(points[i].p);
    }
    const std::size_t own = out.size();
    for (const std::uint32_t v : border)
    {
      out.push_back(mesh.points[v]);
    }
    for (std::size_t i = begin; i < end; ++i)
    {
      Triangle t = mesh.triangles[buckets.triangles[i]];
      for (std::uint32_t& v : t)
      {
        v = partitionOf[v] == p
              ? local[v]
              : static_cast<std::uint32_t>(
                  own + static_cast<std::size_t>(
                          std::lower_bound(border.begin(), border.end(), v) - border.begin()));
      }
      indices.push_back(t);
    }
    const std::uint64_t sizes[3] = { own, out.size(), indices.size() };
    std::fwrite(sizes, sizeof(sizes), 1, file);
    std::fwrite(out.data(), sizeof(out[0]), out.size(), file);
    std::fwrite(indices.data(), sizeof(indices[0]), indices.size(), file);
  }
  if (std::fflush(file) != 0 || ::fdatasync(::fileno(file)) != 0 || std::fclose(file) != 0)
  {
    Fail(name);
  }
}

}

int main(int argc, char** argv)
{
  if (argc < 3)
  {
    std::fprintf(stderr, "BenchFloor INPUT.ply OUTPUT [VERTICES_PER_PARTITION]\n");
    return 2;
  }
  const std::size_t most = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 2000;
  const double start = Seconds();
  const Mesh mesh = Read(argv[1]);
  const double read = Seconds();
  std::vector<Point> points(mesh.points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    points[i] = { mesh.points[i], static_cast<std::uint32_t>(i) };
  }
  std::size_t deepest = 0;
  while (((points.size() - 1) >> deepest) + 1 > most)
  {
    ++deepest;
  }
  std::vector<std::size_t> partitionBegin;
  Split(points, 0, points.size(), 0, deepest, partitionBegin);
  partitionBegin.push_back(points.size());
  const double tree = Seconds();
  const std::size_t partitions = partitionBegin.size() - 1;
  std::vector<std::uint32_t> partitionOf(points.size());
  for (std::size_t p = 0; p < partitions; ++p)
  {
    for (std::size_t i = partitionBegin[p]; i < partitionBegin[p + 1]; ++i)
    {
      partitionOf[points[i].id] = static_cast<std::uint32_t>(p);
    }
  }
  const Buckets buckets = Bucket(mesh.triangles, partitionOf, partitions);
  const double faces = Seconds();
  Write(argv[2], mesh, points, partitionBegin, partitionOf, buckets);
  const double written = Seconds();
  std::printf("{\"read\":%.3f,\"tree\":%.3f,\"faces\":%.3f,\"write\":%.3f,\"total\":%.3f}\n",
    read - start, tree - read, faces - tree, written - faces, written - start);
  return 0;
}
