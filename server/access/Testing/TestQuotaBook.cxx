// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "server/access/QuotaBook.h"

#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/store/Sqlite.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <set>
#include <thread>
#include <vector>

using namespace kdstream;

namespace
{

constexpr std::int64_t second = 1'000'000;
constexpr std::uint64_t partitions = 1000;

CountedModel Model(std::string_view digest, std::string_view input = {})
{
  return { digest, input, "1000", partitions };
}

class Quotas : public testing::Test
{
protected:
  const fixtures::TemporaryFolder folder;
  const std::filesystem::path file = this->folder.Path / "quotas.db";
  std::atomic<std::int64_t> time{ 1'000'000 * second };

  std::unique_ptr<QuotaBook> Open(const QuotaLimits& limits)
  {
    auto book = QuotaBook::Open(this->file, limits, [this] { return this->time.load(); });
    EXPECT_TRUE(book) << book.GetError().message;
    return std::move(*book);
  }
  static bool May(QuotaBook& book, const std::string& subject, std::uint32_t partition,
    const std::string& model = "m", std::uint64_t bytes = 1)
  {
    const auto taken = book.TakePartition(subject, Model(model), partition, bytes);
    EXPECT_TRUE(taken) << taken.GetError().message;
    return taken && !*taken;
  }
};

QuotaLimits Share(double share)
{
  QuotaLimits limits;
  limits.share = share;
  limits.window = std::chrono::seconds(100);
  return limits;
}

}

TEST_F(Quotas, ItsFileIsOnlyForItsOwner)
{
  const auto book = this->Open(Share(0.01));
  EXPECT_TRUE(May(*book, "ann", 1));
  namespace fs = std::filesystem;
  std::size_t files = 0;
  for (const auto& each : fs::directory_iterator(this->folder.Path))
  {
    const auto others = fs::perms::group_all | fs::perms::others_all;
    EXPECT_EQ(each.status().permissions() & others, fs::perms::none) << each.path();
    ++files;
  }
  EXPECT_GE(files, 1u);
}

// Otherwise two servers would continue with different files, or one with no file.
TEST_F(Quotas, AFileThatIsRemovedOrReplacedIsNoticed)
{
  const auto book = this->Open(Share(0.002)); // 2 of 1000
  EXPECT_TRUE(May(*book, "ann", 1));
  EXPECT_TRUE(May(*book, "ann", 2));
  EXPECT_FALSE(May(*book, "ann", 3));
  for (const char* const end : { "", "-wal", "-shm" })
  {
    std::filesystem::remove(this->file.string() + end);
  }
  const auto refused = book->TakePartition("ann", Model("m"), 3, 1);
  EXPECT_TRUE(fixtures::FailsAt(refused, ErrorCode::InputOutput, "removed or replaced"));
  EXPECT_TRUE(May(*book, "ann", 3)) << "in a new one";
  EXPECT_TRUE(std::filesystem::exists(this->file));
  const auto other = this->Open(Share(0.002));
  EXPECT_TRUE(May(*other, "ann", 4));
  EXPECT_FALSE(May(*book, "ann", 5)) << "which they share";
  std::filesystem::remove(this->file);
  std::filesystem::create_directory(this->file);
  for (int i = 0; i < 2; ++i)
  {
    EXPECT_FALSE(book->TakePartition("ann", Model("m"), 5, 1)) << "no file, no partition";
  }
}

TEST_F(Quotas, AShareOfTheModelInAWindow)
{
  const auto book = this->Open(Share(0.0105)); // 10 of 1000
  for (std::uint32_t p = 0; p < 10; ++p)
  {
    EXPECT_TRUE(May(*book, "ann", 7 * p));
    this->time += second;
  }
  const auto refused = book->TakePartition("ann", Model("m"), 500, 1);
  ASSERT_TRUE(refused && *refused);
  EXPECT_EQ((*refused)->endsIn, std::chrono::seconds(90)) << "when the first is forgotten";
  EXPECT_EQ((*refused)->message,
    "the quota of 10 partitions of this model is used up: try again at 1970-01-12T13:48:20Z");
  EXPECT_TRUE(May(*book, "ann", 7)) << "which she has";
  EXPECT_TRUE(May(*book, "bob", 500)) << "each has his own";
  EXPECT_TRUE(May(*book, "ann", 500, "another")) << "of each model";
  this->time += 90 * second;
  EXPECT_TRUE(May(*book, "ann", 500)) << "the first is forgotten";
  EXPECT_FALSE(May(*book, "ann", 501));
  EXPECT_FALSE(May(*book, "ann", 0)) << "and counts anew";
}

