// SPDX-License-Identifier: BSD-3-Clause
// Finds the double nearest to a decimal number:
//   1. Split the number into an integer and a power of ten.
//   2. If both fit into a double, one multiplication or division rounds correctly (Clinger 1990,
//      "How to read floating point numbers accurately").
//   3. Otherwise write it as a fraction of two natural numbers of any length, scale it by a power
//      of two into 1 … 2, and divide bit by bit; the remainder decides the rounding.
// The inverse: produce digits of the exact fraction until no other double is as near (Steele and
// White 1990, "How to print floating-point numbers accurately"; Burger and Dybvig 1996).
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

// A natural number of any length: digits to the base 2^32, the lowest first, the highest not zero.
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

  void Add(const Natural& other)
  {
    std::uint64_t carry = 0;
    this->Parts.resize(std::max(this->Parts.size(), other.Parts.size()));
    for (std::size_t i = 0; i < this->Parts.size(); ++i)
    {
      carry += std::uint64_t{ this->Parts[i] } + (i < other.Parts.size() ? other.Parts[i] : 0);
      this->Parts[i] = static_cast<std::uint32_t>(carry);
      carry >>= 32;
    }
    if (carry != 0)
    {
      this->Parts.push_back(static_cast<std::uint32_t>(carry));
    }
  }

private:
  std::vector<std::uint32_t> Parts;
};

struct Decimal
{
  bool negative = false;
  std::vector<unsigned char> digits; // without leading zeros
  int exponent = 0;                  // of ten, after the last digit
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
      decimal.digits.back() |= 1; // slightly larger, so that it cannot be a tie
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
  // Compares the remainder with half of the last bit.
  const bool above = denominator.IsLess(numerator);
  const bool tie = !above && !numerator.IsLess(denominator);
  mantissa += above || (tie && mantissa % 2 == 1) ? 1 : 0;
  return std::ldexp(static_cast<double>(mantissa), power - bits + 1);
}

// The numbers that are nearer to `value` than to its neighbouring doubles reach from `less` below
// it to `more` above it; both are fractions of `whole`.
struct Interval
{
  Natural value, less, more, whole;
  bool hasEnds; // the ends of the interval also round to the number

  explicit Interval(double positive)
    : hasEnds(false)
  {
    int exponent = 0;
    auto mantissa = static_cast<std::uint64_t>(std::ldexp(std::frexp(positive, &exponent), 53));
    exponent -= 53;
    for (; exponent < -1074; ++exponent) // subnormal
    {
      mantissa >>= 1;
    }
    this->hasEnds = mantissa % 2 == 0;
    // Below the lowest number with a given power of two, the next number is only half as far.
    const bool isLowest = mantissa == std::uint64_t{ 1 } << 52 && exponent > -1074;
    const int half = isLowest ? 2 : 1; // in halves or quarters of a step
    this->value = Natural(static_cast<std::uint32_t>(mantissa >> 32));
    this->value.ShiftLeft(32);
    this->value.Add(Natural(static_cast<std::uint32_t>(mantissa)));
    this->value.ShiftLeft(half + std::max(exponent, 0));
    this->less = this->more = this->whole = Natural(1);
    this->less.ShiftLeft(std::max(exponent, 0));
    this->more.ShiftLeft(half - 1 + std::max(exponent, 0));
    this->whole.ShiftLeft(half + std::max(-exponent, 0));
  }

  void MultiplyBy10()
  {
    for (Natural* const each : { &this->value, &this->less, &this->more })
    {
      each->MultiplyAdd(10, 0);
    }
  }
  // Whether the digits so far already identify the number. ReachesDown: as they are. ReachesUp: if
  // the last digit is increased by one.
  bool ReachesDown() const
  {
    return this->hasEnds ? !this->less.IsLess(this->value) : this->value.IsLess(this->less);
  }
  bool ReachesUp() const
  {
    Natural sum = this->value;
    sum.Add(this->more);
    return this->hasEnds ? !sum.IsLess(this->whole) : this->whole.IsLess(sum);
  }
};

// The digits, and the power of ten before the first digit: 0.ddd * 10^power.
std::string ShortestDigits(double positive, int& power)
{
  Interval left(positive);
  power = 0;
  for (; left.ReachesUp(); ++power) // value + more > whole
  {
    left.whole.MultiplyAdd(10, 0);
  }
  for (;; --power)
  {
    Interval tenfold = left;
    tenfold.MultiplyBy10();
    if (tenfold.ReachesUp())
    {
      break;
    }
    left = std::move(tenfold);
  }
  std::string digits;
  for (;;)
  {
    left.MultiplyBy10();
    char digit = '0';
    for (; !left.value.IsLess(left.whole); ++digit)
    {
      left.value.Subtract(left.whole);
    }
    const bool down = left.ReachesDown(), up = left.ReachesUp();
    if (down || up)
    {
      Natural twice = left.value;
      twice.Add(left.value);
      const bool isHalf = !twice.IsLess(left.whole) && !left.whole.IsLess(twice);
      const bool isUpNearer = isHalf ? digit % 2 == 1 : left.whole.IsLess(twice); // half: to even
      digits += static_cast<char>(digit + (up && (!down || isUpNearer) ? 1 : 0));
      return digits;
    }
    digits += digit;
  }
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
  constexpr int mostExactPower = 22; // all powers up to 10^22 are doubles
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

std::string ShortestDecimal(double value)
{
  const std::string sign = std::signbit(value) ? "-" : "";
  if (value == 0)
  {
    return sign + "0.0";
  }
  int power = 0;
  std::string digits = ShortestDigits(std::abs(value), power);
  const int count = static_cast<int>(digits.size());
  if (power > 21 || power <= -6)
  {
    digits.insert(1, count > 1 ? "." : "");
    return sign + digits + "e" + std::to_string(power - 1);
  }
  if (power <= 0)
  {
    return sign + "0." + std::string(static_cast<std::size_t>(-power), '0') + digits;
  }
  if (power < count)
  {
    return sign + digits.insert(static_cast<std::size_t>(power), ".");
  }
  return sign + digits + std::string(static_cast<std::size_t>(power - count), '0') + ".0";
}

double NearestDouble(std::string_view text)
{
  const Decimal decimal = TakeApart(text);
  const double magnitude = NearestMagnitude(decimal);
  return decimal.negative ? -magnitude : magnitude;
}

}
