// SPDX-License-Identifier: BSD-3-Clause
// The metadata as the text that a store holds. Doubles are spelled as stores have always spelled
// them, by nlohmann's library, so that the same build gives the same file to the byte.
#include "filters/model/ModelJson.h"
#include "filters/store/StoreSchema.h"

#include <nlohmann/json.hpp>

namespace kdstream
{

std::string MetadataOf(const ModelDescription& model)
{
  return WriteStoredModel(model, [](double value) { return nlohmann::json(value).dump(); });
}

}
