// SPDX-License-Identifier: BSD-3-Clause
// Opens what the command line names: see SourceOpening.h.
#include "viewer/desktop/window/SourceOpening.h"

#include "filters/core/CaughtError.h"

#include <filesystem>
#include <iostream>
#include <mutex>
#include <utility>

namespace kdstream
{

// Shared by the thread and the window; it exists until both have released it.
struct SourceOpening::State
{
  std::mutex mutex; // guards everything below
  bool givenUp = false;
  std::string reported;
  std::optional<Result<OpenedSources>> ended;
};

namespace
{

Result<OpenedSources> OpenBoth(const ViewOptions& options,
  const std::function<bool(std::string_view progress)>& report,
  const std::function<void(std::string_view sentence)>& warn)
{
  OpenedSources opened;
  auto models = OpenSource(options, report, warn);
  KDSTREAM_TRY(models);
  opened.models = std::move(*models);
  if (opened.models->Models().size() > 1)
  {
    // The warnings were already reported when `models` was opened.
    auto previews = OpenSource(options, report, [](std::string_view) {});
    KDSTREAM_TRY(previews);
    opened.previews = std::move(*previews);
  }
  return opened;
}

}

SourceOpening::SourceOpening(std::string program, const ViewOptions& options)
  : Name(NamesServer(options.source) ? options.source
                                     : std::filesystem::path(options.source).filename().string())
  , IsServer(NamesServer(options.source))
  , Shared(std::make_shared<State>())
  , Thread(
      [shared = this->Shared, program = std::move(program), options]
      {
        const auto report = [&shared](std::string_view progress)
        {
          const std::lock_guard lock(shared->mutex);
          shared->reported = progress;
          return !shared->givenUp;
        };
        std::string warnings;
        const auto warn = [&](std::string_view sentence)
        {
          std::cerr << program + ": warning: " + std::string(sentence) + "\n";
          warnings += (warnings.empty() ? "" : "\n") + std::string(sentence);
        };
        Result<OpenedSources> ended = Error{};
        try
        {
          ended = OpenBoth(options, report, warn);
        }
        catch (...)
        {
          ended = CaughtError();
        }
        if (ended)
        {
          ended->warnings = std::move(warnings);
        }
        const std::lock_guard lock(shared->mutex);
        shared->ended = std::move(ended);
      })
{
}

SourceOpening::~SourceOpening()
{
  {
    const std::lock_guard lock(this->Shared->mutex);
    this->Shared->givenUp = true;
  }
  if (this->IsServer)
  {
    this->Thread.detach(); // it may wait 40 s for a server that does not answer
  }
  else
  {
    this->Thread.join();
  }
}

std::string SourceOpening::Progress() const
{
  const std::lock_guard lock(this->Shared->mutex);
  return "Opening " + this->Name +
         (this->Shared->reported.empty() ? "" : ": " + this->Shared->reported);
}

std::optional<Result<OpenedSources>> SourceOpening::Take()
{
  const std::lock_guard lock(this->Shared->mutex);
  return std::exchange(this->Shared->ended, std::nullopt);
}

}
