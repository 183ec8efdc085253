// SPDX-License-Identifier: BSD-3-Clause
// kdstream-serve with crowds of viewers that open a model, zoom and tap, over loopback. Some of
// them are slow, and some vanish. Measures how fast the server answers, what a client costs, and
// whether the server returns to its initial state when all have left. Usage:
//   BenchServe PROGRAMS STORE LOG [MINUTES [VIEWERS...]]
// PROGRAMS: the folder of kdstream-serve. STORE: NAME.kds, the only store in its folder. For each
// crowd (1,000 and 5,000 viewers) there are three servers, one after the other. With the first,
// memory is measured. With the second, viewers move for MINUTES (1). With the third, viewers move
// for 20 seconds while the server may have only 1,024 descriptors. Before that, viewers that read
// as fast as they can are measured without and with slow ones, in turn. Ends with an error if a
// limit is missed.
#include "Testing/Benchmarks/Serving/CrowdViewer.h"
#include "Testing/Benchmarks/Serving/ServerProcess.h"
#include "filters/store/Store.h"

#include <boost/asio/executor_work_guard.hpp>

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <iterator>
#include <thread>

namespace
{

using namespace kdstream;
using namespace kdstream::benchmarks;
using std::filesystem::path;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr double mostGrowth = 16; // MiB, after the first fifth of the time
constexpr rlim_t fewDescriptors = 1024;
// Together with the finest level, these are more bytes than the buffers of kernel and server hold.
constexpr std::uint64_t enoughPartitions = 40;
constexpr Seconds pauseOfViewers{ 10 }, timeWithFew{ 20 }, longestWait{ 120 };

[[noreturn]] void Fail(const std::string& what)
{
  std::cerr << "BenchServe: error: " << what << "\n";
  std::exit(1);
}

// Of thirty viewers, one is deaf, two are slow, and three vanish.
Manner MannerOf(std::size_t viewer)
{
  const auto place = viewer % 30;
  return place == 0  ? Manner::Deaf
         : place < 3 ? Manner::Slow
         : place < 6 ? Manner::Vanishing
                     : Manner::Eager;
}

class Crowd
{
public:
  Crowd(const CrowdModel& model, std::uint16_t port, std::size_t viewers,
    const std::function<Manner(std::size_t)>& mannerOf)
  {
    for (std::size_t i = 0; i < viewers; ++i)
    {
      this->Viewers.emplace_back(
        this->Context, model, port, mannerOf(i), static_cast<std::uint32_t>(i + 1), this->Tally);
    }
  }

  // Connects the viewers, a thousand a second.
  void Arrive()
  {
    for (std::size_t i = 0; i < this->Viewers.size(); ++i)
    {
      this->Viewers[i].Arrive();
      if (i % 10 == 9)
      {
        this->RunFor(Seconds(0.01));
      }
    }
  }
  std::size_t Settled() const
  {
    return static_cast<std::size_t>(std::count_if(this->Viewers.begin(), this->Viewers.end(),
      [](const CrowdViewer& viewer) { return viewer.IsSettled(); }));
  }
  // Waits until all viewers have settled. Returns whether they have.
  bool Settle()
  {
    const auto until = Clock::now() + longestWait;
    while (this->Settled() < this->Viewers.size() && Clock::now() < until)
    {
      this->RunFor(Seconds(0.1));
    }
    return this->Settled() == this->Viewers.size();
  }
  template <class Work>
  void Each(const Work& work)
  {
    std::for_each(this->Viewers.begin(), this->Viewers.end(), work);
  }
  void RunFor(Seconds time)
  {
    this->Context.restart();
    this->Context.run_for(std::chrono::duration_cast<Clock::duration>(time));
  }
  void Leave()
  {
    this->Each([](CrowdViewer& viewer) { viewer.Leave(); });
    this->RunFor(Seconds(2));
    this->Viewers.clear();
  }

  CrowdTally Tally;

private:
  boost::asio::io_context Context{ 1 };
  // Keeps the context running even if there is nothing to do.
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> Work{
    this->Context.get_executor()
  };
  std::vector<CrowdViewer> Viewers;
};

double Percentile(std::vector<float> values, double part)
{
  if (values.empty())
  {
    return 0;
  }
  const auto place = static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return values[static_cast<std::size_t>(place)];
}

// One crowd's visit to one server, from the server's start to its end.
class Visit
{
public:
  enum class Kind
  {
    Weighed,
    Roaming,
    Crushed // the server has fewer descriptors than viewers
  };

