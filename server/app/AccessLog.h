// SPDX-License-Identifier: BSD-3-Clause
// The access log of kdstream-serve: one line a request.
//
//   2026-01-31T12:00:00Z 127.0.0.1 "GET /api/models.json" 200 512 0.3
//
// time, client, method and target, status, bytes sent, milliseconds. What a client has sent is
// escaped.
#pragma once

#include "filters/core/Result.h"
#include "server/http/HttpServer.h"

#include <cstdio>
#include <memory>
#include <string>

namespace kdstream
{

class AccessLog
{
public:
  // Appends to `file`; "-" is stderr. Errors: InputOutput.
  static Result<std::shared_ptr<AccessLog>> Open(const std::string& file);
  ~AccessLog();
  AccessLog(const AccessLog&) = delete;
  AccessLog& operator=(const AccessLog&) = delete;

  // One thread at a time.
  void Write(const AccessRecord& record);

private:
  explicit AccessLog(std::FILE* stream)
    : Stream(stream)
  {
  }
  std::FILE* Stream;
};

}
