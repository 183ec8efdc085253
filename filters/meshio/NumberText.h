// SPDX-License-Identifier: BSD-3-Clause
// Numbers as decimal text, the same in every locale: for the text formats of step "read".
#pragma once

#include "filters/core/BitCast.h"

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

namespace kdstream
{

enum class NumberTextError
{
  None,
  NotANumber, // the whole word is not a number of this type
  OutOfRange  // the number is too large for its type
};

// True if the absolute value of the decimal number `word` is below one. REQUIRES: std::from_chars
// reads the whole word as a floating-point number.
bool IsBelowOne(std::string_view word);

// A decimal number as it is written: digits × 10^power.
struct PlainDecimal
{
  std::uint64_t digits = 0;
  int power = 0;
  bool negative = false;
};

// Reads a word of the usual form, -12.5e-3, with at most 18 significant digits: nearly all numbers.
// Returns false for other words, which std::from_chars must read.
inline bool ScanDecimal(std::string_view word, PlainDecimal& decimal)
{
  constexpr std::uint64_t mostDigits = 100000000000000000U; // one more digit fits
  const char* at = word.data();
  const char* const end = at + word.size();
  decimal = {};
  if (at != end && *at == '-')
  {
    decimal.negative = true;
    ++at;
  }
  bool any = false;
  for (bool fraction = false; at != end; ++at)
  {
    const auto digit = static_cast<unsigned>(*at) - '0';
    if (digit < 10)
    {
      if (decimal.digits >= mostDigits)
      {
        return false;
      }
      decimal.digits = 10 * decimal.digits + digit;
      decimal.power -= fraction ? 1 : 0;
      any = true;
    }
    else if (*at == '.' && !fraction)
    {
      fraction = true;
    }
    else
    {
      break;
    }
  }
  if (at == end || !any)
  {
    return any;
  }
  if (*at != 'e' && *at != 'E')
  {
    return false;
  }
  ++at;
  const bool down = at != end && *at == '-';
  at += at != end && (*at == '-' || *at == '+') ? 1 : 0;
  int exponent = 0;
  constexpr int mostExponent = 3; // digits
  const auto size = end - at;
  for (; at != end && static_cast<unsigned>(*at) - '0' < 10; ++at)
  {
    exponent = size <= mostExponent ? 10 * exponent + (*at - '0') : 0;
  }
  decimal.power += down ? -exponent : exponent;
  return at == end && size > 0 && size <= mostExponent;
}

// Returns "nan" or "inf", with its sign, for the forms that old Windows compilers write: -1.#IND,
// 1.#QNAN00, 1.#INF. Empty for all other words.
std::string_view SpecialNumber(std::string_view word);

// Where a comment begins: at the first # that is not part of a number such as 1.#QNAN; npos if
// there is none.
std::size_t FindComment(std::string_view text);

// Returns the number with an e in place of the D or d that Fortran writes before the exponent
// (1.0D+00); empty for all other words.
std::string WithPlainExponent(std::string_view word);

// Powers of ten that doubles hold exactly.
inline constexpr int mostExactPower = 22;
inline constexpr double exactPowers[mostExactPower + 1] = { 1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7,
  1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22 };

// Finds the nearest double if one rounding gives it: the digits and the power of ten must be exact
// doubles. Else returns false.
inline bool NearestDouble(const PlainDecimal& decimal, double& value)
{
  if (decimal.digits > (std::uint64_t{ 1 } << 53) || decimal.power < -mostExactPower ||
      decimal.power > mostExactPower)
  {
    return false;
  }
  const auto digits = static_cast<double>(decimal.digits);
  value =
    decimal.power < 0 ? digits / exactPowers[-decimal.power] : digits * exactPowers[decimal.power];
  value = decimal.negative ? -value : value;
  return true;
}

// Reads a word as std::from_chars does, but faster; false if std::from_chars must read it.
inline bool ReadPlain(std::string_view word, double& value)
{
  PlainDecimal decimal;
  return ScanDecimal(word, decimal) && NearestDouble(decimal, value);
}

inline bool ReadPlain(std::string_view word, float& value)
{
  double nearest = 0;
  if (!ReadPlain(word, nearest))
  {
    return false;
  }
  // The double may have been rounded to a value halfway between two floats. Values here are zero or
  // between 10^-22 and 10^38, where floats are neither denormal nor infinite.
  const std::uint64_t bits = BitCast<std::uint64_t>(nearest);
  constexpr std::uint64_t below = (std::uint64_t{ 1 } << 29) - 1, half = std::uint64_t{ 1 } << 28;
  if ((bits & below) == half)
  {
    return false;
  }
  value = static_cast<float>(nearest);
  return true;
}

// Reads the whole of `word` as a T. Floating-point text is rounded once, to the nearest T; numbers
// that are too small become zero. Also reads "nan", "inf", 1.#QNAN and similar words, and Fortran's
// exponents. Integers have no fraction and no exponent. A leading '+' is allowed.
template <class T>
NumberTextError ParseNumber(std::string_view word, T& value)
{
  if (word.size() > 1 && word[0] == '+' && word[1] != '-')
  {
    word.remove_prefix(1);
  }
  if constexpr (std::is_floating_point_v<T>)
  {
    if (ReadPlain(word, value))
    {
      return NumberTextError::None;
    }
  }
  if constexpr (std::is_floating_point_v<T>)
  {
    if (const std::string_view plain = SpecialNumber(word); !plain.empty())
    {
      word = plain;
    }
  }
  const char* end = word.data() + word.size();
  const std::from_chars_result parsed = std::from_chars(word.data(), end, value);
  if (parsed.ec == std::errc::invalid_argument || parsed.ptr != end)
  {
    if constexpr (std::is_floating_point_v<T>)
    {
      if (const std::string plain = WithPlainExponent(word); !plain.empty())
      {
        return ParseNumber(plain, value);
      }
    }
    return NumberTextError::NotANumber;
  }
  if (parsed.ec == std::errc())
  {
    return NumberTextError::None;
  }
  if constexpr (std::is_floating_point_v<T>)
  {
    // from_chars does not distinguish too small from too large.
    if (IsBelowOne(word))
    {
      value = word[0] == '-' ? -T{ 0 } : T{ 0 };
      return NumberTextError::None;
    }
  }
  return NumberTextError::OutOfRange;
}

// Tells whether coordinates that a file has as decimals can be floats: whether floats, written with
// the same number of decimals, would give the same text.
class DecimalPrecision
{
public:
  // Words that are not numbers have an undefined effect.
  void Add(std::string_view word);
  bool FloatsSuffice() const { return this->Suffice; }

private:
  bool Suffice = true;
};

}
