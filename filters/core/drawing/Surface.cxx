// SPDX-License-Identifier: BSD-3-Clause
// The drawing rule: see Surface.h. Implemented in SurfaceParts.cxx.
#include "filters/core/drawing/Surface.h"

#include "filters/core/drawing/SurfaceParts.h"

namespace kdstream
{

Result<Surface> DrawSurface(const Cut& cut, const PieceLookup& lookup, const Execution& execution)
{
  SurfaceParts parts;
  KDSTREAM_TRY(parts.GoTo(cut, lookup, execution));
  KDSTREAM_TRY(execution.Report("glue", 1));
  return MergeParts(parts.Parts());
}

}
