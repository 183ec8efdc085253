// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/ClientLimits.h"

#include <gtest/gtest.h>

using namespace kdstream;
using namespace std::chrono_literals;

TEST(ClientLimits, AnAddressHasALimitedNumberOfSlots)
{
  ClientLimits limits(2, 0);
  auto first = limits.TakeSlot("10.0.0.1");
  const auto second = limits.TakeSlot("::ffff:10.0.0.1");
  EXPECT_TRUE(first && second);
  EXPECT_FALSE(limits.TakeSlot("10.0.0.1"));
  const auto other = limits.TakeSlot("10.0.0.2");
  EXPECT_TRUE(other);
  first.reset();
  EXPECT_TRUE(limits.TakeSlot("10.0.0.1"));
}

TEST(ClientLimits, OneSubscriberHasOneNetworkOfIpv6)
{
  ClientLimits limits(1, 0);
  const auto slot = limits.TakeSlot("2001:db8:1:2::1");
  EXPECT_FALSE(limits.TakeSlot("2001:db8:1:2:ffff::1"));
  EXPECT_TRUE(limits.TakeSlot("2001:db8:1:3::1"));
}

TEST(ClientLimits, TheDefaultIsNotForThisMachine)
{
  ClientLimits limits({}, {});
  std::vector<std::shared_ptr<void>> slots;
  for (std::size_t i = 0; i < ClientLimits::defaultConnections; ++i)
  {
    slots.push_back(limits.TakeSlot("192.0.2.1"));
    slots.push_back(limits.TakeSlot("127.0.0.1"));
    slots.push_back(limits.TakeSlot("::1"));
    EXPECT_TRUE(slots.rbegin()[0] && slots.rbegin()[1] && slots.rbegin()[2]);
  }
  EXPECT_FALSE(limits.TakeSlot("192.0.2.1"));
  EXPECT_TRUE(limits.TakeSlot("127.0.0.1"));
  EXPECT_TRUE(limits.TakeSlot("::1"));
  ClientLimits own(1, 0);
  const auto slot = own.TakeSlot("127.0.0.1");
  EXPECT_FALSE(own.TakeSlot("127.0.0.1")) << "unless it is given";
}

TEST(ClientLimits, RequestsComeBackEvenly)
{
  ClientLimits limits(0, 60);
  const auto start = ClientLimits::Clock::now();
  for (int i = 0; i < 60; ++i)
  {
    EXPECT_EQ(limits.TakeRequest("10.0.0.1", start), 0s);
  }
  EXPECT_EQ(limits.TakeRequest("10.0.0.1", start), 1s);
  EXPECT_EQ(limits.TakeRequest("10.0.0.2", start), 0s);
  EXPECT_EQ(limits.TakeRequest("10.0.0.1", start + 900ms), 1s);
  EXPECT_EQ(limits.TakeRequest("10.0.0.1", start + 1100ms), 0s);
  EXPECT_EQ(limits.TakeRequest("10.0.0.1", start + 1200ms), 1s);
  for (int i = 0; i < 60; ++i)
  {
    EXPECT_EQ(limits.TakeRequest("10.0.0.1", start + 10min), 0s);
  }
  EXPECT_EQ(limits.TakeRequest("10.0.0.1", start + 10min), 1s) << "never more than a minute's";
}

TEST(ClientLimits, WhoHasToWaitLearnsHowLong)
{
  ClientLimits limits(0, 20); // one every three seconds
  const auto start = ClientLimits::Clock::now();
  for (int i = 0; i < 20; ++i)
  {
    EXPECT_EQ(limits.TakeRequest("10.0.0.1", start), 0s);
  }
  EXPECT_EQ(limits.TakeRequest("10.0.0.1", start), 3s);
  EXPECT_EQ(limits.TakeRequest("10.0.0.1", start + 1500ms), 2s);
  EXPECT_EQ(limits.TakeRequest("10.0.0.1", start + 2900ms), 1s);
  EXPECT_EQ(limits.TakeRequest("10.0.0.1", start + 3100ms), 0s) << "as it was told";
}

