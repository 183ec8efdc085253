// SPDX-License-Identifier: BSD-3-Clause
// How far long work is, reported on stderr: every program's progress.
#pragma once

#include "filters/program/ProgressEstimate.h"

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace kdstream
{

// What a step goes through from its beginning to its end: its rate is reported in this.
struct StepAmount
{
  double amount = 0;
  std::string unit; // "B" for bytes, "triangles"; the plural
};

// The values of a progress line.
struct ProgressState
{
  std::string step;
  double fraction = 0;             // of the step; 0 or 1 for a step without reports in between
  double seconds = 0;              // since the work began
  std::optional<double> perSecond; // of the unit
  std::string unit;
  std::optional<ProgressEstimate::Time> left;
};

// "levels 35 %, 42 s, 2.1 M triangles/s, about 40 s left". A fraction without meaning, at the
// beginning and the end of a step, is left out.
std::string ProgressText(const ProgressState& state);
// The same after a bar: "levels [########## ] 35 % 42 s …", at most `columns` wide. If the fraction
// has no meaning, a part of the bar moves to and fro.
std::string ProgressBar(const ProgressState& state, std::size_t columns);

// "4 s", "3 min 20 s", "1 h 12 min"; "250 kB", "14 MB"; "2.1 M", "850 k".
std::string DurationText(double seconds);
std::string BytesText(double bytes);
std::string CountText(double count);

// Prints a bar on a terminal, else a line every three seconds; nothing if quiet. Its own thread
// updates the time while a step reports nothing, so that the program does not seem to hang.
class ProgressReporter
{
public:
  // shares: see ProgressEstimate.
  explicit ProgressReporter(
    std::string_view program, bool quiet, std::vector<StepShare> shares = {});
  ~ProgressReporter(); // takes the bar away
  ProgressReporter(const ProgressReporter&) = delete;
  ProgressReporter& operator=(const ProgressReporter&) = delete;

  // Takes a report, as Execution::progress. Returns false, which cancels the work, once the process
  // is interrupted.
  bool operator()(std::string_view step, double fraction);

  // An empty step: of all that have none of their own.
  void SetAmount(const std::string& step, StepAmount amount);

private:
  double Now() const; // seconds since the work began
  void PrintUntilDone();
  void Print();
  ProgressState State() const;

  std::string Program;
  bool Terminal;
  std::chrono::steady_clock::time_point Begin;

  std::mutex Mutex; // of all below
  std::condition_variable Ended;
  bool Done = false, LineOpen = false;
  ProgressEstimate Estimate;
  std::map<std::string, StepAmount> Amounts;
  std::string Step;
  double Fraction = 0, Reported = 0; // and when
  std::thread Printer;               // none if quiet
};

}
