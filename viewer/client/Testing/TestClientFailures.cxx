// SPDX-License-Identifier: BSD-3-Clause
// A client whose thread runs out of memory, at any place. Then the connection is lost, or a request
// fails, with a message; but the program does not end, and nobody waits forever.
#include "viewer/client/ServerClient.h"

#include "server/http/HttpServer.h"
#include "viewer/client/Testing/TorusCatalog.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <new>

#include <unistd.h>

namespace
{

// Threads whose allocations never fail: those that exist before a client is made.
std::array<pid_t, 128> others{};
std::atomic<std::size_t> otherCount{ 0 };
// How many allocations of the client's thread succeed before one fails; negative: all succeed.
std::atomic<std::int64_t> allocationsLeft{ -1 };

bool FailsNow()
{
  if (allocationsLeft.load(std::memory_order_relaxed) < 0)
  {
    return false;
  }
  thread_local const pid_t thread = ::gettid();
  const auto end = others.begin() + static_cast<std::ptrdiff_t>(otherCount.load());
  return std::find(others.begin(), end, thread) == end && allocationsLeft.fetch_sub(1) == 0;
}

}

// Not inlined: otherwise the compiler sees only one half of a pair of new and delete, and takes it
// for a mistake.
[[gnu::noinline]] void* operator new(std::size_t bytes)
{
  void* const memory = FailsNow() ? nullptr : std::malloc(bytes > 0 ? bytes : 1);
  if (memory == nullptr)
  {
    throw std::bad_alloc();
  }
  return memory;
}

// Sorting algorithms allocate their buffers with this operator.
[[gnu::noinline]] void* operator new(std::size_t bytes, const std::nothrow_t& /*no throw*/) noexcept
{
  return FailsNow() ? nullptr : std::malloc(bytes > 0 ? bytes : 1);
}

[[gnu::noinline]] void operator delete(void* memory) noexcept
{
  std::free(memory);
}

[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept
{
  std::free(memory);
}

namespace kdstream
{
namespace
{

void ExemptThreads()
{
  std::size_t count = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task"))
  {
    ASSERT_LT(count, others.size());
    others[count++] = std::stoi(task.path().filename().string());
  }
  otherCount = count;
}

// Whether, before the deadline, the session has everything, or has a message that says why not.
bool Exchange(ServerClient& client, ViewerSession& session)
{
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < deadline)
  {
    for (const ClientEvent& event : client.Take())
    {
      Deliver(event, session);
    }
    for (const SessionRequest& request : session.TakeRequests())
    {
      client.Send(request);
    }
    session.BeginFrame();
    if (session.IsIdle())
    {
      return true;
    }
    client.Wait(std::chrono::milliseconds(100));
  }
  return false;
}

// Shows the torus with this number of successful allocations. Returns whether an allocation failed.
bool LookAtTorus(const std::string& url, std::int64_t allocations)
{
  allocationsLeft = allocations;
  auto client = ServerClient::Connect(url);
  if (client)
  {
    ViewerSession session;
    session.SetModels((*client)->Models());
    session.Resize({ 800, 600, 1 });
    EXPECT_TRUE(session.SelectModel("torus"));
    EXPECT_TRUE(Exchange(**client, session)) << "somebody waits for ever";
    const bool shown = session.GetStatus().triangles > 0;
    EXPECT_TRUE(shown || !session.GetStatus().error.empty());
  }
  else
  {
    EXPECT_FALSE(client.GetError().message.empty());
  }
  return allocationsLeft.exchange(-1) < 0;
}

TEST(ClientFailures, NoAllocationThatFailsEndsTheProgram)
{
  const testing::TorusCatalog models;
  auto server = HttpServer::Start(models, {});
  ASSERT_TRUE(server);
  const std::string url = (*server)->Url();
  ASSERT_FALSE(LookAtTorus(url, std::numeric_limits<std::int64_t>::max() / 2));
  ExemptThreads();
  int runs = 0;
  for (std::int64_t allocations = 0; LookAtTorus(url, allocations);
       allocations += 1 + allocations / 16)
  {
    ASSERT_FALSE(HasFailure()) << "allocation " << allocations;
    ++runs;
  }
  EXPECT_GT(runs, 50);
  RecordProperty("runs", runs);
}

}
}
