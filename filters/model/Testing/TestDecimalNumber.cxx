// SPDX-License-Identifier: BSD-3-Clause
// Decimal numbers to doubles, compared with strtod; and back, compared with std::to_chars.
#include "Testing/Fixtures/Sanitized.h"
#include "filters/model/DecimalNumber.h"

#include <gtest/gtest.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <iomanip>
#include <random>
#include <sstream>
#include <string>

using kdstream::NearestDouble;
using kdstream::ShortestDecimal;

namespace
{

void ExpectAsStrtod(const std::string& text)
{
  ASSERT_EQ(std::bit_cast<std::uint64_t>(NearestDouble(text)),
    std::bit_cast<std::uint64_t>(std::strtod(text.c_str(), nullptr)))
    << text;
}

// All decimal digits of a number.
std::string Exact(long double value)
{
  std::ostringstream text;
  text << std::setprecision(1200) << value;
  return text.str();
}

}

TEST(TestDecimalNumber, AnyDigitsAndExponents)
{
  std::mt19937_64 random(2);
  for (int i = 0; i < kdstream::fixtures::Rounds(100000); ++i)
  {
    std::string text = (i % 3 == 0 ? "-" : "") + std::to_string(random() % 10) + ".";
    for (auto digits = random() % 40; digits > 0; --digits)
    {
      text += static_cast<char>('0' + random() % 10);
    }
    text += "0e" + std::to_string(static_cast<int>(random() % 660) - 345);
    ExpectAsStrtod(text);
  }
}

// Numbers exactly halfway between two doubles, and slightly above and below.
TEST(TestDecimalNumber, Ties)
{
  std::mt19937_64 random(3);
  for (int i = 0; i < kdstream::fixtures::Rounds(4000); ++i)
  {
    auto bits = random() >> 1;
    bits >>= i % 4 == 0 ? 11 + random() % 52 : 0; // subnormal
    const double low = std::bit_cast<double>(bits);
    const double high = std::bit_cast<double>(bits + 1);
    if (!std::isfinite(high))
    {
      continue;
    }
    // A long double has 64 bits, so it holds the number halfway between.
    const std::string tie = Exact((static_cast<long double>(low) + high) / 2);
    const std::size_t exponent = tie.find('e');
    const std::string digits = tie.substr(0, exponent),
                      rest = exponent == std::string::npos ? "" : tie.substr(exponent);
    const std::string point = digits.find('.') == std::string::npos ? "." : "";
    ExpectAsStrtod(tie);
    ExpectAsStrtod(digits + point + std::string(1 + i % 1000, '0') + "1" + rest);
    std::string below = digits;
    const std::size_t last = below.find_last_of("123456789");
    --below[last];
    ExpectAsStrtod(below + point + std::string(i % 100, '9') + rest);
  }
}

TEST(TestDecimalNumber, Edges)
{
  for (const char* text :
    { "0", "-0", "0.0", "0e999", "-0.000e-5", "1", "-1", "10", "1e22", "1e23", "123456789012345e22",
      "9007199254740993", "9007199254740993.00000000000000000000000000000000000000001",
      "18446744073709551616", "1.7976931348623157e308", "1.7976931348623158e308",
      "1.7976931348623159e308", "1e309", "-1e309", "1e99999999999999999999", "1E+5", "1e-5",
      "1e-99999999999999999999", "0.000000000000000000000000000001", "2.2250738585072011e-308",
      "2.2250738585072014e-308", "4.9406564584124654e-324", "5e-324", "3e-324",
      "2.4703282292062328e-324", "2.4703282292062327e-324", "2e-324", "5.8486907944580796e-325",
      "1e-324", "1e-400", "6631236846766476e-316" })
  {
    ExpectAsStrtod(text);
  }
  ExpectAsStrtod("0." + std::string(400, '0') + "1e401");
  ExpectAsStrtod("1" + std::string(400, '0') + "e-400");
  ExpectAsStrtod("1" + std::string(1000, '0') + "e-1000");
  ExpectAsStrtod("0." + std::string(100000, '3'));
}

namespace
{

// The digits without point, exponent, and zeros at both ends.
std::string DigitsOf(std::string text)
{
  text = text.substr(0, text.find('e'));
  std::erase(text, '.');
  std::erase(text, '-');
  text.erase(0, text.find_first_not_of('0'));
  text.erase(text.find_last_not_of('0') + 1);
  return text;
}

}

TEST(TestDecimalNumber, TheShortestDigitsAreThoseOfTheLibrary)
{
  std::mt19937_64 random(4);
  for (int i = 0; i < kdstream::fixtures::Rounds(20000); ++i)
  {
    double value = std::bit_cast<double>(random());
    value = i % 5 == 1   ? double(std::bit_cast<float>(static_cast<std::uint32_t>(random())))
            : i % 5 == 2 ? std::bit_cast<double>(random() >> (12 + random() % 52)) // subnormal
            : i % 5 == 3 ? std::bit_cast<double>(random() << 52) // the lowest number with a power
                                                                 // of two
            : i % 5 == 4 ? double(random() % 100000) / 1000
                         : value;
    if (!std::isfinite(value))
    {
      continue;
    }
    char text[64];
    const auto end = std::to_chars(text, text + 64, value, std::chars_format::scientific).ptr;
    const std::string expected(text, end), found = ShortestDecimal(value);
    ASSERT_EQ(DigitsOf(found), DigitsOf(expected)) << expected;
    ASSERT_EQ(
      std::bit_cast<std::uint64_t>(NearestDouble(found)), std::bit_cast<std::uint64_t>(value))
      << found;
    ASSERT_LE(found.size(), 25U);
  }
}

TEST(TestDecimalNumber, ExponentsStandWhereThereWouldBeManyZeros)
{
  for (const auto& [value, text] :
    { std::pair{ 0.0, "0.0" }, { -0.0, "-0.0" }, { 640.0, "640.0" }, { -2.5, "-2.5" },
      { 1e-6, "0.000001" }, { 1e-7, "1e-7" }, { 1.25e-7, "1.25e-7" },
      { 123456789012345680000.0, "123456789012345680000.0" }, { 1e20, "100000000000000000000.0" },
      { 1e21, "1e21" }, { 1.5e300, "1.5e300" }, { 5e-324, "5e-324" }, { 9.5, "9.5" },
      { 0.1 + 0.2, "0.30000000000000004" }, { 1.7976931348623157e308, "1.7976931348623157e308" } })
  {
    EXPECT_EQ(ShortestDecimal(value), text);
  }
}
