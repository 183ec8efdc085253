// SPDX-License-Identifier: BSD-3-Clause
// What tests say of an error: its code, and the place that its message names. The sentences are in
// Testing/Documents/Messages.txt.
#pragma once

#include "filters/core/Result.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace kdstream::fixtures
{

// place: "face 1 (line 15)", "levels/0/1"; empty: it names none.
inline ::testing::AssertionResult IsAt(
  const Error& error, ErrorCode code, std::string_view place = {})
{
  const std::string message = error.message + " ";
  const std::size_t at = message.find(place);
  // "face 1" is not "face 12".
  const bool isThere = at != message.npos && (place.empty() || message[at + place.size()] < '0' ||
                                               message[at + place.size()] > '9');
  return isThere && error.code == code ? ::testing::AssertionSuccess()
                                       : ::testing::AssertionFailure()
                                           << "code " << static_cast<int>(error.code) << ": "
                                           << error.message << " is not about '" << place
                                           << "' with code " << static_cast<int>(code);
}

// Of a Result or Status.
template <class Outcome>
::testing::AssertionResult FailsAt(
  const Outcome& outcome, ErrorCode code, std::string_view place = {})
{
  return outcome
           ? ::testing::AssertionFailure() << "no error, but one is expected at '" << place << "'"
           : IsAt(outcome.GetError(), code, place);
}

}
