// SPDX-License-Identifier: BSD-3-Clause
// What kdstream-store info prints about a store.
#pragma once

#include "filters/model/ModelDescription.h"

#include <cstdint>

namespace kdstream
{

// On standard output, a line each; a table of the levels, if there are any. bytes: of the file.
void PrintStoreInfo(const ModelDescription& info, std::uintmax_t bytes);

}
