// SPDX-License-Identifier: BSD-3-Clause
// Changes the texts and directions in a store's description of its model, without a new build.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/store/Store.h"

#include <filesystem>
#include <optional>
#include <string>

namespace kdstream
{

// Texts and directions that replace those of a store. What is not given stays; an empty text
// removes the old one. If a direction is given, up direction and first view count as known, not
// guessed. REQUIRES: `up` and `view` are directions (DirectionOf).
struct StoreTexts
{
  std::optional<std::string> title{};
  std::optional<std::string> credit{};
  std::optional<std::string> license{};
  std::optional<std::string> unit{};
  std::optional<std::string> description{};
  std::optional<Vec3> up{}, view{};
};

// Replaces texts and directions; tree, levels, partitions and digest stay. A changed copy replaces
// the store, with the same permissions. The old file is never changed, because a server that has it
// open treats it as immutable. Whatever interrupts this function, the store is either the old or
// the new one. Needs disk space for the copy. O(bytes of the store); almost nothing if the file
// system shares blocks between files. Errors: those of Store::Open; Unsupported for a store of an
// earlier version; InputOutput, also if another process has replaced the store meanwhile;
// Cancelled.
Result<ModelDescription> EditStore(
  const std::filesystem::path& store, const StoreTexts& texts, const Execution& execution = {});

}
