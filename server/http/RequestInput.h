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
  // headerBytes: the most bytes of a request's header.
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

  // Parses the bytes received so far. Returns nothing if more bytes are needed, otherwise an error
  // code; it holds no error if the request is complete.
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
    if (AnnouncesBody(*this->Parser)) // the body is not awaited
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

  // Prepare returns room for the next bytes; Commit says how many bytes have been put there.
  auto Prepare()
  {
    return this->Bytes.prepare(boost::beast::read_size(this->Bytes, this->Bytes.max_size()));
  }
  void Commit(std::size_t bytes) { this->Bytes.commit(bytes); }

  const ParsedRequest& Request() const { return this->Parser->get(); } // the part received so far
  bool IsBegun() const { return this->Parser->got_some() || this->HasMore(); }
  bool HasMore() const { return this->Bytes.size() != 0; } // bytes that are not parsed yet

private:
  // Skips an empty line before the request. Returns whether it is certain that no such line is
  // left.
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
    // The parser keeps a line back while the next one may continue it, so no folded line is missed.
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
  bool IsLineSkipped = false; // an empty line was skipped before this request
};

}
