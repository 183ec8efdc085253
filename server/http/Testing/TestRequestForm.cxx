// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/RequestForm.h"

#include <gtest/gtest.h>

using namespace kdstream;

TEST(RequestForm, AnEmptyLineBeforeARequestIsFound)
{
  EXPECT_EQ(EmptyLine(""), std::nullopt);
  EXPECT_EQ(EmptyLine("\r"), std::nullopt) << "not yet told";
  EXPECT_EQ(EmptyLine("\r\n"), 2u);
  EXPECT_EQ(EmptyLine("\r\nGET / HTTP/1.1\r\n"), 2u);
  EXPECT_EQ(EmptyLine("\rGET"), 0u);
  EXPECT_EQ(EmptyLine("G"), 0u);
}

TEST(RequestForm, AFoldedLineIsFoundBeforeTheHeaderEnds)
{
  EXPECT_TRUE(HasFoldedLine("GET / HTTP/1.1\r\nHost: a\r\n b\r\n\r\n"));
  EXPECT_TRUE(HasFoldedLine("GET / HTTP/1.1\r\n\tHost: a\r\n"));
  EXPECT_TRUE(HasFoldedLine("Host: a\r\n ")) << "as far as it has come";
  EXPECT_FALSE(HasFoldedLine("GET / HTTP/1.1\r\nHost: a\r\n\r\n"));
  EXPECT_FALSE(HasFoldedLine("GET / HTTP/1.1\r\nHost: a\r\n"));
  EXPECT_FALSE(HasFoldedLine("GET / HTTP/1.1\r\nHost: a\r\n\r\n GET")) << "of the next one";
  EXPECT_FALSE(HasFoldedLine(""));
}

TEST(RequestForm, AHostIsANameOrAnAddressAndAPort)
{
  const auto parsed = [](std::string_view field) { return std::string(*ParseHost(field)); };
  EXPECT_EQ(parsed("models.example"), "models.example");
  EXPECT_EQ(parsed("Models-1_x~.example:8700"), "Models-1_x~.example");
  EXPECT_EQ(parsed("models.example.:8700"), "models.example") << "the same name";
  EXPECT_EQ(parsed("127.0.0.1:80"), "127.0.0.1");
  EXPECT_EQ(parsed("[::1]"), "[::1]");
  EXPECT_EQ(parsed("[::ffff:192.0.2.1]:8700"), "[::ffff:192.0.2.1]");
  EXPECT_EQ(parsed("localhost:"), "localhost") << "the standard's port may be empty";
  EXPECT_EQ(parsed(""), "");
  EXPECT_EQ(parsed(":80"), "");
  for (const char* wrong : { "evil.example/.localhost", "evil.example#.localhost",
         "evil.example?.localhost", "evil.example\\.localhost", "x.localhost:80@evil.example",
         "localhost@evil.example", "[evil.example]", "[::1].evil.example", "[::1]x", "[::1", "[]",
         "[::1%25eth0]", "[1.2.3.4]", "[v1.evil]", "[[::1]]", "::1", "]", "localhost:80:90",
         "localhost:abc", "localhost:-1", "localhost:+1", "localhost: 80", "a b", "a\tb", "a,b",
         "loca%6chost", "evil.example:127.0.0.1", "http://localhost", "\xc3\xa4", "*" })
  {
    EXPECT_FALSE(ParseHost(wrong)) << wrong;
  }
  EXPECT_FALSE(ParseHost(std::string_view("localhost\0x", 11)));
  EXPECT_FALSE(ParseHost(std::string_view("[::1\0]", 6)));
}

TEST(RequestForm, NamesThatSomebodyMayHaveRegisteredCanBeRebound)
{
  for (const char* safe :
    { "127.0.0.1", "192.0.2.1", "127.1", "[::1]", "[::ffff:127.0.0.1]", "localhost", "LocalHost",
      "models.localhost", "localhost.localdomain", "x", "workstation" })
  {
    EXPECT_TRUE(CannotBeRebound(safe)) << safe;
  }
  for (const char* rebound : { "evil.example", "127.0.0.1.evil.example", "localhost.evil.example",
         "evil.notlocalhost", "localhost.localdomain.evil.example", "a.b", ".", "machine.local",
         "127.0.0.1x", "1.2.3.4.5a", "" })
  {
    EXPECT_FALSE(CannotBeRebound(rebound)) << rebound;
  }
}

TEST(RequestForm, ATargetMayNameItsHost)
{
  const auto split = [](std::string_view target)
  {
    const auto parts = SplitTarget(target);
    return parts.host.value_or("-") + " " + parts.path;
  };
  EXPECT_EQ(split("/a/b?c"), "- /a/b?c");
  EXPECT_EQ(split("http://example.com/a/b?c"), "example.com /a/b?c");
  EXPECT_EQ(split("HTTPS://[::1]:8700/"), "[::1]:8700 /");
  EXPECT_EQ(split("http://example.com"), "example.com /");
  EXPECT_EQ(split("http://example.com?c"), "example.com /?c");
  EXPECT_EQ(split("http:///a"), "- http:///a") << "names none";
  EXPECT_EQ(split("http://ann@example.com/a"), "- http://ann@example.com/a");
  EXPECT_EQ(split("ftp://example.com/a"), "- ftp://example.com/a");
  EXPECT_EQ(split("*"), "- *");
  EXPECT_EQ(split(""), "- ");
}
