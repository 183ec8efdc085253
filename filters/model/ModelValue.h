// SPDX-License-Identifier: BSD-3-Clause
// The description that servers tell as a JSON value, for messages that hold one. Internal: not
// installed.
#pragma once

#include "filters/model/Json.h"
#include "filters/model/JsonWriter.h"
#include "filters/model/ModelDescription.h"

namespace kdstream
{

// Writes the model as one value.
void PutModel(JsonWriter& json, const ModelDescription& model);

// Errors: InvalidInput naming the member that is wrong.
Result<ModelDescription> ModelFromJson(const JsonValue& json);

}
