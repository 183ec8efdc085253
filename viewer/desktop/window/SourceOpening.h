// SPDX-License-Identifier: BSD-3-Clause
// Opening what the command line names, while the window goes on: on a thread of its own.
#pragma once

#include "viewer/desktop/OpenSource.h"

#include <atomic>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace kdstream
{

struct OpenedSources
{
  std::unique_ptr<ModelSource> models;
  std::unique_ptr<ModelSource> previews; // the same once more; null where there is one model only
};

class SourceOpening
{
public:
  SourceOpening(std::string program, const ViewOptions& options);
  // Gives up.
  ~SourceOpening();

  // What is being done.
  std::string Progress() const;
  // How it ended, once: nothing until then.
  std::optional<Result<OpenedSources>> Take();

private:
  Result<OpenedSources> Open();

  std::string Program;
  ViewOptions Options;
  std::atomic<bool> GivenUp{ false };
  mutable std::mutex Mutex;
  std::string Told;
  std::future<Result<OpenedSources>> Ending;
};

}
