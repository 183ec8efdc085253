// SPDX-License-Identifier: BSD-3-Clause
// The output of kdstream-store info.
#pragma once

#include "filters/model/ModelDescription.h"

#include <cstdint>

namespace kdstream
{

// Prints to standard output, with a line for each fact, and a table of the levels if there are any.
// bytes: size of the file.
void PrintStoreInfo(const ModelDescription& info, std::uintmax_t bytes);

}