  Visit(const path& programs, const path& store, const path& log, const CrowdModel& model,
    std::size_t viewers, Kind kind)
    : Model(model)
    , Count(viewers)
    , Is(kind)
    , Server({ programs / "kdstream-serve", store.parent_path(), "--port", "0", "--max-connections",
               std::to_string(viewers + 100) },
        log, kind == Kind::Crushed ? std::optional(fewDescriptors) : std::nullopt)
    , Port(this->Server.ReadPort())
  {
  }

  // Returns whether all limits are met.
  bool Run(Seconds time)
  {
    this->Warm();
    const auto atStart = this->Server.Descriptors();
    {
      Crowd crowd(this->Model, this->Port, this->Count, MannerOf);
      this->Is == Kind::Crushed ? this->Crush(crowd) : this->Admit(crowd);
      this->Is == Kind::Weighed ? this->Weigh(crowd) : this->Roam(crowd, time);
      crowd.Leave();
      this->Judge(crowd.Tally);
    }
    this->Compare("descriptors above the start's when all have gone", this->LeftOver(atStart), 0);
    this->Warm(); // does not return unless the server still answers
    if (!this->Server.End())
    {
      this->Missed("the server did not end well");
    }
    return this->Good;
  }

private:
  // Brings all blobs into the server's memory.
  void Warm()
  {
    Crowd one(this->Model, this->Port, 1, [](std::size_t) { return Manner::Eager; });
    one.Arrive();
    if (!one.Settle())
    {
      Fail("the server does not answer");
    }
    one.Each(
      [this](CrowdViewer& viewer)
      {
        viewer.Hold(this->Model.description.partitions);
        viewer.GoOn();
      });
    if (!one.Settle() || one.Tally.failures != 0)
    {
      Fail("the server does not send its model: " + one.Tally.firstFailure);
    }
    one.Leave();
  }

  void Admit(Crowd& crowd)
  {
    this->Before = this->Server.ResidentMebibytes();
    crowd.Arrive();
    if (!crowd.Settle())
    {
      this->Missed("only " + std::to_string(crowd.Settled()) + " have got their preview");
    }
  }

  // The memory that a client costs: one that has its preview and waits, and one that is being sent
  // blobs.
  void Weigh(Crowd& crowd)
  {
    const double idle = this->Server.ResidentMebibytes();
    const double sent = this->Sent();
    crowd.Each([](CrowdViewer& viewer) { viewer.Hold(enoughPartitions); });
    crowd.RunFor(Seconds(3));
    const double streaming = this->Server.ResidentMebibytes();
    const double inFlight = this->Sent() - sent;
    const auto had = crowd.Tally.bytes;
    const auto begin = Clock::now();
    crowd.Each([](CrowdViewer& viewer) { viewer.GoOn(); });
    if (!crowd.Settle())
    {
      this->Missed("some have not got what they asked for");
    }
    const auto all = static_cast<double>(crowd.Tally.bytes - had);
    const auto each = [this](double now)
    { return (now - this->Before) * 1024 / static_cast<double>(this->Count); };
    std::printf("  KiB of the server a client: %.1f idle, %.1f while it is sent to\n", each(idle),
      each(streaming));
    std::printf("  all at once, as fast as it goes: %.0f MB/s\n",
      all / 1e6 / Seconds(Clock::now() - begin).count());
    if (inFlight > 0.8 * all)
    {
      this->Missed("too much had been sent for this to tell what sending takes");
    }
  }

  // The number of bytes that the server has sent, by its own count.
  double Sent() const
  {
    const std::string name = "\nkdstream_sent_bytes_total ";
    const auto metrics = Get(this->Port, "/metrics");
    const auto at = metrics.find(name);
    return at == metrics.npos ? 0 : std::atof(metrics.c_str() + at + name.size());
  }

  // There are more clients than descriptors: those that get no slot connect again and again.
  void Crush(Crowd& crowd)
  {
    crowd.Arrive();
    crowd.RunFor(Seconds(3));
    std::printf("  have a place: %zu\n", crowd.Settled());
    this->Placed = crowd.Settled();
  }

