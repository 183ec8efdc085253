// SPDX-License-Identifier: BSD-3-Clause
// Does something again and again on a thread of its own: what may wait for a disk. The program
// continues to serve, and to handle its signals, while a disk blocks it.
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
  // isAsked: by Ask, not by the interval. Must not throw.
  using Work = std::function<void(bool isAsked)>;

  // Does it whenever it is asked for and, with an interval, whenever that has passed.
  explicit BackgroundJob(Work work, std::optional<std::chrono::milliseconds> interval = {});
  // Waits for the disk.
  ~BackgroundJob();
  BackgroundJob(const BackgroundJob&) = delete;
  BackgroundJob& operator=(const BackgroundJob&) = delete;

  // Does it once more, soon. From any thread; never waits.
  void Ask();
  // Ends, after what it was asked for. False where a disk holds it for longer than `time`.
  bool End(std::chrono::milliseconds time);

private:
  void Run();

  const Work Does;
  const std::optional<std::chrono::milliseconds> Interval;
  std::mutex Mutex; // for what follows
  std::condition_variable Changed;
  bool Asked = false, Ending = false, Ended = false;
  std::thread Thread;
};

}
