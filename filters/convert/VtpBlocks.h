// SPDX-License-Identifier: BSD-3-Clause
// Checks the bytes of a .vtp's arrays before VTK reads them: it decodes base64 whatever is in it,
// and reads on after the end of appended data. Part of step "convert".
#pragma once

#include "filters/core/Result.h"
#include "filters/meshio/ByteSource.h"

#include <functional>
#include <string_view>

namespace kdstream
{

// Goes through the file once. keep: is given all its bytes but the blanks within base64, which VTK
// cannot read. True if there are such blanks. Errors: keep's; InputOutput; InvalidInput, naming an
// array and its line, for a length or offset beyond its bytes, bytes beyond its length, and what is
// not base64; where the appended data do not end. What is not XML is left to VTK.
using KeptBytes = std::function<Status(std::string_view)>;
Result<bool> CheckVtpBlocks(ByteSource& source, const KeptBytes& keep);

}
