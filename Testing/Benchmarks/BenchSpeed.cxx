// SPDX-License-Identifier: BSD-3-Clause
// Time and memory of kdstream-build, compared with a lower bound (BenchFloor). The same mesh is
// built with ordered and with shuffled triangles, one after the other in one run. Usage:
//   BenchSpeed PROGRAMS OUTPUT_FOLDER [VERTICES [ROUNDS]]
// PROGRAMS: the folder of kdstream-build, kdstream-generate and BenchFloor. Makes relief.ply and
// relief-shuffled.ply of VERTICES (14,030,000) in the output folder, and removes them at the end.
// Everything runs ROUNDS (3) times in turn; the shortest time of each counts. Memory is each
// process's peak according to the kernel. Prints the table and writes speed.csv.
#include "Testing/Benchmarks/MeasuredRun.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

namespace
{

using namespace kdstream::benchmarks;
using std::filesystem::path;

// The limits of this project: in core and out of core, at most this multiple of the floor;
// shuffled, at most this multiple of the ordered mesh. Out of core, not much more memory than the
// memory limit.
constexpr double mostOfFloor = 5, mostOfFloorExternally = 8, mostOfCoherent = 2;
constexpr const char* limit = "256M";
constexpr double mostMebibytes = 256 + 64;

class Bench
{
public:
  Bench(path folderOfPrograms, path folder, std::string count, int repeats)
    : Programs(std::move(folderOfPrograms))
    , Folder(std::move(folder))
    , Vertices(std::move(count))
    , Rounds(repeats)
  {
    std::filesystem::create_directories(this->Folder);
  }

  void Run()
  {
    this->Generate();
    for (int round = 0; round < this->Rounds; ++round)
    {
      for (std::size_t order = 0; order < 2; ++order)
      {
        this->Keep(0, order, this->Floor(this->Meshes[order]));
        this->Keep(1, order, this->Build(this->Meshes[order], { "--threads", "1" }));
        this->Keep(2, order, this->Build(this->Meshes[order], {}));
        this->Keep(3, order, this->Build(this->Meshes[order], { "--memory", limit }));
      }
    }
    this->Print();
    this->WriteTable();
    for (const path& mesh : this->Meshes)
    {
      std::filesystem::remove(mesh);
    }
  }

private:
  static constexpr std::array<const char*, 4> names{ "floor, 1 thread",
    "kdstream-build --threads 1", "kdstream-build", "kdstream-build --memory 256M" };
  static constexpr std::array<const char*, 2> orders{ "coherent", "shuffled" };

  void Generate()
  {
    this->Meshes = { this->Folder / "relief.ply", this->Folder / "relief-shuffled.ply" };
    for (std::size_t order = 0; order < 2; ++order)
    {
      std::vector<std::string> command{ this->Programs / "kdstream-generate", "relief",
        this->Meshes[order], "--vertices", this->Vertices, "--quiet" };
      if (order == 1)
      {
        command.emplace_back("--shuffled");
      }
      const Cost cost = RunMeasured(command, "/dev/null");
      std::printf("generated, %s: %.1f s, %.0f MB\n", orders[order], cost.seconds,
        static_cast<double>(std::filesystem::file_size(this->Meshes[order])) / 1e6);
    }
  }

  Cost Floor(const path& mesh) const
  {
    const path output = this->Folder / "floor.out", steps = this->Folder / "floor.json";
    Cost cost = RunMeasured({ this->Programs / "BenchFloor", mesh, output }, steps);
    cost.steps = Json::parse(std::ifstream(steps));
    std::filesystem::remove(output);
    std::filesystem::remove(steps);
    return cost;
  }

  Cost Build(const path& mesh, const std::vector<std::string>& options) const
  {
    const path store = this->Folder / "relief.kds", stats = this->Folder / "stats.json";
    std::vector<std::string> command{ this->Programs / "kdstream-build", mesh, "-o", store,
      "--stats", stats, "--quiet" };
    command.insert(command.end(), options.begin(), options.end());
    Cost cost = RunMeasured(command, "/dev/null");
    cost.steps = Json::parse(std::ifstream(stats)).at("seconds");
    std::filesystem::remove(store);
    std::filesystem::remove(stats);
    return cost;
  }

