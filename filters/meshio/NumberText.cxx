// SPDX-License-Identifier: BSD-3-Clause
// Numbers as decimal text, the same in every locale: for the text formats of step "read".
#include "filters/meshio/NumberText.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>

namespace kdstream
{

std::string_view SpecialNumber(std::string_view word)
{
  const bool negative = word.starts_with('-');
  word.remove_prefix(negative ? 1 : 0);
  if (!word.starts_with("1.#"))
  {
    return {};
  }
  word.remove_prefix(3);
  if (word.starts_with("INF"))
  {
    return negative ? "-inf" : "inf";
  }
  const bool none = word.starts_with("IND") || word.starts_with("QNAN") || word.starts_with("SNAN");
  return none ? "nan" : std::string_view();
}

std::size_t FindComment(std::string_view text)
{
  std::size_t at = text.find('#');
  while (at != std::string_view::npos && text.substr(0, at).ends_with("1."))
  {
    at = text.find('#', at + 1);
  }
  return at;
}

std::string WithPlainExponent(std::string_view word)
{
  constexpr std::string_view digits = "0123456789";
  const std::size_t at = word.find_first_of("dD");
  if (at == std::string_view::npos || at == 0 || at + 1 == word.size())
  {
    return {};
  }
  std::string_view exponent = word.substr(at + 1);
  exponent.remove_prefix(exponent[0] == '+' || exponent[0] == '-' ? 1 : 0);
  const std::string_view number = word.substr(0, at);
  const bool isNumber = number.find_first_of(digits) != number.npos &&
                        number.find_first_not_of("+-.0123456789") == number.npos &&
                        !exponent.empty() && exponent.find_first_not_of(digits) == exponent.npos;
  std::string plain(isNumber ? word : std::string_view());
  if (isNumber)
  {
    plain[at] = 'e';
  }
  return plain;
}

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
  // The power of ten of the first digit that is not 0, before the written exponent is added.
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

namespace
{

// Ten to the power of `exponent`: exact up to 10^22, and beyond this near enough for comparing.
double PowerOfTen(int exponent)
{
  if (std::abs(exponent) <= mostExactPower)
  {
    return exponent < 0 ? 1 / exactPowers[-exponent] : exactPowers[exponent];
  }
  double power = 1;
  for (int i = std::abs(exponent); i > 0; --i)
  {
    power *= 10;
  }
  return exponent < 0 ? 1 / power : power;
}

// Whether `value`, whose last decimal has the weight 10^power, can be recovered from a float.
bool FloatTells(double value, int power, bool even)
{
  const double halfDecimal = 0.5 * PowerOfTen(power);
  const double difference = std::abs(double(static_cast<float>(value)) - value);
  // A value halfway between two decimals is written as the even one (1912017.75 as 1912017.8).
  constexpr double blur = 1e-6; // relative error of decimals as doubles
  return difference < halfDecimal * (even ? 1 + blur : 1 - blur);
}

}

void DecimalPrecision::Add(std::string_view word)
{
  if (!this->Suffice)
  {
    return;
  }
  // Floats keep all decimals of six digits distinct, except near the ends of the range of floats.
  constexpr std::uint64_t sureDigits = 1000000;
  constexpr int farPower = 25;
  PlainDecimal decimal;
  double value = 0;
  const bool plain = ScanDecimal(word, decimal);
  if (plain && decimal.digits < sureDigits && decimal.power >= -farPower &&
      decimal.power <= farPower)
  {
    return;
  }
  if (plain && NearestDouble(decimal, value))
  {
    this->Suffice = FloatTells(value, decimal.power, decimal.digits % 2 == 0);
    return;
  }
  const std::size_t exponentAt = std::min(word.find_first_of("eEdD"), word.size());
  int exponent = 0;
  std::string_view digits = word.substr(std::min(exponentAt + 1, word.size()));
  digits.remove_prefix(!digits.empty() && digits[0] == '+' ? 1 : 0);
  std::from_chars(digits.data(), digits.data() + digits.size(), exponent);
  const std::size_t point = std::min(word.find('.'), exponentAt);
  const auto decimals = static_cast<int>(exponentAt - point) - (point < exponentAt ? 1 : 0) -
                        std::clamp(exponent, -999, 999);
  static_cast<void>(ParseNumber(word, value));
  const std::string_view mantissa = word.substr(0, exponentAt);
  const std::size_t last = mantissa.find_last_of("0123456789");
  const bool even = last != std::string_view::npos && (mantissa[last] - '0') % 2 == 0;
  this->Suffice = FloatTells(value, -std::clamp(decimals, -999, 999), even);
}

}
