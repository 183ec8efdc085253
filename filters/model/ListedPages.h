// SPDX-License-Identifier: BSD-3-Clause
// Says whether the models of a list have their own pages (doc/protocol.md#pages).
#pragma once

#include <string>
#include <string_view>

namespace kdstream
{

// Adds the folder of the pages to a list of models (WriteModelList). `folder` is relative to that
// of the viewer, with a slash at its end. If it is empty, the list stays unchanged.
std::string WithPages(std::string list, std::string_view folder);

}
