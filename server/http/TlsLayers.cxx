// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/TlsLayers.h"

#include "server/http/RoundTrip.h"

#include <boost/asio/error.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>

#include <algorithm>
#include <cstring>
#include <utility>

namespace kdstream
{

namespace
{

// The same error as if the client had left: no answer can be sent.
const beast::error_code noTls = asio::error::connection_aborted;

// The first bytes to write, in one buffer.
class FirstRecord
{
public:
  explicit FirstRecord(const ClientSocket::Output& buffers)
  {
    for (const auto& part : buffers)
    {
      if (part.size() == 0)
      {
        continue;
      }
      if (this->Bytes == 0 && part.size() >= TlsEngine::mostWritten)
      {
        this->Begin = static_cast<const char*>(part.data());
        this->Bytes = TlsEngine::mostWritten;
        return;
      }
      const auto taken = std::min(part.size(), this->Gathered.size() - this->Bytes);
      std::memcpy(this->Gathered.data() + this->Bytes, part.data(), taken);
      this->Bytes += taken;
    }
  }
  FirstRecord(const FirstRecord&) = delete;
  FirstRecord& operator=(const FirstRecord&) = delete;

  const char* Data() const { return this->Begin; }
  std::size_t Size() const { return this->Bytes; }

private:
  // Bytes of the first buffers, if there are several.
  std::array<char, TlsEngine::mostWritten> Gathered;
  const char* Begin = Gathered.data();
  std::size_t Bytes = 0;
};

}

TlsLayers::TlsLayers(TcpSocket socket, ssl_ctx_st& context, ClientSocket::Offload offload)
  : Socket(std::move(socket))
  , Engine(context)
  , Elsewhere(std::move(offload))
{
}

// A handshake in progress. Its computation runs on another thread, while nothing else uses the
// engine.
struct TlsLayers::ShakingHands
{
  ClientSocket::ErrorHandler handler;
  Outcome outcome = Outcome::WantsInput;
};

void TlsLayers::Handshake(ClientSocket::ErrorHandler handler)
{
  this->Shake(std::make_shared<ShakingHands>(ShakingHands{ std::move(handler) }));
}

void TlsLayers::Shake(const std::shared_ptr<ShakingHands>& hands)
{
  this->Receive(
    [this, hands](beast::error_code error)
    {
      if (error)
      {
        hands->handler(error);
        return;
      }
      MakeRoundTrip(
        this->Socket.get_executor(),
        [this](WorkerPool::Work work, const WorkerPool::Work& /*giveUp*/)
        { this->Elsewhere(std::move(work)); },
        [this, hands]
        {
          try
          {
            hands->outcome = this->Engine.Handshake();
          }
          catch (...)
          {
            hands->outcome = Outcome::Failed;
          }
        },
        [this, hands](bool /*isDone*/) { this->GoOnShaking(hands); });
    });
}

// Sends the engine's output, even if the handshake failed.
void TlsLayers::GoOnShaking(const std::shared_ptr<ShakingHands>& hands)
{
  this->Flush(
    [this, hands](beast::error_code error)
    {
      if (!error && hands->outcome == Outcome::WantsInput)
      {
        this->Shake(hands);
        return;
      }
      hands->handler(error || hands->outcome == Outcome::Done ? error : noTls);
    });
}

void TlsLayers::EndOutput(ClientSocket::ErrorHandler handler)
{
  this->Engine.EndOutput();
  this->Flush(
    [this, handler = std::move(handler)](beast::error_code error) mutable
    {
      beast::error_code ended;
      this->Socket.socket().shutdown(TcpSocket::shutdown_send, ended);
      handler(error ? error : ended);
    });
}

void TlsLayers::ReadSome(asio::mutable_buffer buffer, ClientSocket::BytesHandler handler)
{
  std::size_t got = 0;
  const auto outcome =
    buffer.size() == 0 ? Outcome::Done : this->Engine.Read(buffer.data(), buffer.size(), got);
  if (outcome == Outcome::WantsInput)
  {
    auto goOn = [this, buffer, handler = std::move(handler)](beast::error_code error) mutable
    {
      if (error)
      {
        handler(error, 0);
        return;
      }
      this->ReadSome(buffer, std::move(handler));
    };
    this->Receive(std::move(goOn));
    return;
  }
  const beast::error_code error = outcome == Outcome::Done    ? beast::error_code()
                                  : outcome == Outcome::Ended ? asio::error::eof
                                                              : noTls;
  asio::post(this->Socket.get_executor(),
    [error, got, handler = std::move(handler)]() mutable { handler(error, got); });
}

void TlsLayers::WriteSome(const ClientSocket::Output& buffers, ClientSocket::BytesHandler handler)
{
  const FirstRecord record(buffers);
  const auto bytes = record.Size();
  if (bytes != 0 && this->Engine.Write(record.Data(), bytes) != Outcome::Done)
  {
    asio::post(
      this->Socket.get_executor(), [handler = std::move(handler)]() mutable { handler(noTls, 0); });
    return;
  }
  this->Flush([bytes, handler = std::move(handler)](beast::error_code error) mutable
    { handler(error, error ? 0 : bytes); });
}

// Receives more from the client. First sends the output that reading has caused (new keys).
void TlsLayers::Receive(ClientSocket::ErrorHandler handler)
{
  if (this->Engine.HasOutput())
  {
    this->Flush(
      [this, handler = std::move(handler)](beast::error_code error) mutable
      {
        if (error)
        {
          handler(error);
          return;
        }
        this->Receive(std::move(handler));
      });
    return;
  }
  this->Socket.async_read_some(asio::buffer(this->Arrived),
    [this, handler = std::move(handler)](beast::error_code error, std::size_t bytes) mutable
    {
      if (!error)
      {
        this->Engine.PutInput(this->Arrived.data(), bytes);
      }
      handler(error);
    });
}

// Calls the handler when there is nothing more to send.
void TlsLayers::Flush(ClientSocket::ErrorHandler handler)
{
  if (const auto inFlight = this->UntilAllIsSent.lock())
  {
    inFlight->push_back(std::move(handler));
    return;
  }
  const auto untilAllIsSent = std::make_shared<Handlers>();
  untilAllIsSent->push_back(std::move(handler));
  this->UntilAllIsSent = untilAllIsSent;
  this->SendNext(untilAllIsSent);
}

void TlsLayers::SendNext(std::shared_ptr<Handlers> untilAllIsSent)
{
  this->Engine.TakeOutput(this->Leaving);
  asio::async_write(this->Socket, asio::buffer(this->Leaving),
    [this, untilAllIsSent = std::move(untilAllIsSent)](beast::error_code error, std::size_t) mutable
    {
      if (!error && this->Engine.HasOutput())
      {
        this->SendNext(std::move(untilAllIsSent));
        return;
      }
      this->UntilAllIsSent.reset();
      // The last handler may end the connection, so no member is used after this.
      for (auto& handler : *untilAllIsSent)
      {
        handler(error);
      }
    });
}

}