// After a clock was years ahead for a while, nobody is refused for years.
TEST_F(Quotas, OutliveAClockThatWasAhead)
{
  auto limits = Share(0.002); // 2 of 1000
  limits.bytesPerSecond = 1'000'000;
  limits.regionsPerMinute = 1;
  const auto book = this->Open(limits);
  constexpr std::int64_t years = std::int64_t{ 10 } * 365 * 24 * 3600 * second;
  const auto region = [&book]
  {
    const auto taken = book->TakeRegion("ann", Model("m"));
    return taken && !*taken;
  };
  this->time += years;
  EXPECT_TRUE(May(*book, "ann", 1, "m", 30'000'000));
  EXPECT_TRUE(region());
  EXPECT_FALSE(May(*book, "ann", 3)) << "too many bytes";
  EXPECT_FALSE(region());
  this->time -= years;
  EXPECT_TRUE(May(*book, "ann", 4));
  EXPECT_FALSE(May(*book, "ann", 5)) << "what was had in the future is not forgotten";
  EXPECT_TRUE(region());
  EXPECT_FALSE(region());
  this->time += 101 * second;
  EXPECT_TRUE(May(*book, "ann", 5)) << "but it counts from now on";
}

// However far the clock is set back, nobody gets a quota twice.
TEST_F(Quotas, AClockThatIsSetBackForgetsNothing)
{
  constexpr std::int64_t steps[] = { 1, 99, 101, 1'000, 100'000 }; // the window has 100 seconds
  for (const auto back : steps)
  {
    const auto model = std::to_string(back);
    const auto book = this->Open(Share(0.002)); // 2 of 1000
    EXPECT_TRUE(May(*book, "ann", 1, model));
    EXPECT_TRUE(May(*book, "ann", 2, model));
    this->time -= back * second;
    EXPECT_FALSE(May(*book, "ann", 3, model)) << back;
    EXPECT_TRUE(May(*book, "ann", 2, model)) << "which she has";
    EXPECT_FALSE(May(*this->Open(Share(0.002)), "ann", 3, model)) << "after a restart";
    this->time += back * second;
  }
}

// Nor does a clock that goes back a little, or is a little late, give a new quota.
TEST_F(Quotas, AClockThatIsALittleSlowGivesNoMore)
{
  QuotaLimits limits;
  limits.regionsPerMinute = 3;
  limits.bytesPerSecond = 1'000'000;
  const std::unique_ptr<QuotaBook> books[] = { this->Open(limits), this->Open(limits) };
  const auto region = [&books](int server)
  { return !*books[server]->TakeRegion("ann", Model("m")); };
  int had = 0;
  for (int i = 0; i < 120; ++i) // two minutes; one server is a second behind
  {
    had += region(0) ? 1 : 0;
    this->time -= second;
    had += region(1) ? 1 : 0;
    this->time += 2 * second;
  }
  EXPECT_LE(had, 3 + 2 * 3);
  EXPECT_GE(had, 3 + 2 * 3 - 2) << "and not much less";
  EXPECT_TRUE(May(*books[0], "ann", 1, "m", 60'000'000));
  this->time -= 30 * second;
  EXPECT_FALSE(May(*books[1], "ann", 2));
}

