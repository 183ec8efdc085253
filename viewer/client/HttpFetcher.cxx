// SPDX-License-Identifier: BSD-3-Clause
// GET over one connection that is kept open.
#include "viewer/client/HttpFetcher.h"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include <chrono>
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
}

class HttpFetcher::Connection : public std::enable_shared_from_this<Connection>
{
public:
  Connection(asio::io_context& context, ServerUrl server)
    : Server(std::move(server))
    , Resolver(context)
    , Stream(context)
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
    this->Resolver.cancel();
    this->Stream.close();
  }

private:
  void Connect()
  {
    this->Open = false;
    this->Resolver.async_resolve(this->Server.host, this->Server.port,
      [self = this->shared_from_this()](error_code error, const auto& endpoints)
      {
        if (error)
        {
          self->Finish(self->Unreachable(error));
          return;
        }
        self->Stream.expires_after(fetchConnectTimeout);
        self->Stream.async_connect(endpoints,
          [self](error_code failure, const auto&)
          {
            if (failure)
            {
              self->Finish(self->Unreachable(failure));
              return;
            }
            self->Open = true;
            self->Write();
          });
      });
  }

  void Write()
  {
    this->Request = {};
    this->Request.method(http::verb::get);
    this->Request.target(this->What.target);
    this->Request.version(11);
    this->Request.set(http::field::host, this->Server.Authority());
    this->Request.set(http::field::user_agent, "kdstream");
    this->Buffer.clear();
    this->Parser.emplace();
    this->Parser->body_limit(this->What.mostBytes);
    this->Stream.expires_after(stallTimeout);
    http::async_write(this->Stream, this->Request,
      [self = this->shared_from_this()](error_code error, std::size_t)
      { error ? self->Lost(error) : self->Read(); });
  }

  // Reads piece by piece, so that the timeout counts from the last bytes that came.
  void Read()
  {
    this->Stream.expires_after(stallTimeout);
    http::async_read_some(this->Stream, this->Buffer, *this->Parser,
      [self = this->shared_from_this()](error_code error, std::size_t)
      {
        if (error == http::error::body_limit)
        {
          self->Disconnect();
          self->Finish(
            Error{ ErrorCode::LimitExceeded, self->What.target + " is larger than " +
                                               std::to_string(self->What.mostBytes) + " bytes" });
        }
        else if (error)
        {
          self->Lost(error);
        }
        else
        {
          self->Parser->is_done() ? self->Answer() : self->Read();
        }
      });
  }

  void Answer()
  {
    HttpReply reply{ this->Parser->get().result_int(), std::move(this->Parser->get().body()) };
    if (!this->Parser->keep_alive())
    {
      this->Disconnect();
    }
    this->Finish(std::move(reply));
  }

  // A kept connection may have been closed meanwhile: that is no error yet.
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
    this->Finish(Error{ ErrorCode::InputOutput,
      "the connection to " + this->Server.Authority() + " was lost: " + error.message() });
  }

  Error Unreachable(error_code error) const
  {
    return { ErrorCode::InputOutput,
      this->Server.Authority() + " cannot be reached: " + error.message() };
  }

  void Disconnect()
  {
    this->Open = false;
    this->Stream.close();
  }

  void Finish(Result<HttpReply> reply)
  {
    if (this->Done)
    {
      std::exchange(this->Done, nullptr)(std::move(reply));
    }
  }

  ServerUrl Server;
  asio::ip::tcp::resolver Resolver;
  beast::tcp_stream Stream;
  bool Open = false;
  int Retries = 0;
  HttpFetch What;
  Handler Done;
  http::request<http::empty_body> Request;
  beast::flat_buffer Buffer;
  std::optional<http::response_parser<http::string_body>> Parser;
};

HttpFetcher::HttpFetcher(asio::io_context& context, ServerUrl server)
  : Kept(std::make_shared<Connection>(context, std::move(server)))
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