  void Roam(Crowd& crowd, Seconds time)
  {
    const CrowdTally before = crowd.Tally;
    crowd.Tally.firstBlobs.clear();
    crowd.Tally.lastBlobs.clear();
    crowd.Each([](CrowdViewer& viewer) { viewer.Roam(pauseOfViewers); });
    const auto begin = Clock::now();
    double early = 0;
    for (Seconds passed{ 0 }; passed < time; passed = Clock::now() - begin)
    {
      crowd.RunFor(std::min(Seconds(1), time));
      if (early == 0 && Clock::now() - begin >= time / 5)
      {
        early = this->Server.ResidentMebibytes();
      }
    }
    const double seconds = Seconds(Clock::now() - begin).count();
    this->Late = this->Server.ResidentMebibytes();
    this->Early = early;
    const CrowdTally& now = crowd.Tally;
    std::printf("  roaming for %.0f s: %.0f acts/s, %.0f blobs/s, %.1f MB/s\n", seconds,
      static_cast<double>(now.acts - before.acts) / seconds,
      static_cast<double>(now.blobs - before.blobs) / seconds,
      static_cast<double>(now.bytes - before.bytes) / 1e6 / seconds);
    std::printf("  region, ms from the tap (%zu taps): first blob p50 %.1f, p99 %.1f; last p50 "
                "%.1f, p99 %.1f\n",
      now.lastBlobs.size(), 1e3 * Percentile(now.firstBlobs, 0.5),
      1e3 * Percentile(now.firstBlobs, 0.99), 1e3 * Percentile(now.lastBlobs, 0.5),
      1e3 * Percentile(now.lastBlobs, 0.99));
    std::fflush(stdout);
  }

  void Judge(const CrowdTally& tally)
  {
    std::printf("  vanished %llu times, deaf ones dropped %llu times, refused %llu times\n",
      static_cast<unsigned long long>(tally.vanished),
      static_cast<unsigned long long>(tally.deafDropped),
      static_cast<unsigned long long>(tally.refused));
    this->Compare("failures", tally.failures, 0);
    if (tally.failures != 0)
    {
      std::printf("  the first: %s\n", tally.firstFailure.c_str());
    }
    this->Compare("readers dropped", tally.dropped, 0);
    if (this->Is == Kind::Crushed)
    {
      if (this->Placed == 0 || tally.refused == 0)
      {
        this->Missed("nobody had a place, or nobody was refused");
      }
      return;
    }
    this->Compare("refused", tally.refused, 0);
    if (this->Is == Kind::Weighed)
    {
      return;
    }
    std::printf(
      "  MiB resident, at a fifth of the time: %.1f; at its end %.1f (wanted: at most %.0f "
      "more)%s\n",
      this->Early, this->Late, mostGrowth,
      this->Late - this->Early <= mostGrowth ? "" : "  MISSED");
    this->Good = this->Good && this->Late - this->Early <= mostGrowth;
  }

  std::uint64_t LeftOver(std::size_t atStart)
  {
    const auto until = Clock::now() + std::chrono::seconds(20);
    while (this->Server.Descriptors() > atStart && Clock::now() < until)
    {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return this->Server.Descriptors() - std::min(atStart, this->Server.Descriptors());
  }

  void Compare(const char* what, std::uint64_t value, std::uint64_t most)
  {
    std::printf("  %s: %llu (wanted: %llu)%s\n", what, static_cast<unsigned long long>(value),
      static_cast<unsigned long long>(most), value <= most ? "" : "  MISSED");
    this->Good = this->Good && value <= most;
  }
  void Missed(const std::string& what)
  {
    std::printf("  %s  MISSED\n", what.c_str());
    this->Good = false;
  }

  const CrowdModel& Model;
  const std::size_t Count;
  const Kind Is;
  ServerProcess Server;
  const std::uint16_t Port;
  std::size_t Placed = 0;
  double Before = 0, Early = 0, Late = 0; // MiB
  bool Good = true;
};

// How much later viewers get what they request if others read slowly or not at all.
class Neighbours
{
public:
  Neighbours(const path& programs, const path& store, const path& log, const CrowdModel& model)
    : Model(model)
    , Server({ programs / "kdstream-serve", store.parent_path(), "--port", "0" }, log, std::nullopt)
    , Port(this->Server.ReadPort())
  {
  }

