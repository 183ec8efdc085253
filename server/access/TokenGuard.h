// SPDX-License-Identifier: BSD-3-Clause
// Admits clients with a valid token, and knows how long each token is valid. All functions may be
// called from any thread.
#pragma once

#include "filters/core/Result.h"
#include "server/access/Token.h"
#include "server/access/TokenKeys.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

namespace kdstream
{

// A token that was valid when its bearer was admitted.
struct Pass
{
  TokenClaims claims;
  std::string token;
  std::shared_ptr<const TokenKeys> keys; // the keys that checked the token
};

class TokenGuard
{
public:
  using Clock = std::function<std::int64_t()>; // seconds since 1970

  // Without a clock, the system's clock is used.
  explicit TokenGuard(TokenKeys keys, Clock clock = {});

  // From now on tokens are checked with these keys, and with the tokens and subjects that they
  // revoke.
  void Replace(TokenKeys keys);

  // Admits the bearer of a token. Errors: InvalidInput, with a message for the bearer, if there is
  // no token ("") or if it is not valid.
  Result<std::shared_ptr<const Pass>> Admit(std::string_view token) const;

  // Checks that the pass is still valid. Errors: InvalidInput, with a message for the bearer.
  Status Check(const Pass& pass) const;

private:
  std::shared_ptr<const TokenKeys> Keys() const;

  mutable std::mutex Mutex;
  std::shared_ptr<const TokenKeys> Current;
  Clock Now;
};

// The token in an Authorization field ("Bearer TOKEN"). Without one, the token among the
// subprotocols that a browser offers for its WebSocket: the one with two dots. "" if there is no
// token.
std::string_view FindToken(std::string_view authorization, std::string_view subprotocols = {});

}
