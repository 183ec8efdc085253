// SPDX-License-Identifier: BSD-3-Clause
// Opening what the command line names: see SourceOpening.h.
#include "viewer/desktop/window/SourceOpening.h"

#include <filesystem>
#include <iostream>
#include <utility>

namespace kdstream
{

SourceOpening::SourceOpening(std::string program, const ViewOptions& options)
  : Program(std::move(program))
  , Options(options)
  , Ending(std::async(std::launch::async, [this] { return this->Open(); }))
{
}

SourceOpening::~SourceOpening()
{
  this->GivenUp = true;
}

std::string SourceOpening::Progress() const
{
  const std::lock_guard lock(this->Mutex);
  const std::string name = NamesServer(this->Options.source)
                             ? this->Options.source
                             : std::filesystem::path(this->Options.source).filename().string();
  return "Opening " + name + (this->Told.empty() ? "" : ": " + this->Told);
}

std::optional<Result<OpenedSources>> SourceOpening::Take()
{
  if (!this->Ending.valid() ||
      this->Ending.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
  {
    return std::nullopt;
  }
  return this->Ending.get();
}

Result<OpenedSources> SourceOpening::Open()
{
  const auto report = [this](std::string_view progress)
  {
    const std::lock_guard lock(this->Mutex);
    this->Told = progress;
    return !this->GivenUp;
  };
  const auto warn = [program = this->Program](std::string_view sentence)
  { std::cerr << program + ": warning: " + std::string(sentence) + "\n"; };
  OpenedSources opened;
  auto models = OpenSource(this->Options, report, warn);
  KDSTREAM_TRY(models);
  opened.models = std::move(*models);
  if (opened.models->Models().size() > 1)
  {
    auto previews = OpenSource(this->Options, report, warn);
    KDSTREAM_TRY(previews);
    opened.previews = std::move(*previews);
  }
  return opened;
}

}
