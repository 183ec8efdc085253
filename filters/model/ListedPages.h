// SPDX-License-Identifier: BSD-3-Clause
// Where the models of a list have pages of their own (doc/protocol.md#pages).
#pragma once

#include <string>
#include <string_view>

namespace kdstream
{

// A list of models (WriteModelList) that says so: `folder` is below that of the viewer, with a
// slash at its end. Empty: the list stays as it is.
std::string WithPages(std::string list, std::string_view folder);

}
