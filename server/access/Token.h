// SPDX-License-Identifier: BSD-3-Clause
// Tokens: what a server allows their bearers, signed with the server's secret. JSON Web Tokens (RFC
// 7519, 8725) of only one kind, HS256. No files, no clock.
#pragma once

#include "filters/core/Result.h"
#include "filters/model/ModelDescription.h"
#include "server/access/TokenKeys.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// One of NameOf's names. Errors: InvalidArgument.
Result<ModelDetail> ParseDetail(std::string_view name);

struct TokenClaims
{
  std::string subject;             // sub: the holder of the token
  std::string id;                  // jti: of this very token; may be empty
  std::int64_t notBefore = 0;      // nbf, seconds since 1970
  std::int64_t expires = 0;        // exp: from this time on the token is invalid
  bool allModels = false;          // models: "*"
  std::vector<std::string> models; // else these
  ModelDetail detail = ModelDetail::Preview;

  bool AllowsModel(std::string_view model) const;
  bool operator==(const TokenClaims&) const = default;
};

inline constexpr std::size_t maximumTokenBytes = 4096;
inline constexpr std::size_t maximumSubjectBytes = 256;

// The claims of a token that is valid at `now`, in seconds since 1970. The signature is checked
// before anything except the header is read, in a time that does not depend on how much of it is
// right. Errors: InvalidInput, with a message for the bearer that contains no part of the token.
Result<TokenClaims> ReadToken(std::string_view token, const TokenKeys& keys, std::int64_t now);

// Signed with the first of the keys. Errors: InvalidArgument for claims that no token may have: an
// invalid subject or model, or too long a token.
Result<std::string> WriteToken(
  const TokenClaims& claims, const TokenKeys& keys, std::int64_t issuedAt);

// A random id for a new token: 32 hexadecimal digits. Errors: InputOutput if the system has no
// random numbers.
Result<std::string> MakeTokenId();

// Whether it can be sent in a field of HTTP: a token's characters, and not too many of them.
bool LooksLikeToken(std::string_view text);

}
