// SPDX-License-Identifier: BSD-3-Clause
// A tap in the line between a client and a server. It passes all data on, counts the blobs that
// arrive completely through streams, and can hold data back until LetThrough is called.
#pragma once

#include "filters/protocol/BinaryFrame.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>

#include <array>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <limits>
#include <list>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace kdstream
{

// Parses the data that arrives on one connection: first HTTP, then the WebSocket frames of a
// server, which are not masked.
class StreamReader
{
public:
  // onBlob: called for each complete blob.
  explicit StreamReader(std::function<void(const protocol::FrameAssembler::Blob&)> onBlob)
    : OnBlob(std::move(onBlob))
  {
  }

  void Take(const char* bytes, std::size_t size)
  {
    if (this->Is != Kind::Http)
    {
      this->Text.append(bytes, size);
    }
    if (this->Is == Kind::Unknown && this->Text.find("\r\n\r\n") != std::string::npos)
    {
      this->Is = this->Text.rfind("HTTP/1.1 101", 0) == 0 ? Kind::Stream : Kind::Http;
      this->Text.erase(0, this->Text.find("\r\n\r\n") + 4);
    }
    while (this->Is == Kind::Stream && this->TakeFrame())
    {
    }
  }

private:
  enum class Kind
  {
    Unknown,
    Http,
    Stream
  };

  std::uint64_t Number(std::size_t at, std::size_t bytes) const
  {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i)
    {
      value = value << 8 | static_cast<unsigned char>(this->Text[at + i]);
    }
    return value;
  }

  // RFC 6455, section 5.2. Our server sends each message in one frame.
  bool TakeFrame()
  {
    if (this->Text.size() < 10)
    {
      return false; // shorter ones wait for the next
    }
    const auto start = this->Number(1, 1);
    const std::size_t head = start == 127 ? 10 : start == 126 ? 4 : 2;
    const auto size = start == 127 ? this->Number(2, 8) : start == 126 ? this->Number(2, 2) : start;
    if (this->Text.size() < head + size)
    {
      return false;
    }
    if ((this->Text[0] & 0xf) == 2)
    {
      const auto* const bytes = reinterpret_cast<const std::uint8_t*>(this->Text.data()) + head;
      const auto frame = protocol::ParseFrame({ bytes, static_cast<std::size_t>(size) });
      auto blob = this->Frames.Accept(*frame);
      if (*blob)
      {
        this->OnBlob(**blob);
      }
    }
    this->Text.erase(0, head + static_cast<std::size_t>(size));
    return true;
  }

  std::function<void(const protocol::FrameAssembler::Blob&)> OnBlob;
  Kind Is = Kind::Unknown;
  std::string Text; // received, but not parsed yet
  protocol::FrameAssembler Frames;
};

class StreamTap
{
  using tcp = boost::asio::ip::tcp;

public:
  // A tap between a port of its own and the server's port. After a stream has brought this number
  // of blobs, no more of it passes until LetThrough.
  StreamTap(std::uint16_t server, std::size_t blobsBeforeHold)
    : Server(server)
    , Hold(blobsBeforeHold)
    , Listening(this->Context, { boost::asio::ip::address_v4::loopback(), 0 })
    , Accepting([this] { this->Accept(); })
  {
  }
  ~StreamTap()
  {
    this->LetThrough();
    {
      const std::lock_guard lock(this->Mutex);
      this->Ends = true;
    }
    boost::system::error_code error;
    tcp::socket knock(this->Context); // wakes up accept
    knock.connect(this->Listening.local_endpoint(), error);
    this->Accepting.join();
    for (Pair& pair : this->Pairs)
    {
      pair.client.shutdown(tcp::socket::shutdown_both, error);
      pair.server.shutdown(tcp::socket::shutdown_both, error);
    }
    for (std::thread& thread : this->Threads)
    {
      thread.join();
    }
  }

  std::string Url() const
  {
    return "http://127.0.0.1:" + std::to_string(this->Listening.local_endpoint().port());
  }
  void AwaitHold()
  {
    std::unique_lock lock(this->Mutex);
    this->Changed.wait(lock, [this] { return this->Held; });
  }
  void LetThrough()
  {
    const std::lock_guard lock(this->Mutex);
    this->Hold = std::numeric_limits<std::size_t>::max();
    this->Changed.notify_all();
  }
  // The number of connections made so far.
  std::size_t Connections() const
  {
    const std::lock_guard lock(this->Mutex);
    return this->Made;
  }
  // How often each blob has arrived completely.
  std::map<protocol::BlobId, std::size_t> Counts() const
  {
    const std::lock_guard lock(this->Mutex);
    return this->Seen;
  }

private:
  struct Pair
  {
    explicit Pair(boost::asio::io_context& context)
      : client(context)
      , server(context)
    {
    }
    tcp::socket client, server;
  };

  void Accept()
  {
    for (;;)
    {
      Pair& pair = this->Pairs.emplace_back(this->Context);
      boost::system::error_code error;
      this->Listening.accept(pair.client, error);
      if (!this->CountConnection())
      {
        return;
      }
      // A small buffer, so that little is in flight while data is held back.
      pair.server.open(tcp::v4());
      pair.server.set_option(boost::asio::socket_base::receive_buffer_size(4096));
      pair.server.connect({ boost::asio::ip::address_v4::loopback(), this->Server }, error);
      this->Threads.emplace_back([this, &pair] { this->Pass(pair.client, pair.server, {}); });
      this->Threads.emplace_back(
        [this, &pair]
        {
          StreamReader reader([this](const auto& blob) { this->Count(blob.id); });
          this->Pass(pair.server, pair.client,
            [&](const char* bytes, std::size_t size) { reader.Take(bytes, size); });
        });
    }
  }

  // Returns false if the tap is ending.
  bool CountConnection()
  {
    const std::lock_guard lock(this->Mutex);
    ++this->Made;
    return !this->Ends;
  }

  void Count(const protocol::BlobId& blob)
  {
    std::unique_lock lock(this->Mutex);
    ++this->Seen[blob];
    if (++this->Blobs >= this->Hold)
    {
      this->Held = true;
      this->Changed.notify_all();
      this->Changed.wait(lock, [this] { return this->Blobs < this->Hold; });
    }
  }

  // Passes data until the sender ends, or the receiver takes no more. The other direction stays
  // open, because data may still be in flight there.
  static void Pass(
    tcp::socket& from, tcp::socket& to, const std::function<void(const char*, std::size_t)>& look)
  {
    boost::system::error_code error;
    std::array<char, 4096> buffer{};
    while (!error)
    {
      const auto size = from.read_some(boost::asio::buffer(buffer), error);
      boost::system::error_code failed;
      boost::asio::write(to, boost::asio::buffer(buffer.data(), size), failed);
      look && !failed ? look(buffer.data(), size) : void();
      error = error ? error : failed;
    }
    to.shutdown(tcp::socket::shutdown_send, error);
  }

  const std::uint16_t Server;
  mutable std::mutex Mutex;
  std::condition_variable Changed;
  std::size_t Hold, Blobs = 0, Made = 0;
  bool Held = false, Ends = false;
  std::map<protocol::BlobId, std::size_t> Seen;
  boost::asio::io_context Context;
  tcp::acceptor Listening;
  std::list<Pair> Pairs;
  std::list<std::thread> Threads;
  std::thread Accepting; // last: it uses all of the above
};

}
