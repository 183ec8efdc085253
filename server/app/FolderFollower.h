// SPDX-License-Identifier: BSD-3-Clause
// Reads the folder of stores on a thread of its own, first at the start and then whenever it may
// have changed. A disk that hangs blocks only this thread: the program continues to serve and to
// handle its signals.
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
  // Called with errors, from its thread.
  using Warn = std::function<void(const std::string& what)>;

  // Begins to read the folder. REQUIRES: the catalog outlives it.
  FolderFollower(StoreCatalog& catalog, std::filesystem::path folder, Warn warn);
  // Waits for the disk.
  ~FolderFollower();
  FolderFollower(const FolderFollower&) = delete;
  FolderFollower& operator=(const FolderFollower&) = delete;

  // The result of the first reading. Waits for it, at most this time.
  std::optional<Status> AwaitFirst(std::chrono::milliseconds time);

  // From now on reads what changes.
  void Follow();
  // Reads all again; done: called after that, from its thread.
  void ReadAnew(std::function<void()> done);

  // Ends it. False where a disk holds it for longer than `time`.
  bool End(std::chrono::milliseconds time);

private:
  void Run();
  void Guarded(const std::function<void()>& work) const;
  void Wake() const;
  void Wait(int watched) const;

  StoreCatalog& Catalog;
  const std::filesystem::path Folder;
  const Warn Tell;
  int Bell = -1;    // an event: there is something to do
  std::mutex Mutex; // for what follows
  std::condition_variable Changed;
  std::optional<Status> First;
  bool Follows = false, Ending = false, Ended = false;
  bool Anew = false;
  std::function<void()> Done; // after that
  std::thread Thread;
};

}
