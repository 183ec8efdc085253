// SPDX-License-Identifier: BSD-3-Clause
// For names that nobody can foresee.
#pragma once

#include <cstddef>
#include <random>
#include <string>

namespace kdstream
{

inline constexpr std::size_t randomLetters = 6;

inline std::string RandomLetters()
{
  std::random_device random;
  std::string letters;
  while (letters.size() < randomLetters)
  {
    letters += static_cast<char>('a' + random() % 26);
  }
  return letters;
}

}
