// SPDX-License-Identifier: BSD-3-Clause
// The thread of a ModelSource, and the source's events for the session. Part of step "receive" of
// the pipeline picture. Only for sources of this folder, because this header includes Boost.
#pragma once

#include "viewer/client/ClientEvent.h"

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <iterator>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace kdstream
{

// Runs posted tasks one at a time, in order. Functions may be called from any thread, unless stated
// otherwise.
class ClientThread
{
public:
  // onFailure: called on the thread, in the catch clause, when a task throws (mostly for lack of
  // memory): this ends the task, but not the program. If onFailure itself throws, it is called
  // again 0.1 s later.
  explicit ClientThread(std::function<void()> onFailure)
    : OnFailure(std::move(onFailure))
    , Thread([this] { this->Run(); })
  {
  }

  ClientThread(const ClientThread&) = delete;
  ClientThread& operator=(const ClientThread&) = delete;
  ~ClientThread() { this->Stop(); }

  // Ends the thread when the running task ends; the other tasks are not run. For an owner with
  // members that tasks use and that are destroyed before this object. Do not call this on the
  // thread.
  void Stop()
  {
    this->Loop.stop();
    if (this->Thread.joinable())
    {
      this->Thread.join();
    }
  }

  // For sockets and timers whose handlers are tasks of this thread.
  boost::asio::io_context& Context() { return this->Loop; }

  template <class Task>
  void Post(Task&& task)
  {
    boost::asio::post(this->Loop, std::forward<Task>(task));
  }

  // Takes all of `events`; if it throws, it takes none of them.
  void Publish(std::vector<ClientEvent>& events)
  {
    if (events.empty())
    {
      return;
    }
    const std::lock_guard lock(this->Mutex);
    this->Events.insert(this->Events.end(), std::make_move_iterator(events.begin()),
      std::make_move_iterator(events.end()));
    events.clear();
    this->Arrived.notify_all();
  }

  // As the functions of ModelSource.
  std::vector<ClientEvent> Take()
  {
    const std::lock_guard lock(this->Mutex);
    return std::exchange(this->Events, {});
  }
  bool Wait(std::chrono::milliseconds atMost)
  {
    std::unique_lock lock(this->Mutex);
    return this->Arrived.wait_for(lock, atMost, [this] { return !this->Events.empty(); });
  }

private:
  void Run() noexcept
  {
    while (!this->Loop.stopped())
    {
      try
      {
        this->Loop.run(); // until it is stopped
      }
      catch (...)
      {
        while (!this->Recover() && !this->Loop.stopped()) // not enough memory even for that
        {
          std::this_thread::sleep_for(std::chrono::milliseconds(100));
        }
      }
    }
  }

  bool Recover() noexcept
  {
    try
    {
      this->OnFailure();
      return true;
    }
    catch (...)
    {
      return false;
    }
  }

  std::function<void()> OnFailure;
  boost::asio::io_context Loop;
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> Working{
    Loop.get_executor()
  };

  std::mutex Mutex; // guards the next two
  std::condition_variable Arrived;
  std::vector<ClientEvent> Events;

  std::thread Thread; // the last member, because the thread uses all members above
};

}
