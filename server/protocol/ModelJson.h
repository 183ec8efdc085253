// A model's description as a JSON value, for messages that hold one. Internal to the protocol.
#pragma once

#include "server/protocol/JsonReader.h"
#include "server/protocol/ModelDescription.h"

namespace kdstream::protocol
{

// Writes the model as one value.
void PutModel(JsonWriter& writer, const ModelDescription& model);

// Errors: InvalidInput naming the member that is wrong.
Result<ModelDescription> ModelFromJson(const Json& json);

}
