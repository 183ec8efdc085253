// SPDX-License-Identifier: BSD-3-Clause
// Rate limits: how many connections at a time, and requests a minute, each address may have.
// Internal to the server.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace kdstream
{

// An IPv4 address that came through a socket of IPv6 ("::ffff:1.2.3.4") in IPv4 form; all other
// texts unchanged.
std::string PlainAddress(const std::string& address);

// All functions may be called from any thread. An address is an IPv4 address, or the first 64 bits
// of an IPv6 address, which usually belong to one subscriber.
class ClientLimits
{
public:
  using Clock = std::chrono::steady_clock;

  // Without a number: the default, which does not apply to this machine itself (loopback), because
  // a proxy may be there. 0: no limit.
  ClientLimits(std::optional<std::size_t> connections, std::optional<std::size_t> requestsAMinute)
    : Connections(connections)
    , Requests(requestsAMinute)
  {
  }
  static constexpr std::size_t defaultConnections = 100;
  static constexpr std::size_t defaultRequests = 6000; // a minute

  // A connection slot of this address, held while its client is connected; null if the address
  // already has all that it may have.
  std::shared_ptr<void> TakeSlot(std::string_view address);

  // Takes a request of this address. It may make all requests of a minute at once; they are
  // restored evenly. If none is left, returns the seconds until there is one; else 0.
  std::chrono::seconds TakeRequest(std::string_view address, Clock::time_point now = Clock::now());

  // Addresses that are remembered.
  std::size_t Size() const;

private:
  struct Client
  {
    std::size_t slots = 0;
    double requests = 0; // requests that the address may still make
    Clock::time_point counted;
  };
  static std::string KeyOf(std::string_view address, bool& isLoopback);
  void GiveBack(const std::string& key);
  void Sweep(Clock::time_point now, double most);

  const std::optional<std::size_t> Connections, Requests;
  mutable std::mutex Mutex;
  std::unordered_map<std::string, Client> Clients;
  std::size_t SweepAt = 1000;
};

// Which peers are trusted proxies, whose client addresses are believed.
class TrustedProxies
{
public:
  // Each an address or a network (10.0.0.0/8). Nothing if one is neither.
  static std::optional<TrustedProxies> Parse(const std::vector<std::string>& networks);

  bool Holds(std::string_view address) const;

  // The address of the client behind `peer`, from the X-Forwarded-For fields that the peer has
  // sent, joined by commas: the last address that is not a trusted proxy. The peer itself if it is
  // not trusted, or names none.
  std::string ClientOf(const std::string& peer, std::string_view forwardedFor) const;

private:
  std::vector<std::string> Networks;
};

}
