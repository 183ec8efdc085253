// SPDX-License-Identifier: BSD-3-Clause
#include "server/access/TokenGuard.h"

#include "filters/core/Texts.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <utility>

namespace kdstream
{

namespace
{

std::int64_t SystemSeconds()
{
  return std::chrono::duration_cast<std::chrono::seconds>(
    std::chrono::system_clock::now().time_since_epoch())
    .count();
}

}

TokenGuard::TokenGuard(TokenKeys keys, Clock clock)
  : Current(std::make_shared<const TokenKeys>(std::move(keys)))
  , Now(clock ? std::move(clock) : Clock(SystemSeconds))
{
}

void TokenGuard::Replace(TokenKeys keys)
{
  auto next = std::make_shared<const TokenKeys>(std::move(keys));
  const std::lock_guard lock(this->Mutex);
  this->Current.swap(next);
}

std::shared_ptr<const TokenKeys> TokenGuard::Keys() const
{
  const std::lock_guard lock(this->Mutex);
  return this->Current;
}

Result<std::shared_ptr<const Pass>> TokenGuard::Admit(std::string_view token) const
{
  if (token.empty())
  {
    return Error{ ErrorCode::InvalidInput, "this server requires a token" };
  }
  auto keys = this->Keys();
  auto claims = ReadToken(token, *keys, this->Now());
  KDSTREAM_TRY(claims);
  return std::make_shared<const Pass>(
    Pass{ std::move(*claims), std::string(token), std::move(keys) });
}

Status TokenGuard::Check(const Pass& pass) const
{
  const auto keys = this->Keys();
  const auto now = this->Now();
  const bool same = keys == pass.keys; // with the same keys only time can change the result
  if (same && now < pass.claims.expires && now >= pass.claims.notBefore)
  {
    return {};
  }
  const auto claims = ReadToken(pass.token, *keys, now);
  KDSTREAM_TRY(claims);
  return {};
}

std::string_view FindToken(std::string_view authorization, std::string_view subprotocols)
{
  constexpr std::string_view scheme = "bearer";
  const auto field = Trimmed(authorization);
  const auto space = std::min(field.find(' '), field.size());
  const bool isBearer = std::equal(field.begin(),
    field.begin() + static_cast<std::ptrdiff_t>(space), scheme.begin(), scheme.end(),
    [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
  if (isBearer)
  {
    return Trimmed(field.substr(space));
  }
  while (!subprotocols.empty())
  {
    const auto comma = std::min(subprotocols.find(','), subprotocols.size());
    const auto offered = Trimmed(subprotocols.substr(0, comma));
    if (std::count(offered.begin(), offered.end(), '.') == 2)
    {
      return offered;
    }
    subprotocols.remove_prefix(std::min(comma + 1, subprotocols.size()));
  }
  return {};
}

}
