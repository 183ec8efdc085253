// SPDX-License-Identifier: BSD-3-Clause
// The logs of kdstream-serve, and its messages once it serves. The access log: one line a request.
//
//   2026-01-31T12:00:00Z 127.0.0.1 "GET /api/models.json" 200 512 0.3
//
// time, client, method and target, status, bytes sent, milliseconds. What a client has sent is
// escaped. The audit log: one line a partition that a client gets, as JSON.
//
//   {"time":"2026-01-31T12:00:00Z","sub":"ann","jti":"…","client":"127.0.0.1","model":"dragon",
//    "digest":"…","partition":12,"bytes":15000}
//
// A thread of its own writes: a disk that is full or slow, or a pipe that nobody reads,
// costs lines, never an answer's time.
#pragma once

#include "filters/core/Result.h"
#include "server/http/HttpServer.h"

#include <memory>
#include <string>

namespace kdstream
{

class AccessLog
{
public:
  // Lines that wait for the disk take at most so many bytes; further ones are left out, and a line
  // says how many: "# 17 lines are lost", as JSON {"lost":17}.
  static constexpr std::size_t waitingBytes = std::size_t{ 4 } << 20;

  enum class Form
  {
    Text,
    Json
  };
  // Appends to `file`; "-" is stderr. Errors: InputOutput.
  static Result<std::shared_ptr<AccessLog>> Open(const std::string& file, Form form = Form::Text);
  // Writes what waits, for at most a second.
  ~AccessLog();
  AccessLog(const AccessLog&) = delete;
  AccessLog& operator=(const AccessLog&) = delete;

  // Waits for nobody. From any thread.
  void Write(const AccessRecord& record);
  void Write(const PartitionRecord& record);
  void Write(const std::string& line); // with its end

  // What comes from now on goes to what has the file's name now: log rotation. Errors: InputOutput;
  // then the lines go on where they went.
  Status Reopen();

private:
  struct Writer;
  AccessLog(std::string file, std::shared_ptr<Writer> writer);
  std::string File;
  std::shared_ptr<Writer> Lines;
};

}
