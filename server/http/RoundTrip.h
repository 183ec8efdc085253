// SPDX-License-Identifier: BSD-3-Clause
// Runs a task for a connection on another thread, and returns to the connection's event loop.
// Internal to the server.
#pragma once

#include "server/http/ClientSocket.h"

#include <boost/asio/execution/allocator.hpp>
#include <boost/asio/execution/blocking.hpp>
#include <boost/asio/require.hpp>

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>

namespace kdstream
{

// Memory for one handler of Asio.
struct HandlerPlace
{
  alignas(std::max_align_t) std::array<std::byte, 128> memory;
};

// An allocator that gives the memory of a HandlerPlace to one object at a time.
template <class Type>
class ReservedMemory
{
public:
  using value_type = Type;

  explicit ReservedMemory(HandlerPlace& place) noexcept
    : Reserved(&place)
  {
  }
  template <class Other>
  ReservedMemory(const ReservedMemory<Other>& other) noexcept // NOLINT: as allocators convert
    : Reserved(&other.Place())
  {
  }
  Type* allocate(std::size_t /*one*/) noexcept
  {
    static_assert(sizeof(Type) <= sizeof(HandlerPlace) && alignof(Type) <= alignof(HandlerPlace));
    return reinterpret_cast<Type*>(this->Reserved->memory.data());
  }
  void deallocate(Type* /*object*/, std::size_t /*one*/) noexcept {}

  HandlerPlace& Place() const noexcept { return *this->Reserved; }
  template <class Other>
  bool operator==(const ReservedMemory<Other>& other) const noexcept
  {
    return &this->Place() == &other.Place();
  }

private:
  HandlerPlace* Reserved;
};

// Runs `there` on another thread, and then `here` on the event loop. `begin` gets two functions.
// The other thread calls the first, which runs `there`, and then makes the loop run here(true). Any
// thread may call the second, which gives up waiting: the loop runs here(false), even if `there`
// still waits for a disk. `here` runs once.
// - Only `begin` may fail, for lack of memory. The way back needs no memory, because an error on
//   the other thread could not be handled: a connection may be used and ended only on its loop. So
//   the loop frees what `here` holds.
// - If waiting may be given up, `there` must not hold a connection, because `there` may be freed at
//   any time.
//
// Returns a function that gives up waiting. It may outlive the round trip, and keeps nothing of it
// alive. REQUIRES: `there` does not throw.
template <class Begin, class There, class Here>
auto MakeRoundTrip(EventLoop loop, const Begin& begin, There there, Here here)
{
  struct Trip
  {
    EventLoop loop;
    There there;
    Here here;
    HandlerPlace memory;
    std::atomic<bool> returns{ false };

    Trip(EventLoop home, There away, Here back)
      : loop(std::move(home))
      , there(std::move(away))
      , here(std::move(back))
    {
    }
    static void Return(std::shared_ptr<Trip> trip, bool isDone)
    {
      if (trip->returns.exchange(true))
      {
        return;
      }
      const ReservedMemory<std::byte> memory(trip->memory);
      const auto back = asio::require(
        trip->loop, asio::execution::blocking.never, asio::execution::allocator(memory));
      back.execute(
        [trip = std::move(trip), isDone]
        {
          auto arrived = std::move(trip->here);
          arrived(isDone);
        });
    }
  };
  auto trip = std::make_shared<Trip>(std::move(loop), std::move(there), std::move(here));
  begin(
    [trip]() mutable noexcept
    {
      trip->there();
      Trip::Return(std::move(trip), true);
    },
    [trip]() mutable noexcept { Trip::Return(std::move(trip), false); });
  return [weak = std::weak_ptr(trip)]
  {
    if (auto self = weak.lock())
    {
      Trip::Return(std::move(self), false);
    }
  };
}

}
