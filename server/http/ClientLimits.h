// SPDX-License-Identifier: BSD-3-Clause
// Rate limits: how many connections each address may have at a time, and how many requests a
// minute. Internal to the server.
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

// Returns an IPv4 address that came through an IPv6 socket ("::ffff:1.2.3.4") in IPv4 form, and any
// other text unchanged.
std::string PlainAddress(const std::string& address);

// All functions may be called from any thread. Here an address is an IPv4 address, or the first 64
// bits of an IPv6 address, which usually belong to one subscriber.
class ClientLimits
{
public:
  using Clock = std::chrono::steady_clock;

  // Without a number, the default is the limit, except for this machine itself (loopback), because
  // a proxy may run there. 0: no limit.
  ClientLimits(std::optional<std::size_t> connections, std::optional<std::size_t> requestsAMinute)
    : Connections(connections)
    , Requests(requestsAMinute)
  {
  }
  static constexpr std::size_t defaultConnections = 100;
  static constexpr std::size_t defaultRequests = 6000; // a minute

  // A connection slot of this address, held while its client is connected; null if the address
  // already has as many as it may have.
  std::shared_ptr<void> TakeSlot(std::string_view address);

  // Counts a request of this address. An address may make all requests of a minute at once; then
  // they become available again evenly over time. If none is left, returns the seconds until there
  // is one, else 0.
  std::chrono::seconds TakeRequest(std::string_view address, Clock::time_point now = Clock::now());

  // The number of addresses that are remembered.
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

// The peers that are trusted proxies: the client addresses that they report are believed.
class TrustedProxies
{
public:
  // Each text is an address or a network (10.0.0.0/8). Returns nothing if one of them is neither.
  static std::optional<TrustedProxies> Parse(const std::vector<std::string>& networks);

  bool Holds(std::string_view address) const;

  // The address of the client that `peer` forwards for. It is found in the X-Forwarded-For fields
  // that the peer has sent, joined by commas: the last address that is not a trusted proxy. It is
  // the peer's own address if the peer is not trusted, or names no client.
  std::string ClientOf(const std::string& peer, std::string_view forwardedFor) const;

private:
  std::vector<std::string> Networks;
};

}
