// SPDX-License-Identifier: BSD-3-Clause
// Units of length, as named in models.
#pragma once

#include <optional>
#include <string>

namespace kdstream
{

// The length in metres of the unit of a model's coordinates ("mm", "feet"); nothing if the unit is
// not known.
std::optional<double> MetresOfUnit(const std::string& unit);

}