// Builds with another precision or title, or by another conversion, have the same original.
TEST_F(Quotas, BuildsOfOneInputCountTogether)
{
  auto limits = Share(0.002); // 2 of 1000
  limits.regionsPerMinute = 1;
  limits.bytesPerSecond = 1'000'000;
  const auto book = this->Open(limits);
  const auto may = [&](const CountedModel& model, std::uint32_t partition, std::uint64_t bytes = 1)
  {
    const auto taken = book->TakePartition("ann", model, partition, bytes);
    EXPECT_TRUE(taken) << taken.GetError().message;
    return taken && !*taken;
  };
  const auto fine = Model("fine", "input"), coarse = Model("coarse", "input"),
             another = Model("another", "another input");
  EXPECT_TRUE(may(fine, 1));
  EXPECT_TRUE(may(coarse, 1)) << "which she has";
  EXPECT_TRUE(may(coarse, 2));
  EXPECT_FALSE(may(coarse, 3));
  EXPECT_FALSE(may(fine, 3));
  EXPECT_TRUE(may(fine, 2));
  EXPECT_TRUE(may(another, 3));
  EXPECT_FALSE(*book->TakeRegion("ann", fine));
  EXPECT_TRUE(*book->TakeRegion("ann", coarse)) << "too fast";
  EXPECT_FALSE(*book->TakeRegion("ann", another));
  EXPECT_TRUE(may(fine, 1, 60'000'000));
  EXPECT_FALSE(may(coarse, 1)) << "too fast";
  EXPECT_TRUE(may(another, 3));
  this->time += 101 * second;
  EXPECT_TRUE(may(coarse, 8)) << "all expires";
  EXPECT_TRUE(may(fine, 9));
  EXPECT_FALSE(may(coarse, 10));
}

// If a model has half as many partitions, each counts twice as much.
TEST_F(Quotas, BuildsThatAreDividedOtherwiseCountByTheirShare)
{
  const auto book = this->Open(Share(0.01));
  const CountedModel thousand = Model("a", "input"), hundred{ "b", "input", "100", 100 },
                     many{ "c", "input", "3000", 3000 };
  const auto may = [&](const CountedModel& model, std::uint32_t partition)
  { return !*book->TakePartition("ann", model, partition, 1); };
  for (std::uint32_t p = 0; p < 5; ++p)
  {
    EXPECT_TRUE(may(thousand, p));
  }
  EXPECT_FALSE(may(hundred, 1)) << "one is all there is, and half of that was had";
  std::uint32_t more = 0;
  for (; more < 100 && may(many, more); ++more)
  {
  }
  EXPECT_EQ(more, 15u);
  EXPECT_FALSE(may(thousand, 5));
  EXPECT_TRUE(may(thousand, 4)) << "which she has";
  this->time += 101 * second;
  EXPECT_TRUE(may(hundred, 1));
  EXPECT_FALSE(may(many, 0));
}

// Entries made before a store gave its input (also by older servers) count as entries of the input;
// none of them counts twice.
TEST_F(Quotas, WhatWasHadBeforeTheInputWasKnownCounts)
{
  const auto book = this->Open(Share(0.004)); // 4 of 1000
  EXPECT_TRUE(May(*book, "ann", 1, "fine"));
  this->time += second;
  EXPECT_TRUE(May(*book, "ann", 2, "fine"));
  EXPECT_TRUE(May(*book, "ann", 1, "coarse"));
  EXPECT_TRUE(May(*book, "ann", 3, "coarse"));
  EXPECT_TRUE(May(*book, "bob", 1, "coarse"));
  ASSERT_TRUE(Execute(OpenForWriting(this->file)->get(), "DELETE FROM originals"));
  const auto fine = Model("fine", "input"), coarse = Model("coarse", "input");
  const auto may = [&](const CountedModel& model, std::uint32_t partition)
  { return !*book->TakePartition("ann", model, partition, 1); };
  EXPECT_TRUE(may(fine, 3)) << "it is not yet known that she has it";
  EXPECT_TRUE(may(coarse, 2)) << "now it is";
  EXPECT_TRUE(may(coarse, 4)) << "the fourth";
  EXPECT_FALSE(may(fine, 5));
  EXPECT_FALSE(may(coarse, 5));
  EXPECT_FALSE(May(*book, "ann", 5, "fine")) << "of a store that does not tell";
  const auto count = [this](const char* sql)
  { return *QueryInteger(OpenForWriting(this->file)->get(), sql); };
  EXPECT_EQ(count("SELECT count(*) FROM had WHERE subject = 'ann'"), 4);
  EXPECT_EQ(count("SELECT sum(count) FROM counts WHERE subject = 'ann'"), 4);
  EXPECT_EQ(count("SELECT count(*) FROM had WHERE subject = 'bob'"), 1);
  this->time += 99 * second;
  EXPECT_TRUE(may(coarse, 6)) << "the first is forgotten, which was had first by the other";
  EXPECT_FALSE(may(coarse, 7));
}

