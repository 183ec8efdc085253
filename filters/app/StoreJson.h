// What a store says of itself as JSON, with the keys of doc/cli.md#info: for `kdstream-build
// --stats` and `kdstream-store info`.
#pragma once

#include "filters/store/Store.h"

#include <nlohmann/json.hpp>

namespace kdstream
{

nlohmann::json StoreToJson(const StoreInfo& info, std::uint64_t storeBytes);

}
