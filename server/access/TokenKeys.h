// SPDX-License-Identifier: BSD-3-Clause
// The file of --tokens: secrets that tokens are signed with, and tokens that have been revoked.
//
//   {"secret": "…", "id": "2026-11",
//    "earlier": [{"secret": "…", "id": "2026-05"}],
//    "revoked": ["…"], "revoked_subjects": ["…"]}
#pragma once

#include "filters/core/Result.h"

#include <cstddef>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

struct TokenKeys
{
  struct Key
  {
    std::string id; // kid of the tokens that this key signs; "": they have none
    std::string secret;
  };
  std::vector<Key> keys;                      // at least one; new tokens are signed with the first
  std::set<std::string, std::less<>> revoked; // single tokens, by their jti
  std::set<std::string, std::less<>> revokedSubjects; // subjects all of whose tokens are revoked

  // The key with this id; null if there is none.
  const Key* Find(std::string_view id) const;
};

// The length of an HS256 signature (RFC 7518, 3.2).
inline constexpr std::size_t leastSecretBytes = 32;
inline constexpr std::size_t maximumKeys = 16;
inline constexpr std::size_t maximumKeysBytes = std::size_t{ 4 } << 20;

// Errors: InvalidInput, with a message that names the wrong member, but never contains any part of
// a secret. An unknown member is an error, so that a misspelt "revoked" does not go unnoticed.
Result<TokenKeys> ParseTokenKeys(std::string_view json);
// Errors: those of ParseTokenKeys; NotFound; InputOutput.
Result<TokenKeys> ReadTokenKeys(const std::filesystem::path& file);

}
