// SPDX-License-Identifier: BSD-3-Clause
// What the operating system says of a call that failed: one way to put it for the whole project.
#pragma once

#include "filters/core/Result.h"

#include <cerrno>
#include <string>
#include <system_error>

namespace kdstream
{

// The text of an errno. Not by strerror, which threads share.
inline std::string SystemReason(int reason)
{
  return std::generic_category().message(reason);
}

// Whether a write failed for lack of room: on the disk, in a quota, or because a file may not
// become longer.
inline bool IsDiskFull(int reason)
{
  return reason == ENOSPC || reason == EDQUOT || reason == EFBIG;
}

// Whether the same may succeed later.
inline bool IsTransient(const Error& error)
{
  return error.code == ErrorCode::InputOutput || error.code == ErrorCode::LimitExceeded;
}

// "WHAT: reason": DiskFull or InputOutput. file: that it is about, if the caller does not name it.
inline Error SystemError(const std::string& what, int reason, const std::string& file = {})
{
  return { IsDiskFull(reason) ? ErrorCode::DiskFull : ErrorCode::InputOutput,
    what + ": " + SystemReason(reason), file };
}

}
