// SPDX-License-Identifier: BSD-3-Clause
// Tokens: what a server allows their bearers, signed with the server's secret. They are JSON Web
// Tokens (RFC 7519, 8725) of only one kind, HS256. This code uses no files and no clock.
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

// The level of detail with this name, as NameOf writes it. Errors: InvalidArgument.
Result<ModelDetail> ParseDetail(std::string_view name);

struct TokenClaims
{
  std::string subject;             // sub: the holder of the token
  std::string id;                  // jti: of this one token; may be empty
  std::int64_t notBefore = 0;      // nbf, seconds since 1970
  std::int64_t expires = 0;        // exp: from this time on the token is invalid
  bool allModels = false;          // models: "*"
  std::vector<std::string> models; // models: a list of ids, unless it is "*"
  ModelDetail detail = ModelDetail::Preview;

  bool AllowsModel(std::string_view model) const;
  bool operator==(const TokenClaims&) const = default;
};

inline constexpr std::size_t maximumTokenBytes = 4096;
inline constexpr std::size_t maximumSubjectBytes = 256;

// The claims of a token that is valid at `now`, in seconds since 1970. The signature is checked
// before anything except the header is read. The time of this check does not reveal how much of a
// wrong signature is right. Errors: InvalidInput, with a message for the bearer that contains no
// part of the token.
Result<TokenClaims> ReadToken(std::string_view token, const TokenKeys& keys, std::int64_t now);

// Writes a token, signed with the first of the keys. Errors: InvalidArgument for claims that no
// token may have: an invalid subject or model, or claims that make the token too long.
Result<std::string> WriteToken(
  const TokenClaims& claims, const TokenKeys& keys, std::int64_t issuedAt);

// A random id for a new token: 32 hexadecimal digits. Errors: InputOutput if the system provides no
// random numbers.
Result<std::string> MakeTokenId();

// Whether the text has the form of a token: three parts with dots between them, only a token's
// characters, and not too many of them.
bool LooksLikeToken(std::string_view text);

}
