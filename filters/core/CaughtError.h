// SPDX-License-Identifier: BSD-3-Clause
// Turns exceptions into errors. Our own code does not throw, but memory can run out, and libraries
// throw. So programs, and ranks on which other ranks wait, catch every exception and report it.
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

// The exception that is being handled as an error with a message of one line. The code is
// LimitExceeded if memory ran out, InputOutput for everything else. REQUIRES: a catch clause is
// being executed.
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
    // Only starting a thread throws this code: the system has no resources for another thread.
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
