// SPDX-License-Identifier: BSD-3-Clause
// The cost of a picture: bytes and seconds until few enough pixels are wrong
// (doc/benchmarks.md#views).
//
//   BenchView FOLDER OUT [--directions I,J...] [MODEL...]
//
// Views the models of a folder of stores from 36 places (12 directions at zooms of 1, 4 and 16),
// over simulated lines of 1, 10 and 100 Mbit/s with a round trip of 30 ms. The comparison is with
// one level for the whole model, with an oracle that fetches exactly the pieces of the final cut,
// and with the whole file.
//
// A pixel is wrong if a channel differs by more than 8 of 255 from the picture of the original;
// only pixels of the object count. Pictures are drawn 4 x 4 times as fine (2 x 2, each of 4
// samples). Writes OUT/view-MODEL.tsv with every picture and view-MODEL.png; prints medians, and
// whether the limits are met. Exit code 1 if one is missed. The dragon's flank is compared with the
// bytes that Nexus's viewer fetched.
//
// Models of 10 million triangles and more come first: the cost of approaching them, and whether it
// grows with the model. Their pictures are only measured at 10 Mbit/s.
//
// --directions: only pictures, from these directions (0 to 11) and at 10 Mbit/s, without limits;
// for
// ./dev bench tiles, which compares them with those of other clients.
#include "Testing/Benchmarks/ErrorChart.h"
#include "Testing/Benchmarks/MeasuredViews.h"
#include "server/session/StoreCatalog.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numeric>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

using namespace kdstream;
using namespace kdstream::bench;

namespace
{

// For models with at least this number of triangles, the cost of a view is measured before their
// pictures.
constexpr std::uint64_t large = 10'000'000;

[[noreturn]] void Fail(const std::string& what)
{
  std::fprintf(stderr, "BenchView: %s\n", what.c_str());
  std::exit(2);
}

// The first sample from which on at most `share` of the pixels is wrong.
Sample Reached(const MeasuredView& measured, double share)
{
  Sample reached{ never, never, 0 };
  for (auto sample = measured.samples.rbegin();
       sample != measured.samples.rend() && sample->wrong <= share; ++sample)
  {
    reached = *sample;
  }
  return reached;
}

double Median(std::vector<double> values)
{
  std::sort(values.begin(), values.end());
  return values.empty() ? never : values[values.size() / 2];
}

std::string Text(double value, double unit)
{
  char text[32];
  std::snprintf(text, sizeof(text), "%.1f", value / unit);
  return value == never ? "not reached" : text;
}

// All views of one kind.
struct Column
{
  std::vector<std::vector<Sample>> samples;
  std::vector<double> t0, b0, b95, b99, t95, t99, settled, triangles, bytes, overOracle;

  void Add(const MeasuredView& measured)
  {
    this->samples.push_back(measured.samples);
    const Sample at95 = Reached(measured, 0.05), at99 = Reached(measured, 0.01);
    this->b0.push_back(measured.firstBytes);
    this->t0.push_back(measured.firstSeconds);
    this->b95.push_back(at95.bytes);
    this->b99.push_back(at99.bytes);
    this->t95.push_back(at95.seconds);
    this->t99.push_back(at99.seconds);
    this->settled.push_back(measured.samples.back().wrong);
    this->triangles.push_back(static_cast<double>(measured.triangles));
    this->bytes.push_back(measured.samples.back().bytes);
    this->overOracle.push_back(measured.samples.back().bytes / measured.oracleBytes);
  }

