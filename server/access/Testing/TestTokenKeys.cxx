// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "server/access/TokenKeys.h"

#include "Testing/Fixtures/TemporaryFolder.h"

#include <gtest/gtest.h>

#include <fstream>

using namespace kdstream;
using fixtures::Mentions;

namespace
{

const std::string secret = "0123456789abcdef0123456789abcdef";

std::string Wrong(const std::string& json)
{
  const auto keys = ParseTokenKeys(json);
  return keys ? "" : keys.GetError().message;
}

TEST(Keys, ASecretIsEnough)
{
  const auto keys = ParseTokenKeys("{\"secret\":\"" + secret + "\"}");
  ASSERT_TRUE(keys) << keys.GetError().message;
  ASSERT_EQ(keys->keys.size(), 1u);
  EXPECT_EQ(keys->keys[0].secret, secret);
  EXPECT_EQ(keys->keys[0].id, "");
  EXPECT_TRUE(keys->revoked.empty());
}

TEST(Keys, EarlierOnesAndWhatIsRevoked)
{
  const auto keys =
    ParseTokenKeys("{\"secret\":\"" + secret + "\",\"id\":\"b\",\"earlier\":[{\"secret\":\"" +
                   secret + "2\",\"id\":\"a\"},{\"secret\":\"" + secret +
                   "3\"}],\"revoked\":[\"t1\",\"t2\"],\"revoked_subjects\":[\"ann\"]}");
  ASSERT_TRUE(keys) << keys.GetError().message;
  EXPECT_EQ(keys->keys.size(), 3u);
  EXPECT_EQ(keys->keys[0].id, "b"); // the key that signs
  EXPECT_EQ(keys->Find("a")->secret, secret + "2");
  EXPECT_EQ(keys->Find("")->secret, secret + "3");
  EXPECT_EQ(keys->Find("c"), nullptr);
  EXPECT_TRUE(keys->revoked.contains("t2"));
  EXPECT_TRUE(keys->revokedSubjects.contains("ann"));
}

TEST(Keys, WhatIsWrongIsNamedAndNoSecretIsReported)
{
  EXPECT_NE(Wrong("").find("JSON"), std::string::npos);
  EXPECT_EQ(Wrong("[]"), "is not a JSON object");
  const std::string shortOne = "\"secret\" must be a string of at least 32 bytes";
  EXPECT_EQ(Wrong("{}"), shortOne);
  EXPECT_EQ(Wrong("{\"secret\":7}"), shortOne);
  EXPECT_EQ(Wrong("{\"secret\":\"" + secret.substr(1) + "\"}"), shortOne);
  const auto with = [](const std::string& more)
  { return Wrong("{\"secret\":\"" + secret + "\"," + more + "}"); };
  EXPECT_EQ(with("\"id\":\"a b\""), "\"id\" must have 1 to 64 characters of A-Z a-z 0-9 . _ -");
  EXPECT_EQ(with("\"id\":\"\""), "\"id\" must have 1 to 64 characters of A-Z a-z 0-9 . _ -");
  EXPECT_EQ(with("\"secret\":\"" + secret + "\""), "\"secret\" appears twice");
  EXPECT_TRUE(Mentions(with("\"revokd\":[]"), { "unknown", "\"revokd\"" }));
  EXPECT_TRUE(Mentions(with("\"revoked\":\"t1\""), { "\"revoked\"" }));
  EXPECT_TRUE(Mentions(with("\"revoked\":[7]"), { "\"revoked\"" }));
  EXPECT_TRUE(Mentions(with("\"revoked_subjects\":[\"\"]"), { "\"revoked_subjects\"" }));
  EXPECT_TRUE(Mentions(with("\"earlier\":{}"), { "\"earlier\"" }));
  EXPECT_NE(with("\"earlier\":[7]"), "");
  EXPECT_NE(with("\"earlier\":[{\"id\":\"a\"}]"), "");
  EXPECT_TRUE(Mentions(with("\"earlier\":[{\"secret\":\"" + secret + "\"}]"), { "\"id\"" }));
  std::string many;
  for (std::size_t i = 0; i < maximumKeys; ++i)
  {
    many +=
      (i ? ",{\"id\":\"" : "{\"id\":\"") + std::to_string(i) + "\",\"secret\":\"" + secret + "\"}";
  }
  EXPECT_EQ(with("\"earlier\":[" + many + "]"), "has more than 16 secrets");
  EXPECT_EQ(Wrong(std::string(maximumKeysBytes + 1, ' ')).find(secret), std::string::npos);
}

TEST(Keys, TheFileIsReadOrItIsSaidWhyNot)
{
  const fixtures::TemporaryFolder folder;
  const auto file = folder.Path / "tokens.json";
  EXPECT_EQ(ReadTokenKeys(file).GetError().code, ErrorCode::NotFound);
  EXPECT_EQ(ReadTokenKeys(folder.Path).GetError().code, ErrorCode::InputOutput);
  std::ofstream(file) << "{\"secret\":\"" << secret << "\"}\n";
  EXPECT_TRUE(ReadTokenKeys(file));
  std::ofstream(file) << std::string(maximumKeysBytes + 10, ' ');
  EXPECT_EQ(ReadTokenKeys(file).GetError().code, ErrorCode::InvalidInput);
}

}
