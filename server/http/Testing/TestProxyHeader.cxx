// SPDX-License-Identifier: BSD-3-Clause
#include "filters/protocol/Testing/RandomMessages.h"
#include "server/http/ProxyHeader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <optional>

using namespace kdstream;
using namespace std::string_literals;

namespace
{

struct Outcome
{
  bool whole = false, malformed = false;
  std::string client;
  std::size_t taken = 0;
};

// Gives the header as many bytes as it wants to take.
Outcome Feed(const std::string& bytes)
{
  ProxyHeader header;
  Outcome outcome;
  for (;;)
  {
    const auto space = header.Space();
    if (space.empty() || outcome.taken + space.size() > bytes.size())
    {
      outcome.whole = space.empty() && !header.IsMalformed();
      outcome.malformed = header.IsMalformed();
      outcome.client = outcome.whole ? header.Client() : "";
      return outcome;
    }
    std::memcpy(space.data(), bytes.data() + outcome.taken, space.size());
    outcome.taken += space.size();
    header.Take();
  }
}

// The client in the header, which must be complete, with no bytes left over.
std::string ClientOf(const std::string& header)
{
  const auto outcome = Feed(header + "GET / HTTP/1.1\r\n\r\n");
  EXPECT_TRUE(outcome.whole) << header;
  EXPECT_EQ(outcome.taken, header.size()) << header;
  return outcome.client;
}

// Version 2 after its signature: command, family, addresses and more.
std::string Binary(unsigned command, unsigned family, const std::string& rest)
{
  std::string header = "\r\n\r\n\0\r\nQUIT\n"s;
  header += static_cast<char>(command);
  header += static_cast<char>(family);
  header += static_cast<char>(rest.size() >> 8);
  header += static_cast<char>(rest.size() & 255);
  return header + rest;
}

const std::string of4 = "\x01\x02\x03\x04\x05\x06\x07\x08\xc3\x50\x01\xbb";
const std::string of6 =
  "\x20\x01\x0d\xb8"s + std::string(11, '\0') + "\x07" + std::string(16, '\0') + "\0\1\0\2"s;

}

TEST(ProxyHeader, NamesTheClient)
{
  EXPECT_EQ(ClientOf("PROXY TCP4 1.2.3.4 5.6.7.8 50000 443\r\n"), "1.2.3.4");
  EXPECT_EQ(ClientOf("PROXY TCP6 2001:db8::7 ::1 1 65535\r\n"), "2001:db8::7");
  EXPECT_EQ(ClientOf("PROXY UNKNOWN\r\n"), "");
  EXPECT_EQ(ClientOf("PROXY UNKNOWN ffff::1 what ever\r\n"), "");
}

TEST(ProxyHeader, NamesTheClientInBytes)
{
  EXPECT_EQ(ClientOf(Binary(0x21, 0x11, of4)), "1.2.3.4");
  EXPECT_EQ(ClientOf(Binary(0x21, 0x11, of4 + std::string(200, 'x'))), "1.2.3.4") << "with more";
  EXPECT_EQ(ClientOf(Binary(0x21, 0x21, of6)), "2001:db8::7");
  EXPECT_EQ(ClientOf(Binary(0x20, 0x11, of4)), "") << "the proxy's own connection";
  EXPECT_EQ(ClientOf(Binary(0x20, 0, "")), "");
  EXPECT_EQ(ClientOf(Binary(0x21, 0, "")), "") << "it does not tell";
  EXPECT_EQ(ClientOf(Binary(0x21, 0x31, std::string(216, 's'))), "") << "a socket of its machine";
}

TEST(ProxyHeader, RefusesInvalidText)
{
  for (const std::string& wrong : { "GET /healthz HTTP/1.1\r\n\r\n"s, "PROXYTCP4 1.2.3.4"s,
         "PROXY TCP4 1.2.3.4 5.6.7.8 50000\r\n"s, "PROXY TCP4 1.2.3.4 5.6.7.8 1 2 3\r\n"s,
         "PROXY TCP4 1.2.3.4  5.6.7.8 1 2\r\n"s, "PROXY TCP4 1.2.3 5.6.7.8 1 2\r\n"s,
         "PROXY TCP4 ::1 5.6.7.8 1 2\r\n"s, "PROXY TCP6 1.2.3.4 ::1 1 2\r\n"s,
         "PROXY TCP4 1.2.3.4 5.6.7.8 65536 2\r\n"s, "PROXY TCP4 1.2.3.4 5.6.7.8 -1 2\r\n"s,
         "PROXY TCP4 1.2.3.4 5.6.7.8 1 2 \r\n"s, "PROXY UDP4 1.2.3.4 5.6.7.8 1 2\r\n"s,
         "PROXY UNKNOWN "s + std::string(200, 'x') + "\r\n", std::string(100, '\0'),
         Binary(0x11, 0x11, of4), Binary(0x22, 0x11, of4), Binary(0x21, 0x11, of4.substr(1)),
         Binary(0x21, 0x21, of6.substr(1)), Binary(0x21, 0x11, std::string(5000, 'x')) })
  {
    const auto outcome = Feed(wrong);
    EXPECT_TRUE(outcome.malformed) << wrong;
    EXPECT_LE(outcome.taken, ProxyHeader::mostBytes);
  }
}

TEST(ProxyHeader, WaitsForTheRest)
{
  for (const std::string& good : { "PROXY TCP4 1.2.3.4 5.6.7.8 50000 443\r\n"s,
         Binary(0x21, 0x11, of4), Binary(0x21, 0x21, of6) })
  {
    for (std::size_t bytes = 0; bytes < good.size(); ++bytes)
    {
      const auto outcome = Feed(good.substr(0, bytes));
      EXPECT_FALSE(outcome.whole) << bytes;
      EXPECT_FALSE(outcome.malformed) << bytes;
    }
  }
}

TEST(ProxyHeader, SurvivesHostileBytes)
{
  protocol::RandomMessages random(5);
  for (int i = 0; i < 20000; ++i)
  {
    const auto bytes = random.Mutated(i % 3 == 0   ? "PROXY TCP6 2001:db8::7 ::1 1 65535\r\n"s
                                      : i % 3 == 1 ? Binary(0x21, 0x11, of4)
                                                   : Binary(0x21, 0x21, of6));
    const auto outcome = Feed(bytes + std::string(5000, 'x'));
    EXPECT_TRUE(outcome.whole || outcome.malformed);
    EXPECT_LE(outcome.taken, ProxyHeader::mostBytes);
  }
}
