// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/Extent.h"

#include <string>

namespace kdstream
{

Status CheckExtent(const Box& box)
{
  for (std::size_t k = 0; k < 3; ++k)
  {
    if (box.hi[k] - box.lo[k] > mostExtent)
    {
      return Error{ ErrorCode::InvalidInput,
        std::string("the mesh spans more than 2^127 (1.7e38) along ") + "xyz"[k] +
          ", the limit for computing levels" };
    }
  }
  return {};
}

}
