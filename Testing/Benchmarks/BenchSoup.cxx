// SPDX-License-Identifier: BSD-3-Clause
// The time of kdstream-build for a soup, compared with scans of the same size, all in one run.
// Unordered triangles are the worst input that it must be able to finish. Usage:
//   BenchSoup PROGRAMS OUTPUT_FOLDER [TRIANGLES [ROUNDS]]
// PROGRAMS: the folder of kdstream-build and kdstream-generate. Makes a soup of TRIANGLES
// (3,000,000) and two scans in the output folder, and removes them at the end. One scan has the
// same number of triangles, the other the same number of vertices (a soup has three times as many
// vertices as triangles). Every build is out of core and runs ROUNDS (4) times; the shortest time
// counts.
#include "Testing/Benchmarks/MeasuredRun.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/meshio/MeshWriter.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>

namespace
{

using namespace kdstream::benchmarks;
using std::filesystem::path;

constexpr double mostOfScan = 3; // times the scan with as many vertices
constexpr const char* limit = "64M";
constexpr double mostMebibytes = 64 + 64;

struct Input
{
  const char* name;
  path mesh;
  Cost least;
};

std::array<Input, 3> MakeMeshes(const path& programs, const path& folder, unsigned triangles)
{
  std::array<Input, 3> inputs{ { { "soup", folder / "soup.ply", {} },
    { "scan, as many vertices", folder / "scan-vertices.ply", {} },
    { "scan, as many triangles", folder / "scan-triangles.ply", {} } } };
  if (const kdstream::Status written =
        kdstream::WriteMesh(inputs[0].mesh, kdstream::fixtures::Soup(triangles, 1));
      !written)
  {
    std::cerr << "BenchSoup: error: " << written.GetError().message << "\n";
    std::exit(1);
  }
  const unsigned vertices[] = { 3 * triangles, triangles / 2 };
  for (std::size_t i = 0; i < 2; ++i)
  {
    RunMeasured({ programs / "kdstream-generate", "relief", inputs[i + 1].mesh, "--vertices",
                  std::to_string(vertices[i]), "--quiet" },
      "/dev/null");
  }
  return inputs;
}

void Build(const path& programs, const path& folder, Input& input)
{
  const path store = folder / "soup.kds", stats = folder / "soup.json";
  Cost cost = RunMeasured({ programs / "kdstream-build", input.mesh, "-o", store, "--memory", limit,
                            "--stats", stats, "--quiet" },
    "/dev/null");
  std::filesystem::remove(store);
  std::filesystem::remove(stats);
  if (input.least.seconds == 0 || cost.seconds < input.least.seconds)
  {
    input.least = std::move(cost);
  }
}

void Print(const std::array<Input, 3>& inputs)
{
  const Cost& soup = inputs[0].least;
  std::printf("kdstream-build --memory %s\n%-26s %9s %9s %10s %12s %12s\n", limit, "", "s", "CPU s",
    "MiB peak", "soup / it", "CPU, soup/it");
  for (const Input& input : inputs)
  {
    const Cost& cost = input.least;
    std::printf("%-26s %9.2f %9.2f %10.0f %12.2f %12.2f\n", input.name, cost.seconds,
      cost.processor, cost.mebibytes, soup.seconds / cost.seconds, soup.processor / cost.processor);
  }
  const double ratio = soup.seconds / inputs[1].least.seconds;
  std::printf("soup over the scan with as many vertices: %.2f (wanted: at most %.0f)%s\n", ratio,
    mostOfScan, ratio <= mostOfScan ? "" : "  MISSED");
  std::printf("MiB of the soup: %.0f (wanted: at most %.0f)%s\n", soup.mebibytes, mostMebibytes,
    soup.mebibytes <= mostMebibytes ? "" : "  MISSED");
}

}

int main(int argc, char** argv)
{
  if (argc < 3)
  {
    std::cerr << "BenchSoup PROGRAMS OUTPUT_FOLDER [TRIANGLES [ROUNDS]]\n";
    return 2;
  }
  const path programs = argv[1], folder = argv[2];
  const auto triangles = static_cast<unsigned>(argc > 3 ? std::atoi(argv[3]) : 3000000);
  const int rounds = argc > 4 ? std::atoi(argv[4]) : 4;
  std::filesystem::create_directories(folder);
  std::array<Input, 3> inputs = MakeMeshes(programs, folder, triangles);
  for (int round = 0; round < rounds; ++round)
  {
    for (Input& input : inputs)
    {
      Build(programs, folder, input);
    }
  }
  Print(inputs);
  for (const Input& input : inputs)
  {
    std::filesystem::remove(input.mesh);
  }
  return 0;
}
