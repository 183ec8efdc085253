// SPDX-License-Identifier: BSD-3-Clause
// A model's description as JSON, and back. There is one form: a store keeps it with the facts of
// the build ("build"), a server sends it with the model's id, and viewers read it. Statistics are
// for people and scripts.
//
// Doubles come back bit for bit, so that server and viewers compute with the same grid and box.
#pragma once

#include "filters/core/Result.h"
#include "filters/model/Json.h"
#include "filters/model/JsonWriter.h"
#include "filters/model/ModelDescription.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// The largest size in bytes of model.json, and of the list of models, that a parser accepts.
inline constexpr std::size_t maximumModelBytes = std::size_t{ 1 } << 20;
inline constexpr std::size_t maximumModelListBytes = std::size_t{ 16 } << 20;

// Writes model.json; and the models of models.json.
std::string WriteModel(const ModelDescription& model);
std::string WriteModelList(
  const std::vector<ModelSummary>& models, const SiteDescription& site = {});

// Errors: LimitExceeded for too many bytes; InvalidInput, naming the member that is missing, of a
// wrong type or out of range. Unknown members are ignored.
Result<ModelDescription> ParseModel(std::string_view text);
Result<std::vector<ModelSummary>> ParseModelList(std::string_view text);
// Checks that ParseModel accepts what WriteModel would write. It may not accept a model from a
// store, because stores allow longer texts. Errors: those of ParseModel.
Status CheckServed(const ModelDescription& model);

// The row "model" of a store's metadata: everything except the id.
std::string WriteStoredModel(const ModelDescription& model);
enum class StoredForm : std::uint8_t
{
  Earlier, // of stores before version 13
  Present
};
// Errors: Damaged, naming the member that is wrong.
Result<ModelDescription> ParseStoredModel(
  std::string_view text, StoredForm form = StoredForm::Present);

// Writes the statistics of a store into an object, for kdstream-store info --json and
// kdstream-build --stats.
void PutStatistics(JsonWriter& json, const ModelDescription& model, std::uint64_t storeBytes);

// Writes the description that servers send, as a value in a message.
void PutModel(JsonWriter& json, const ModelDescription& model);

// Errors: InvalidInput, naming the member that is wrong.
Result<ModelDescription> ModelFromJson(const JsonValue& json);

}
