// SPDX-License-Identifier: BSD-3-Clause
// Table 3 of the paper: partitioning out of core, by octree and by k-d tree with each of the four
// medians, compared with the paper's figures. Also the number of passes of its heaps, and the tree
// in memory compared with only std::nth_element. Usage:
//   BenchTable3 OUTPUT_FOLDER [--temp-dir DIR] [--memory BYTES] [--points KIND:COUNT] … [MESH.ply]
//   …
// KIND: uniform in a cube | skewed: exponential along every axis | tied: on a grid of 100 steps a
// side | sphere: a displaced sphere in the order of its latitudes, like a scan. Without --points:
// spheres with the paper's three numbers of vertices; the other kinds only with the largest number.
// Without --memory: a third of the points' bytes, so that two depths of the tree are out of core at
// any size. Every time is also given as a multiple of a bare sequential read and write of the same
// bytes in the same folder, measured just before. Writes table3.csv.
#include "filters/baselines/OctreeClustering.h"
#include "filters/baselines/stores/Baselines.h"
#include "filters/baselines/stores/ExternalOctree.h"
#include "filters/core/tree/KdTree.h"
#include "filters/meshio/MeshReader.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/tree/ExternalTree.h"
#include "filters/program/Program.h"
#include "filters/program/TbbExecution.h"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace
{

using namespace kdstream;

using Clock = std::chrono::steady_clock;

constexpr const char* methods[] = { "heaps", "torben", "sort", "histogram" };

template <class T>
T Need(Result<T> result)
{
  if (!result)
  {
    throw std::runtime_error(result.GetError().message); // not exit(): temporary files are removed
  }
  return std::move(*result);
}

void Need(const Status& status)
{
  if (!status)
  {
    throw std::runtime_error(status.GetError().message); // not exit(): temporary files are removed
  }
}

double SecondsSince(Clock::time_point begin)
{
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

struct Settings
{
  std::filesystem::path output, temporary = std::filesystem::temp_directory_path();
  std::uint64_t memory = 0;       // 0: a third of the size of the points
  std::vector<std::string> kinds; // KIND:COUNT
  std::vector<std::string> meshes;
};

struct NamedPoints
{
  std::string name;
  std::vector<Vec3> points;
};

// ---- points

Vec3 SpherePoint(std::size_t i, std::size_t n)
{
  // A spiral from pole to pole, with relief of several wavelengths.
  const double z = 1 - 2 * (double(i) + 0.5) / double(n);
  const double around = 2 * 3.14159265358979 * std::fmod(double(i) * 0.6180339887498949, 1.0);
  const double flat = std::sqrt(1 - z * z);
  const Vec3 p{ flat * std::cos(around), flat * std::sin(around), z };
  const double relief = 1 + 0.1 * std::sin(5 * p[0]) * std::sin(4 * p[1]) +
                        0.02 * std::sin(31 * p[1]) * std::sin(37 * p[2]) +
                        0.004 * std::sin(211 * p[0] + 157 * p[2]);
  return { p[0] * relief, p[1] * relief * 1.3, p[2] * relief * 0.8 };
}

NamedPoints Generate(const std::string& kind, std::size_t count)
{
  NamedPoints named{ kind, {} };
  named.points.reserve(count);
  std::mt19937_64 engine(7);
  const auto unit = [&] { return double(engine() >> 11) / 9007199254740992.0; };
  for (std::size_t i = 0; i < count; ++i)
  {
    Vec3 p = kind == "sphere" ? SpherePoint(i, count) : Vec3{ unit(), unit(), unit() };
    for (double& coordinate : p)
    {
      coordinate = kind == "skewed" ? -std::log(1 - coordinate)
                   : kind == "tied" ? std::floor(100 * coordinate)
                                    : coordinate;
      coordinate = double(float(coordinate));
    }
    named.points.push_back(p);
  }
  return named;
}

NamedPoints ReadPoints(const std::string& file)
{
  auto reader = Need(MeshReader::Open(file));
  Mesh mesh;
  while (Need(reader->ReadVertices(mesh, 1 << 20)) > 0)
  {
  }
  return { std::filesystem::path(file).stem().string(), std::move(mesh.points) };
}

// ---- out of core

using Record = PointRecord<float>;

// The cost of a bare sequential pass in the folder.
struct BareSpeed
{
  double readSeconds = 0, writeSeconds = 0; // for each byte

  double SecondsOf(std::uint64_t bytesRead, std::uint64_t bytesWritten) const
  {
    return double(bytesRead) * this->readSeconds + double(bytesWritten) * this->writeSeconds;
  }
};

BareSpeed MeasureBare(SpillFolder& folder, std::uint64_t bytes)
{
  const std::vector<std::byte> block(2 * spillBlockBytes);
  std::vector<std::byte> back(block.size());
  SpillFile file = Need(folder.CreateFile("bare pass", bytes));
  // Reads and writes the file repeatedly, so that the time is long enough to be measured.
  const std::uint64_t blocks = std::max<std::uint64_t>(1, bytes / block.size());
  const std::uint64_t all = (100 + blocks - 1) / blocks * blocks;
  Clock::time_point begin = Clock::now();
  for (std::uint64_t i = 0; i < all; ++i)
  {
    Need(file.Write(i % blocks * block.size(), block));
  }
  BareSpeed speed;
  speed.writeSeconds = SecondsSince(begin) / double(all * block.size());
  begin = Clock::now();
  for (std::uint64_t i = 0; i < all; ++i)
  {
    Need(file.Read(i % blocks * block.size(), back));
  }
  speed.readSeconds = SecondsSince(begin) / double(all * block.size());
  return speed;
}

SpillFile Spill(SpillFolder& folder, const std::vector<Vec3>& points)
{
  SpillFile file = Need(folder.CreateFile("points", points.size() * sizeof(Record)));
  RecordWriter<Record> writer(file);
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    const Vec3& p = points[i];
    writer.Append({ { float(p[0]), float(p[1]), float(p[2]) }, static_cast<VertexId>(i) });
  }
  Need(writer.Finish());
  return file;
}

// Runs on all threads, and notes when the survey of the points ended, which is the paper's
// initialization.
class TimedExecution
{
public:
  TimedExecution()
    : Run(MakeTbbExecution(0))
  {
    this->Run.progress = [this](std::string_view step, double)
    {
      if (step == "survey")
      {
        this->SurveyEnd = Clock::now();
      }
      return true;
    };
  }

  Execution Run;
  Clock::time_point SurveyEnd = Clock::now();
};

struct Row
{
  std::string points, method;
  std::size_t vertices = 0;
  std::uint64_t memory = 0;
  std::uint64_t partitions = 0;
  double initialization = 0, partitioning = 0;
  std::string passes; // of the median over one cell; the most at each depth
  std::uint64_t bytesRead = 0, bytesWritten = 0;
  double bare = 0;
};

// The paper's number of partitions.
std::uint32_t PartitionsOf(std::size_t vertices)
{
  const std::uint32_t wanted = vertices > 8000000 ? 1024 : 512;
  return static_cast<std::uint32_t>(std::min<std::size_t>(wanted, std::bit_floor(vertices)));
}

// median: a name as for kdstream-build.
Row RunTree(const NamedPoints& named, const Settings& settings, std::uint64_t memory,
  const char* median, double heapShare = 0)
{
  const ExternalTreeOptions options{ memory, MedianMethodOfName(median), heapShare, false };
  SpillFolder folder = Need(SpillFolder::Create(settings.temporary));
  const BareSpeed bare = MeasureBare(folder, named.points.size() * sizeof(Record));
  TimedExecution timed;
  const Clock::time_point begin = Clock::now();
  SpillFile file = Spill(folder, named.points);
  timed.SurveyEnd = Clock::now(); // stays if there is no survey, because all points fit into memory
  const TreeDepths depths =
    Need(ComputeDepths(named.points.size(), { 2000, PartitionsOf(named.points.size()), 0 }));
  const ExternalTree tree =
    Need(BuildExternalTree<float>(folder, file, depths, options, timed.Run));
  Row row{ named.name, median, named.points.size(), memory, std::uint64_t{ 1 } << depths.partition,
    0, SecondsSince(timed.SurveyEnd), "", 0, 0, 0 };
  row.initialization = std::chrono::duration<double>(timed.SurveyEnd - begin).count();
  for (const ExternalDepthStatistics& depth : tree.statistics.depths)
  {
    row.passes += (row.passes.empty() ? "" : ",") + std::to_string(depth.mostMedianPasses);
  }
  row.bytesRead = tree.statistics.bytesRead;
  row.bytesWritten = tree.statistics.bytesWritten + named.points.size() * sizeof(Record);
  row.bare = bare.SecondsOf(row.bytesRead, row.bytesWritten);
  return row;
}

// Finds the N that gives about as many octree partitions as the k-d tree has; in the paper their
// numbers differ by up to 17 %.
Row RunOctree(const NamedPoints& named, const Settings& settings, std::uint64_t memory)
{
  OctreeOptions wanted;
  wanted.partitions = PartitionsOf(named.points.size());
  const std::uint32_t most = Need(ClusterByOctree(named.points, wanted)).verticesPerPartition;
  SpillFolder folder = Need(SpillFolder::Create(settings.temporary));
  const BareSpeed bare = MeasureBare(folder, named.points.size() * sizeof(Record));
  TimedExecution timed;
  const Clock::time_point begin = Clock::now();
  SpillFile file = Spill(folder, named.points);
  const ExternalOctree octree =
    Need(ClusterByExternalOctree<float>(folder, file, { most, memory, false }, timed.Run));
  Row row{ named.name, "octree", named.points.size(), memory, octree.clusterBegin.size() - 1, 0,
    SecondsSince(timed.SurveyEnd), "", octree.statistics.bytesRead,
    octree.statistics.bytesWritten + named.points.size() * sizeof(Record), 0 };
  row.initialization = std::chrono::duration<double>(timed.SurveyEnd - begin).count();
  row.bare = bare.SecondsOf(row.bytesRead, row.bytesWritten);
  return row;
}

void Print(const Row& row, std::ofstream& csv)
{
  const double total = row.initialization + row.partitioning;
  std::printf(
    "%-12s %9zu %6.0fM %-10s %6llu | %7.2f %7.2f %7.2f %9.5f | %-8s %7.0f %7.0f | %5.1f x\n",
    row.points.c_str(), row.vertices, double(row.memory) / (1 << 20), row.method.c_str(),
    static_cast<unsigned long long>(row.partitions), row.initialization, row.partitioning, total,
    total / double(row.partitions), row.passes.c_str(), double(row.bytesRead) / 1e6,
    double(row.bytesWritten) / 1e6, total / row.bare);
  std::fflush(stdout);
  csv << row.points << "," << row.vertices << "," << row.memory << "," << row.method << ","
      << row.partitions << "," << row.initialization << "," << row.partitioning << ","
      << total / double(row.partitions) << ",\"" << row.passes << "\"," << row.bytesRead << ","
      << row.bytesWritten << "," << total / row.bare << "\n";
}

void PrintPaper()
{
  std::printf("The paper's Table 3 (2 GHz, 3 GB, 256 MB for the heaps; its octree's total for Lucy "
              "is less than what it adds up to):\n"
              "%-14s %10s %-8s %6s | %8s %8s %8s %8s\n",
    "mesh", "vertices", "method", "parts", "init s", "part s", "total s", "s/part");
  struct
  {
    const char* mesh;
    unsigned vertices;
    const char* method;
    unsigned partitions;
    double initialization, partitioning, total, each;
  } const rows[] = {
    { "Buddha", 541336, "k-means", 584, 410, 390, 800, 1.37 },
    { "Buddha", 541336, "octree", 587, 65, 10, 75, 0.13 },
    { "Buddha", 541336, "k-d tree", 512, 65, 12, 77, 0.15 },
    { "Xyzrgb_dragon", 3609455, "k-means", 576, 6900, 2220, 9120, 15.83 },
    { "Xyzrgb_dragon", 3609455, "octree", 571, 453, 15, 468, 0.82 },
    { "Xyzrgb_dragon", 3609455, "k-d tree", 512, 453, 42, 495, 0.97 },
    { "Lucy", 14027867, "k-means", 1195, 11700, 8700, 20400, 17.07 },
    { "Lucy", 14027867, "octree", 1196, 1187, 95, 1282, 1.07 },
    { "Lucy", 14027867, "k-d tree", 1024, 1887, 205, 2092, 2.04 },
  };
  for (const auto& row : rows)
  {
    std::printf("%-14s %10u %-8s %6u | %8.0f %8.0f %8.0f %8.2f\n", row.mesh, row.vertices,
      row.method, row.partitions, row.initialization, row.partitioning, row.total, row.each);
  }
}

void RunTable(const NamedPoints& named, const Settings& settings, std::ofstream& csv)
{
  const std::uint64_t bytes = named.points.size() * sizeof(Record);
  const std::uint64_t memory = settings.memory > 0 ? settings.memory : bytes / 3;
  for (const char* median : methods)
  {
    Print(RunTree(named, settings, memory, median), csv);
  }
  Print(RunOctree(named, settings, memory), csv);
  const std::uint64_t ofPaper = std::uint64_t{ 256 } << 20;
  if (settings.memory == 0)
  {
    Print(RunTree(named, settings, ofPaper, "histogram"), csv);
  }
}

// ---- the claims about heaps

// The rank of the mean of the coordinates along the longest axis, in percent of the vertices; the
// median's rank is 50.
double RankOfMean(const std::vector<Vec3>& points)
{
  Box box;
  Vec3 sum{};
  for (const Vec3& p : points)
  {
    box.Add(p);
    for (std::size_t k = 0; k < 3; ++k)
    {
      sum[k] += p[k];
    }
  }
  const std::size_t axis = LongestAxis(box);
  const double mean = sum[axis] / double(points.size());
  const auto upTo =
    std::count_if(points.begin(), points.end(), [&](const Vec3& p) { return p[axis] <= mean; });
  return 100 * double(upTo) / double(points.size());
}

void PrintHeaps(const NamedPoints& named, const Settings& settings)
{
  const std::uint64_t memory = named.points.size() * sizeof(Record) / 3;
  const double rank = RankOfMean(named.points);
  std::printf("%-12s %9zu | %6.1f %% %s |", named.name.c_str(), named.points.size(), rank,
    std::fabs(rank - 50) <= 5 ? "holds" : "FAILS");
  for (const double share : { 0.01, 0.05, 0.1 })
  {
    const Row row = RunTree(named, settings, memory, "heaps", share);
    std::printf(" %12s", row.passes.c_str());
  }
  std::printf("\n");
  std::fflush(stdout);
}

// ---- in memory

// Only the tree, by std::nth_element: records, boxes and medians down to depth L, without outputs.
class BareTree
{
public:
  BareTree(const std::vector<Vec3>& points, unsigned depths, const Execution& execution)
    : Run(execution)
    , Records(points.size())
  {
    this->Run.parallelFor(points.size(), 1 << 16,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = begin; i < end; ++i)
        {
          const Vec3& p = points[i];
          this->Records[i] = { { float(p[0]), float(p[1]), float(p[2]) },
            static_cast<VertexId>(i) };
        }
      });
    const unsigned forked = std::min(depths, 8U);
    std::vector<std::span<Record>> cells{ this->Records };
    for (unsigned depth = 0; depth < forked; ++depth)
    {
      std::vector<std::span<Record>> halves(2 * cells.size());
      this->Run.parallelFor(cells.size(), 1,
        [&](std::size_t begin, std::size_t end)
        {
          for (std::size_t i = begin; i < end; ++i)
          {
            Split(cells[i]);
            halves[2 * i] = cells[i].first(cells[i].size() / 2);
            halves[2 * i + 1] = cells[i].subspan(cells[i].size() / 2);
          }
        });
      cells = std::move(halves);
    }
    this->Run.parallelFor(cells.size(), 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = begin; i < end; ++i)
        {
          Recurse(cells[i], depths - forked);
        }
      });
  }

