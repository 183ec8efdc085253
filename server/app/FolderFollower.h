// SPDX-License-Identifier: BSD-3-Clause
// Reads the folder of stores on a thread of its own: first at the start, and then whenever the
// folder may have changed. A disk that hangs blocks only this thread; the program continues to
// serve and to handle its signals.
#pragma once

#include "filters/core/Result.h"
#include "server/session/StoreCatalog.h"

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace kdstream
{

class FolderFollower
{
public:
  // Called with errors, from the follower's thread.
  using Warn = std::function<void(const std::string& what)>;

  // Begins to read the folder. REQUIRES: the catalog outlives this object.
  FolderFollower(StoreCatalog& catalog, std::filesystem::path folder, Warn warn);
  // Waits for its thread, also for a disk that blocks it.
  ~FolderFollower();
  FolderFollower(const FolderFollower&) = delete;
  FolderFollower& operator=(const FolderFollower&) = delete;

  // The result of the first reading. Waits for it, at most for this time; nothing if it has not
  // ended by then.
  std::optional<Status> AwaitFirst(std::chrono::milliseconds time);

  // From now on notices changes of the folder, and reads it again.
  void Follow();
  // Reads the whole folder again. done: called after that, from the follower's thread.
  void ReadAnew(std::function<void()> done);

  // Ends the thread. False if it has not ended within `time`, as when a disk blocks it.
  bool End(std::chrono::milliseconds time);

private:
  void Run();
  void Guarded(const std::function<void()>& work) const;
  void Wake() const;
  void Wait(int watched) const;

  StoreCatalog& Catalog;
  const std::filesystem::path Folder;
  const Warn Tell;
  int Bell = -1;    // an eventfd: there is something to do
  std::mutex Mutex; // for the members below
  std::condition_variable Changed;
  std::optional<Status> First;
  bool Follows = false, Ending = false, Ended = false;
  bool Anew = false;
  std::function<void()> Done; // called after reading the whole folder again
  std::thread Thread;
};

}
