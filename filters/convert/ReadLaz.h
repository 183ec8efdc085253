// SPDX-License-Identifier: BSD-3-Clause
// Compressed LAS.
#pragma once

#include "filters/convert/ForeignMesh.h"
#include "filters/convert/LasHeader.h"

namespace kdstream
{

// By LASzip, where that was there when KdStream was built. No memory is taken for what the header
// claims. Errors: InvalidInput in LASzip's words, and at which point; Cancelled.
Result<ForeignMesh> ReadLaz(
  const std::filesystem::path& file, const LasHeader& header, const Execution& execution);

}
