// SPDX-License-Identifier: BSD-3-Clause
// The address of a server as a user writes it: see ServerUrl.h.
#include "viewer/client/ServerUrl.h"

#include <algorithm>
#include <charconv>

namespace kdstream
{
namespace
{

std::string Shortened(std::string_view url)
{
  return std::string(1, '\'').append(url.substr(0, 200)).append(1, '\'');
}

Error Wrong(std::string_view url, const std::string& what)
{
  return { ErrorCode::InvalidArgument,
    Shortened(url).append(" is not a server's address: ").append(what) };
}

bool IsHostCharacter(char c)
{
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '-' || c == '_' || c == ':';
}

bool IsPort(std::string_view text)
{
  unsigned port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc{} && end == text.data() + text.size() && port > 0 && port < 65536;
}

}

std::string ServerUrl::Authority() const
{
  std::string text = this->host;
  if (text.find(':') != std::string::npos)
  {
    text.insert(text.begin(), '[');
    text += ']';
  }
  return text.append(":").append(this->port);
}

std::string ServerUrl::Origin() const
{
  return (this->isSecure ? "https://" : "http://") + this->Authority();
}

bool IsToken(std::string_view text)
{
  const auto isPart = [](char c) { return IsHostCharacter(c) && c != ':'; };
  return !text.empty() && text.size() <= 4096 && std::all_of(text.begin(), text.end(), isPart);
}

Result<ServerUrl> ParseServerUrl(std::string_view url)
{
  constexpr std::string_view plain = "http://", secure = "https://";
  ServerUrl server;
  server.isSecure = url.substr(0, secure.size()) == secure;
  if (!server.isSecure && url.substr(0, plain.size()) != plain)
  {
    return Wrong(url, "it must be http://HOST:PORT or https://HOST:PORT");
  }
  server.port = server.isSecure ? "443" : "80";
  std::string_view rest = url.substr((server.isSecure ? secure : plain).size());
  if (!rest.empty() && rest.back() == '/')
  {
    rest.remove_suffix(1);
  }
  std::string_view host = rest, port;
  if (!rest.empty() && rest.front() == '[')
  {
    const std::size_t end = rest.find(']');
    if (end == std::string_view::npos)
    {
      return Wrong(url, "']' is missing");
    }
    host = rest.substr(1, end - 1);
    port = rest.substr(end + 1);
  }
  else if (const std::size_t colon = rest.find(':'); colon != std::string_view::npos)
  {
    host = rest.substr(0, colon);
    port = rest.substr(colon);
  }
  if (host.empty() || !std::all_of(host.begin(), host.end(), IsHostCharacter))
  {
    return Wrong(url, "it must be http://HOST:PORT or https://HOST:PORT, without a path");
  }
  server.host = host;
  if (!port.empty())
  {
    if (port.front() != ':' || !IsPort(port.substr(1)))
    {
      return Wrong(url, "the port must be a number from 1 to 65535");
    }
    server.port = port.substr(1);
  }
  return server;
}

}
