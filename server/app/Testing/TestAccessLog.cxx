// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/Eventually.h"
#include "server/app/AccessLog.h"

#include "Testing/Fixtures/TemporaryFolder.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <sstream>

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

TEST_F(Log, AClientBreaksNoLine)
{
  {
    const auto log = AccessLog::Open(this->file);
    ASSERT_TRUE(log);
    this->record.client = "fe80::1%\n127.0.0.1 \"";
    (*log)->Write(this->record);
  }
  const auto text = fixtures::ReadWhole(this->file);
  EXPECT_EQ(text.substr(20),
    " fe80::1%\\x0a127.0.0.1\\x20\\x22 \"GET /a\\x20\\x22b\\x22\" 200 512 250.0\n");
}

TEST_F(Log, ANewFileIsNotReadableForEverybody)
{
  ASSERT_TRUE(AccessLog::Open(this->file));
  EXPECT_EQ(fs::status(this->file).permissions() & fs::perms::others_all, fs::perms::none);
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
      (*log)->Write(this->record); // would wait forever
    }
    ::fcntl(reader, F_SETFL, 0);
    char part[65536];
    while (text.find(" lines were lost\n") == std::string::npos)
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

// A file that may not grow takes some of the lines, and the others are counted. When the file takes
// lines again, the next one begins on a line of its own, and the lost lines are reported.
TEST_F(Log, WhatADiskDoesNotTakeIsCounted)
{
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{ 1000, before.rlim_max };
  {
    const auto log = AccessLog::Open(this->file);
    ASSERT_TRUE(log);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    for (int i = 0; i < 100; ++i)
    {
      (*log)->Write(this->record);
    }
    const auto written = [this]
    {
      const auto text = fixtures::ReadWhole(this->file);
      return static_cast<std::uint64_t>(std::count(text.begin(), text.end(), '\n'));
    };
    // Wait until each line is either written or counted as lost.
    EXPECT_TRUE(fixtures::Eventually([&] { return (*log)->Lost() + written() >= 100; }));
    EXPECT_GT((*log)->Lost(), 80u); // there is room for about 16 lines
    EXPECT_TRUE(fixtures::ReadWhole(this->file).ends_with(" 250.0\n")) << "whole lines, or none";
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    this->record.target = "/after";
    (*log)->Write(this->record);
  }
  std::istringstream text(fixtures::ReadWhole(this->file));
  std::size_t whole = 0, lost = 0, after = 0;
  for (std::string line; std::getline(text, line);)
  {
    whole += line.ends_with(" 127.0.0.1 \"GET /a\\x20\\x22b\\x22\" 200 512 250.0") ? 1 : 0;
    after += line.ends_with(" 127.0.0.1 \"GET /after\" 200 512 250.0") ? 1 : 0;
    EXPECT_EQ(line.find("127.0.0.1"), line.rfind("127.0.0.1")) << line;
    lost += line.starts_with("# ") ? std::stoul(line.substr(2)) : 0;
  }
  EXPECT_GT(whole, 5u);
  EXPECT_EQ(whole + lost, 100u);
  EXPECT_EQ(after, 1u);
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
