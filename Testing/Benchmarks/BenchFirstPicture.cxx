// SPDX-License-Identifier: BSD-3-Clause
// The first picture of a large model: kdstream-view with its store, compared with F3D with the
// mesh, both as new processes that write a PNG.
//
//   BenchFirstPicture PROGRAMS STORE.kds MESH.ply OUT [ROUNDS]
//
// Without F3D (f3d in the PATH, and a display, as from xvfb-run) only kdstream-view is measured.
// The programs take turns, ROUNDS (3) times; the shortest time of each counts. Limits: the preview
// in at most 1 s and 200 MB. Exit code 1 if one is missed.
#include "Testing/Benchmarks/MeasuredRun.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

namespace
{

using namespace kdstream::benchmarks;
using std::filesystem::path;

constexpr double mostSeconds = 1, mostMegabytes = 200;
constexpr double megabyte = 1e6, mebibyte = 1 << 20;

class Bench
{
public:
  Bench(const path& folderOfPrograms, path storeFile, path meshFile, path folder)
    : View(folderOfPrograms / "kdstream-view")
    , Store(std::move(storeFile))
    , Mesh(std::move(meshFile))
    , Folder(std::move(folder))
  {
    std::filesystem::create_directories(this->Folder);
  }

  // Returns the exit code.
  int Run(int rounds)
  {
    const bool peer = std::filesystem::exists("/usr/bin/f3d") && std::getenv("DISPLAY") != nullptr;
    for (int round = 0; round < rounds; ++round)
    {
      Keep(this->Preview, this->Picture(false));
      Keep(this->Settled, this->Picture(true));
      if (peer)
      {
        Keep(this->Theirs,
          RunMeasured({ "/usr/bin/f3d", "--resolution=800,480",
                        "--output=" + (this->Folder / "first-f3d.png").string(), this->Mesh },
            "/dev/null"));
      }
    }
    std::printf("%-44s %8s %8s %8s\n", "800 x 480, a new process each time", "s", "CPU s", "MB");
    Print("kdstream-view, the preview", this->Preview);
    Print("kdstream-view, as fine as the screen shows", this->Settled);
    if (!peer)
    {
      std::printf("F3D: not measured, /usr/bin/f3d or a display is missing\n");
    }
    else
    {
      Print("f3d, the whole mesh", this->Theirs);
      std::printf("ours over F3D's: %.3f of the seconds, %.3f of the memory\n",
        this->Preview.seconds / this->Theirs.seconds,
        this->Preview.mebibytes / this->Theirs.mebibytes);
    }
    const double megabytes = this->Preview.mebibytes * mebibyte / megabyte;
    const bool met = this->Preview.seconds <= mostSeconds && megabytes <= mostMegabytes;
    std::printf("the preview: %.2f s (bar %.0f), %.0f MB (bar %.0f): %s\n", this->Preview.seconds,
      mostSeconds, megabytes, mostMegabytes, met ? "met" : "MISSED");
    return met ? 0 : 1;
  }

private:
  // The cost of the preview, or (settled) of the picture after everything has arrived.
  Cost Picture(bool settled) const
  {
    const path session = this->Folder / "first.jsonl";
    const std::string select = "{\"select\":\"" + this->Store.stem().string() + "\"}\n";
    const std::string idle = "{\"wait\":\"idle\"}\n";
    const path picture = this->Folder / (settled ? "first-settled.png" : "first-preview.png");
    std::ofstream(session) << select << idle << (settled ? select + idle : std::string());
    return RunMeasured({ this->View, this->Store, "--offscreen", "auto", "--size", "800x480",
                         "--replay", session, "--screenshot", picture },
      "/dev/null");
  }

  static void Keep(Cost& least, const Cost& cost)
  {
    if (least.seconds == 0 || cost.seconds < least.seconds)
    {
      least = cost;
    }
  }

  static void Print(const char* what, const Cost& cost)
  {
    std::printf("%-44s %8.2f %8.2f %8.0f\n", what, cost.seconds, cost.processor,
      cost.mebibytes * mebibyte / megabyte);
  }

  path View, Store, Mesh, Folder;
  Cost Preview, Settled, Theirs;
};

}

int main(int argc, char** argv)
{
  if (argc < 5)
  {
    std::fprintf(stderr, "usage: BenchFirstPicture PROGRAMS STORE.kds MESH.ply OUT [ROUNDS]\n");
    return 2;
  }
  return Bench(argv[1], argv[2], argv[3], argv[4]).Run(argc > 5 ? std::atoi(argv[5]) : 3);
}
