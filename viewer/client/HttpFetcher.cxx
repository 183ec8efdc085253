// SPDX-License-Identifier: BSD-3-Clause
// GET over one connection that is kept open.
#include "viewer/client/HttpFetcher.h"

#include "viewer/client/ServerStream.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/read_size.hpp>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <utility>

namespace kdstream
{
namespace
{
namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using boost::system::error_code;

constexpr std::chrono::seconds fetchConnectTimeout{ 10 };
constexpr std::chrono::seconds stallTimeout{ 30 };
constexpr std::size_t bytesAtOnce = 65536;
}

class HttpFetcher::Connection : public std::enable_shared_from_this<Connection>
{
public:
  Connection(asio::io_context& context, ServerUrl server, std::shared_ptr<asio::ssl::context> tls)
    : Server(std::move(server))
    , Stream(context, this->Server, std::move(tls))
  {
  }

  void Fetch(const HttpFetch& fetch, Handler handler)
  {
    this->What = fetch;
    this->Done = std::move(handler);
    this->Retries = this->Open ? 1 : 0;
    this->Open ? this->Write() : this->Connect();
  }

  void Close()
  {
    this->Done = nullptr;
    this->Stream.Close();
  }

private:
  void Connect()
  {
    this->Open = false;
    this->Stream.Connect(fetchConnectTimeout,
      [self = this->shared_from_this()](const Status& connected)
      {
        if (!connected)
        {
          self->Finish(self->Unreachable(connected.GetError()));
          return;
        }
        self->Open = true;
        self->Write();
      });
  }

  void Write()
  {
    this->Request = "GET " + this->What.target + " HTTP/1.1\r\nHost: " + this->Server.Authority() +
                    "\r\nUser-Agent: kdstream\r\n";
    if (!this->Server.token.empty())
    {
      this->Request += "Authorization: Bearer " + this->Server.token + "\r\n";
    }
    this->Request += "\r\n";
    this->Buffer.clear();
    this->Parser.emplace();
    this->Parser->body_limit(this->What.mostBytes);
    this->Stream.next_layer().expires_after(stallTimeout);
    asio::async_write(this->Stream, asio::buffer(this->Request),
      [self = this->shared_from_this()](error_code error, std::size_t)
      { error ? self->Lost(error) : self->Read(); });
  }

  // Reads part by part, so that the timeout counts from the last bytes that arrived.
  void Read()
  {
    this->Stream.next_layer().expires_after(stallTimeout);
    this->Stream.async_read_some(this->Buffer.prepare(beast::read_size(this->Buffer, bytesAtOnce)),
      [self = this->shared_from_this()](error_code error, std::size_t bytes)
      {
        self->Buffer.commit(bytes);
        self->Parse(error);
      });
  }

  // Parses as much of the answer as has arrived; `error` is the socket's.
  void Parse(error_code error)
  {
    if (error == asio::error::eof && this->Parser->got_some())
    {
      error = {};
      this->Parser->put_eof(error);
    }
    while (!error && !this->Parser->is_done() && this->Buffer.size() != 0)
    {
      this->Buffer.consume(this->Parser->put(this->Buffer.data(), error));
    }
    if (error == http::error::body_limit)
    {
      this->Disconnect();
      this->Finish(Error{ ErrorCode::LimitExceeded,
        this->What.target + " is larger than " + std::to_string(this->What.mostBytes) + " bytes" });
    }
    else if (error && error != http::error::need_more)
    {
      this->Lost(error);
    }
    else
    {
      this->Parser->is_done() ? this->Answer() : this->Read();
    }
  }

  void Answer()
  {
    this->HasAnswered = true;
    const auto field = this->Parser->get()[http::field::retry_after];
    HttpReply reply{ this->Parser->get().result_int(), std::move(this->Parser->get().body()),
      RetryAfterIn(std::string(field.data(), field.size())) };
    if (!this->Parser->keep_alive())
    {
      this->Disconnect();
    }
    this->Finish(std::move(reply));
  }

  // The connection was lost. A kept connection may have been closed in the meantime: that is not an
  // error yet.
  void Lost(error_code error)
  {
    const bool untouched = !this->Parser || !this->Parser->got_some();
    this->Disconnect();
    if (this->Done && this->Retries > 0 && untouched)
    {
      --this->Retries;
      this->Connect();
      return;
    }
    const bool mayWantTls = untouched && !this->HasAnswered && !this->Server.isSecure;
    this->Finish(Error{ ErrorCode::InputOutput, "the connection to " + this->Server.Authority() +
                                                  " was lost: " + error.message() +
                                                  (mayWantTls ? "; does it need https?" : "") });
  }

  Error Unreachable(const Error& error) const
  {
    return { error.code, this->Server.Authority() + " cannot be reached: " + error.message };
  }

  void Disconnect()
  {
    this->Open = false;
    this->Stream.Close();
  }

  void Finish(Result<HttpReply> reply)
  {
    if (this->Done)
    {
      std::exchange(this->Done, nullptr)(std::move(reply));
    }
  }

  ServerUrl Server;
  ServerStream Stream;
  bool Open = false;
  bool HasAnswered = false; // on any connection so far
  int Retries = 0;
  HttpFetch What;
  Handler Done;
  std::string Request;
  beast::flat_buffer Buffer;
  std::optional<http::response_parser<http::string_body>> Parser;
};

HttpFetcher::HttpFetcher(
  asio::io_context& context, ServerUrl server, std::shared_ptr<asio::ssl::context> tls)
  : Kept(std::make_shared<Connection>(context, std::move(server), std::move(tls)))
{
}

HttpFetcher::~HttpFetcher()
{
  this->Kept->Close();
}

void HttpFetcher::Fetch(const HttpFetch& fetch, Handler handler)
{
  this->Kept->Fetch(fetch, std::move(handler));
}

}
