// SPDX-License-Identifier: BSD-3-Clause
// NumberText: words become numbers of a type, rounded once, or are refused.
#include "filters/meshio/NumberText.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>

namespace kdstream::test
{

namespace
{

template <class T>
void ExpectNumber(std::string_view word, T expected)
{
  T value = 99;
  EXPECT_EQ(ParseNumber(word, value), NumberTextError::None) << word;
  EXPECT_EQ(value, expected) << word;
  EXPECT_EQ(std::signbit(static_cast<double>(value)), std::signbit(static_cast<double>(expected)))
    << word;
}

template <class T>
void ExpectNone(std::string_view word, NumberTextError error)
{
  T value = 0;
  EXPECT_EQ(ParseNumber(word, value), error) << word;
}

}

TEST(NumberText, ReadsNumbersOfEveryType)
{
  ExpectNumber<std::int8_t>("-128", -128);
  ExpectNumber<std::uint8_t>("+255", 255);
  ExpectNumber<std::int64_t>("0007", 7);
  ExpectNumber<float>("0.1", 0.1F);
  ExpectNumber<double>("+1E-3", 0.001);
  ExpectNumber<double>("-.5", -0.5);
  ExpectNumber<double>("5.", 5.0);
}

TEST(NumberText, ReadsExponentsOfFortran)
{
  ExpectNumber<double>("1.0D+00", 1);
  ExpectNumber<double>("-2.5d-3", -0.0025);
  ExpectNumber<float>("+.125D1", 1.25F);
  ExpectNumber<double>("0.1D-400", 0.0);
  ExpectNone<double>("1D400", NumberTextError::OutOfRange);
  for (const char* word : { "1D", "D1", "1D+", "1Dx", "1D1.5", "1D1D1", ".D1", "-D1", "1eD1", "d" })
  {
    ExpectNone<double>(word, NumberTextError::NotANumber);
  }
  ExpectNone<std::int32_t>("1D2", NumberTextError::NotANumber);
  DecimalPrecision precision;
  precision.Add("0.1234560D+07");
  EXPECT_TRUE(precision.FloatsSuffice());
  precision.Add("0.123456789012D+07");
  EXPECT_FALSE(precision.FloatsSuffice());
}

TEST(NumberText, ReportsWhatIsNotANumber)
{
  for (const char* word :
    { "", "+", "-", "x", "1x", "1.5.2", "0x1p3", "+-1", "++1", "--1", "1e", "1 2", "1,5" })
  {
    ExpectNone<double>(word, NumberTextError::NotANumber);
    ExpectNone<std::int32_t>(word, NumberTextError::NotANumber);
  }
  for (const char* word : { "1.0", "1e3", "nan" })
  {
    ExpectNone<std::int32_t>(word, NumberTextError::NotANumber);
  }
}

TEST(NumberText, DistinguishesTooLargeFromTooSmall)
{
  ExpectNone<std::uint8_t>("256", NumberTextError::OutOfRange);
  ExpectNone<std::int8_t>("-129", NumberTextError::OutOfRange);
  const std::string zeros(1000, '0');
  for (const std::string word : { "1e39", "3.4028236e38", "-1e999999999999", "0.0001e+500" })
  {
    ExpectNone<float>(word, NumberTextError::OutOfRange);
  }
  ExpectNone<double>("1" + zeros, NumberTextError::OutOfRange);
  ExpectNone<double>("1" + zeros + ".5e-2", NumberTextError::OutOfRange);
  ExpectNumber<double>("1" + zeros + "e-1000", 1.0);
  for (const std::string word : { "1e-50", "0.00001e-45", "1e-999999999999", "1000e-1000" })
  {
    ExpectNumber<float>(word, 0.0F);
    ExpectNumber<float>("-" + word, -0.0F);
  }
  ExpectNumber<double>("0." + zeros + "1", 0.0);
  ExpectNumber<double>("-0." + zeros + "1e+600", -0.0);
}

// The C library gives the expected values: in the "C" locale, strtof and strtod round only once,
// too.
TEST(NumberText, RoundsAsTheCLibraryDoes)
{
  std::mt19937_64 random(7);
  for (int i = 0; i < 20000; ++i)
  {
    const double number = std::bit_cast<double>(random());
    if (!std::isfinite(number))
    {
      continue;
    }
    char text[64];
    std::snprintf(text, sizeof(text), i % 2 == 0 ? "%.17e" : "%.9e",
      i % 3 == 0 ? number : std::fmod(number, 1e40));
    ExpectNumber<double>(text, std::strtod(text, nullptr));
    const float single = std::strtof(text, nullptr);
    if (std::isfinite(single))
    {
      ExpectNumber<float>(text, single);
    }
    else
    {
      ExpectNone<float>(text, NumberTextError::OutOfRange);
    }
  }
}

// Decimals of few digits have their own code path.
TEST(NumberText, RoundsShortDecimalsAsTheCLibraryDoes)
{
  std::mt19937_64 random(11);
  const auto expectSame = [](const std::string& text)
  {
    ExpectNumber<double>(text, std::strtod(text.c_str(), nullptr));
    const float single = std::strtof(text.c_str(), nullptr);
    if (std::isfinite(single))
    {
      ExpectNumber<float>(text, single);
    }
    else
    {
      ExpectNone<float>(text, NumberTextError::OutOfRange);
    }
  };
  for (int i = 0; i < 300000; ++i)
  {
    std::string text = std::to_string(random() >> (random() % 64));
    if (random() % 2 == 0)
    {
      text.insert(random() % (text.size() + 1), ".");
    }
    text.insert(0, random() % 2 == 0 ? "-" : "");
    text +=
      random() % 2 == 0 ? "" : (random() % 2 == 0 ? "e-" : "E") + std::to_string(random() % 50);
    expectSame(text);
  }
  // Values so near to the middle between two floats that the nearest double is exactly the middle.
  for (int i = 0; i < 20000; ++i)
  {
    const float low = std::uniform_real_distribution<float>(1e-5F, 1e5F)(random);
    const double middle = (double(low) + double(std::nextafter(low, 1e9F))) / 2;
    char text[64];
    std::snprintf(text, sizeof(text), "%.15e", middle);
    expectSame(text);
  }
  // Halfway between two floats, exactly and nearly.
  for (const char* text : { "16777217", "16777219", "1.6777217e7", "167772170e-1",
         "16777217.000000001", "16777216.999999999", "9007199254740993", "9007199254740992",
         "1.1754943e-38", "7e-46", "7.1e-46", "3.4028235677973366e38",
         "0.000000000000000000000000000001", "123456789012345678901234567890" })
  {
    expectSame(text);
  }
  for (const char* text :
    { "1e", "e5", ".", "-", "-.", "1e+", "1.2.3", "1-", "--1", "0x10", "1e5x", "1 " })
  {
    ExpectNone<double>(text, NumberTextError::NotANumber);
    ExpectNone<float>(text, NumberTextError::NotANumber);
  }
}

// Tests whether a file with only this number is read as floats.
TEST(NumberText, DecimalsThatFloatsDistinguish)
{
  const auto suffice = [](std::string_view word)
  {
    DecimalPrecision precision;
    precision.Add(word);
    return precision.FloatsSuffice();
  };
  for (const char* word : { "0", "-0.1", "123456", "1e25", "-1.23456e-25", "16777216",
         "0.100000001", "1e-45", "3.4028235e38", "1912017.8", "0.50000000000000000000", "+0.0" })
  {
    EXPECT_TRUE(suffice(word)) << word;
  }
  for (const char* word : { "0.123456789", "16777217", "1.00000001e2", "4000000.001", "1e39",
         "1.23456e-42", "1912017.7", "0.1000000000", "1e-60" })
  {
    EXPECT_FALSE(suffice(word)) << word;
  }
  std::mt19937_64 random(3);
  for (int i = 0; i < 200000; ++i)
  {
    const float value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    char text[64];
    const char* const end = std::to_chars(text, text + sizeof(text), value).ptr;
    EXPECT_TRUE(!std::isfinite(value) || suffice(std::string_view(text, std::size_t(end - text))))
      << value;
  }
}

}
