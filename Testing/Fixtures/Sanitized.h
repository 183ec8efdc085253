// SPDX-License-Identifier: BSD-3-Clause
// Whether this build has the address or the thread sanitizer, whose own memory no limit can hold,
// and which makes loops slow.
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

// How often a random case is tried: an eighth of `rounds` with a sanitizer, where the fuzz targets
// try many more.
constexpr int Rounds(int rounds)
{
  return sanitized ? rounds / 8 : rounds;
}

}
