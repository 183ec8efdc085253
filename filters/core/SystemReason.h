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

// "WHAT: reason".
inline Error SystemError(const std::string& what, int reason)
{
  return { ErrorCode::InputOutput, what + ": " + SystemReason(reason) };
}

// Whether a write failed for lack of room: on the disk, in a quota, or in the longest file that is
// allowed.
inline bool IsDiskFull(int reason)
{
  return reason == ENOSPC || reason == EDQUOT || reason == EFBIG;
}

}
