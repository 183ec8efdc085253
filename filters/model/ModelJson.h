// SPDX-License-Identifier: BSD-3-Clause
// A model's description as JSON and back, in the forms that there are: told by servers, kept in
// stores, printed as statistics. What they share is written and read in one place
// (ModelMembers.h).
//
// Doubles survive the way bit for bit, so that all compute with the same grid and box.
#pragma once

#include "filters/core/Result.h"
#include "filters/model/JsonWriter.h"
#include "filters/model/ModelDescription.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// The most bytes of model.json that a parser takes, and of the list of models.
inline constexpr std::size_t maximumModelBytes = std::size_t{ 1 } << 20;
inline constexpr std::size_t maximumModelListBytes = std::size_t{ 16 } << 20;

// model.json, and the models of models.json.
std::string WriteModel(const ModelDescription& model);
std::string WriteModelList(
  const std::vector<ModelSummary>& models, const SiteDescription& site = {});

// Errors: LimitExceeded for too many bytes; InvalidInput naming the member that is missing, of
// another type or out of its range. Unknown members are ignored.
Result<ModelDescription> ParseModel(std::string_view text);
Result<std::vector<ModelSummary>> ParseModelList(std::string_view text);

// The row "model" of a store's metadata; all but the id. number: how its doubles are written.
std::string WriteStoredModel(const ModelDescription& model, std::string (*number)(double));
// Errors: Damaged, naming the member that is wrong.
Result<ModelDescription> ParseStoredModel(std::string_view text);

// Into an object: what kdstream-store info --json and kdstream-build --stats say of a store.
void PutStatistics(JsonWriter& json, const ModelDescription& model, std::uint64_t storeBytes);

}
