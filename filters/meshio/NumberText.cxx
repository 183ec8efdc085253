// Numbers as decimal text, the same in every locale: for the text formats of step "read".
#include "filters/meshio/NumberText.h"

#include <algorithm>
#include <cstdint>

namespace kdstream
{

bool IsBelowOne(std::string_view word)
{
  if (word.starts_with('-'))
  {
    word.remove_prefix(1);
  }
  const std::size_t exponentAt = std::min(word.find_first_of("eE"), word.size());
  const std::string_view digits = word.substr(0, exponentAt);
  const std::size_t first = digits.find_first_of("123456789");
  if (first == std::string_view::npos)
  {
    return true;
  }
  // The power of ten of the first digit that counts, before the written exponent.
  const auto point = static_cast<std::int64_t>(std::min(digits.find('.'), digits.size()));
  const auto place = static_cast<std::int64_t>(first);
  std::int64_t power = place < point ? point - place - 1 : point - place;
  if (exponentAt < word.size())
  {
    std::string_view exponent = word.substr(exponentAt + 1);
    if (exponent.starts_with('+'))
    {
      exponent.remove_prefix(1);
    }
    std::int32_t written = 0;
    const auto parsed =
      std::from_chars(exponent.data(), exponent.data() + exponent.size(), written);
    if (parsed.ec == std::errc::result_out_of_range)
    {
      return exponent.starts_with('-');
    }
    power += written;
  }
  return power < 0;
}

}
