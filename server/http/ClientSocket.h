// SPDX-License-Identifier: BSD-3-Clause
// The bytes from and to one client, plain or through TLS: one type for both, so that HTTP and
// WebSocket code is compiled once. Internal to the server.
#pragma once

#include <boost/asio/basic_stream_socket.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/error.hpp>

#include <array>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <type_traits>
#include <utility>

struct ssl_ctx_st;

namespace kdstream
{

namespace asio = boost::asio;
namespace beast = boost::beast;

// The executor of a connection's handlers: the event loop of one thread, so that the handlers run
// one at a time without a strand. With a strand, or with any_io_executor, Asio and Beast would
// allocate memory in places where an allocation must not fail; lack of memory would then end the
// server.
using EventLoop = asio::io_context::executor_type;
using TcpSocket = asio::basic_stream_socket<asio::ip::tcp, EventLoop>;

// A handler of any type, called at most once. It has no executor of its own, so Asio calls it on
// the socket's executor.
template <class... Arguments>
class AnyHandler
{
public:
  template <class Handler,
    class = std::enable_if_t<!std::is_same_v<std::decay_t<Handler>, AnyHandler>>>
  AnyHandler(Handler&& handler) // NOLINT(bugprone-forwarding-reference-overload)
    : Held(std::make_unique<Holder<std::decay_t<Handler>>>(std::forward<Handler>(handler)))
  {
  }

  void operator()(Arguments... arguments)
  {
    const auto held = std::move(this->Held);
    held->Call(arguments...);
  }

private:
  struct Callable
  {
    virtual ~Callable() = default;
    virtual void Call(Arguments... arguments) = 0;
  };
  template <class Handler>
  struct Holder final : Callable
  {
    explicit Holder(Handler handler)
      : Kept(std::move(handler))
    {
    }
    void Call(Arguments... arguments) override { this->Kept(arguments...); }
    Handler Kept;
  };
  std::unique_ptr<Callable> Held;
};

// A connected socket as Boost's AsyncReadStream and AsyncWriteStream, with or without TLS. Handlers
// run on the socket's executor. Call one function at a time.
class ClientSocket
{
public:
  using executor_type = EventLoop;
  using ErrorHandler = AnyHandler<beast::error_code>;
  using BytesHandler = AnyHandler<beast::error_code, std::size_t>;

  explicit ClientSocket(TcpSocket socket);
  // Runs work on another thread, because the socket's own thread must not wait for it.
  using Offload = std::function<void(std::function<void()>)>;
  // A socket with TLS. The computations of a handshake run on `elsewhere`.
  ClientSocket(TcpSocket socket, ssl_ctx_st& tls, Offload elsewhere);
  ClientSocket(ClientSocket&&) noexcept;
  ~ClientSocket();

  executor_type get_executor() const noexcept;
  TcpSocket& Tcp();

  // Sets a deadline, or none: operations in flight, and those begun before the next call of either
  // function, fail after `time`, or never.
  void ExpireAfter(std::chrono::milliseconds time);
  void ExpireNever();
  // Ends the connection at once: operations in flight fail.
  void Close();

  // Before the handshake, without TLS: reads exactly as many bytes as the buffer holds.
  void ReadPlain(asio::mutable_buffer buffer, BytesHandler handler);
  // The TLS handshake; a plain socket is ready at once.
  void Handshake(ErrorHandler handler);
  // Informs the client that nothing more will be sent.
  void EndOutput(ErrorHandler handler);

  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler)
  {
    this->ReadSome(FirstBuffer(buffers), BytesHandler(std::forward<Handler>(handler)));
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler)
  {
    this->WriteSome(Output(buffers), BytesHandler(std::forward<Handler>(handler)));
  }

  // The parts of a message that are written at once, as a buffer sequence of one type.
  class Output
  {
  public:
    template <class Buffers>
    explicit Output(const Buffers& buffers)
    {
      const auto end = asio::buffer_sequence_end(buffers);
      for (auto each = asio::buffer_sequence_begin(buffers);
           each != end && this->Count < this->Parts.size(); ++each)
      {
        this->Parts[this->Count++] = asio::const_buffer(*each);
      }
    }
    using value_type = asio::const_buffer;
    using const_iterator = const asio::const_buffer*;
    const_iterator begin() const { return this->Parts.data(); }
    const_iterator end() const { return this->Parts.data() + this->Count; }

  private:
    std::array<asio::const_buffer, 16> Parts; // later buffers are left to the next call
    std::size_t Count = 0;
  };

  class Layers;

private:
  template <class Buffers>
  static asio::mutable_buffer FirstBuffer(const Buffers& buffers)
  {
    const auto first = asio::buffer_sequence_begin(buffers);
    return first == asio::buffer_sequence_end(buffers) ? asio::mutable_buffer()
                                                       : asio::mutable_buffer(*first);
  }
  void ReadSome(asio::mutable_buffer buffer, BytesHandler handler);
  void WriteSome(const Output& buffers, BytesHandler handler);

  std::unique_ptr<Layers> Below;
};

}
