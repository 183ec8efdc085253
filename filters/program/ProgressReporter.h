// SPDX-License-Identifier: BSD-3-Clause
// Reports the progress of long work on stderr, for every program.
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

// The amount that a step processes from its beginning to its end. Its rate is displayed in this
// unit.
struct StepAmount
{
  double amount = 0;
  std::string unit; // in the plural: "triangles"; "B" for bytes
};

// The values displayed in a progress line.
struct ProgressState
{
  std::string step;
  double fraction = 0;             // of the step; 0 or 1 if the step reports nothing in between
  double seconds = 0;              // since the work began
  std::optional<double> perSecond; // in the unit of the amount
  std::string unit;
  std::optional<ProgressEstimate::Time> left;
};

// "levels 35 %, 42 s, 2.1 M triangles/s, about 40 s left". At the beginning and at the end of a
// step the fraction has no meaning, and is omitted.
std::string ProgressText(const ProgressState& state);
// The same after a bar: "levels [########## ] 35 % 42 s …", at most `columns` wide. If the fraction
// has no meaning, a part of the bar moves back and forth.
std::string ProgressBar(const ProgressState& state, std::size_t columns);

// Texts such as "4 s", "3 min 20 s", "1 h 12 min"; "250 kB", "14 MB"; "2.1 M", "850 k".
std::string DurationText(double seconds);
std::string BytesText(double bytes);
std::string CountText(double count);

// Prints a bar on a terminal, otherwise a line every three seconds; nothing if quiet. While a step
// reports nothing, a separate thread updates the time, so that the program does not seem to hang.
class ProgressReporter
{
public:
  // shares: see ProgressEstimate.
  explicit ProgressReporter(
    std::string_view program, bool quiet, std::vector<StepShare> shares = {});
  ~ProgressReporter(); // removes the bar
  ProgressReporter(const ProgressReporter&) = delete;
  ProgressReporter& operator=(const ProgressReporter&) = delete;

  // Takes a report, like Execution::progress. Once the process is interrupted it returns false,
  // which cancels the work.
  bool operator()(std::string_view step, double fraction);

  // If `step` is empty: the amount of all steps without one of their own.
  void SetAmount(const std::string& step, StepAmount amount);

private:
  double Now() const; // seconds since the work began
  void PrintUntilDone();
  void Print();
  ProgressState State() const;

  std::string Program;
  bool Terminal;
  std::chrono::steady_clock::time_point Begin;

  std::mutex Mutex; // for all members below
  std::condition_variable Ended;
  bool Done = false, LineOpen = false;
  ProgressEstimate Estimate;
  std::map<std::string, StepAmount> Amounts;
  std::string Step;
  double Fraction = 0, Reported = 0; // of the step; time of its report
  std::thread Printer;               // none if quiet
};

}
