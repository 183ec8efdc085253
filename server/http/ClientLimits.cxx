// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/ClientLimits.h"

#include "filters/core/Texts.h"

#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/network_v4.hpp>
#include <boost/asio/ip/network_v6.hpp>

#include <algorithm>
#include <utility>

namespace kdstream
{

namespace
{

namespace ip = boost::asio::ip;

// Parses an address. An IPv4 address that came through an IPv6 socket becomes a plain IPv4 address.
std::optional<ip::address> ParseAddress(std::string_view text)
{
  boost::system::error_code error;
  auto address = ip::make_address(std::string(text), error);
  if (error)
  {
    return std::nullopt;
  }
  if (address.is_v6() && address.to_v6().is_v4_mapped())
  {
    address = ip::make_address_v4(ip::v4_mapped, address.to_v6());
  }
  return address;
}

template <class Network, class Address>
bool IsWithin(const Network& network, const Address& address, unsigned bits)
{
  return network.canonical() == Network(address, static_cast<unsigned short>(bits)).canonical();
}

// Whether the address is in the network, "ADDRESS" or "ADDRESS/BITS"; nothing if that text is
// neither.
std::optional<bool> IsOf(std::string_view network, const ip::address& address)
{
  const auto slash = network.find('/');
  const auto base = ParseAddress(network.substr(0, slash));
  if (!base)
  {
    return std::nullopt;
  }
  if (slash == std::string_view::npos)
  {
    return *base == address;
  }
  boost::system::error_code error;
  const std::string text(network);
  if (base->is_v4())
  {
    const auto of = ip::make_network_v4(text, error);
    return error
             ? std::nullopt
             : std::optional(address.is_v4() && IsWithin(of, address.to_v4(), of.prefix_length()));
  }
  const auto of = ip::make_network_v6(text, error);
  return error
           ? std::nullopt
           : std::optional(address.is_v6() && IsWithin(of, address.to_v6(), of.prefix_length()));
}

// An entry of X-Forwarded-For without its port: some proxies add the client's port, as in
// "1.2.3.4:567" and "[::1]:567".
std::string_view WithoutPort(std::string_view entry)
{
  const bool inBrackets = entry.starts_with('[') && entry.find(']') != std::string_view::npos;
  const auto end = inBrackets ? entry.find(']') + 1 : entry.find(':');
  const auto rest = entry.substr(std::min(end, entry.size()));
  const bool isPort =
    rest.empty() || (rest.size() >= 2 && rest.size() <= 6 && rest.front() == ':' &&
                      rest.find_first_not_of("0123456789", 1) == std::string_view::npos);
  if (!isPort)
  {
    return entry; // an IPv6 address, or something unknown
  }
  return inBrackets ? entry.substr(1, end - 2) : entry.substr(0, end);
}

}

std::string PlainAddress(const std::string& address)
{
  const auto parsed = ParseAddress(address);
  return parsed ? parsed->to_string() : address; // in canonical form, not as the client wrote it
}

std::string ClientLimits::KeyOf(std::string_view address, bool& isLoopback)
{
  const auto parsed = ParseAddress(address);
  isLoopback = parsed && parsed->is_loopback();
  if (!parsed || parsed->is_v4())
  {
    return parsed ? parsed->to_string() : std::string(address);
  }
  const auto bytes = parsed->to_v6().to_bytes();
  return { reinterpret_cast<const char*>(bytes.data()), 8 };
}

std::shared_ptr<void> ClientLimits::TakeSlot(std::string_view address)
{
  bool isLoopback = false;
  auto key = KeyOf(address, isLoopback);
  const std::size_t most = this->Connections.value_or(isLoopback ? 0 : defaultConnections);
  if (most == 0)
  {
    return std::make_shared<int>();
  }
  {
    const std::lock_guard lock(this->Mutex);
    auto& client = this->Clients[key];
    if (client.slots >= most)
    {
      return nullptr;
    }
    ++client.slots;
  }
  // If there is no memory for the shared_ptr, the deleter is called at once; so the slot is given
  // back.
  return std::shared_ptr<void>(this,
    [key = std::move(key)](void* limits) { static_cast<ClientLimits*>(limits)->GiveBack(key); });
}

void ClientLimits::GiveBack(const std::string& key)
{
  const std::lock_guard lock(this->Mutex);
  const auto found = this->Clients.find(key);
  if (--found->second.slots == 0 && found->second.counted == Clock::time_point())
  {
    this->Clients.erase(found);
  }
}

std::chrono::seconds ClientLimits::TakeRequest(std::string_view address, Clock::time_point now)
{
  bool isLoopback = false;
  const auto key = KeyOf(address, isLoopback);
  const auto most = static_cast<double>(this->Requests.value_or(isLoopback ? 0 : defaultRequests));
  constexpr std::chrono::seconds none{ 0 };
  if (most == 0)
  {
    return none;
  }
  const std::lock_guard lock(this->Mutex);
  this->Sweep(now, most);
  auto& client = this->Clients[key];
  const bool isNew = client.counted == Clock::time_point();
  const std::chrono::duration<double> passed = now - client.counted;
  client.requests = isNew ? most : std::min(most, client.requests + passed.count() * most / 60);
  client.counted = now;
  if (client.requests < 1)
  {
    const std::chrono::duration<double> wait((1 - client.requests) * 60 / most);
    return std::max(std::chrono::seconds(1), std::chrono::ceil<std::chrono::seconds>(wait));
  }
  client.requests -= 1;
  return none;
}

// Forgets addresses that have no connections and whose rate limit has recovered: they are the same
// as new ones.
void ClientLimits::Sweep(Clock::time_point now, double most)
{
  if (this->Clients.size() < this->SweepAt)
  {
    return;
  }
  std::erase_if(this->Clients,
    [&](const auto& entry)
    {
      const std::chrono::duration<double> passed = now - entry.second.counted;
      return entry.second.slots == 0 && entry.second.requests + passed.count() * most / 60 >= most;
    });
  this->SweepAt = std::max<std::size_t>(1000, 2 * this->Clients.size());
}

std::size_t ClientLimits::Size() const
{
  const std::lock_guard lock(this->Mutex);
  return this->Clients.size();
}

std::optional<TrustedProxies> TrustedProxies::Parse(const std::vector<std::string>& networks)
{
  for (const auto& network : networks)
  {
    if (!IsOf(network, ip::address()))
    {
      return std::nullopt;
    }
  }
  TrustedProxies proxies;
  proxies.Networks = networks;
  return proxies;
}

bool TrustedProxies::Holds(std::string_view address) const
{
  const auto parsed = ParseAddress(address);
  return parsed && std::any_of(this->Networks.begin(), this->Networks.end(),
                     [&](const std::string& network) { return IsOf(network, *parsed) == true; });
}

std::string TrustedProxies::ClientOf(const std::string& peer, std::string_view forwardedFor) const
{
  std::string client = peer;
  while (this->Holds(client) && !Trimmed(forwardedFor).empty())
  {
    const auto comma = forwardedFor.rfind(',');
    const auto last =
      Trimmed(comma == std::string_view::npos ? forwardedFor : forwardedFor.substr(comma + 1));
    const auto address = ParseAddress(WithoutPort(last));
    if (!address)
    {
      break;
    }
    client = address->to_string();
    forwardedFor = comma == std::string_view::npos ? "" : forwardedFor.substr(0, comma);
  }
  return client;
}

}
