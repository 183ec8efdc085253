// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/desktop/CheckColors.h"

#include "filters/program/UsageMessage.h"

#include <string>
#include <vector>

namespace kdstream
{

Status CheckColors(const ColorChoice& colors, const ScalarDescriptions& scalars)
{
  if (ColoringOf(colors, scalars).kind == colors.coloring)
  {
    return {};
  }
  std::string listed;
  std::vector<std::string> names;
  for (const ScalarDescription& scalar : scalars)
  {
    listed += (listed.empty() ? "'" : ", '") + scalar.name + "'";
    names.push_back(scalar.name);
  }
  const std::string meant = DidYouMean(colors.attribute, names);
  return Error{ ErrorCode::NotFound,
    "the model has no array of numbers '" + colors.attribute + "' to colour it by; it has " +
      (listed.empty() ? "none" : listed) +
      (meant.empty() ? "; arrays of faces cannot be shown" : meant) };
}

}
