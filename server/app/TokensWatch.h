// SPDX-License-Identifier: BSD-3-Clause
// Watches the file of --tokens on a thread of its own: a revoked token must stop working within a
// second, even while the rest of the server reads stores or ends.
#pragma once

#include "server/app/TokensFile.h"

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

namespace kdstream
{

class TokensWatch
{
public:
  // warn: called with the reason why the file cannot be read, from any thread.
  using Warn = std::function<void(const std::string& what)>;

  TokensWatch(TokensFile file, Warn warn);
  ~TokensWatch();
  TokensWatch(const TokensWatch&) = delete;
  TokensWatch& operator=(const TokensWatch&) = delete;

  // Reads it now, whether it has changed or not. From any thread.
  void Reload();

private:
  void Run();
  void Tell(const Status& status);

  TokensFile File;
  Warn Warning;
  std::mutex Mutex;
  std::condition_variable Changed;
  bool Ending = false;
  std::thread Thread;
};

}
