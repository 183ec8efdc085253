// SPDX-License-Identifier: BSD-3-Clause
// Repeats work that may wait for a disk, on a thread of its own. While a disk blocks this work, the
// program continues to serve and to handle its signals.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

namespace kdstream
{

class BackgroundJob
{
public:
  // isAsked: whether Ask was called; false if only the interval has passed. Must not throw.
  using Work = std::function<void(bool isAsked)>;

  // Does the work whenever Ask is called and, with an interval, whenever the interval has passed.
  explicit BackgroundJob(Work work, std::optional<std::chrono::milliseconds> interval = {});
  // Waits until the work is done, also for a disk that blocks it.
  ~BackgroundJob();
  BackgroundJob(const BackgroundJob&) = delete;
  BackgroundJob& operator=(const BackgroundJob&) = delete;

  // Has the work done once more, soon. From any thread; never waits.
  void Ask();
  // Does the work that Ask has requested, and then ends. False if the work has not ended within
  // `time`, as when a disk blocks it.
  bool End(std::chrono::milliseconds time);

private:
  void Run();

  const Work Does;
  const std::optional<std::chrono::milliseconds> Interval;
  std::mutex Mutex; // for the members below
  std::condition_variable Changed;
  bool Asked = false, Ending = false, Ended = false;
  std::thread Thread;
};

}
