// SPDX-License-Identifier: BSD-3-Clause
// Changing what a store says of its model, without building it again.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/store/Store.h"

#include <filesystem>
#include <optional>
#include <string>

namespace kdstream
{

// Each that is given takes the place of the store's; an empty text removes it. What is up and the
// first view are taken to be known then. REQUIRES: `up` and `view` are directions (DirectionOf).
struct StoreTexts
{
  std::optional<std::string> title{};
  std::optional<std::string> credit{};
  std::optional<std::string> license{};
  std::optional<std::string> unit{};
  std::optional<std::string> description{};
  std::optional<Vec3> up{}, view{};
};

// Tree, levels, partitions and digest stay. A changed copy takes the store's place as a whole, with
// its permissions. A server that has the store open treats it as immutable, so the old file never
// changes; and whatever ends this function leaves the old store or the new one. Needs disk space
// for the copy. O(bytes of the store); where the file system shares blocks between files, next to
// nothing. Errors: those of Store::Open; Unsupported for a store of an earlier version;
// InputOutput, also where another process has replaced the store meanwhile; Cancelled.
Result<ModelDescription> EditStore(
  const std::filesystem::path& store, const StoreTexts& texts, const Execution& execution = {});

}