  void Print(const std::string& what) const
  {
    std::printf("%-22s %6s %6s | %8s %8s | %7s %7s | %7.2f %% %9.0f %8s %6.2f\n", what.c_str(),
      Text(Median(this->b0), 1e3).c_str(), Text(Median(this->t0), 1).c_str(),
      Text(Median(this->b95), 1e3).c_str(), Text(Median(this->b99), 1e3).c_str(),
      Text(Median(this->t95), 1).c_str(), Text(Median(this->t99), 1).c_str(),
      100 * Median(this->settled), Median(this->triangles), Text(Median(this->bytes), 1e3).c_str(),
      Median(this->overOracle));
  }
};

// The median share of wrong pixels over the views of a column, by bytes.
ErrorCurve CurveOf(const std::string& name, const Column& column)
{
  constexpr double step = 1.1;
  ErrorCurve curve{ name, {}, {} };
  for (double bytes = 5e3; bytes < step * Median(column.bytes); bytes *= step)
  {
    std::vector<double> wrong;
    for (const std::vector<Sample>& samples : column.samples)
    {
      const auto behind = std::partition_point(samples.begin(), samples.end(),
        [bytes](const Sample& sample) { return sample.bytes <= bytes; });
      wrong.push_back(behind == samples.begin() ? 1 : (behind - 1)->wrong);
    }
    curve.costs.push_back(bytes / 1e3);
    // Not 0, because the axis is logarithmic.
    curve.errors.push_back(std::max(100 * Median(wrong), 0.01));
  }
  return curve;
}

int misses = 0;

void Bar(const std::string& what, double value, double most)
{
  const bool met = value <= most;
  misses += met ? 0 : 1;
  std::printf("  %-66s %8.2f, bar %6.2f: %s\n", what.c_str(), value, most, met ? "met" : "MISSED");
}

void WriteSamples(std::ofstream& table, const View& view, const std::string& kind, double rate,
  const MeasuredView& measured)
{
  for (const Sample& sample : measured.samples)
  {
    table << view.direction << '\t' << view.zoom << '\t' << kind << '\t' << rate * 8e-6 << '\t'
          << sample.bytes << '\t' << sample.seconds << '\t' << sample.wrong << '\n';
  }
}

// The most that a picture may cost. column: at 10 Mbit/s.
void CheckLimits(const std::string& id, double zoom, const Column& view, const Column& byLevel)
{
  Bar(id + ", zoom " + Text(zoom, 1) + ": kB before the first picture", Median(view.b0) / 1e3,
    id == "dragon" ? 20 : 30);
  Bar(
    id + ", zoom " + Text(zoom, 1) + ": all bytes over the oracle's", Median(view.overOracle), 1.5);
  if (zoom >= 4)
  {
    Bar(id + ", zoom " + Text(zoom, 1) + ": wrong pixels over those of one level",
      (Median(view.settled) + 1e-6) / (Median(byLevel.settled) + 1e-6), 1);
    Bar(id + ", zoom " + Text(zoom, 1) + ": bytes over those of one level",
      Median(view.bytes) / Median(byLevel.bytes), 1.0 / 8);
  }
}

// Limits and curves are for all twelve directions.
void Bench(const ServedModel& model, const std::string& folder, const std::string& out,
  const std::vector<double>& rates, const std::vector<int>& directions)
{
  const bool all = directions.size() == 12;
  const std::string id = model.Description().id;
  std::ifstream file(folder + "/" + id + ".kds", std::ios::ate | std::ios::binary);
  std::printf(
    "\n%s: %llu triangles, the whole file %.0f kB. Medians of %zu directions at 800 x 480; kB "
    "and seconds until at most 5 %% and 1 %% are wrong\n",
    id.c_str(), static_cast<unsigned long long>(model.Description().triangles),
    static_cast<double>(file.tellg()) / 1e3, directions.size());
  std::printf("%-22s %6s %6s | %8s %8s | %7s %7s | %9s %9s %8s %6s\n", "", "B0", "T0", "B95", "B99",
    "T95", "T99", "settled", "triangles", "all kB", "oracle");
  std::ofstream table(out + "/view-" + id + ".tsv");
  table << "direction\tzoom\tdetail\tMbit/s\tbytes\tseconds\twrong\n";
  Painter painter;
  ReferencePictures references(model);
  std::vector<ErrorPanel> panels;
  for (const double zoom : { 1.0, 4.0, 16.0 })
  {
    std::map<double, Column> byView;
    Column byLevel;
    for (const int direction : directions)
    {
      const View view{ direction, zoom };
      const Reference reference = references.Of(view, painter);
      for (const double megabits : rates)
      {
        const MeasuredView measured =
          MeasureView(model, view, {}, megabits * 1e6 / 8, &reference, painter);
        byView[megabits].Add(measured);
        WriteSamples(table, view, "view", megabits * 1e6 / 8, measured);
      }
      SessionOptions level;
      level.detail = DetailMode::Level;
      const MeasuredView measured = MeasureView(model, view, level, 10e6 / 8, &reference, painter);
      byLevel.Add(measured);
      WriteSamples(table, view, "level", 10e6 / 8, measured);
    }
    for (const auto& [megabits, column] : byView)
    {
      column.Print("zoom " + Text(zoom, 1) + ", " + Text(megabits, 1) + " Mbit/s");
    }
    byLevel.Print("  one level, 10 Mbit/s");
    panels.push_back({ id + ", zoom " + Text(zoom, 1), "kB", "wrong pixels, %", {} });
    for (const auto& [megabits, column] : byView)
    {
      panels.back().curves.push_back(CurveOf("by view, " + Text(megabits, 1) + " Mbit/s", column));
    }
    panels.back().curves.push_back(CurveOf("one level", byLevel));
    if (all)
    {
      CheckLimits(id, zoom, byView.at(10), byLevel);
    }
  }
  if (!all)
  {
    return;
  }
  if (const Status drawn = WriteErrorCharts({ panels }, out + "/view-" + id + ".png"); !drawn)
  {
    Fail(drawn.GetError().message);
  }
}

// Approaches the dragon's flank, compared with Nexus's viewer: what that viewer fetched for the
// same views, and how far its pictures were from the original's (measured once, 800 x 480, 30
// degrees).
void BenchFlank(const ServedModel& model)
{
  struct Peer
  {
    double zoom, bytes, rms, share;
  };
  constexpr std::array<Peer, 4> peers{ { { 1, 895e3, 0.0167, 0.25 }, { 3, 2951e3, 0.0061, 0.5 },
    { 6, 2227e3, 0.0088, 0.25 }, { 12, 1519e3, 0.0056, 0.25 } } };
  Painter painter;
  std::printf("\nthe flank of %s: kB, triangles, RMS of the picture %%; Nexus's kB, RMS\n",
    model.Description().id.c_str());
  for (const Peer& peer : peers)
  {
    const View view{ 0, peer.zoom };
    const Reference reference = ReferencePictures(model).Of(view, painter);
    for (const DetailMode detail : { DetailMode::View, DetailMode::Level })
    {
      SessionOptions options;
      options.detail = detail;
      WindowPicture picture;
      const MeasuredView measured =
        MeasureView(model, view, options, 10e6 / 8, &reference, painter, &picture);
      std::printf("zoom %4.0f, %-9s %8.1f %8llu %6.2f | %8.1f %6.2f\n", peer.zoom,
        detail == DetailMode::View ? "view" : "one level", measured.bytes / 1e3,
        static_cast<unsigned long long>(measured.triangles),
        100 * RmsDifference(picture, reference.original), peer.bytes / 1e3, 100 * peer.rms);
      if (detail == DetailMode::View)
      {
        Bar("bytes over Nexus's", measured.bytes / peer.bytes, peer.share);
        Bar("RMS over Nexus's", RmsDifference(picture, reference.original) / peer.rms, 1);
      }
    }
  }
}

// Approaches in six steps. stays: waits at each step until nothing more arrives; else only at the
// last one.
void BenchApproach(const ServedModel& model, bool stays)
{
  constexpr double step = 1.75;
  std::printf("\n%s, six times nearer by %.2f, %s: all kB (wasted), triangles\n",
    model.Description().id.c_str(), step, stays ? "staying in each place" : "0.1 s in each place");
  for (const DetailMode detail : { DetailMode::View, DetailMode::Level })
  {
    SessionOptions options;
    options.detail = detail;
    options.mostStatistics = 0;
    ViewerSession session(std::move(options));
    SimulatedLine line(model, 10e6 / 8, roundTrip);
    MeasuredView measured;
    OpenPreview(session, line, model.Description().id, measured);
    session.EnterFullScreen();
    std::printf("  %-9s", detail == DetailMode::View ? "by view" : "one level");
    for (int i = 0; i <= 6; ++i)
    {
      session.Zoom(i == 0 ? 1 : step, width / 2.0, height / 2.0);
      const double until = line.Now() + 0.1;
      do
      {
        session.BeginFrame();
      } while (line.Next(session) && (stays || i == 6 || line.Now() < until));
      session.BeginFrame();
      std::printf(" | %.1f: %.0f (%.0f) %llu", std::pow(step, i),
        static_cast<double>(line.Bytes()) / 1e3,
        static_cast<double>(session.GetTraffic().wasted) / 1e3,
        static_cast<unsigned long long>(session.GetStatus().triangles));
    }
    std::printf("\n");
  }
}

// Jumps to another view while pieces are in flight: how many of the bytes that arrive after the
// jump are wasted.
void BenchJumps(const ServedModel& model)
{
  std::printf("\n%s, jumps to 11 other directions, 10 Mbit/s: kB from then on (wasted)\n",
    model.Description().id.c_str());
  for (const double zoom : { 1.0, 4.0, 16.0 })
  {
    double bytes = 0, wasted = 0;
    for (int direction = 1; direction < 12; ++direction)
    {
      for (const double after : { 0.1, 0.3, 1.0 })
      {
        const JumpCost cost = CostOfJump(model, { direction, zoom }, after, 10e6 / 8);
        bytes += cost.bytes;
        wasted += cost.wasted;
      }
    }
    std::printf("  zoom %4.1f: %.0f (%.0f)\n", zoom, bytes / 33e3, wasted / 33e3);
    Bar("wasted of the bytes after a jump", wasted / bytes, 0.1);
  }
}

// The cost of a view for models of any size. It should depend on the screen, not on the model, so
// larger models are compared with the smallest one.
void BenchSizes(const std::vector<std::shared_ptr<const ServedModel>>& models, double megabits)
{
  Painter painter;
  std::printf("\nmodels of any size, %.0f Mbit/s\n", megabits);
  for (const double zoom : { 1.0, 4.0, 16.0, 64.0 })
  {
    std::optional<MeasuredView> smallest;
    for (const auto& model : models)
    {
      const ModelDescription& description = model->Description();
      const MeasuredView measured =
        MeasureView(*model, { 0, zoom }, {}, megabits * 1e6 / 8, nullptr, painter);
      std::printf(
        "zoom %4.1f, %-12s %10llu triangles: %8.1f kB, %.2f of the oracle's, %7llu shown\n", zoom,
        description.id.c_str(), static_cast<unsigned long long>(description.triangles),
        measured.bytes / 1e3, measured.bytes / measured.oracleBytes,
        static_cast<unsigned long long>(measured.triangles));
      if (smallest)
      {
        Bar("bytes over the smallest model's", measured.bytes / smallest->bytes, 1.3);
        Bar("triangles over the smallest model's",
          static_cast<double>(measured.triangles) / static_cast<double>(smallest->triangles), 1.3);
      }
      smallest = smallest.value_or(measured);
    }
  }
}

}

