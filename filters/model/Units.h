// SPDX-License-Identifier: BSD-3-Clause
// Units of lengths, as models name theirs.
#pragma once

#include <optional>
#include <string>

namespace kdstream
{

// How many metres a unit is that the model's coordinates are in ("mm", "feet"); nothing where the
// text names none that is known.
std::optional<double> MetresOfUnit(const std::string& unit);

}
