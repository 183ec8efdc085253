// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/RequestForm.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>

namespace kdstream
{

namespace
{

// Whether the text begins with `start`, which is in lower case; the text may be in any case.
bool BeginsWith(std::string_view text, std::string_view start)
{
  return text.size() >= start.size() &&
         std::equal(start.begin(), start.end(), text.begin(),
           [](char a, char b) { return a == (b >= 'A' && b <= 'Z' ? b + ('a' - 'A') : b); });
}

bool IsSame(std::string_view text, std::string_view inLowerCase)
{
  return text.size() == inLowerCase.size() && BeginsWith(text, inLowerCase);
}

constexpr std::string_view digits = "0123456789";

bool IsAddressOf6(const std::string& text)
{
  in6_addr address{};
  return text.find('\0') == text.npos && ::inet_pton(AF_INET6, text.c_str(), &address) == 1;
}

}

std::optional<std::size_t> EmptyLine(std::string_view input)
{
  if (input == "\r" || input.empty())
  {
    return std::nullopt;
  }
  return input.substr(0, 2) == "\r\n" ? 2 : 0;
}

bool HasFoldedLine(std::string_view input)
{
  for (auto end = input.find("\r\n"); end != input.npos; end = input.find("\r\n", end + 2))
  {
    const auto next = input.substr(end + 2);
    if (next.empty() || next.front() == '\r') // the header's end
    {
      return false;
    }
    if (next.front() == ' ' || next.front() == '\t')
    {
      return true;
    }
  }
  return false;
}

std::optional<std::string_view> ParseHost(std::string_view field)
{
  constexpr std::string_view ofNames =
    "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._~";
  const bool isLiteral = field.starts_with('[');
  const auto end =
    isLiteral ? field.find(']') : std::min(field.find_first_not_of(ofNames), field.size());
  if (end == field.npos || (isLiteral && !IsAddressOf6(std::string(field.substr(1, end - 1)))))
  {
    return std::nullopt;
  }
  const auto host = field.substr(0, isLiteral ? end + 1 : end);
  const auto port = field.substr(host.size());
  if (!port.empty() && (port.front() != ':' || port.find_first_not_of(digits, 1) != port.npos))
  {
    return std::nullopt;
  }
  return host.substr(0, host.size() - (host.ends_with('.') ? 1 : 0));
}

bool CannotBeRebound(std::string_view host)
{
  if (host.empty())
  {
    return false;
  }
  const auto dot = host.rfind('.');
  if (dot == host.npos)
  {
    return true;
  }
  // If the last part of a host is a number, browsers take the host for an IPv4 address, or refuse
  // it.
  const auto last = host.substr(dot + 1);
  return (!last.empty() && last.find_first_not_of(digits) == last.npos) || host.front() == '[' ||
         IsSame(last, "localhost") || IsSame(host, "localhost.localdomain");
}

RequestTarget SplitTarget(std::string_view target)
{
  for (const std::string_view scheme : { "http://", "https://" })
  {
    if (BeginsWith(target, scheme))
    {
      const auto rest = target.substr(scheme.size());
      const auto end = std::min(rest.find_first_of("/?"), rest.size());
      const auto host = rest.substr(0, end);
      const auto path = rest.substr(end);
      if (host.empty() || host.find('@') != host.npos)
      {
        break;
      }
      return { std::string(host), (path.empty() || path[0] == '?' ? "/" : "") + std::string(path) };
    }
  }
  return { std::nullopt, std::string(target) };
}

}
