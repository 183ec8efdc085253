// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/PatientLoop.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <future>
#include <memory>
#include <stdexcept>
#include <vector>

using namespace kdstream;

namespace
{

constexpr std::chrono::milliseconds patience{ 700 }, leisure{ 60'000 };

// Shared with threads that are abandoned.
struct Work
{
  std::promise<void> tell;
  std::shared_future<void> answers{ tell.get_future() };
  std::array<std::atomic<bool>, 10> done{};
};

}

TEST(PatientLoop, DoesAllInTheirOrder)
{
  std::vector<std::size_t> done;
  ForEachPatiently(
    5, leisure, [&done](std::size_t i) { done.push_back(i); }, [](std::size_t) { FAIL(); });
  EXPECT_EQ(done, (std::vector<std::size_t>{ 0, 1, 2, 3, 4 }));
  ForEachPatiently(
    0, leisure, [](std::size_t) { FAIL(); }, [](std::size_t) { FAIL(); });
}

TEST(PatientLoop, LeavesOutWhatTakesTooLong)
{
  const auto work = std::make_shared<Work>();
  std::vector<std::size_t> late;
  ForEachPatiently(
    work->done.size(), patience,
    [work](std::size_t i)
    {
      if (i == 3 || i == 4 || i == 9)
      {
        work->answers.wait();
      }
      work->done[i] = true;
    },
    [&late](std::size_t i) { late.push_back(i); });
  EXPECT_EQ(late, (std::vector<std::size_t>{ 3, 4, 9 }));
  for (std::size_t i = 0; i < work->done.size(); ++i)
  {
    EXPECT_EQ(work->done[i], i != 3 && i != 4 && i != 9) << i;
  }
  work->tell.set_value();
}

TEST(PatientLoop, ThrowsWhatIsThrown)
{
  std::size_t done = 0;
  const auto throwing = [&done](std::size_t i)
  {
    if (i == 2)
    {
      throw std::runtime_error("2");
    }
    ++done;
  };
  EXPECT_THROW(
    ForEachPatiently(5, leisure, throwing, [](std::size_t) { FAIL(); }), std::runtime_error);
  EXPECT_EQ(done, 2u);
}