TEST(ClientLimits, ThoseWhoAreGoneAreForgotten)
{
  ClientLimits limits(5, 60);
  const auto start = ClientLimits::Clock::now();
  const auto slot = limits.TakeSlot("10.9.9.9");
  for (int minute = 0; minute < 20; ++minute)
  {
    for (int i = 0; i < 1000; ++i)
    {
      limits.TakeRequest("10.0." + std::to_string(minute) + "." + std::to_string(i), // any text
        start + minute * 2min);
      limits.TakeSlot("10.1." + std::to_string(i));
    }
  }
  EXPECT_LE(limits.Size(), 3000u);
  EXPECT_GE(limits.Size(), 1u);
}

TEST(TrustedProxies, OnlyTheyAreBelieved)
{
  const auto proxies = *TrustedProxies::Parse({ "127.0.0.1", "10.0.0.0/8", "2001:db8::/32" });
  EXPECT_EQ(proxies.ClientOf("192.0.2.1", "1.2.3.4"), "192.0.2.1");
  EXPECT_EQ(proxies.ClientOf("127.0.0.1", "1.2.3.4"), "1.2.3.4");
  EXPECT_EQ(proxies.ClientOf("127.0.0.1", "6.6.6.6, 1.2.3.4 , 10.1.2.3"), "1.2.3.4")
    << "what the client wrote itself is not believed";
  EXPECT_EQ(proxies.ClientOf("2001:db8::7", "1.2.3.4"), "1.2.3.4");
  EXPECT_EQ(proxies.ClientOf("::ffff:10.3.3.3", "1.2.3.4"), "1.2.3.4");
  EXPECT_EQ(proxies.ClientOf("127.0.0.1", "::ffff:1.2.3.4"), "1.2.3.4");
  EXPECT_EQ(proxies.ClientOf("127.0.0.1", "1.2.3.4:567"), "1.2.3.4") << "with its port";
  EXPECT_EQ(proxies.ClientOf("127.0.0.1", "1.2.3.4:567, 10.1.2.3:80"), "1.2.3.4");
  EXPECT_EQ(proxies.ClientOf("127.0.0.1", "[2001:db9::1]:80"), "2001:db9::1");
  EXPECT_EQ(proxies.ClientOf("127.0.0.1", "[2001:db9::1]"), "2001:db9::1");
  EXPECT_EQ(proxies.ClientOf("127.0.0.1", "2001:db9::1"), "2001:db9::1");
  for (const char* wrong : { "1.2.3.4:", "1.2.3.4:x", "1.2.3.4:567890", "[2001:db9::1", "[]:80",
         ":80", "[2001:db9::1]80" })
  {
    EXPECT_EQ(proxies.ClientOf("127.0.0.1", wrong), "127.0.0.1") << wrong;
  }
  EXPECT_EQ(proxies.ClientOf("127.0.0.1", ""), "127.0.0.1");
  EXPECT_EQ(proxies.ClientOf("127.0.0.1", "nobody\"\n"), "127.0.0.1");
  EXPECT_EQ(proxies.ClientOf("127.0.0.1", "x, 10.0.0.1"), "10.0.0.1");
  EXPECT_EQ(proxies.ClientOf("127.0.0.1", ",,"), "127.0.0.1");
  EXPECT_EQ(TrustedProxies().ClientOf("127.0.0.1", "1.2.3.4"), "127.0.0.1");
}

TEST(TrustedProxies, AreAddressesAndNetworks)
{
  for (const char* wrong :
    { "", "proxy", "1.2.3", "1.2.3.4/33", "::1/129", "1.2.3.4/", "1.2.3.4/x" })
  {
    EXPECT_FALSE(TrustedProxies::Parse({ wrong })) << wrong;
  }
  EXPECT_TRUE(TrustedProxies::Parse({}));
}