// One store is built from two files with the same content, another store from only one of them.
TEST_F(Quotas, InputsOfOneContentAreOneOriginal)
{
  const auto book = this->Open(Share(0.003)); // 3 of 1000
  const auto may = [&](const CountedModel& model, std::uint32_t partition)
  { return !*book->TakePartition("ann", model, partition, 1); };
  EXPECT_TRUE(may(Model("fine", "ascii"), 1));
  EXPECT_TRUE(may(Model("coarse", "binary"), 2));
  EXPECT_TRUE(may(Model("another", "ascii"), 3));
  EXPECT_TRUE(may(Model("coarse", "binary"), 4)) << "nothing says that they are one";
  EXPECT_FALSE(may(Model("fine", "binary"), 5)) << "this does: four were had";
  EXPECT_FALSE(may(Model("another", "ascii"), 5));
  EXPECT_TRUE(may(Model("another", "ascii"), 4)) << "she has all four";
}

TEST_F(Quotas, LeaveAtLeastOnePartition)
{
  const auto book = this->Open(Share(1e-9));
  EXPECT_TRUE(May(*book, "ann", 3));
  EXPECT_FALSE(May(*book, "ann", 4));
}

TEST_F(Quotas, AreKeptOverRestarts)
{
  {
    const auto book = this->Open(Share(0.002));
    EXPECT_TRUE(May(*book, "ann", 1));
    EXPECT_TRUE(May(*book, "ann", 2));
  }
  this->time += 50 * second;
  {
    const auto book = this->Open(Share(0.002));
    EXPECT_FALSE(May(*book, "ann", 3));
  }
  this->time += 50 * second;
  const auto book = this->Open(Share(0.002)); // removes expired entries
  EXPECT_TRUE(May(*book, "ann", 3));
  EXPECT_TRUE(May(*book, "ann", 4));
  EXPECT_FALSE(May(*book, "ann", 5));
}

