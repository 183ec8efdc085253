// SPDX-License-Identifier: BSD-3-Clause
// Measures how long the steps of a build take.
#pragma once

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{

// Adds the time since the last call to a named step.
class StepClock
{
public:
  void Finish(const std::string& step)
  {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - this->Last).count();
    this->Last = now;
    const auto found = std::find_if(this->Steps.begin(), this->Steps.end(),
      [&](const auto& entry) { return entry.first == step; });
    if (found == this->Steps.end())
    {
      this->Steps.emplace_back(step, seconds);
    }
    else
    {
      found->second += seconds;
    }
  }
  std::vector<std::pair<std::string, double>> Take()
  {
    double total = 0;
    for (const auto& entry : this->Steps)
    {
      total += entry.second;
    }
    this->Steps.emplace_back("total", total);
    return std::move(this->Steps);
  }

private:
  std::chrono::steady_clock::time_point Last = std::chrono::steady_clock::now();
  std::vector<std::pair<std::string, double>> Steps;
};

}
