// SPDX-License-Identifier: BSD-3-Clause
// One store as a served model.
#pragma once

#include "server/session/Catalog.h"

#include <filesystem>
#include <functional>
#include <string>

namespace kdstream
{

// Told of a damaged blob, once for each. Called from any thread.
using DamageReport = std::function<void(const std::string& what)>;

// Opens the store `file` as the model `id`. If its tree is damaged that is reported, and only
// regions are refused.
// Errors: those of Store::Open; InvalidInput where its metadata cannot be told to a client.
Result<std::shared_ptr<const ServedModel>> OpenStoreModel(
  const std::filesystem::path& file, const std::string& id, DamageReport report);

}
