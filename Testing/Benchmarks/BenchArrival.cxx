// SPDX-License-Identifier: BSD-3-Clause
// What an arriving piece costs, beside drawing all anew.
//
//   BenchArrival FOLDER MODEL ZOOM
#include "Testing/Benchmarks/SimulatedLine.h"
#include "server/session/StoreCatalog.h"
#include "viewer/mobile/SurfaceChunks.h"
#include "viewer/rendering/SurfaceScene.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

using namespace kdstream;
using kdstream::bench::SimulatedLine;

namespace
{
double Now()
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
double Median(std::vector<double> v)
{
  std::sort(v.begin(), v.end());
  return v.empty() ? 0 : v[v.size() / 2];
}
}

int main(int, char** a)
{
  StoreCatalog stores(a[1], [](const std::filesystem::path&, const std::string&) {});
  if (!stores.Reload())
    return 2;
  const auto models = stores.Models();
  const auto model = *std::find_if(
    models.begin(), models.end(), [&](auto& m) { return m->Description().id == a[2]; });
  SessionOptions o;
  o.refinement.triangles = 300000;
  o.mostStatistics = 0;
  ViewerSession s(o);
  SimulatedLine line(*model, 1e6, 0.03);
  s.Resize({ 1600, 960, 1 });
  static_cast<void>(s.SelectModel(a[2]));
  while (line.Next(s))
    s.BeginFrame();
  s.EnterFullScreen();
  s.Zoom(atof(a[3]), 800, 480);
  std::vector<double> arrive, frame, cut, scene;
  SurfaceScene vtk; std::vector<DrawnSurface::Part> old;
  std::uint64_t version = 0;
  do
  {
    double t = Now();
    s.BeginFrame();
    double f = Now() - t;
    const ViewerScene v = s.Scene();
    if (v.surfaceVersion != version && v.surface->TriangleCount() > 150000)
    {
      version = v.surfaceVersion;
      frame.push_back(f);
      t = Now();
      static_cast<void>(vtk.Update(*v.surface, v.depths, v.box.lo * .5 + v.box.hi * .5));
      scene.push_back(Now() - t);
      int same = 0;
      for (auto& p : v.surface->Parts()) for (auto& q : old) same += q == p;
      old = v.surface->Parts();
      std::printf("%zu parts, %zu differ; frame %.2f scene %.2f\n", old.size(), old.size() - same, 1e3 * frame.back(), 1e3 * scene.back());
    }
    t = Now();
    if (!line.Next(s))
      break;
    arrive.push_back(Now() - t);
  } while (true);
  std::printf(
    "%zu frames, %llu triangles, %zu pieces: arrive %.1f frame %.1f chunks %.1f vtk %.1f ms\n",
    frame.size(), (unsigned long long)s.GetStatus().triangles, s.ShownPieces().size(),
    1e3 * Median(arrive), 1e3 * Median(frame), 1e3 * Median(cut), 1e3 * Median(scene));
}
