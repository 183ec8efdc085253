// SPDX-License-Identifier: BSD-3-Clause
// What another thread does for a connection, and the way back to the connection's event loop.
// Internal to the server.
#pragma once

#include "server/http/ClientSocket.h"

#include <boost/asio/execution/allocator.hpp>
#include <boost/asio/execution/blocking.hpp>
#include <boost/asio/require.hpp>

#include <array>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>

namespace kdstream
{

// Where one handler of Asio has its place.
struct HandlerPlace
{
  alignas(std::max_align_t) std::array<std::byte, 128> memory;
};

// An allocator that gives such a place, to one object at a time.
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

// Gives `begin` what another thread is to call: that does `there`, and then has the event loop do
// `here`. Only to begin may fail, for want of memory. Had the other thread to take memory for the
// way back it could fail there, and nothing of a connection may be touched, nor ended, but on its
// loop. What both hold is let go by the loop too. REQUIRES: there throws nothing.
template <class Begin, class There, class Here>
void MakeRoundTrip(EventLoop loop, const Begin& begin, There there, Here here)
{
  struct Trip
  {
    EventLoop loop;
    There there;
    Here here;
    HandlerPlace memory;
  };
  auto trip = std::make_shared<Trip>(Trip{ loop, std::move(there), std::move(here), {} });
  begin(
    [trip = std::move(trip)]() mutable noexcept
    {
      trip->there();
      const ReservedMemory<std::byte> memory(trip->memory);
      const auto back = asio::require(
        trip->loop, asio::execution::blocking.never, asio::execution::allocator(memory));
      back.execute([trip = std::move(trip)] { trip->here(); });
    });
}

}
