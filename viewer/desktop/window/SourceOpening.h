// SPDX-License-Identifier: BSD-3-Clause
// Opening what the command line names, while the window goes on: on a thread of its own.
#pragma once

#include "viewer/desktop/OpenSource.h"

#include <memory>
#include <optional>
#include <string>
#include <thread>

namespace kdstream
{

struct OpenedSources
{
  std::unique_ptr<ModelSource> models;
  std::unique_ptr<ModelSource> previews; // the same once more; null where there is one model only
  std::string warnings;                  // a sentence a line
};

class SourceOpening
{
public:
  SourceOpening(std::string program, const ViewOptions& options);
  // Gives up: a build is stopped and leaves nothing behind, a server is waited for no more.
  ~SourceOpening();
  SourceOpening(const SourceOpening&) = delete;
  SourceOpening& operator=(const SourceOpening&) = delete;

  // What is being done.
  std::string Progress() const;
  // Each warning is reported on stderr too.
  // How it ended, once: nothing until then.
  std::optional<Result<OpenedSources>> Take();

private:
  struct State;

  std::string Name; // of what is opened
  bool IsServer;
  std::shared_ptr<State> Shared;
  std::thread Thread;
};

}
