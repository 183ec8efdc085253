// SPDX-License-Identifier: BSD-3-Clause
// Reads compressed LAS.
#pragma once

#include "filters/convert/ForeignMesh.h"
#include "filters/convert/LasHeader.h"

namespace kdstream
{

// Reads LAZ by LASzip, if KdStream was built with it. Allocates no memory because of claims in the
// header. Errors: InvalidInput with LASzip's message and the number of the point; Cancelled.
Result<ForeignMesh> ReadLaz(
  const std::filesystem::path& file, const LasHeader& header, const Execution& execution);

}