// The directions of an option, as in "0,7".
std::vector<int> ReadDirections(const std::string& text)
{
  std::vector<int> directions;
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, ',');)
  {
    int direction = -1;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), direction);
    if (error != std::errc{} || end != word.data() + word.size() || direction < 0 || direction > 11)
    {
      Fail("--directions " + text + ": numbers from 0 to 11 with commas are needed");
    }
    directions.push_back(direction);
  }
  return directions;
}

int main(int count, char** arguments)
{
  std::vector<std::string> words(arguments + 1, arguments + count);
  std::vector<int> directions;
  if (words.size() > 3 && words[2] == "--directions")
  {
    directions = ReadDirections(words[3]);
    words.erase(words.begin() + 2, words.begin() + 4);
  }
  if (words.size() < 2)
  {
    std::fprintf(stderr, "usage: BenchView FOLDER OUT [--directions I,J...] [MODEL...]\n");
    return 2;
  }
  const std::string &folder = words[0], &out = words[1];
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  StoreCatalog stores(folder, [](const std::filesystem::path& file, const std::string& wrong)
    { std::fprintf(stderr, "%s: %s\n", file.c_str(), wrong.c_str()); });
  if (const Status status = stores.Reload(); !status)
  {
    Fail(status.GetError().message);
  }
  std::vector<std::shared_ptr<const ServedModel>> models, largeOnes;
  for (const auto& model : stores.Models())
  {
    const std::string& id = model->Description().id;
    if (words.size() == 2 || std::find(words.begin() + 2, words.end(), id) != words.end())
    {
      (model->Description().triangles < large ? models : largeOnes).push_back(model);
    }
  }
  if (!directions.empty())
  {
    models.insert(models.end(), largeOnes.begin(), largeOnes.end());
    for (const auto& model : models)
    {
      Bench(*model, folder, out, { 10 }, directions);
    }
    return 0;
  }
  directions.resize(12);
  std::iota(directions.begin(), directions.end(), 0);
  for (const auto& model : models)
  {
    BenchApproach(*model, true);
    BenchApproach(*model, false);
    BenchJumps(*model);
    if (model->Description().id == "dragon")
    {
      BenchFlank(*model);
    }
    Bench(*model, folder, out, { 1, 10, 100 }, directions);
  }
  std::sort(largeOnes.begin(), largeOnes.end(),
    [](const auto& a, const auto& b)
    { return a->Description().triangles < b->Description().triangles; });
  for (const auto& model : largeOnes)
  {
    BenchApproach(*model, true);
    BenchApproach(*model, false);
    BenchJumps(*model);
  }
  BenchSizes(largeOnes, 10);
  BenchSizes(largeOnes, 100);
  for (const auto& model : largeOnes)
  {
    Bench(*model, folder, out, { 10 }, directions);
  }
  return misses > 0 ? 1 : 0;
}
