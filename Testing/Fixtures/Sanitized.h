// SPDX-License-Identifier: BSD-3-Clause
// Whether this build has the address or the thread sanitizer. A sanitizer's own memory does not fit
// into any limit, and it makes loops slow.
#pragma once

namespace kdstream::fixtures
{

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool sanitized = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
inline constexpr bool sanitized = true;
#else
inline constexpr bool sanitized = false;
#endif
#else
inline constexpr bool sanitized = false;
#endif

// How often to try a random case: an eighth of `rounds` with a sanitizer, because then the fuzz
// targets try many more.
constexpr int Rounds(int rounds)
{
  return sanitized ? rounds / 8 : rounds;
}

}