private:
  static void Recurse(std::span<Record> cell, unsigned depths)
  {
    if (depths > 0)
    {
      Split(cell);
      Recurse(cell.first(cell.size() / 2), depths - 1);
      Recurse(cell.subspan(cell.size() / 2), depths - 1);
    }
  }

  static void Split(std::span<Record> cell)
  {
    if (cell.empty())
    {
      return;
    }
    std::array<float, 3> lo = cell[0].p, hi = lo;
    for (const Record& record : cell)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        lo[k] = std::min(lo[k], record.p[k]);
        hi[k] = std::max(hi[k], record.p[k]);
      }
    }
    const float x = hi[0] - lo[0], y = hi[1] - lo[1], z = hi[2] - lo[2];
    x >= y&& x >= z ? Select<0>(cell) : y >= z ? Select<1>(cell) : Select<2>(cell);
  }

  template <std::size_t Axis>
  static void Select(std::span<Record> cell)
  {
    std::nth_element(cell.begin(), cell.begin() + std::ptrdiff_t(cell.size() / 2), cell.end(),
      [](const Record& a, const Record& b)
      { return a.p[Axis] < b.p[Axis] || (a.p[Axis] == b.p[Axis] && a.id < b.id); });
  }

  Execution Run;
  std::vector<Record> Records;
};

