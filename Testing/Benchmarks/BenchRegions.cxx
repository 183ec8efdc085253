// SPDX-License-Identifier: BSD-3-Clause
// Figs. 10, 11 and 19 of the paper: the partitions of a region by k-d tree and by octree, their
// bytes, and the time until they arrive. Also compares partitions of 2,000 and of 4,000 vertices.
//
//   BenchRegions PROGRAMS STORES OUT MODEL...
//
// STORES has three stores of each model: MODEL-kd2000.kds, MODEL-kd4000.kds and MODEL-octree.kds
// (cells of at most 2,000 vertices). Serves them by kdstream-serve and taps 20 places all over the
// model. The region of a tap is the paper's (section 5.4): the box of the k-d cell there, with its
// sides moved outward by their average length. Each store sends the partitions that touch this box,
// over loopback and over 20 Mbit/s with 30 ms; in one request, as viewers do, and one after the
// other, as the paper's client did. Prints means over the taps, and writes regions.tsv and
// fig10-MODEL.png.
#include "Testing/Benchmarks/ErrorChart.h"
#include "Testing/Benchmarks/Serving/ServerProcess.h"
#include "Testing/Benchmarks/ShapedProxy.h"
#include "filters/codec/PieceCodec.h"
#include "server/session/StoreCatalog.h"
#include "viewer/client/ServerClient.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

namespace
{

using namespace kdstream;
using namespace kdstream::benchmarks;
using std::filesystem::path;

constexpr std::uint32_t taps = 20;

[[noreturn]] void Fail(const std::string& what)
{
  std::fprintf(stderr, "BenchRegions: error: %s\n", what.c_str());
  std::exit(1);
}

template <class T>
T Take(Result<T> result)
{
  if (!result)
  {
    Fail(result.GetError().message);
  }
  return std::move(*result);
}

// A store that is read directly.
struct Store
{
  std::shared_ptr<const ServedModel> model;
  std::span<const Box> boxes;

  const std::string& Id() const { return this->model->Description().id; }
  const Box& BoxOf(std::uint32_t partition) const
  {
    return this->boxes[NodeOfPartition(partition, this->model->Description().depths)];
  }
  std::uint32_t Partitions() const
  {
    return static_cast<std::uint32_t>(this->model->Description().partitions);
  }
  Piece Read(std::uint32_t partition) const
  {
    const ModelDescription& description = this->model->Description();
    const auto bytes = Take(this->model->ReadBlob(protocol::BlobId::Partition(partition)));
    return Take(DecodePiece(*bytes,
      { Resolution::Original(), NodeOfPartition(partition, description.depths) },
      description.Codec()));
  }
};

Store Open(const StoreCatalog& catalog, const std::string& id)
{
  const auto model = catalog.Find(id);
  if (!model)
  {
    Fail(id + ".kds is not there");
  }
  return { model, Take(model->Boxes()) };
}

// ---- regions

double SquaredDistance(const Box& box, const Vec3& point)
{
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double beside = std::max({ box.lo[k] - point[k], 0.0, point[k] - box.hi[k] });
    sum += beside * beside;
  }
  return sum;
}

Vec3 CentreOf(const Box& box)
{
  Vec3 centre{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    centre[k] = (box.lo[k] + box.hi[k]) / 2;
  }
  return centre;
}

Box RegionAround(const Box& cell)
{
  double sides = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    sides += cell.hi[k] - cell.lo[k];
  }
  Box region = cell;
  for (std::size_t k = 0; k < 3; ++k)
  {
    region.lo[k] -= sides / 3;
    region.hi[k] += sides / 3;
  }
  return region;
}

bool Touch(const Box& a, const Box& b)
{
  bool touch = !a.Empty() && !b.Empty();
  for (std::size_t k = 0; k < 3; ++k)
  {
    touch = touch && a.lo[k] <= b.hi[k] && b.lo[k] <= a.hi[k];
  }
  return touch;
}

