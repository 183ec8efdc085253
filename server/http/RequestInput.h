// SPDX-License-Identifier: BSD-3-Clause
// Splits the bytes of a connection into requests, one after the other. No sockets. Internal to the
// server.
#pragma once

#include "server/http/ParsedRequest.h"

#include <boost/beast/core/error.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/read_size.hpp>
#include <boost/beast/http/error.hpp>

#include <cstddef>
#include <optional>
#include <string_view>

namespace kdstream
{

class RequestInput
{
public:
  // headerBytes: most of a request's header.
  explicit RequestInput(std::size_t headerBytes)
    : HeaderBytes(headerBytes)
    , Bytes(headerBytes + 1024)
  {
    this->Begin();
  }

  // Begins the next request; a part of it may have arrived already.
  void Begin()
  {
    this->IsLineSkipped = false;
    SetLimits(this->Parser.emplace(), this->HeaderBytes);
  }

  // Goes on in what has come: nothing where more is to come, an error, or none for a whole request.
  std::optional<boost::beast::error_code> Parse()
  {
    namespace http = boost::beast::http;
    if (!this->SkipEmptyLine())
    {
      return std::nullopt;
    }
    const auto error = this->Take();
    if (error && error != http::error::need_more)
    {
      return error;
    }
    if (AnnouncesBody(*this->Parser)) // the body is not waited for
    {
      return make_error_code(http::error::body_limit);
    }
    if (this->Parser->is_done())
    {
      return boost::beast::error_code();
    }
    return this->Bytes.size() < this->Bytes.max_size()
             ? std::nullopt
             : std::optional(make_error_code(http::error::buffer_overflow));
  }

  // Room for the next bytes; and reports how much of it has been filled.
  auto Prepare()
  {
    return this->Bytes.prepare(boost::beast::read_size(this->Bytes, this->Bytes.max_size()));
  }
  void Commit(std::size_t bytes) { this->Bytes.commit(bytes); }

  const ParsedRequest& Request() const { return this->Parser->get(); } // the part received so far
  bool IsBegun() const { return this->Parser->got_some() || this->HasMore(); }
  bool HasMore() const { return this->Bytes.size() != 0; } // that is not yet parsed

private:
  // Skips an empty line before the request. Whether it is certain that there is none.
  bool SkipEmptyLine()
  {
    if (this->Parser->got_some() || this->IsLineSkipped)
    {
      return true;
    }
    const auto bytes = EmptyLine(this->Unparsed());
    this->Bytes.consume(bytes.value_or(0));
    this->IsLineSkipped = bytes.value_or(0) != 0;
    return bytes.has_value();
  }

  boost::beast::error_code Take()
  {
    // The parser leaves a line as long as the next one may go on with it, so none is missed.
    if (HasFoldedLine(this->Unparsed()))
    {
      return make_error_code(boost::beast::http::error::bad_obs_fold);
    }
    boost::beast::error_code error;
    while (!error && !this->Parser->is_done() && this->Bytes.size() != 0)
    {
      this->Bytes.consume(this->Parser->put(this->Bytes.data(), error));
    }
    return error;
  }

  std::string_view Unparsed() const
  {
    const auto bytes = this->Bytes.data();
    return { static_cast<const char*>(bytes.data()), bytes.size() };
  }

  const std::size_t HeaderBytes;
  boost::beast::flat_buffer Bytes;
  std::optional<RequestParser> Parser;
  bool IsLineSkipped = false; // before this request
};

}