void PrintInMemory(const NamedPoints& named)
{
  const TreeDepths depths = Need(ComputeDepths(named.points.size(), {}));
  for (const unsigned threads : { 1U, 0U })
  {
    const Execution execution = MakeTbbExecution(threads);
    double bare = INFINITY, ours = INFINITY;
    for (int repeat = 0; repeat < 3; ++repeat)
    {
      Clock::time_point begin = Clock::now();
      const BareTree tree(named.points, depths.finest, execution);
      bare = std::min(bare, SecondsSince(begin));
      begin = Clock::now();
      const KdTree built = Need(BuildKdTree(named.points, {}, execution));
      ours = std::min(ours, SecondsSince(begin));
    }
    std::printf("%-12s %9zu %3u %8s | %7.3f %7.3f | %5.2f x (at most 1.2)\n", named.name.c_str(),
      named.points.size(), depths.finest, threads == 1 ? "1" : "all", bare, ours, ours / bare);
    std::fflush(stdout);
  }
}

// ---- the program

void Usage()
{
  std::cerr << "usage: BenchTable3 OUTPUT_FOLDER [--temp-dir DIR] [--memory BYTES] "
               "[--points KIND:COUNT] ... [MESH.ply] ...\n";
  std::exit(2);
}

Settings Parse(int argc, char** argv)
{
  Settings settings;
  for (int i = 1; i < argc; ++i)
  {
    const std::string_view argument = argv[i];
    const auto value = [&]() -> std::string { return i + 1 < argc ? argv[++i] : (Usage(), ""); };
    if (argument == "--temp-dir")
    {
      settings.temporary = value();
    }
    else if (argument == "--memory")
    {
      settings.memory = Need(ParseSize(value()));
    }
    else if (argument == "--points")
    {
      settings.kinds.push_back(value());
    }
    else if (settings.output.empty())
    {
      settings.output = argument;
    }
    else
    {
      settings.meshes.emplace_back(argument);
    }
  }
  if (settings.output.empty())
  {
    Usage();
  }
  if (settings.kinds.empty())
  {
    settings.kinds = { "sphere:541336", "sphere:3609455", "sphere:14027867", "uniform:3609455",
      "skewed:3609455", "tied:3609455" };
  }
  return settings;
}

