// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/HttpMessage.h"

#include <boost/beast/http/status.hpp>

#include <cstdio>
#include <ctime>
#include <string_view>

namespace kdstream
{

namespace
{

// The time in the format of the Date field, in any locale.
std::string HttpDate(std::time_t time)
{
  constexpr const char* days[] = { "Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat" };
  constexpr const char* months[] = { "Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep",
    "Oct", "Nov", "Dec" };
  std::tm utc{};
  gmtime_r(&time, &utc);
  char text[40];
  std::snprintf(text, sizeof text, "%s, %02d %s %d %02d:%02d:%02d GMT", days[utc.tm_wday],
    utc.tm_mday, months[utc.tm_mon], utc.tm_year + 1900, utc.tm_hour, utc.tm_min, utc.tm_sec);
  return text;
}

// The present date, formatted once a second.
const std::string& DateNow()
{
  thread_local std::time_t written = -1;
  thread_local std::string text;
  const std::time_t now = std::time(nullptr);
  if (now != written)
  {
    text = HttpDate(now);
    written = now;
  }
  return text;
}

}

std::string_view HttpResponse::Field(std::string_view name) const
{
  for (const auto& field : this->fields)
  {
    if (field.first == name)
    {
      return field.second;
    }
  }
  return {};
}

std::string WriteResponseHead(
  const HttpResponse& response, bool isOld, bool keepAlive, std::chrono::seconds strictTransport)
{
  namespace http = boost::beast::http;
  const auto reason = http::obsolete_reason(static_cast<http::status>(response.status));
  std::string head;
  head.reserve(512);
  head = isOld ? "HTTP/1.0 " : "HTTP/1.1 ";
  head += std::to_string(response.status) + " ";
  head.append(reason.data(), reason.size());
  head += "\r\n";
  const auto field = [&head](std::string_view name, std::string_view value)
  { head.append(name).append(": ").append(value).append("\r\n"); };
  for (const auto& [name, value] : response.fields)
  {
    field(name, value);
  }
  field("Date", DateNow());
  if (strictTransport.count() > 0)
  {
    field("Strict-Transport-Security", "max-age=" + std::to_string(strictTransport.count()));
  }
  if (keepAlive == isOld) // differs from the version's default
  {
    field("Connection", isOld ? "keep-alive" : "close");
  }
  if (response.status != 304 && response.status != 204)
  {
    field("Content-Length", std::to_string(response.length));
  }
  return head + "\r\n";
}

}
