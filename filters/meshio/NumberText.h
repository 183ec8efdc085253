// Numbers as decimal text, the same in every locale: for the text formats of step "read".
#pragma once

#include <charconv>
#include <string_view>
#include <system_error>
#include <type_traits>

namespace kdstream
{

enum class NumberTextError
{
  None,
  NotANumber, // the word is not wholly a number of the kind
  OutOfRange  // it is one, too large for its type
};

// True if the decimal number `word` is nearer to zero than one.
// REQUIRES: std::from_chars took the whole word for a floating-point number.
bool IsBelowOne(std::string_view word);

// Reads the whole of `word` as a T. Floating-point text is rounded once, to the nearest T; what is
// too small becomes zero; "nan" and "inf" are read. Integers have no fraction and no exponent. A
// leading '+' is allowed.
template <class T>
NumberTextError ParseNumber(std::string_view word, T& value)
{
  if (word.size() > 1 && word[0] == '+' && word[1] != '-')
  {
    word.remove_prefix(1);
  }
  const char* end = word.data() + word.size();
  const std::from_chars_result parsed = std::from_chars(word.data(), end, value);
  if (parsed.ec == std::errc::invalid_argument || parsed.ptr != end)
  {
    return NumberTextError::NotANumber;
  }
  if (parsed.ec == std::errc())
  {
    return NumberTextError::None;
  }
  if constexpr (std::is_floating_point_v<T>)
  {
    // from_chars does not tell too small from too large.
    if (IsBelowOne(word))
    {
      value = word[0] == '-' ? -T{ 0 } : T{ 0 };
      return NumberTextError::None;
    }
  }
  return NumberTextError::OutOfRange;
}

// Coordinates that were written as decimals: whether floats would give all of them again, if they
// were written with as many decimals.
class DecimalPrecision
{
public:
  // What is no number makes no difference that can be relied on.
  void Add(std::string_view word);
  bool FloatsSuffice() const { return this->Suffice; }

private:
  bool Suffice = true;
};

}
