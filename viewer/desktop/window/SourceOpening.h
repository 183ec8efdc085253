// SPDX-License-Identifier: BSD-3-Clause
// Opens what the command line names on a thread of its own, so that the window goes on.
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
  // The same source again, for previews; null if there is only one model.
  std::unique_ptr<ModelSource> previews;
  std::string warnings; // one sentence per line
};

class SourceOpening
{
public:
  SourceOpening(std::string program, const ViewOptions& options);
  // Gives up: stops a build, which then leaves nothing behind, or stops waiting for a server.
  ~SourceOpening();
  SourceOpening(const SourceOpening&) = delete;
  SourceOpening& operator=(const SourceOpening&) = delete;

  // A text about the progress.
  std::string Progress() const;
  // Returns the result once, when opening has ended; nothing before and after that. Each warning is
  // also printed on stderr.
  std::optional<Result<OpenedSources>> Take();

private:
  struct State;

  std::string Name; // of the source
  bool IsServer;
  std::shared_ptr<State> Shared;
  std::thread Thread;
};

}
