// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/WorkerPool.h"

#include "server/http/Testing/ScarceMemory.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <utility>

using namespace kdstream;
using namespace std::chrono_literals;

namespace
{

// Long enough for anything that should happen, even on a busy machine.
constexpr auto deadline = 20s;

// A disk that answers when the test lets it.
class Disk
{
public:
  ~Disk() { this->Answer(); }
  void Read()
  {
    ++this->held;
    this->answers.wait();
    --this->held;
  }
  void Answer()
  {
    if (!std::exchange(this->answered, true))
    {
      this->tell.set_value();
    }
  }
  std::atomic<int> held{ 0 };

private:
  bool answered = false;
  std::promise<void> tell;
  std::shared_future<void> answers{ this->tell.get_future() };
};

template <class Holds>
bool Await(const Holds& holds)
{
  const auto until = std::chrono::steady_clock::now() + deadline;
  while (!holds() && std::chrono::steady_clock::now() < until)
  {
    std::this_thread::sleep_for(1ms);
  }
  return holds();
}

class Workers : public testing::Test
{
protected:
  Disk disk; // declared first, so that it outlives the pool's threads
  std::array<char, 300> sources{};
  std::atomic<int> done{ 0 }, givenUp{ 0 };
  WorkerPool pool;

  void TearDown() override
  {
    this->disk.Answer();
    this->pool.Stop();
  }
  void AddHanging(std::size_t source, const std::string& part = "")
  {
    this->pool.Add({ [this]
      {
        this->disk.Read();
        ++this->done;
      },
      [this] { ++this->givenUp; }, &this->sources.at(source), part });
  }
  // Whether a task of this source is done in time.
  bool Works(std::size_t source)
  {
    auto reported = std::make_shared<std::promise<bool>>();
    auto future = reported->get_future();
    this->pool.Add({ [reported] { reported->set_value(true); },
      [reported] { reported->set_value(false); }, &this->sources.at(source), "" });
    return future.wait_for(deadline) == std::future_status::ready && future.get();
  }
};

}

TEST_F(Workers, ASourceThatHangsHasHalfOfTheThreads)
{
  this->pool.Start(4, { 1h, 1h });
  for (int i = 0; i < 1000; ++i)
  {
    this->AddHanging(0, "part " + std::to_string(i));
  }
  ASSERT_TRUE(Await([this] { return this->disk.held == 2; }));
  EXPECT_TRUE(this->Works(1));
  EXPECT_TRUE(this->Works(2));
  EXPECT_EQ(this->disk.held, 2);
  this->disk.Answer();
  EXPECT_TRUE(Await([this] { return this->done == 1000; }));
  EXPECT_EQ(this->givenUp, 0);
}

TEST_F(Workers, WhoWantsTheSameWaitsWithoutAThread)
{
  this->pool.Start(4, { 1h, 1h });
  for (int i = 0; i < 100; ++i)
  {
    this->AddHanging(0, "same");
  }
  ASSERT_TRUE(Await([this] { return this->disk.held == 1; }));
  EXPECT_TRUE(this->Works(0)) << "another part of that source";
  EXPECT_EQ(this->disk.held, 1);
  this->disk.Answer();
  EXPECT_TRUE(Await([this] { return this->done == 100; }));
}

// Even one thread is enough: at each look one blocked thread is replaced.
TEST_F(Workers, ThreadsThatAreHeldAreReplaced)
{
  this->pool.Start(1, { 1ms, 1h });
  constexpr std::size_t hanging = 20;
  for (std::size_t source = 0; source < hanging; ++source)
  {
    this->AddHanging(source, "a");
    this->AddHanging(source, "b");
  }
  EXPECT_TRUE(Await([this] { return this->disk.held == int(hanging); })) << this->disk.held;
  EXPECT_TRUE(this->Works(hanging));
  this->disk.Answer();
  EXPECT_TRUE(Await([this] { return this->done == 2 * int(hanging); }));
  EXPECT_TRUE(this->Works(0));
}

TEST_F(Workers, WhatTakesTooLongIsGivenUpAndWhatComesAfterItAtOnce)
{
  this->pool.Start(4, { 1ms, 50ms });
  for (int i = 0; i < 100; ++i)
  {
    this->AddHanging(0, "part " + std::to_string(i));
    this->AddHanging(0, "part 0");
  }
  EXPECT_TRUE(Await([this] { return this->givenUp == 200; })) << this->givenUp;
  EXPECT_EQ(this->disk.held, 2);
  this->AddHanging(0, "part 200");
  EXPECT_EQ(this->givenUp, 201) << "without waiting";
  EXPECT_TRUE(this->Works(1));
  this->disk.Answer();
  EXPECT_TRUE(Await([this] { return this->disk.held == 0; }));
  EXPECT_TRUE(Await([this] { return this->Works(0); })) << "it is well again";
  EXPECT_EQ(this->done, 2) << "what has not begun never does";
}

TEST_F(Workers, WhatIsNotGivenUpWaits)
{
  this->pool.Start(1, { 1h, 1ms });
  this->AddHanging(0);
  std::atomic<bool> ran{ false };
  this->pool.Add({ [&ran] { ran = true; } });
  EXPECT_TRUE(Await([this] { return this->givenUp == 1; }));
  this->disk.Answer();
  EXPECT_TRUE(Await([&ran] { return ran.load(); }));
}

TEST_F(Workers, StopsForTheTimeSpecified)
{
  this->pool.Start(2, { 1h, 1h });
  this->AddHanging(0);
  ASSERT_TRUE(Await([this] { return this->disk.held == 1; }));
  EXPECT_FALSE(this->pool.Stop(1ms));
  this->disk.Answer();
  EXPECT_TRUE(this->pool.Stop(deadline));
}

TEST_F(Workers, WhoWatchesOverThemOutlivesALackOfMemory)
{
  this->pool.Start(1, { 1h, 200ms });
  this->AddHanging(0);
  ASSERT_TRUE(Await([this] { return this->disk.held == 1; }));
  const ScarceMemory scarce(0, ScarceMemory::Where::OtherThreads);
  EXPECT_GT(scarce.AwaitFailure(), 0U) << "the next look";
  EXPECT_TRUE(Await([this] { return this->givenUp == 1; })) << "at a later one";
}
