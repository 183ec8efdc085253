// SPDX-License-Identifier: BSD-3-Clause
// The operating system's reason why a call failed, worded in the same way in the whole project.
#pragma once

#include "filters/core/Result.h"

#include <cerrno>
#include <string>
#include <system_error>

namespace kdstream
{

// The text for an errno. Does not use strerror, whose buffer is shared by all threads.
inline std::string SystemReason(int reason)
{
  return std::generic_category().message(reason);
}

// Whether a write failed for lack of room: on the disk, in a quota, or because the file has reached
// the length limit.
inline bool IsDiskFull(int reason)
{
  return reason == ENOSPC || reason == EDQUOT || reason == EFBIG;
}

// Whether the same operation may succeed later.
inline bool IsTransient(const Error& error)
{
  return error.code == ErrorCode::InputOutput || error.code == ErrorCode::LimitExceeded;
}

// An error DiskFull or InputOutput with the message "WHAT: reason". file: the file concerned; empty
// if the caller adds it.
inline Error SystemError(const std::string& what, int reason, const std::string& file = {})
{
  return { IsDiskFull(reason) ? ErrorCode::DiskFull : ErrorCode::InputOutput,
    what + ": " + SystemReason(reason), file };
}

}
