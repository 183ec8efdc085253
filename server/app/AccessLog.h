// SPDX-License-Identifier: BSD-3-Clause
// The logs of kdstream-serve. The access log has one line for each request:
//
//   2026-01-31T12:00:00Z 127.0.0.1 "GET /api/models.json" 200 512 0.3
//
// The fields: time, client, method and target, status, bytes sent, milliseconds. Text that a client
// has sent is escaped. The audit log has one line of JSON for each partition that a client
// receives:
//
//   {"time":"2026-01-31T12:00:00Z","sub":"ann","jti":"…","client":"127.0.0.1","model":"dragon",
//    "digest":"…","original":"…","partition":12,"bytes":15000}
//
// Lines that cannot be written are lost. A later line gives their number: "# 17 lines were lost",
// or {"lost":17} in the audit log.
#pragma once

#include "filters/core/Result.h"
#include "server/app/LineLog.h"
#include "server/http/HttpServer.h"

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

namespace kdstream
{

class AccessLog
{
public:
  enum class Form
  {
    Text,
    Json
  };
  // Appends to `file`; "-" is stderr. Errors: InputOutput.
  static Result<std::shared_ptr<AccessLog>> Open(const std::string& file, Form form = Form::Text);

  // Returns at once: the line is written later. From any thread.
  void Write(const AccessRecord& record);
  void Write(const PartitionRecord& record);

  // The number of lines lost so far (LineLog::Lost).
  std::uint64_t Lost() const { return this->Lines->Lost(); }
  std::string WhyLost() const { return this->Lines->WhyLost(); }
  Status Reopen() { return this->Lines->Reopen(); }
  void End() { this->Lines->End(); }

private:
  explicit AccessLog(std::shared_ptr<LineLog> lines)
    : Lines(std::move(lines))
  {
  }
  std::shared_ptr<LineLog> Lines;
};

}
