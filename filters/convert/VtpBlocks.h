// SPDX-License-Identifier: BSD-3-Clause
// Checks the bytes of a .vtp's arrays before VTK reads them. VTK decodes any bytes as base64, and
// reads beyond the end of appended data. Part of step "convert".
#pragma once

#include "filters/core/Result.h"
#include "filters/meshio/ByteSource.h"

#include <functional>
#include <string_view>

namespace kdstream
{

// Reads the file once. keep: is called with all bytes of the file except blanks within base64,
// which VTK cannot read. Returns whether there are such blanks. Errors: keep's; InputOutput;
// InvalidInput, naming an array and its line, for a length or offset beyond the array's bytes, for
// bytes beyond the length, and for bytes that are not base64; InvalidInput also for appended data
// that do not end. Anything that is not XML is left to VTK.
using KeptBytes = std::function<Status(std::string_view)>;
Result<bool> CheckVtpBlocks(ByteSource& source, const KeptBytes& keep);

}
