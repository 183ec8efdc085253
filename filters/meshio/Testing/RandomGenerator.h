// SPDX-License-Identifier: BSD-3-Clause
// Seeded choices for random test files.
#pragma once

#include "filters/core/Types.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace kdstream::test
{

// A random mesh in random notation, and what a reader must make of it.
struct RandomFile
{
  std::string bytes;
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;
  std::uint64_t faces = 0;
  bool soup = false;
  ScalarType scalarType = ScalarType::Float32;
  std::vector<Attribute> attributes;
  std::vector<std::string> ignored;
};

class RandomGenerator
{
public:
  explicit RandomGenerator(unsigned seed)
    : Random(seed)
  {
  }

  std::uint64_t Pick(std::uint64_t below)
  {
    return std::uniform_int_distribution<std::uint64_t>(0, below - 1)(this->Random);
  }
  bool Chance(double probability) { return std::bernoulli_distribution(probability)(this->Random); }
  std::string PickOf(const std::vector<std::string>& words)
  {
    return words[this->Pick(words.size())];
  }

  // A finite value of any bits; often a small one.
  template <class Real>
  Real AnyReal()
  {
    if (this->Chance(0.5))
    {
      return std::uniform_real_distribution<Real>(-1, 1)(this->Random);
    }
    if constexpr (sizeof(Real) == 4)
    {
      const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(this->Random()));
      return std::isfinite(value) ? value : -0.0F;
    }
    else
    {
      const auto value = std::bit_cast<double>(this->Random());
      return std::isfinite(value) ? value : -0.0;
    }
  }

protected:
  std::mt19937_64 Random;
};

// The shortest text that reads back as this value.
template <class Real>
std::string ShortText(Real value)
{
  char text[64];
  return std::string(text, std::to_chars(text, text + sizeof(text), value).ptr);
}

// Makes one change to good bytes, as a failing disk or an attacker might. lines: pieces of text
// that mean something in the format.
inline void Mutate(
  std::string& bytes, RandomGenerator& generator, const std::vector<std::string>& lines)
{
  static const std::vector<std::string> numbers{ "0", "-1", "1", "255", "256", "65536",
    "2147483648", "4294967294", "4294967295", "4294967296", "9223372036854775807",
    "-9223372036854775808", "9223372036854775808", "18446744073709551615", "1e999", "nan",
    "1.00000001", "x" };
  const std::size_t at = generator.Pick(bytes.size());
  switch (generator.Pick(8))
  {
    case 0: // change one bit
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << generator.Pick(8)));
      break;
    case 1: // change one byte
      bytes[at] = static_cast<char>(generator.Pick(256));
      break;
    case 2: // cut off the end
      bytes.resize(at + 1);
      break;
    case 3: // remove a part
      bytes.erase(at, 1 + generator.Pick(16));
      break;
    case 4: // repeat a part
      bytes.insert(generator.Pick(bytes.size()), bytes.substr(at, 1 + generator.Pick(64)));
      break;
    case 5: // set four bytes to ones
      bytes.replace(at, 4, "\xff\xff\xff\xff");
      break;
    case 6: // change a number of the text
    {
      const std::size_t digit = std::min(bytes.find_first_of("0123456789", at), bytes.size());
      const std::size_t end = std::min(bytes.find_first_not_of("0123456789", digit), bytes.size());
      bytes.replace(digit, end - digit, generator.PickOf(numbers));
      break;
    }
    default: // add a line, often near the start: to the header, if the format has one
    {
      const std::size_t after = generator.Chance(0.5) ? at : at / 4;
      bytes.insert(std::min(bytes.find('\n', after) + 1, bytes.size()), generator.PickOf(lines));
    }
  }
}

}
