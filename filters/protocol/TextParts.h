// SPDX-License-Identifier: BSD-3-Clause
// Small strict parsers that paths and blob names share. Internal to the protocol.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream::protocol
{

// Splits "a/b/c" into its parts. Empty parts are kept, so that "a//b" does not match any known
// form.
std::vector<std::string_view> SplitPath(std::string_view path);

// A decimal number in [lowest, highest]: digits only, no sign, no leading zero except "0" itself.
std::optional<std::uint32_t> ParseDecimal(
  std::string_view text, std::uint32_t lowest, std::uint32_t highest);

}