  void Keep(std::size_t what, std::size_t order, const Cost& cost)
  {
    Cost& least = this->Costs[what][order];
    if (least.seconds == 0 || cost.seconds < least.seconds)
    {
      least = cost;
    }
  }

  double OfFloor(std::size_t what, std::size_t order) const
  {
    return this->Costs[what][order].seconds / this->Costs[0][order].seconds;
  }

  double OfCoherent(std::size_t what) const
  {
    return this->Costs[what][1].seconds / this->Costs[what][0].seconds;
  }

  void Print() const
  {
    std::printf("\n%-28s %-9s %9s %9s %10s %10s %12s %11s\n", "", "order", "s", "CPU s", "MiB peak",
      "x floor", "CPU x floor", "x coherent");
    for (std::size_t what = 0; what < names.size(); ++what)
    {
      for (std::size_t order = 0; order < orders.size(); ++order)
      {
        const Cost& cost = this->Costs[what][order];
        std::printf("%-28s %-9s %9.2f %9.2f %10.0f %10.2f %12.2f %11.2f\n", names[what],
          orders[order], cost.seconds, cost.processor, cost.mebibytes, this->OfFloor(what, order),
          cost.processor / this->Costs[0][order].processor,
          order == 0 ? 1.0 : this->OfCoherent(what));
      }
    }
    std::printf("\nSeconds of each step:\n");
    for (std::size_t what = 0; what < names.size(); ++what)
    {
      for (std::size_t order = 0; order < orders.size(); ++order)
      {
        std::printf("%-28s %-9s", names[what], orders[order]);
        for (const auto& [step, seconds] : this->Costs[what][order].steps.items())
        {
          std::printf("  %s %.2f", step.c_str(), seconds.get<double>());
        }
        std::printf("\n");
      }
    }
    Compare("in core over the floor", this->OfFloor(2, 0), mostOfFloor);
    Compare("out of core over the floor", this->OfFloor(3, 0), mostOfFloorExternally);
    Compare("shuffled over coherent, in core", this->OfCoherent(2), mostOfCoherent);
    Compare("shuffled over coherent, out of core", this->OfCoherent(3), mostOfCoherent);
    Compare("MiB out of core", std::max(this->Costs[3][0].mebibytes, this->Costs[3][1].mebibytes),
      mostMebibytes);
  }

  static void Compare(const char* what, double value, double most)
  {
    std::printf(
      "%s: %.2f (wanted: at most %.0f)%s\n", what, value, most, value <= most ? "" : "  MISSED");
  }

  void WriteTable() const
  {
    std::ofstream table(this->Folder / "speed.csv");
    table << "what,order,seconds,processor_seconds,peak_mebibytes,of_floor\n";
    for (std::size_t what = 0; what < names.size(); ++what)
    {
      for (std::size_t order = 0; order < orders.size(); ++order)
      {
        const Cost& cost = this->Costs[what][order];
        table << '"' << names[what] << "\"," << orders[order] << ',' << cost.seconds << ','
              << cost.processor << ',' << cost.mebibytes << ',' << this->OfFloor(what, order)
              << '\n';
      }
    }
  }

  path Programs, Folder;
  std::string Vertices;
  int Rounds;
  std::array<path, 2> Meshes;
  std::array<std::array<Cost, 2>, 4> Costs;
};

}

int main(int argc, char** argv)
{
  if (argc < 3)
  {
    std::cerr << "BenchSpeed PROGRAMS OUTPUT_FOLDER [VERTICES [ROUNDS]]\n";
    return 2;
  }
  Bench(argv[1], argv[2], argc > 3 ? argv[3] : "14030000", argc > 4 ? std::atoi(argv[4]) : 3).Run();
  return 0;
}
