// SPDX-License-Identifier: BSD-3-Clause
// Writes the tape for BenchArrival, and measures VTK's time for one arrival, compared with drawing
// everything again.
//
//   TapeArrivals FOLDER MODEL ZOOM TAPE      exit code 1 if the limit is missed
#include "Testing/Benchmarks/Arrivals.h"
#include "server/session/StoreCatalog.h"
#include "viewer/rendering/SurfaceScene.h"

#include <cstdlib>
#include <numeric>
#include <optional>

using namespace kdstream;
using namespace kdstream::bench;

namespace
{

struct VtkTimes
{
  SurfaceScene scene;
  std::uint64_t version = 0;
  double arrival = 0, anew = 0;
  int count = 0;

  void Draw(const ViewerScene& shown)
  {
    if (std::exchange(this->version, shown.surfaceVersion) == shown.surfaceVersion)
    {
      return;
    }
    const Vec3 center = shown.box.lo * 0.5 + shown.box.hi * 0.5;
    const double kept = SecondsOf(
      [&] { static_cast<void>(this->scene.Update(*shown.surface, shown.depths, center)); });
    if (shown.surface->TriangleCount() < 250'000)
    {
      return;
    }
    SurfaceScene fresh;
    this->arrival += kept;
    this->anew +=
      SecondsOf([&] { static_cast<void>(fresh.Update(*shown.surface, shown.depths, center)); });
    ++this->count;
  }
};

}

int main(int count, char** arguments)
{
  if (count != 5)
  {
    std::fprintf(stderr, "usage: TapeArrivals FOLDER MODEL ZOOM TAPE\n");
    return 2;
  }
  StoreCatalog stores(arguments[1], [](const std::filesystem::path& file, const std::string& wrong)
    { std::fprintf(stderr, "%s: %s\n", file.c_str(), wrong.c_str()); });
  static_cast<void>(stores.Reload());
  const auto served = stores.Find(arguments[2]);
  if (!served)
  {
    std::fprintf(stderr, "TapeArrivals: %s has no model %s\n", arguments[1], arguments[2]);
    return 2;
  }
  Tape tape;
  tape.zoom = std::atof(arguments[3]);
  tape.model = WriteModel(served->Description());
  VtkTimes vtk;
  Arrivals{
    served->Description(), tape.zoom,
    [&](const protocol::BlobId& blob)
    {
      const auto bytes = served->ReadBlob(blob);
      return bytes ? **bytes : Bytes();
    },
    [&](const protocol::BlobId& blob, const Bytes& bytes)
    { tape.blobs[protocol::BlobName(blob)] = bytes; },
    [&](ViewerSession& session)
    {
      session.BeginFrame();
      vtk.Draw(session.Scene());
    }
  }.Run();
  const double ratio = vtk.arrival / vtk.anew;
  std::printf("%-28s %4d arrivals: %6.2f ms each, all anew %6.2f ms: %5.3f (at most 0.1: %s)\n",
    "VTK's scene", vtk.count, 1e3 * vtk.arrival / vtk.count, 1e3 * vtk.anew / vtk.count, ratio,
    ratio <= 0.1 ? "met" : "MISSED");
  if (!tape.Write(arguments[4]))
  {
    std::fprintf(stderr, "TapeArrivals: %s cannot be written\n", arguments[4]);
    return 2;
  }
  return ratio <= 0.1 ? 0 : 1;
}