TEST_F(Quotas, BytesASecond)
{
  QuotaLimits limits;
  limits.bytesPerSecond = 1000;
  const auto book = this->Open(limits);
  EXPECT_TRUE(May(*book, "ann", 0, "m", 9'999));
  EXPECT_TRUE(May(*book, "ann", 0, "m", 5'000)) << "as long as it is within ten seconds' worth";
  const auto refused = book->TakePartition("ann", Model("m"), 0, 1);
  ASSERT_TRUE(refused && *refused);
  EXPECT_EQ((*refused)->endsIn, std::chrono::seconds(5));
  EXPECT_TRUE(May(*book, "bob", 0, "m", 1));
  this->time += 5 * second;
  EXPECT_TRUE(May(*book, "ann", 0, "m", 1'000));
  // In the long run the rate is not exceeded.
  std::uint64_t had = 0;
  for (int i = 0; i < 1000; ++i)
  {
    this->time += second / 2;
    had += May(*book, "ann", 0, "m", 2'000) ? 2'000 : 0;
  }
  EXPECT_NEAR(static_cast<double>(had), 500'000, 12'000);
}

// A request that one quota refuses does not count against any quota.
TEST_F(Quotas, OfWhatIsRefusedNothingIsEntered)
{
  auto limits = Share(0.002);
  limits.bytesPerSecond = 1000;
  const auto book = this->Open(limits);
  EXPECT_TRUE(May(*book, "ann", 1, "m", 15'000));
  EXPECT_FALSE(May(*book, "ann", 2)) << "too fast";
  EXPECT_FALSE(May(*book, "ann", 3)) << "too fast";
  this->time += 6 * second;
  EXPECT_TRUE(May(*book, "ann", 3)) << "the second of two";
}

TEST_F(Quotas, RegionsAMinute)
{
  QuotaLimits limits;
  limits.regionsPerMinute = 3;
  const auto book = this->Open(limits);
  for (int i = 0; i < 3; ++i)
  {
    EXPECT_FALSE(*book->TakeRegion("ann", Model("m")));
  }
  const auto refused = *book->TakeRegion("ann", Model("m"));
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->endsIn, std::chrono::seconds(20));
  this->time += 20 * second;
  EXPECT_FALSE(*book->TakeRegion("ann", Model("m")));
  EXPECT_TRUE(*book->TakeRegion("ann", Model("m")));
  EXPECT_FALSE(*book->TakeRegion("bob", Model("m")));
}

// Two servers with one file together give no partition more than a single server would.
TEST_F(Quotas, TwoServersGiveNoMoreThanOne)
{
  const std::unique_ptr<QuotaBook> books[] = { this->Open(Share(0.1)), this->Open(Share(0.1)) };
  std::vector<std::set<std::uint32_t>> had(6);
  std::vector<std::thread> readers;
  for (std::uint32_t reader = 0; reader < had.size(); ++reader)
  {
    readers.emplace_back(
      [&, reader]
      {
        for (std::uint32_t i = 0; i < 300; ++i)
        {
          const auto partition = (i * 37 + reader * 151) % partitions;
          if (May(*books[reader % 2], "ann", static_cast<std::uint32_t>(partition)))
          {
            had[reader].insert(static_cast<std::uint32_t>(partition));
          }
        }
      });
  }
  for (auto& reader : readers)
  {
    reader.join();
  }
  std::set<std::uint32_t> all;
  for (const auto& each : had)
  {
    all.insert(each.begin(), each.end());
  }
  EXPECT_EQ(all.size(), 100u);
}

// Nothing is delivered if it cannot be recorded.
TEST_F(Quotas, AFileThatSomebodyKeepsLockedIsAnError)
{
  const auto book = this->Open(Share(0.1));
  const auto other = OpenForWriting(this->file);
  ASSERT_TRUE(other);
  ASSERT_TRUE(Execute(other->get(), "BEGIN IMMEDIATE"));
  const auto taken = book->TakePartition("ann", Model("m"), 1, 1);
  ASSERT_FALSE(taken);
  EXPECT_TRUE(fixtures::FailsAt(taken, ErrorCode::InputOutput, "locked"));
  EXPECT_EQ(taken.GetError().file, this->file.string());
  ASSERT_TRUE(Execute(other->get(), "COMMIT"));
  std::this_thread::sleep_for(QuotaBook::pauseOfLocked);
  EXPECT_TRUE(May(*book, "ann", 1));
}

// Requests that wait for a locked file make others wait, but each waits no longer than it would by
// itself.
TEST_F(Quotas, ManyWhoFindTheFileLockedWaitTogether)
{
  const auto book = this->Open(Share(0.1));
  const auto other = OpenForWriting(this->file);
  ASSERT_TRUE(other);
  ASSERT_TRUE(Execute(other->get(), "BEGIN IMMEDIATE"));
  const auto seconds = [&book](unsigned readers)
  {
    std::vector<std::thread> threads;
    const auto begin = std::chrono::steady_clock::now();
    for (unsigned reader = 0; reader < readers; ++reader)
    {
      threads.emplace_back([&book] { EXPECT_FALSE(book->TakePartition("ann", Model("m"), 1, 1)); });
    }
    for (auto& thread : threads)
    {
      thread.join();
    }
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  const double one = seconds(1);
  EXPECT_LT(seconds(1), one / 2) << "who comes just then waits for nothing";
  std::this_thread::sleep_for(QuotaBook::pauseOfLocked);
  EXPECT_LT(seconds(8), 3 * one);
  ASSERT_TRUE(Execute(other->get(), "COMMIT"));
  std::this_thread::sleep_for(QuotaBook::pauseOfLocked);
  EXPECT_TRUE(May(*book, "ann", 1));
}

TEST_F(Quotas, AnInvalidFileIsAnError)
{
  std::ofstream(this->file) << std::string(10'000, 'x');
  const auto book = QuotaBook::Open(this->file, Share(0.1));
  ASSERT_FALSE(book);
  EXPECT_EQ(book.GetError().code, ErrorCode::InputOutput);
  EXPECT_FALSE(QuotaBook::Open(this->folder.Path / "none" / "quotas.db", Share(0.1)));
}
