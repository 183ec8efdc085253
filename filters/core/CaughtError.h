// SPDX-License-Identifier: BSD-3-Clause
// Turns exceptions into errors. Our code does not throw, but memory runs out, and libraries throw:
// a program, or a rank for which others wait, catches everything and reports it.
#pragma once

#include "filters/core/Result.h"

#include <algorithm>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>

namespace kdstream
{

// The exception that is being handled, in one line: LimitExceeded where memory ran out, InputOutput
// for everything else. REQUIRES: a catch clause is being executed.
inline Error CaughtError()
{
  std::string message;
  try
  {
    throw;
  }
  catch (const std::bad_alloc&)
  {
    return { ErrorCode::LimitExceeded, "out of memory" };
  }
  catch (const std::length_error&) // more elements than a container can have
  {
    return { ErrorCode::LimitExceeded, "out of memory" };
  }
  catch (const std::system_error& failure)
  {
    // Only the start of a thread throws this: the system has no room for one more.
    const bool isThread = failure.code() == std::errc::resource_unavailable_try_again;
    message = (isThread ? "a thread cannot be started: " : "") + std::string(failure.what());
  }
  catch (const std::exception& failure)
  {
    message = std::string("unexpected: ") + failure.what();
  }
  catch (...)
  {
    message = "unexpected: an exception without a message";
  }
  std::replace_if(
    message.begin(), message.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return { ErrorCode::InputOutput, message };
}

}
