// SPDX-License-Identifier: BSD-3-Clause
#include "filters/program/ProgressReporter.h"

#include "filters/program/Program.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace kdstream
{
namespace
{

constexpr std::chrono::milliseconds pauseOnTerminal(100), pauseOfLines(3000);

std::string Format(const char* format, double value)
{
  char text[64] = {};
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

std::string Shortened(double value, const char* const units[4])
{
  int unit = 0;
  for (; unit < 3 && value >= 999.5; ++unit)
  {
    value /= 1000;
  }
  return Format(unit > 0 && value < 9.95 ? "%.1f" : "%.0f", value) + units[unit];
}

std::size_t TerminalColumns()
{
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

std::string PercentText(double fraction)
{
  return Format("%.0f %%", std::floor(100 * fraction));
}

bool TellsSomething(double fraction)
{
  return fraction > 0 && fraction < 1;
}

// A part of the bar moves back and forth, ten places a second: the progress is not known, but the
// work continues.
std::string MovingBar(std::size_t width, double seconds)
{
  constexpr std::size_t part = 6;
  const std::size_t way = width - part;
  const auto steps = static_cast<std::size_t>(seconds * 10) % (2 * way);
  const std::size_t place = std::min(steps, 2 * way - steps);
  return std::string(place, ' ') + std::string(part, '#') + std::string(way - place, ' ');
}

// The text after the step and its fraction.
std::string Rest(const ProgressState& state, const char* separator)
{
  std::string text = separator + DurationText(state.seconds);
  if (state.perSecond)
  {
    text += separator;
    text += state.unit == "B" ? BytesText(*state.perSecond) + "/s"
                              : CountText(*state.perSecond) + " " + state.unit + "/s";
  }
  if (state.left)
  {
    text += separator;
    text += "about " + DurationText(std::max(1.0, std::ceil(state.left->seconds))) + " left";
    text += state.left->whole ? "" : " of " + state.step;
  }
  return text;
}

}

std::string DurationText(double seconds)
{
  const auto whole = static_cast<unsigned long long>(std::max(0.0, seconds));
  const auto two = [](unsigned long long large, const char* largeUnit, unsigned long long small,
                     const char* smallUnit)
  { return std::to_string(large) + largeUnit + std::to_string(small) + smallUnit; };
  return whole < 120    ? std::to_string(whole) + " s"
         : whole < 7200 ? two(whole / 60, " min ", whole % 60, " s")
                        : two(whole / 3600, " h ", whole / 60 % 60, " min");
}

std::string BytesText(double bytes)
{
  static constexpr const char* units[] = { " B", " kB", " MB", " GB" };
  return Shortened(bytes, units);
}

std::string CountText(double count)
{
  static constexpr const char* units[] = { "", " k", " M", " G" };
  return Shortened(count, units);
}

std::string ProgressText(const ProgressState& state)
{
  return state.step + (TellsSomething(state.fraction) ? " " + PercentText(state.fraction) : "") +
         Rest(state, ", ");
}

std::string ProgressBar(const ProgressState& state, std::size_t columns)
{
  constexpr std::size_t width = 30;
  const bool tells = TellsSomething(state.fraction);
  const auto done = static_cast<std::size_t>(state.fraction * width);
  const std::string bar = tells ? std::string(done, '#') + std::string(width - done, ' ')
                                : MovingBar(width, state.seconds);
  std::string text =
    state.step + std::string(state.step.size() < 8 ? 8 - state.step.size() : 0, ' ');
  text += " [" + bar + "] ";
  const std::string percent = tells ? PercentText(state.fraction) : "";
  text += std::string(percent.size() < 5 ? 5 - percent.size() : 0, ' ') + percent;
  text += Rest(state, "  ");
  return text.substr(0, columns);
}

ProgressReporter::ProgressReporter(
  std::string_view program, bool quiet, std::vector<StepShare> shares)
  : Program(program)
  , Terminal(::isatty(STDERR_FILENO) == 1)
  , Begin(std::chrono::steady_clock::now())
  , Estimate(std::move(shares))
{
  if (!quiet)
  {
    this->Printer = std::thread([this]() { this->PrintUntilDone(); });
  }
}

ProgressReporter::~ProgressReporter()
{
  {
    const std::lock_guard lock(this->Mutex);
    this->Done = true;
  }
  this->Ended.notify_one();
  if (this->Printer.joinable())
  {
    this->Printer.join();
  }
  if (this->LineOpen)
  {
    std::fputs("\r\033[K", stderr);
  }
}

bool ProgressReporter::operator()(std::string_view step, double fraction)
{
  {
    const std::lock_guard lock(this->Mutex);
    this->Step = step;
    this->Fraction = std::clamp(fraction, 0.0, 1.0);
    this->Reported = this->Now();
    this->Estimate.Add(step, this->Fraction, this->Reported);
  }
  return !Interrupted();
}

void ProgressReporter::SetAmount(const std::string& step, StepAmount amount)
{
  const std::lock_guard lock(this->Mutex);
  this->Amounts[step] = std::move(amount);
}

double ProgressReporter::Now() const
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - this->Begin).count();
}

void ProgressReporter::PrintUntilDone()
{
  std::unique_lock lock(this->Mutex);
  const auto pause = this->Terminal ? pauseOnTerminal : pauseOfLines;
  while (!this->Ended.wait_for(lock, pause, [this]() { return this->Done; }))
  {
    if (!this->Step.empty())
    {
      this->Print();
    }
  }
}

ProgressState ProgressReporter::State() const
{
  ProgressState state{ this->Step, this->Fraction, this->Now(), {}, {}, this->Estimate.Left() };
  if (state.left)
  {
    state.left->seconds -= state.seconds - this->Reported;
  }
  const auto own = this->Amounts.find(this->Step);
  const auto amount = own == this->Amounts.end() ? this->Amounts.find("") : own;
  if (const auto rate = this->Estimate.Rate(); rate && amount != this->Amounts.end())
  {
    state.perSecond = *rate * amount->second.amount;
    state.unit = amount->second.unit;
  }
  return state;
}

void ProgressReporter::Print()
{
  const ProgressState state = this->State();
  if (this->Terminal)
  {
    std::fprintf(stderr, "\r\033[K%s", ProgressBar(state, TerminalColumns() - 1).c_str());
    this->LineOpen = true;
  }
  else
  {
    std::fprintf(stderr, "%s: %s\n", this->Program.c_str(), ProgressText(state).c_str());
  }
}

}