// Calls work(points) for each input; only one input is in memory at a time.
void ForEachInput(const Settings& settings, const std::function<void(const NamedPoints&)>& work)
{
  for (const std::string& mesh : settings.meshes)
  {
    work(ReadPoints(mesh));
  }
  for (const std::string& kind : settings.kinds)
  {
    const std::size_t colon = kind.find(':');
    const std::string name = kind.substr(0, colon);
    const std::size_t count =
      colon == std::string::npos ? 0 : std::strtoull(kind.c_str() + colon + 1, nullptr, 10);
    if (count == 0 || (name != "uniform" && name != "skewed" && name != "tied" && name != "sphere"))
    {
      Usage();
    }
    work(Generate(name, count));
  }
}

void Run(const Settings& settings)
{
  std::ofstream csv(settings.output / "table3.csv");
  csv << "points,vertices,memory,method,partitions,initialization,partitioning,seconds per "
         "partition,median passes,bytes read,bytes written,ratio to bare\n";
  PrintPaper();
  std::printf(
    "\nOurs, on all threads: points as 16 bytes a vertex, written to %s (initialization: "
    "that and the survey), then partitioned there; of the histogram, auto, a row under the "
    "paper's 256 MB. passes: of the median over a cell, beside the one that divides it, the "
    "most at each depth out of core. x: a bare sequential read and write of the same MB.\n",
    settings.temporary.c_str());
  std::printf("%-12s %9s %7s %-10s %6s | %7s %7s %7s %9s | %-8s %7s %7s |\n", "points", "vertices",
    "memory", "method", "parts", "init s", "part s", "total s", "s/part", "passes", "MB read",
    "written");
  ForEachInput(settings, [&](const NamedPoints& named) { RunTable(named, settings, csv); });

  std::printf(
    "\nThe paper: the median lies within 5 %% of the mean's place, so that heaps of 10 %% "
    "find it in one pass. The mean's place along the longest axis (the median's is 50 %%), "
    "and the passes, the most at each depth out of core, at heap sizes:\n%-12s %9s | %14s | "
    "%12s %12s %12s\n",
    "points", "vertices", "mean at, claim", "1 %", "5 %", "10 %");
  ForEachInput(settings, [&](const NamedPoints& named) { PrintHeaps(named, settings); });

  std::printf(
    "\nIn memory: the tree to depth L beside std::nth_element alone, seconds, the least of "
    "three:\n%-12s %9s %3s %8s | %7s %7s |\n",
    "points", "vertices", "L", "threads", "bare", "ours");
  ForEachInput(settings, [](const NamedPoints& named) { PrintInMemory(named); });
}

}

int main(int argc, char** argv)
{
  const Settings settings = Parse(argc, argv);
  try
  {
    Run(settings);
  }
  catch (const std::runtime_error& error)
  {
    std::cerr << "BenchTable3: error: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
