// SPDX-License-Identifier: BSD-3-Clause
// A bare TCP connection to 127.0.0.1 for tests that send what no client would. Every wait has a
// limit.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace kdstream
{

class RawSocket
{
public:
  using Milliseconds = std::chrono::milliseconds;
  // For bytes that will come, but may take a while on a busy machine.
  static constexpr std::chrono::seconds patience{ 60 };

  // receiveBytes: the size of the system's receive buffer; 0: the system chooses.
  explicit RawSocket(std::uint16_t port, int receiveBytes = 0)
    : Handle(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0))
  {
    if (receiveBytes > 0)
    {
      ::setsockopt(this->Handle, SOL_SOCKET, SO_RCVBUF, &receiveBytes, sizeof receiveBytes);
    }
    const int yes = 1;
    ::setsockopt(this->Handle, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    this->Connected =
      ::connect(this->Handle, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  RawSocket(RawSocket&& other) noexcept
    : Handle(std::exchange(other.Handle, -1))
    , Connected(other.Connected)
  {
  }
  RawSocket& operator=(RawSocket&&) = delete;
  ~RawSocket()
  {
    if (this->Handle >= 0)
    {
      ::close(this->Handle);
    }
  }

  bool IsConnected() const { return this->Connected; }

  // Sends the bytes. Returns whether all were sent within the time.
  bool Send(std::string_view bytes, Milliseconds time = Milliseconds(1000))
  {
    const auto until = std::chrono::steady_clock::now() + time;
    while (!bytes.empty() && this->Await(POLLOUT, until))
    {
      const auto sent =
        ::send(this->Handle, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent < 0)
      {
        return false;
      }
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return bytes.empty();
  }

  // Receives the next bytes. "" if nothing comes within the time, or if the connection ends
  // (HasEnded).
  std::string Receive(Milliseconds time, std::size_t bytes = 65536)
  {
    std::string received(bytes, '\0');
    if (!this->Await(POLLIN, std::chrono::steady_clock::now() + time))
    {
      return {};
    }
    const auto got = ::recv(this->Handle, received.data(), received.size(), 0);
    this->Ended = got <= 0;
    received.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    return received;
  }
  bool HasEnded() const { return this->Ended; }

  // Appends received bytes to `received` until it contains `end`. Returns whether it did within the
  // time.
  bool ReceiveUntil(std::string_view end, std::string& received, Milliseconds time)
  {
    const auto until = std::chrono::steady_clock::now() + time;
    while (received.find(end) == std::string::npos)
    {
      const auto now = std::chrono::steady_clock::now();
      if (this->Ended || now >= until)
      {
        return false;
      }
      received += this->Receive(std::chrono::ceil<Milliseconds>(until - now));
    }
    return true;
  }
  // Returns whether the other side ends the connection within the time; what it still sends is
  // dropped.
  bool AwaitEnd(Milliseconds time)
  {
    std::string dropped;
    this->ReceiveUntil(std::string_view("\0never\0", 7), dropped, time);
    return this->Ended;
  }

  void EndOutput() { ::shutdown(this->Handle, SHUT_WR); }
  // Ends the connection by a reset.
  void Reset()
  {
    const linger at{ 1, 0 };
    ::setsockopt(this->Handle, SOL_SOCKET, SO_LINGER, &at, sizeof at);
    ::close(std::exchange(this->Handle, -1));
    this->Ended = true;
  }

private:
  bool Await(short events, std::chrono::steady_clock::time_point until) const
  {
    pollfd file{ this->Handle, events, 0 };
    const auto left =
      std::chrono::ceil<Milliseconds>(until - std::chrono::steady_clock::now()).count();
    return this->Handle >= 0 && ::poll(&file, 1, left > 0 ? static_cast<int>(left) : 0) == 1;
  }

  int Handle;
  bool Connected = false;
  bool Ended = false;
};

}