std::vector<std::uint32_t> PartitionsIn(const Store& store, const Box& region)
{
  std::vector<std::uint32_t> partitions;
  for (std::uint32_t p = 0; p < store.Partitions(); ++p)
  {
    if (Touch(store.BoxOf(p), region))
    {
      partitions.push_back(p);
    }
  }
  return partitions;
}

// ---- the cost of a region

struct Fetched
{
  double seconds = 0; // until the last one
  std::vector<double> bytes;
};

// Gets the partitions in one request. The model is already open.
double Fetch(
  ModelSource& source, std::uint32_t id, const std::vector<std::uint32_t>& partitions, Fetched& sum)
{
  SessionRequest request;
  request.kind = SessionRequest::Kind::Blobs;
  request.id = id;
  for (const std::uint32_t p : partitions)
  {
    request.blobs.push_back(protocol::BlobId::Partition(p));
  }
  source.Send(request);
  double seconds = 0;
  for (std::size_t missing = partitions.size(); missing > 0;)
  {
    source.Wait(std::chrono::seconds(1));
    for (const ClientEvent& event : source.Take())
    {
      if (event.kind != ClientEvent::Kind::Blob)
      {
        Fail("a partition did not come: " + event.message);
      }
      sum.bytes.push_back(static_cast<double>(event.bytes.size()));
      seconds += event.transmissionSeconds;
      --missing;
    }
  }
  return seconds;
}

class Line
{
public:
  Line(const std::string& url, const std::string& model)
    : Source(Take(ServerClient::Connect(url)))
  {
    SessionRequest open;
    open.id = ++this->Requests;
    open.model = model;
    this->Source->Send(open);
    while (this->Source->Take().empty())
    {
      this->Source->Wait(std::chrono::seconds(1));
    }
  }

  // together: all in one request; else each one is requested when the previous one has arrived.
  Fetched Get(const std::vector<std::uint32_t>& partitions, bool together)
  {
    Fetched fetched;
    if (together)
    {
      fetched.seconds = Fetch(*this->Source, ++this->Requests, partitions, fetched);
      return fetched;
    }
    for (const std::uint32_t partition : partitions)
    {
      fetched.seconds += Fetch(*this->Source, ++this->Requests, { partition }, fetched);
    }
    return fetched;
  }

private:
  std::unique_ptr<ServerClient> Source;
  std::uint32_t Requests = 0;
};

// Sums over the taps; they become means when they are printed.
struct Sums
{
  double partitions = 0, vertices = 0, bytes = 0, least = 0, most = 0;
  double together = 0, apart = 0;             // s, over loopback
  double togetherSlowly = 0, apartSlowly = 0; // s, over the slow line
};

// ---- the benchmark

class Bench
{
public:
  Bench(const path& programs, const path& stores, path folder)
    : Folder(std::move(folder))
    , Server({ programs / "kdstream-serve", stores, "--port", "0" }, this->Folder / "serve.log")
    , Port(this->Server.ReadPort())
    , Short(this->Port, {})
    , Long(this->Port, { 20e6 / 8, 0.03 })
    , Catalog(stores, [](const path& file, const std::string& wrong)
        { std::fprintf(stderr, "%s: %s\n", file.c_str(), wrong.c_str()); })
    , Table(this->Folder / "regions.tsv")
  {
    if (const Status status = this->Catalog.Reload(); !status)
    {
      Fail(status.GetError().message);
    }
    this->Table << "store\ttap\tpartition\tbytes\n";
  }

