// SPDX-License-Identifier: BSD-3-Clause
// A failure that occurs thousands of times is reported once a minute.
#include "server/http/RareMessages.h"

#include <gtest/gtest.h>

using namespace kdstream;

TEST(RareMessages, ReportsTheSameOnceAMinuteWithACount)
{
  RareMessages messages;
  const RareMessages::Clock::time_point start{ std::chrono::hours(1) };
  EXPECT_EQ(messages.Take("no descriptors", start), "no descriptors");
  for (int i = 1; i < 600; ++i)
  {
    EXPECT_EQ(
      messages.Take("no descriptors", start + i * std::chrono::milliseconds(100)), std::nullopt);
  }
  EXPECT_EQ(messages.Take("out of memory", start), "out of memory") << "another one";
  const auto later = start + RareMessages::pause;
  EXPECT_EQ(messages.Take("no descriptors", later),
    "no descriptors (and 599 more times since the last message)");
  EXPECT_EQ(messages.Take("no descriptors", later), std::nullopt);
  EXPECT_EQ(messages.Take("out of memory", later), "out of memory") << "nothing was left out";
}

TEST(RareMessages, RemembersNoEndOfMessages)
{
  RareMessages messages;
  for (int i = 0; i < 1000; ++i)
  {
    const auto text = "error " + std::to_string(i);
    EXPECT_EQ(messages.Take(text), text);
  }
}
