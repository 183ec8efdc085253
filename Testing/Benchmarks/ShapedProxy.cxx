// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Benchmarks/ShapedProxy.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <functional>
#include <thread>
#include <vector>

namespace kdstream::benchmarks
{
namespace
{

namespace asio = boost::asio;
using asio::ip::tcp;
using Clock = std::chrono::steady_clock;
using boost::system::error_code;

Clock::duration Seconds(double seconds)
{
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

// Shared by all connections: says when the next byte may leave.
struct Road
{
  double rate = 0;
  Clock::duration way{}; // half of a round trip
  Clock::time_point free{};

  Clock::time_point Leave(std::size_t bytes)
  {
    this->free = std::max(this->free, Clock::now());
    if (this->rate > 0)
    {
      this->free += Seconds(static_cast<double>(bytes) / this->rate);
    }
    return this->free;
  }
};

// One direction of a connection: bytes that were read wait for their turn, travel, and are written.
class Way : public std::enable_shared_from_this<Way>
{
public:
  Way(std::shared_ptr<tcp::socket> from, std::shared_ptr<tcp::socket> to, Road& road)
    : From(std::move(from))
    , To(std::move(to))
    , Timer(this->From->get_executor())
    , Line(road)
  {
  }

  void Read()
  {
    if (this->Reading || this->Ended || this->Waiting > mostWaiting)
    {
      return;
    }
    this->Reading = true;
    this->From->async_read_some(asio::buffer(this->Buffer),
      [self = this->shared_from_this()](const error_code& error, std::size_t bytes)
      {
        self->Reading = false;
        self->Ended = static_cast<bool>(error);
        self->Add({ self->Buffer.begin(), self->Buffer.begin() + static_cast<long>(bytes) });
        self->Read();
      });
  }

private:
  static constexpr std::size_t mostWaiting = 256 << 10;
  struct Packet
  {
    Clock::time_point arrives;
    std::vector<char> bytes; // empty: the end
  };

  void Add(std::vector<char> bytes)
  {
    this->Waiting += bytes.size();
    this->Packets.push_back({ this->Line.Leave(bytes.size()) + this->Line.way, std::move(bytes) });
    if (this->Packets.size() == 1)
    {
      this->Await();
    }
  }

  void Await()
  {
    this->Timer.expires_at(this->Packets.front().arrives);
    this->Timer.async_wait(
      [self = this->shared_from_this()](const error_code& error)
      {
        if (!error)
        {
          self->Write();
        }
      });
  }

  void Write()
  {
    if (this->Packets.front().bytes.empty())
    {
      error_code ignored;
      this->To->shutdown(tcp::socket::shutdown_send, ignored);
      return;
    }
    asio::async_write(*this->To, asio::buffer(this->Packets.front().bytes),
      [self = this->shared_from_this()](const error_code& error, std::size_t bytes)
      {
        self->Waiting -= bytes;
        self->Packets.pop_front();
        if (error)
        {
          error_code ignored;
          self->From->close(ignored);
          return;
        }
        if (!self->Packets.empty())
        {
          self->Await();
        }
        self->Read();
      });
  }

  std::shared_ptr<tcp::socket> From, To;
  asio::steady_timer Timer;
  Road& Line;
  std::array<char, 4096> Buffer{};
  std::deque<Packet> Packets;
  std::size_t Waiting = 0; // bytes
  bool Reading = false, Ended = false;
};

}

class ShapedProxy::Proxy
{
public:
  Proxy(std::uint16_t server, const Line& line)
    : Acceptor(this->Context, { asio::ip::address_v4::loopback(), 0 })
    , Server(asio::ip::address_v4::loopback(), server)
  {
    this->Up.way = this->Down.way = Seconds(line.roundTrip / 2);
    this->Down.rate = line.rate;
    this->Accept();
    this->Runner = std::thread([this] { this->Context.run(); });
  }

  ~Proxy()
  {
    this->Context.stop();
    this->Runner.join();
  }

  std::uint16_t Port() const { return this->Acceptor.local_endpoint().port(); }

private:
  void Accept()
  {
    auto client = std::make_shared<tcp::socket>(this->Context);
    this->Acceptor.async_accept(*client,
      [this, client](const error_code& error)
      {
        if (error)
        {
          return;
        }
        this->Accept();
        this->Delay(client);
      });
  }

  // The client's first byte has to wait for the round trip of its handshake.
  void Delay(const std::shared_ptr<tcp::socket>& client)
  {
    auto timer = std::make_shared<asio::steady_timer>(this->Context, 2 * this->Up.way);
    timer->async_wait([this, client, timer](const error_code&) { this->Join(client); });
  }

  void Join(const std::shared_ptr<tcp::socket>& client)
  {
    auto server = std::make_shared<tcp::socket>(this->Context);
    error_code error;
    server->connect(this->Server, error);
    if (error)
    {
      client->close(error);
      return;
    }
    client->set_option(tcp::no_delay(true), error);
    server->set_option(tcp::no_delay(true), error);
    std::make_shared<Way>(client, server, this->Up)->Read();
    std::make_shared<Way>(server, client, this->Down)->Read();
  }

  asio::io_context Context;
  tcp::acceptor Acceptor;
  tcp::endpoint Server;
  Road Up, Down;
  std::thread Runner;
};

ShapedProxy::ShapedProxy(std::uint16_t server, const Line& line)
  : Kept(std::make_unique<Proxy>(server, line))
{
}

ShapedProxy::~ShapedProxy() = default;

std::uint16_t ShapedProxy::Port() const
{
  return this->Kept->Port();
}

}