  // Returns whether the limit is met.
  bool Run()
  {
    std::vector<float> alone, beside, ratios;
    // In turn, so other work on the machine affects both.
    for (int round = 0; round < rounds; ++round)
    {
      const auto first = this->Roam(0), second = this->Roam(slowOnes);
      ratios.push_back(static_cast<float>(Percentile(second, 0.99) / Percentile(first, 0.99)));
      alone.insert(alone.end(), first.begin(), first.end());
      beside.insert(beside.end(), second.begin(), second.end());
    }
    const auto ms = [](const std::vector<float>& times, double part)
    { return 1e3 * Percentile(times, part); };
    const double ratio = Percentile(ratios, 0.5);
    std::printf("  region, ms from the tap to the last blob: alone (%zu taps) p50 %.2f, p99 %.2f; "
                "beside (%zu taps) p50 %.2f, p99 %.2f\n  p99 beside over alone, the median of %d "
                "rounds: %.2f (wanted: at "
                "most %.1f)%s\n",
      alone.size(), ms(alone, 0.5), ms(alone, 0.99), beside.size(), ms(beside, 0.5),
      ms(beside, 0.99), rounds, ratio, mostRatio, ratio <= mostRatio ? "" : "  MISSED");
    std::fflush(stdout);
    return this->Server.End() && ratio <= mostRatio;
  }

  static constexpr std::size_t others = 300, slowOnes = 100;

private:
  static constexpr int rounds = 7;
  static constexpr double mostRatio = 1.2;

  // How long the regions of the other viewers took, in one round.
  std::vector<float> Roam(std::size_t slow)
  {
    Crowd crowd(this->Model, this->Port, others + slow,
      [](std::size_t viewer) {
        return viewer < others ? Manner::Eager : viewer % 4 == 0 ? Manner::Deaf : Manner::Slow;
      });
    crowd.Arrive();
    if (!crowd.Settle())
    {
      Fail("some have not got their preview");
    }
    crowd.Each([](CrowdViewer& viewer) { viewer.Roam(Seconds(1)); });
    crowd.RunFor(Seconds(8));
    std::vector<float> times = crowd.Tally.lastBlobs;
    if (crowd.Tally.failures != 0)
    {
      Fail(crowd.Tally.firstFailure);
    }
    crowd.Leave();
    return times;
  }

  const CrowdModel& Model;
  ServerProcess Server;
  const std::uint16_t Port;
};

CrowdModel ReadCrowdModel(const path& file)
{
  const auto store = Store::Open(file);
  if (!store)
  {
    Fail(file.string() + ": " + store.GetError().message);
  }
  auto boxes = (*store)->ReadBoxes();
  if (!boxes)
  {
    Fail(file.string() + ": " + boxes.GetError().message);
  }
  CrowdModel model{ (*store)->Info(), std::move(*boxes) };
  model.description.id = file.stem().string();
  return model;
}

}

int main(int argc, char** argv)
{
  if (argc < 4)
  {
    std::cerr << "BenchServe PROGRAMS STORE LOG [MINUTES [VIEWERS...]]\n";
    return 2;
  }
  const path programs = argv[1], store = std::filesystem::absolute(argv[2]), log = argv[3];
  const Seconds time(60 * (argc > 4 ? std::atof(argv[4]) : 1));
  std::vector<std::size_t> crowds{ 1000, 5000 };
  if (argc > 5)
  {
    crowds.clear();
    std::transform(argv + 5, argv + argc, std::back_inserter(crowds),
      [](const char* text) { return std::strtoul(text, nullptr, 10); });
  }
  rlimit limit{};
  ::getrlimit(RLIMIT_NOFILE, &limit);
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
  const CrowdModel model = ReadCrowdModel(store);
  std::printf("\n%zu viewers, alone and beside %zu that read 16 KiB a second or nothing\n",
    Neighbours::others, Neighbours::slowOnes);
  bool good = Neighbours(programs, store, log, model).Run();
  for (const auto viewers : crowds)
  {
    if (limit.rlim_cur < viewers + 100)
    {
      Fail("this machine gives a process " + std::to_string(limit.rlim_cur) +
           " descriptors, too few for " + std::to_string(viewers) + " viewers");
    }
    const auto visit = [&](const char* what, Visit::Kind kind, Seconds length)
    {
      std::printf("\n%zu viewers%s\n", viewers, what);
      std::fflush(stdout);
      good = Visit(programs, store, log, model, viewers, kind).Run(length) && good;
    };
    visit(", weighed", Visit::Kind::Weighed, {});
    visit(", roaming", Visit::Kind::Roaming, time);
    visit(", roaming; the server may have 1,024 descriptors", Visit::Kind::Crushed, timeWithFew);
  }
  std::printf("\n%s\n", good ? "all bars are met" : "bars are MISSED");
  return good ? 0 : 1;
}