  void Run(const std::string& name)
  {
    const Store tree = Open(this->Catalog, name + "-kd2000"),
                coarse = Open(this->Catalog, name + "-kd4000"),
                octree = Open(this->Catalog, name + "-octree");
    std::vector<Box> regions;
    for (std::uint32_t tap = 0; tap < taps; ++tap)
    {
      regions.push_back(RegionAround(tree.BoxOf(PartitionOfTap(tree, tap))));
    }
    std::printf(
      "\n%s: one region's partitions, means of %u taps (Figs. 10 and 11)\n", name.c_str(), taps);
    std::printf("%-8s %10s %9s %7s %15s | %19s | %19s\n", "", "partitions", "vertices", "kB",
      "least, most kB", "loopback: s, apart", "20 Mbit/s: s, apart");
    const Sums ours = this->Regions("k-d", tree, regions);
    const Sums theirs = this->Regions("octree", octree, regions);
    std::printf("%-8s %10.2f %9.2f %7.2f %15s | %9.2f %9.2f | %9.2f %9.2f\n", "ratio",
      theirs.partitions / ours.partitions, theirs.vertices / ours.vertices,
      theirs.bytes / ours.bytes, "", theirs.together / ours.together, theirs.apart / ours.apart,
      theirs.togetherSlowly / ours.togetherSlowly, theirs.apartSlowly / ours.apartSlowly);
    std::printf("the paper: 13 k-d partitions of 16,600 vertices 0.6 s, 27 octree partitions of "
                "15,295 vertices 0.8 s; ratio 2.08, 0.92, time 1.33\n");
    this->Draw(name);

    std::printf("\n%s: partitions of 2,000 and of 4,000 vertices, the nearest ones until there are "
                "20,000 (Fig. 19)\n",
      name.c_str());
    std::printf(
      "%-8s %10s %9s %7s %22s\n", "", "partitions", "vertices", "kB", "whole within, % of box");
    this->Density("2,000", tree, tree);
    this->Density("4,000", coarse, tree);
    std::printf("the paper: 11 of 2,000, and 6 of 4,000, of about 20,000 vertices\n");
  }

private:
  static std::uint32_t PartitionOfTap(const Store& tree, std::uint32_t tap)
  {
    return static_cast<std::uint32_t>(
      (std::uint64_t{ tap } * 2 + 1) * tree.Partitions() / (2 * taps));
  }

  Sums Regions(const char* what, const Store& store, const std::vector<Box>& regions)
  {
    const auto url = [](const ShapedProxy& proxy)
    { return "http://127.0.0.1:" + std::to_string(proxy.Port()); };
    Line quick(url(this->Short), store.Id()), slow(url(this->Long), store.Id());
    Sums sums;
    bench::ErrorCurve curve{ what, {}, {} };
    for (std::size_t tap = 0; tap < regions.size(); ++tap)
    {
      const auto partitions = PartitionsIn(store, regions[tap]);
      quick.Get(partitions, true); // so the server has read them before any line is measured
      const Fetched fetched = quick.Get(partitions, true);
      sums.together += fetched.seconds / taps;
      sums.apart += quick.Get(partitions, false).seconds / taps;
      sums.togetherSlowly += slow.Get(partitions, true).seconds / taps;
      sums.apartSlowly += slow.Get(partitions, false).seconds / taps;
      this->Count(store, tap, partitions, fetched, sums);
      if (tap == 0)
      {
        for (const double bytes : fetched.bytes)
        {
          curve.costs.push_back(static_cast<double>(curve.costs.size() + 1));
          curve.errors.push_back(bytes / 1e3);
        }
      }
    }
    this->Curves.push_back(std::move(curve));
    std::printf("%-8s %10.1f %9.0f %7.1f %7.2f %7.2f | %9.4f %9.4f | %9.4f %9.4f\n", what,
      sums.partitions, sums.vertices, sums.bytes / 1e3, sums.least / 1e3, sums.most / 1e3,
      sums.together, sums.apart, sums.togetherSlowly, sums.apartSlowly);
    return sums;
  }

  void Count(const Store& store, std::size_t tap, const std::vector<std::uint32_t>& partitions,
    const Fetched& fetched, Sums& sums)
  {
    sums.partitions += static_cast<double>(partitions.size()) / taps;
    for (std::size_t i = 0; i < partitions.size(); ++i)
    {
      sums.vertices += static_cast<double>(store.Read(partitions[i]).ownVertices) / taps;
      sums.bytes += fetched.bytes[i] / taps;
      this->Table << store.Id() << '\t' << tap << '\t' << partitions[i] << '\t' << fetched.bytes[i]
                  << '\n';
    }
    sums.least += *std::min_element(fetched.bytes.begin(), fetched.bytes.end()) / taps;
    sums.most += *std::max_element(fetched.bytes.begin(), fetched.bytes.end()) / taps;
  }

