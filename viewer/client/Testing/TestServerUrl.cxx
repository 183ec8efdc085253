// SPDX-License-Identifier: BSD-3-Clause
// Addresses of servers, and the errors for texts that are none.
#include "viewer/client/ServerUrl.h"

#include <gtest/gtest.h>

using kdstream::ErrorCode;
using kdstream::ParseServerUrl;

namespace
{

TEST(TestServerUrl, ReadsHostsAndPorts)
{
  const std::vector<std::pair<std::string, std::string>> cases = {
    { "http://localhost:8700", "localhost:8700" },
    { "http://localhost:8700/", "localhost:8700" },
    { "http://example.org", "example.org:80" },
    { "http://127.0.0.1:1", "127.0.0.1:1" },
    { "http://[::1]:8700", "[::1]:8700" },
    { "http://[fe80::1]", "[fe80::1]:80" },
    { "https://example.org", "example.org:443" },
    { "https://[::1]:8443/", "[::1]:8443" },
  };
  for (const auto& [url, authority] : cases)
  {
    const auto server = ParseServerUrl(url);
    ASSERT_TRUE(server) << url;
    EXPECT_EQ(server->Authority(), authority);
    EXPECT_EQ(server->isSecure, url.rfind("https:", 0) == 0);
    EXPECT_EQ(server->Origin(), (server->isSecure ? "https://" : "http://") + authority);
  }
}

TEST(TestServerUrl, RefusesEverythingElseByName)
{
  for (const char* url : { "", "localhost:8700", "ftp://x", "http://", "http://:80", "http:///x",
         "http://a/b", "http://a:0", "http://a:65536", "http://a:-1", "http://a:80x", "http://a:",
         "http://[::1", "http://[]:3", "http://[::1]x", "http://a b", "http://u@h", "http://a?b",
         "http://a\r\nX: y", "https://", "https://a/b", "https://a:0", "HTTPS://a", "https:/a" })
  {
    const auto server = ParseServerUrl(url);
    ASSERT_FALSE(server) << url;
    EXPECT_EQ(server.GetError().code, ErrorCode::InvalidArgument) << url;
    EXPECT_NE(server.GetError().message.find(std::string("'") + url + "'"), std::string::npos);
  }
}

}
