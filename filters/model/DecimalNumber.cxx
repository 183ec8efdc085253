// SPDX-License-Identifier: BSD-3-Clause
// A decimal number as the double that is nearest to it:
//   1. take the number apart: an integer of digits, times a power of ten;
//   2. where both fit into a double, one multiplication or division rounds correctly (Clinger 1990,
//      "How to read floating point numbers accurately");
//   3. else write it as a fraction of two natural numbers of any length, find the power of two
//      between 1 and 2 times which it lies, and divide bit by bit; the remainder tells how to
//      round.
#include "filters/model/DecimalNumber.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace kdstream
{

namespace
{

constexpr std::size_t mostDigits = 800; // no tie between two doubles has more than 768

// A natural number of any length: base 2^32, the lowest first, no zeros on top.
class Natural
{
public:
  explicit Natural(std::uint32_t value = 0) { this->MultiplyAdd(1, value); }

  void MultiplyAdd(std::uint32_t factor, std::uint32_t summand)
  {
    std::uint64_t carry = summand;
    for (std::uint32_t& part : this->Parts)
    {
      carry += std::uint64_t{ part } * factor;
      part = static_cast<std::uint32_t>(carry);
      carry >>= 32;
    }
    if (carry != 0)
    {
      this->Parts.push_back(static_cast<std::uint32_t>(carry));
    }
  }

  void MultiplyByPowerOfTen(int exponent)
  {
    for (; exponent > 0; --exponent)
    {
      this->MultiplyAdd(10, 0);
    }
  }

  void ShiftLeft(int bits)
  {
    this->Parts.insert(this->Parts.begin(), static_cast<std::size_t>(bits / 32), 0u);
    this->MultiplyAdd(std::uint32_t{ 1 } << (bits % 32), 0);
  }

  int BitLength() const
  {
    int bits = static_cast<int>(this->Parts.size()) * 32;
    for (std::uint32_t top = this->Parts.back(); (top & 0x80000000u) == 0; top <<= 1)
    {
      --bits;
    }
    return bits;
  }

  bool IsLess(const Natural& other) const
  {
    return this->Parts.size() != other.Parts.size()
             ? this->Parts.size() < other.Parts.size()
             : std::lexicographical_compare(this->Parts.rbegin(), this->Parts.rend(),
                 other.Parts.rbegin(), other.Parts.rend());
  }

  // REQUIRES: other <= *this.
  void Subtract(const Natural& other)
  {
    std::uint64_t borrow = 0;
    for (std::size_t i = 0; i < this->Parts.size(); ++i)
    {
      const std::uint64_t taken = borrow + (i < other.Parts.size() ? other.Parts[i] : 0);
      borrow = this->Parts[i] < taken ? 1 : 0;
      this->Parts[i] = static_cast<std::uint32_t>(this->Parts[i] - taken);
    }
    while (!this->Parts.empty() && this->Parts.back() == 0)
    {
      this->Parts.pop_back();
    }
  }

private:
  std::vector<std::uint32_t> Parts;
};

struct Decimal
{
  bool negative = false;
  std::vector<unsigned char> digits; // without leading zeros
  int exponent = 0;                  // of ten, behind the last digit
};

Decimal TakeApart(std::string_view text)
{
  constexpr int mostExponent = 100000000;
  Decimal decimal;
  bool point = false;
  std::size_t i = 0;
  for (; i < text.size() && text[i] != 'e' && text[i] != 'E'; ++i)
  {
    if (text[i] == '-' || text[i] == '.')
    {
      decimal.negative = decimal.negative || text[i] == '-';
      point = point || text[i] == '.';
      continue;
    }
    const auto digit = static_cast<unsigned char>(text[i] - '0');
    const bool kept = decimal.digits.size() < mostDigits;
    if (kept && (digit != 0 || !decimal.digits.empty()))
    {
      decimal.digits.push_back(digit);
    }
    else if (!kept && digit != 0)
    {
      decimal.digits.back() |= 1; // a bit more: cannot be a tie any more
    }
    decimal.exponent += (kept ? 0 : 1) - (point ? 1 : 0);
  }
  int exponent = 0;
  bool down = false;
  for (++i; i < text.size(); ++i)
  {
    down = down || text[i] == '-';
    if (text[i] >= '0' && text[i] <= '9' && exponent < mostExponent)
    {
      exponent = exponent * 10 + (text[i] - '0');
    }
  }
  decimal.exponent += down ? -exponent : exponent;
  return decimal;
}

double DivideExactly(const Decimal& decimal)
{
  Natural numerator, denominator(1);
  for (const unsigned char digit : decimal.digits)
  {
    numerator.MultiplyAdd(10, digit);
  }
  numerator.MultiplyByPowerOfTen(decimal.exponent);
  denominator.MultiplyByPowerOfTen(-decimal.exponent);

  // 2^power <= numerator / denominator < 2^(power + 1)
  int power = numerator.BitLength() - denominator.BitLength();
  (power > 0 ? denominator : numerator).ShiftLeft(std::abs(power));
  if (numerator.IsLess(denominator))
  {
    numerator.ShiftLeft(1);
    --power;
  }
  constexpr int lowest = -1074; // the power of the smallest double
  const int bits = std::min(53, power - lowest + 1);
  if (bits < 0)
  {
    return 0;
  }
  std::uint64_t mantissa = 0;
  for (int bit = 0; bit < bits; ++bit)
  {
    const bool one = !numerator.IsLess(denominator);
    if (one)
    {
      numerator.Subtract(denominator);
    }
    mantissa = mantissa * 2 + (one ? 1 : 0);
    numerator.ShiftLeft(1);
  }
  // What remains, against half of the last bit.
  const bool above = denominator.IsLess(numerator);
  const bool tie = !above && !numerator.IsLess(denominator);
  mantissa += above || (tie && mantissa % 2 == 1) ? 1 : 0;
  return std::ldexp(static_cast<double>(mantissa), power - bits + 1);
}

double NearestMagnitude(const Decimal& decimal)
{
  if (decimal.digits.empty())
  {
    return 0;
  }
  const int magnitude = static_cast<int>(decimal.digits.size()) + decimal.exponent;
  if (magnitude > 310)
  {
    return std::numeric_limits<double>::infinity();
  }
  if (magnitude < -330)
  {
    return 0;
  }
  constexpr int mostExactPower = 22; // 10^22 and all below are doubles
  if (decimal.digits.size() <= 15 && std::abs(decimal.exponent) <= mostExactPower)
  {
    double value = 0, power = 1;
    for (const unsigned char digit : decimal.digits)
    {
      value = value * 10 + digit;
    }
    for (int i = std::abs(decimal.exponent); i > 0; --i)
    {
      power *= 10;
    }
    return decimal.exponent < 0 ? value / power : value * power;
  }
  return DivideExactly(decimal);
}

}

double NearestDouble(std::string_view text)
{
  const Decimal decimal = TakeApart(text);
  const double magnitude = NearestMagnitude(decimal);
  return decimal.negative ? -magnitude : magnitude;
}

}
