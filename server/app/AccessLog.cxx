// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/AccessLog.h"

#include "filters/core/Texts.h"
#include "filters/core/UtcText.h"
#include "filters/model/JsonWriter.h"

#include <cstdio>
#include <ctime>
#include <utility>

namespace kdstream
{

namespace
{

// The first 1,000 characters, with quotes, and everything except printable ASCII, written as \xHH,
// so that a client cannot break the line.
std::string Escaped(const std::string& text)
{
  std::string safe;
  for (const char c : text.substr(0, 1000))
  {
    if (c > ' ' && c <= '~' && c != '"' && c != '\\')
    {
      safe += c;
      continue;
    }
    char code[8];
    std::snprintf(
      code, sizeof code, "\\x%02x", static_cast<unsigned>(static_cast<unsigned char>(c)));
    safe += code;
  }
  return safe;
}

std::string UtcNow()
{
  return UtcText(std::time(nullptr));
}

std::string LineOf(const PartitionRecord& record)
{
  JsonWriter json;
  json.BeginObject()
    .Member("time", UtcNow())
    .Member("sub", record.subject)
    .Member("jti", record.token)
    .Member("client", record.client)
    .Member("model", record.model)
    .Member("digest", record.digest)
    .Member("original", record.original)
    .Member("partition", record.partition)
    .Member("bytes", record.bytes)
    .EndObject();
  return json.Text() + "\n";
}

std::string LineOf(const AccessRecord& record)
{
  char numbers[80];
  std::snprintf(numbers, sizeof numbers, "\" %u %llu %.1f\n", record.status,
    static_cast<unsigned long long>(record.bytes), record.seconds * 1000);
  return UtcNow() + " " + Escaped(record.client) + " \"" + Escaped(record.method) + " " +
         Escaped(record.target) + numbers;
}

std::string LostAsJson(std::uint64_t count)
{
  return "{\"lost\":" + std::to_string(count) + "}\n";
}

}

Result<std::shared_ptr<AccessLog>> AccessLog::Open(const std::string& file, Form form)
{
  auto lines = LineLog::Open(file, form == Form::Text ? LineLog::LostAsText : LostAsJson);
  KDSTREAM_TRY(lines);
  return std::shared_ptr<AccessLog>(new AccessLog(std::move(*lines)));
}

void AccessLog::Write(const AccessRecord& record)
{
  this->Lines->Add(LineOf(record));
}

void AccessLog::Write(const PartitionRecord& record)
{
  this->Lines->Add(LineOf(record));
}

}
