// SPDX-License-Identifier: BSD-3-Clause
// Checks of an error in tests: its code, and the place that its message names. The sentences are in
// Testing/Documents/Messages.txt.
#pragma once

#include "filters/core/Result.h"

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <string_view>

namespace kdstream::fixtures
{

// place: for example "face 1 (line 15)" or "levels/0/1"; empty: the place is not checked.
inline ::testing::AssertionResult IsAt(
  const Error& error, ErrorCode code, std::string_view place = {})
{
  const std::string message = error.message + " ";
  const std::size_t at = message.find(place);
  // "face 1" must not match "face 12".
  const bool isThere = at != message.npos && (place.empty() || message[at + place.size()] < '0' ||
                                               message[at + place.size()] > '9');
  return isThere && error.code == code ? ::testing::AssertionSuccess()
                                       : ::testing::AssertionFailure()
                                           << "code " << static_cast<int>(error.code) << ": "
                                           << error.message << " is not about '" << place
                                           << "' with code " << static_cast<int>(code);
}

// The same for a Result or a Status.
template <class Outcome>
::testing::AssertionResult FailsAt(
  const Outcome& outcome, ErrorCode code, std::string_view place = {})
{
  return outcome
           ? ::testing::AssertionFailure() << "no error, but one is expected at '" << place << "'"
           : IsAt(outcome.GetError(), code, place);
}

// Whether a text for users has all these parts, in this order. For texts that come without a code.
inline ::testing::AssertionResult Mentions(
  std::string_view text, std::initializer_list<std::string_view> parts)
{
  std::size_t begin = 0;
  for (const std::string_view part : parts)
  {
    const std::size_t at = text.find(part, begin);
    if (at == text.npos)
    {
      return ::testing::AssertionFailure()
             << "\"" << text << "\" does not mention '" << part << "'";
    }
    begin = at + part.size();
  }
  return ::testing::AssertionSuccess();
}

}
