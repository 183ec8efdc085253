// SPDX-License-Identifier: BSD-3-Clause
// Tables 4 to 6 of the paper: how long three levels and a region take to arrive, to be decoded and
// to be drawn, compared with the paper's phone.
//
//   BenchTables456 PROGRAMS STORES OUT [TRIALS]
//
// STORES: a folder with dragon.kds, relief-3600000.kds and relief-14030000.kds, which stand for the
// paper's meshes of 0.54, 3.6 and 14 million vertices. Serves them by kdstream-serve and plays one
// session with kdstream-view for each, TRIALS (10) times, over loopback and over a line of 20
// Mbit/s and 30 ms. A session shows the preview, three levels of the whole model by `--detail
// level` (the coarsest levels with at least as many vertices as the paper's), and the region of a
// double tap. Prints medians and writes tables456.csv. Each picture has 800 x 480 pixels and is
// drawn without a graphics card.
#include "Testing/Benchmarks/MeasuredRun.h"
#include "Testing/Benchmarks/Serving/ServerProcess.h"
#include "Testing/Benchmarks/ShapedProxy.h"
#include "Testing/Benchmarks/SimulatedLine.h"
#include "server/session/StoreCatalog.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace
{

using namespace kdstream;
using namespace kdstream::benchmarks;
using std::filesystem::path;

constexpr int width = 800, height = 480;

[[noreturn]] void Fail(const std::string& what)
{
  std::fprintf(stderr, "BenchTables456: error: %s\n", what.c_str());
  std::exit(1);
}

struct PaperRow
{
  const char* what;
  int vertices, faces;
  double transmission, parsing, rendering, total; // s
};

struct PaperTable
{
  const char* title;
  const char* model;              // our model that is compared with it
  std::array<PaperRow, 4> rows{}; // low, mid, high, region
};

// As printed in the paper; a total may differ from the sum of its parts.
constexpr std::array<PaperTable, 3> paper{
  PaperTable{ "Table 4, Buddha (0.54 M vertices)", "dragon",
    { { { "low", 690, 1348, 0.06, 0.04, 0.03, 0.13 }, { "mid", 2651, 5188, 0.10, 0.12, 0.12, 0.34 },
      { "high", 9751, 19332, 0.34, 0.52, 0.43, 1.28 },
      { "11 partitions", 26544, 45933, 1.19, 0.98, 1.00, 3.17 } } } },
  PaperTable{ "Table 5, Xyzrgb_dragon (3.6 M vertices)", "relief-3600000",
    { { { "low", 690, 1348, 0.05, 0.04, 0.03, 0.12 }, { "mid", 2455, 4778, 0.10, 0.11, 0.11, 0.32 },
      { "high", 9168, 18176, 0.36, 0.52, 0.41, 1.29 },
      { "20 partitions", 42816, 70784, 2.05, 1.57, 0.70, 4.33 } } } },
  PaperTable{ "Table 6, Lucy (14 M vertices)", "relief-14030000",
    { { { "low", 5161, 11856, 0.21, 0.31, 0.24, 0.77 },
      { "mid", 9770, 19386, 0.32, 0.54, 0.43, 1.29 },
      { "high", 18625, 36984, 0.72, 1.06, 0.84, 2.62 },
      { "9 partitions", 18166, 30824, 0.97, 0.69, 0.77, 2.43 } } } },
};

// Sums over the blobs of a row, in one trial.
struct Row
{
  std::uint64_t blobs = 0, vertices = 0, triangles = 0, bytes = 0;
  double transmission = 0, parsing = 0, rendering = 0; // s

  double Total() const { return this->transmission + this->parsing + this->rendering; }
};

// ---- the session that is played

// The level that a session aims at after these turns of the wheel, starting from the preview.
unsigned TargetAfter(const ServedModel& model, const std::vector<double>& wheels)
{
  SessionOptions options;
  options.detail = DetailMode::Level;
  ViewerSession session(std::move(options));
  session.Resize({ width, height, 1 });
  static_cast<void>(session.SelectModel(model.Description().id));
  for (bench::SimulatedLine line(model, 1e12, 0); line.Next(session);)
  {
    session.BeginFrame();
  }
  for (const double factor : wheels)
  {
    session.Zoom(factor, width / 2.0, height / 2.0);
  }
  return session.GetStatus().targetLevel.value_or(0);
}

// The turn of the wheel after `earlier` that makes a session aim at `level`.
double WheelTo(const ServedModel& model, const std::vector<double>& earlier, unsigned level)
{
  for (double factor = 1.0 / 64; factor < 1024; factor *= 1.1)
  {
    std::vector<double> wheels = earlier;
    wheels.push_back(factor);
    if (TargetAfter(model, wheels) == level)
    {
      return factor;
    }
  }
  Fail(model.Description().id + ": no zoom asks for level " + std::to_string(level));
}

// The coarsest level with at least this number of vertices, but not coarser than `atLeast`.
unsigned LevelOf(const ModelDescription& model, int vertices, unsigned atLeast)
{
  for (std::size_t level = atLeast; level < model.levels.size(); ++level)
  {
    if (model.levels[level].vertices >= static_cast<std::uint64_t>(vertices))
    {
      return static_cast<unsigned>(level);
    }
  }
  Fail(model.id + ": has no level of " + std::to_string(vertices) + " vertices");
}

struct Play
{
  std::array<unsigned, 3> levels{};
  std::string steps; // the text of a session file
};

Play PlayOf(const ServedModel& model, const PaperTable& table)
{
  constexpr const char* idle = "{\"wait\":\"idle\"}\n";
  const ModelDescription& description = model.Description();
  const unsigned preview = PreviewLevel(description);
  Play play;
  play.steps = "{\"select\":\"" + description.id + "\"}\n" + idle;
  std::vector<double> wheels;
  unsigned last = preview;
  for (std::size_t row = 0; row < play.levels.size(); ++row)
  {
    const unsigned level = LevelOf(description, table.rows[row].vertices, last);
    play.levels[row] = level;
    if (level > last)
    {
      wheels.push_back(WheelTo(model, wheels, level));
      play.steps += "{\"zoom\":" + std::to_string(wheels.back()) +
                    ",\"x\":" + std::to_string(width / 2) + ",\"y\":" + std::to_string(height / 2) +
                    "}\n" + idle;
    }
    last = level;
  }
  const std::string finger =
    "{\"id\":1,\"x\":" + std::to_string(width / 2) + ",\"y\":" + std::to_string(height / 2) + "}";
  for (const auto& [down, up] : { std::pair("1.00", "1.05"), std::pair("1.15", "1.20") })
  {
    play.steps += std::string("{\"t\":") + down + ",\"touches\":[" + finger + "]}\n" +
                  "{\"t\":" + up + ",\"touches\":[]}\n";
  }
  play.steps += idle;
  return play;
}

// ---- one trial

// Rows 0 to 2 are the levels; row 3 is everything that arrived for the double tap.
std::array<Row, 4> RowsOf(const Json& statistics, const Play& play)
{
  std::array<Row, 4> rows{};
  for (const Json& blob : statistics)
  {
    const std::string id = blob.at("id");
    const std::string prefix = id.substr(0, id.find('/', 7) + 1); // for example "levels/12/"
    std::size_t row = 3;
    for (std::size_t i = 0; i < play.levels.size(); ++i)
    {
      row = prefix == "levels/" + std::to_string(play.levels[i]) + "/" ? i : row;
    }
    Row& sum = rows[row];
    ++sum.blobs;
    sum.vertices += blob.at("vertices").get<std::uint64_t>();
    sum.triangles += blob.at("triangles").get<std::uint64_t>();
    sum.bytes += blob.at("bytes").get<std::uint64_t>();
    sum.transmission += blob.at("transmission_s").get<double>();
    sum.parsing += blob.at("parsing_s").get<double>();
    sum.rendering += blob.at("rendering_s").get<double>();
  }
  return rows;
}

double Median(std::vector<double> values)
{
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// Counts are the same in each trial; times are medians.
Row MedianOf(const std::vector<Row>& trials)
{
  const auto median = [&trials](double Row::*member)
  {
    std::vector<double> values;
    for (const Row& row : trials)
    {
      values.push_back(row.*member);
    }
    return Median(values);
  };
  Row row = trials.front();
  row.transmission = median(&Row::transmission);
  row.parsing = median(&Row::parsing);
  row.rendering = median(&Row::rendering);
  return row;
}

class Bench
{
public:
  Bench(path folderOfPrograms, path stores, path folder, int repeats)
    : Programs(std::move(folderOfPrograms))
    , Folder(std::move(folder))
    , Trials(repeats)
    , Server(
        { this->Programs / "kdstream-serve", stores, "--port", "0" }, this->Folder / "serve.log")
    , Port(this->Server.ReadPort())
    , Catalog(stores, [](const path& file, const std::string& wrong)
        { std::fprintf(stderr, "%s: %s\n", file.c_str(), wrong.c_str()); })
    , Table(this->Folder / "tables456.csv")
  {
    if (const Status status = this->Catalog.Reload(); !status)
    {
      Fail(status.GetError().message);
    }
    this->Table << "model,line,row,blobs,vertices,triangles,bytes,transmission_s,parsing_s,"
                   "rendering_s\n";
  }

  void Run()
  {
    for (const PaperTable& table : paper)
    {
      const auto model = this->Catalog.Find(table.model);
      if (!model)
      {
        Fail(std::string(table.model) + ".kds is not there");
      }
      const Play play = PlayOf(*model, table);
      std::printf("\n%s, ours: %s, %llu vertices; medians of %d, s\n", table.title, table.model,
        static_cast<unsigned long long>(model->Description().vertices), this->Trials);
      std::printf("%-28s %8s %8s %8s %9s %9s %9s %9s\n", "", "vertices", "faces", "kB", "transm.",
        "parsing", "rendering", "total");
      this->Measure(table, play, "loopback", {});
      this->Measure(table, play, "20 Mbit/s, 30 ms", { 20e6 / 8, 0.03 });
    }
  }

private:
  void Measure(const PaperTable& table, const Play& play, const std::string& line,
    const ShapedProxy::Line& shape)
  {
    const ShapedProxy proxy(this->Port, shape);
    std::array<std::vector<Row>, 4> trials;
    for (int trial = 0; trial < this->Trials; ++trial)
    {
      const auto rows = this->Play1(table.model, play, proxy.Port());
      for (std::size_t row = 0; row < rows.size(); ++row)
      {
        trials[row].push_back(rows[row]);
      }
    }
    std::printf("%s\n", line.c_str());
    for (std::size_t row = 0; row < trials.size(); ++row)
    {
      this->Print(table, play, line, row, MedianOf(trials[row]));
    }
  }

  std::array<Row, 4> Play1(const std::string& model, const Play& play, std::uint16_t port) const
  {
    const path session = this->Folder / "tables456.jsonl", stats = this->Folder / "tables456.json";
    std::ofstream(session) << play.steps;
    RunMeasured({ this->Programs / "kdstream-view", "http://127.0.0.1:" + std::to_string(port),
                  "--model", model, "--detail", "level", "--offscreen", "auto", "--size",
                  std::to_string(width) + "x" + std::to_string(height), "--replay", session,
                  "--stats", stats },
      "/dev/null");
    const auto rows = RowsOf(Json::parse(std::ifstream(stats)), play);
    if (std::any_of(rows.begin(), rows.end(), [](const Row& row) { return row.blobs == 0; }))
    {
      Fail(model + ": not all that was to be measured has come");
    }
    std::filesystem::remove(session);
    std::filesystem::remove(stats);
    return rows;
  }

  void Print(const PaperTable& table, const Play& play, const std::string& line, std::size_t number,
    const Row& row)
  {
    const PaperRow& theirs = table.rows[number];
    const std::string name =
      number < 3 ? std::string(theirs.what) + ", level " + std::to_string(play.levels[number])
                 : "region, " + std::to_string(row.blobs) + " pieces";
    const auto count = [](std::uint64_t value) { return static_cast<unsigned long long>(value); };
    std::printf("  %-26s %8llu %8llu %8.1f %9.3f %9.3f %9.3f %9.3f\n", name.c_str(),
      count(row.vertices), count(row.triangles), static_cast<double>(row.bytes) / 1e3,
      row.transmission, row.parsing, row.rendering, row.Total());
    std::printf("  %-26s %8d %8d %8s %9.2f %9.2f %9.2f %9.2f\n",
      (std::string("  the paper's ") + theirs.what).c_str(), theirs.vertices, theirs.faces, "",
      theirs.transmission, theirs.parsing, theirs.rendering, theirs.total);
    this->Table << table.model << ",\"" << line << "\",\"" << name << "\"," << row.blobs << ','
                << row.vertices << ',' << row.triangles << ',' << row.bytes << ','
                << row.transmission << ',' << row.parsing << ',' << row.rendering << '\n';
  }

  path Programs, Folder;
  int Trials;
  ServerProcess Server;
  std::uint16_t Port;
  StoreCatalog Catalog;
  std::ofstream Table;
};

}

int main(int argc, char** argv)
{
  if (argc < 4)
  {
    std::fprintf(stderr, "usage: BenchTables456 PROGRAMS STORES OUT [TRIALS]\n");
    return 2;
  }
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  std::filesystem::create_directories(argv[3]);
  Bench(argv[1], argv[2], argv[3], std::max(1, argc > 4 ? std::atoi(argv[4]) : 10)).Run();
  return 0;
}
