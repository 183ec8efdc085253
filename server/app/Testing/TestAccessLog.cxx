// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/AccessLog.h"

#include "Testing/Fixtures/TemporaryFolder.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <fstream>

using namespace kdstream;
namespace fs = std::filesystem;

namespace
{

class Log : public testing::Test
{
protected:
  const fixtures::TemporaryFolder folder;
  const fs::path file = folder / "access.log";
  AccessRecord record{ "127.0.0.1", "GET", "/a \"b\"", 200, 512, 0.25 };

  void SetUp() override { std::signal(SIGPIPE, SIG_IGN); }
};

}

TEST_F(Log, ALineARequestAppended)
{
  std::ofstream(this->file) << "before\n";
  {
    const auto log = AccessLog::Open(this->file);
    ASSERT_TRUE(log);
    (*log)->Write(this->record);
  }
  const auto text = fixtures::ReadWhole(this->file);
  EXPECT_EQ(text.substr(0, 7), "before\n");
  EXPECT_EQ(text.substr(7 + 20), " 127.0.0.1 \"GET /a\\x20\\x22b\\x22\" 200 512 250.0\n");
}

TEST_F(Log, GoesOnInTheFileThatHasTheName)
{
  const auto old = fs::path(this->file) += ".1";
  {
    const auto log = AccessLog::Open(this->file);
    (*log)->Write(this->record);
    fs::rename(this->file, old);
    this->record.target = "/still-the-old";
    (*log)->Write(this->record);
    EXPECT_TRUE((*log)->Reopen());
    this->record.target = "/new";
    (*log)->Write(this->record);
  }
  EXPECT_NE(fixtures::ReadWhole(old).find("/still-the-old"), std::string::npos);
  EXPECT_EQ(fixtures::ReadWhole(old).find("/new"), std::string::npos);
  EXPECT_NE(fixtures::ReadWhole(this->file).find("/new"), std::string::npos);
}

TEST_F(Log, KeepsItsFileWhereItCannotHaveAnother)
{
  {
    const auto log = AccessLog::Open(this->file);
    fs::remove(this->file);
    fs::create_directory(this->file);
    EXPECT_FALSE((*log)->Reopen());
    (*log)->Write(this->record);
  }
  EXPECT_FALSE(AccessLog::Open(this->file));
  EXPECT_FALSE(AccessLog::Open("/nonexistent/log"));
}

TEST_F(Log, APipeThatNobodyReadsCostsLinesOnly)
{
  ASSERT_EQ(::mkfifo(this->file.c_str(), 0600), 0);
  const int reader = ::open(this->file.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  constexpr int lines = 200000;
  std::size_t got = 0, lost = 0;
  std::string text;
  {
    const auto log = AccessLog::Open(this->file);
    ASSERT_TRUE(log);
    for (int i = 0; i < lines; ++i)
    {
      (*log)->Write(this->record); // would wait for ever
    }
    ::fcntl(reader, F_SETFL, 0);
    char part[65536];
    while (text.find(" lines are lost\n") == std::string::npos)
    {
      const auto bytes = ::read(reader, part, sizeof part);
      ASSERT_GT(bytes, 0);
      text.append(part, static_cast<std::size_t>(bytes));
    }
  }
  ::close(reader);
  got = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) - 1;
  lost = std::stoul(text.substr(text.find("# ") + 2));
  EXPECT_EQ(got + lost, static_cast<std::size_t>(lines));
  EXPECT_GT(lost, 0u);
}

TEST_F(Log, EndsThoughThePipeIsFull)
{
  ASSERT_EQ(::mkfifo(this->file.c_str(), 0600), 0);
  const int reader = ::open(this->file.c_str(), O_RDONLY | O_NONBLOCK);
  {
    const auto log = AccessLog::Open(this->file);
    for (int i = 0; i < 10000; ++i)
    {
      (*log)->Write(this->record);
    }
  }
  ::close(reader);
}
