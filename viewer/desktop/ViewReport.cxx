// SPDX-License-Identifier: BSD-3-Clause
// What a whole view took: see ViewReport.h.
#include "viewer/desktop/ViewReport.h"

#include "filters/model/JsonWriter.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace kdstream
{
namespace
{

// The peak resident memory of this process so far, bytes.
std::uint64_t PeakMemory()
{
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}

std::uint64_t ResidentMemory()
{
  std::uint64_t all = 0;
  std::uint64_t resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

ViewReport::ViewReport()
  : Begin(std::chrono::steady_clock::now())
{
}

double ViewReport::Now() const
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - this->Begin).count();
}

void ViewReport::AddFrame(const ViewerStatus& status, const ViewerScene& scene)
{
  const bool isAsBefore = scene.surfaceVersion == this->Surface && scene.tiles == this->Tiles;
  if (isAsBefore || (this->First < 0 && status.vertices == 0))
  {
    return;
  }
  this->Surface = scene.surfaceVersion;
  this->Tiles = scene.tiles;
  this->PeakTriangles = std::max(this->PeakTriangles, status.triangles);
  this->Settled = this->Now();
  this->First = this->First < 0 ? this->Settled : this->First;
}

std::string ViewReport::Json(const SessionTraffic& traffic, const std::string& link) const
{
  JsonWriter json;
  const auto seconds = [&json](const char* key, double value)
  { value < 0 ? json.Key(key).PutJson("null") : json.Member(key, value); };
  json.BeginObject()
    .Member("bytes", traffic.bytes)
    .Member("blobs", traffic.blobs)
    .Member("bytes_wasted", traffic.wasted);
  seconds("seconds_to_first", this->First);
  seconds("seconds_to_settled", this->Settled);
  json.Member("peak_triangles", this->PeakTriangles)
    .Member("peak_rss_bytes", PeakMemory())
    .Member("link", link)
    .EndObject();
  return json.Text() + "\n";
}

}