  void Draw(const std::string& name)
  {
    const bench::ErrorPanel panel{ name + ", one region (Fig. 10)", "partition", "kB",
      std::move(this->Curves) };
    this->Curves.clear();
    if (const Status drawn =
          bench::WriteErrorCharts({ { panel } }, this->Folder / ("fig10-" + name + ".png"));
        !drawn)
    {
      Fail(drawn.GetError().message);
    }
  }

  // How well the partitions surround the tapped point: the radius of the ball in which everything
  // has arrived, for the same number of vertices.
  static void Density(const char* what, const Store& store, const Store& tapped)
  {
    constexpr std::uint64_t wanted = 20'000;
    const Box& whole = store.model->Description().box;
    const double diagonal = 2 * std::sqrt(SquaredDistance({ whole.hi, whole.hi }, CentreOf(whole)));
    double partitions = 0, vertices = 0, bytes = 0, radius = 0;
    for (std::uint32_t tap = 0; tap < taps; ++tap)
    {
      const Piece cell = tapped.Read(PartitionOfTap(tapped, tap));
      const Vec3 point = cell.positions[cell.ownVertices / 2];
      std::vector<std::pair<double, std::uint32_t>> byDistance;
      for (std::uint32_t p = 0; p < store.Partitions(); ++p)
      {
        byDistance.emplace_back(SquaredDistance(store.BoxOf(p), point), p);
      }
      std::sort(byDistance.begin(), byDistance.end());
      std::uint64_t have = 0;
      auto next = byDistance.begin();
      for (; next != byDistance.end() && have < wanted; ++next)
      {
        have += store.Read(next->second).ownVertices;
        bytes += static_cast<double>(
                   Take(store.model->BlobSize(protocol::BlobId::Partition(next->second)))) /
                 taps;
        partitions += 1.0 / taps;
      }
      vertices += static_cast<double>(have) / taps;
      radius += NearestVertex(store, { next, byDistance.end() }, point) / taps;
    }
    std::printf("%-8s %10.1f %9.0f %7.1f %20.2f %%\n", what, partitions, vertices, bytes / 1e3,
      100 * radius / diagonal);
  }

  // The distance from `point` to the nearest vertex of these partitions, which are sorted by the
  // distance of their boxes.
  static double NearestVertex(const Store& store,
    const std::vector<std::pair<double, std::uint32_t>>& byDistance, const Vec3& point)
  {
    double nearest = std::numeric_limits<double>::infinity();
    for (auto next = byDistance.begin(); next != byDistance.end() && next->first < nearest; ++next)
    {
      const Piece piece = store.Read(next->second);
      for (std::uint32_t v = 0; v < piece.ownVertices; ++v)
      {
        nearest =
          std::min(nearest, SquaredDistance({ piece.positions[v], piece.positions[v] }, point));
      }
    }
    return std::sqrt(nearest);
  }

  path Folder;
  ServerProcess Server;
  std::uint16_t Port;
  ShapedProxy Short, Long;
  StoreCatalog Catalog;
  std::ofstream Table;
  std::vector<bench::ErrorCurve> Curves; // of the current model
};

}

int main(int argc, char** argv)
{
  if (argc < 5)
  {
    std::fprintf(stderr, "usage: BenchRegions PROGRAMS STORES OUT MODEL...\n");
    return 2;
  }
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  std::filesystem::create_directories(argv[3]);
  Bench bench(argv[1], argv[2], argv[3]);
  for (int model = 4; model < argc; ++model)
  {
    bench.Run(argv[model]);
  }
  return 0;
}
