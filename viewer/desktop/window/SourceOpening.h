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
  // The same source again, for previews; null if there is only one model.
  std::unique_ptr<ModelSource> previews;
  std::string warnings; // a sentence a line
};

class SourceOpening
{
public:
  SourceOpening(std::string program, const ViewOptions& options);
  // Gives up: stops a build, which leaves nothing behind, or stops waiting for a server.
  ~SourceOpening();
  SourceOpening(const SourceOpening&) = delete;
  SourceOpening& operator=(const SourceOpening&) = delete;

  // What is being done.
  std::string Progress() const;
  // Each warning is also printed on stderr. Returns the result once, when opening has ended; before
  // that nothing.
  std::optional<Result<OpenedSources>> Take();

private:
  struct State;

  std::string Name; // of what is opened
  bool IsServer;
  std::shared_ptr<State> Shared;
  std::thread Thread;
};

}
