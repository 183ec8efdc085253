// SPDX-License-Identifier: BSD-3-Clause
// The thread of a ModelSource: the order of tasks, failures, and how it ends.
#include "filters/core/CaughtError.h"
#include "viewer/client/ClientThread.h"

#include <gtest/gtest.h>

#include <atomic>
#include <new>
#include <string>
#include <thread>
#include <vector>

using namespace kdstream;

namespace
{

ClientEvent Reported(const std::string& message)
{
  ClientEvent event;
  event.message = message;
  return event;
}

std::string MessagesOf(const std::vector<ClientEvent>& events)
{
  std::string all;
  for (const ClientEvent& event : events)
  {
    all += event.message + ";";
  }
  return all;
}

// Waits until `count` events have arrived.
std::string Await(ClientThread& thread, std::size_t count)
{
  std::vector<ClientEvent> all;
  while (all.size() < count && thread.Wait(std::chrono::seconds(60)))
  {
    for (ClientEvent& event : thread.Take())
    {
      all.push_back(std::move(event));
    }
  }
  return MessagesOf(all);
}

}

TEST(ClientThread, RunsTasksInOrder)
{
  ClientThread thread([] {});
  for (int i = 0; i < 3; ++i)
  {
    thread.Post(
      [&thread, i]
      {
        std::vector<ClientEvent> events{ Reported(std::to_string(i)) };
        thread.Publish(events);
        EXPECT_TRUE(events.empty());
      });
  }
  EXPECT_EQ(Await(thread, 3), "0;1;2;");
  EXPECT_FALSE(thread.Wait(std::chrono::milliseconds(0)));
}

// Here onFailure throws when it is called first.
TEST(ClientThread, ATaskThatThrowsIsNotTheEnd)
{
  int failures = 0;
  ClientThread* reported = nullptr;
  ClientThread thread(
    [&]
    {
      if (++failures == 1)
      {
        throw std::bad_alloc();
      }
      std::vector<ClientEvent> events{ Reported(CaughtError().message) };
      reported->Publish(events);
    });
  reported = &thread;
  thread.Post([] { throw std::bad_alloc(); });
  thread.Post(
    [&thread]
    {
      std::vector<ClientEvent> events{ Reported("next") };
      thread.Publish(events);
    });
  EXPECT_EQ(Await(thread, 2), "out of memory;next;");
  EXPECT_EQ(failures, 2);
}

TEST(ClientThread, WhatIsPostedLaterIsNotRunOnceItIsStopped)
{
  std::atomic<int> ran{ 0 };
  ClientThread thread([] {});
  thread.Post(
    [&thread]
    {
      while (!thread.Context().stopped())
      {
        std::this_thread::yield();
      }
    });
  thread.Post([&ran] { ++ran; });
  thread.Stop();
  thread.Post([&ran] { ++ran; });
  EXPECT_EQ(ran, 0);
}
