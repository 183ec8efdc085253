// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/AccessLog.h"

#include "filters/core/SystemReason.h"

#include <cerrno>
#include <ctime>

namespace kdstream
{

namespace
{

// The first 1,000 characters, with quotes and everything but printable ASCII as \xHH, so that a
// client cannot break the line.
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

}

Result<std::shared_ptr<AccessLog>> AccessLog::Open(const std::string& file)
{
  std::FILE* stream = file == "-" ? stderr : std::fopen(file.c_str(), "a");
  if (!stream)
  {
    return SystemError("cannot be written", errno);
  }
  return std::shared_ptr<AccessLog>(new AccessLog(stream));
}

AccessLog::~AccessLog()
{
  if (this->Stream != stderr)
  {
    std::fclose(this->Stream);
  }
}

void AccessLog::Write(const AccessRecord& record)
{
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char time[32];
  std::strftime(time, sizeof time, "%Y-%m-%dT%H:%M:%SZ", &utc);
  std::fprintf(this->Stream, "%s %s \"%s %s\" %u %llu %.1f\n", time, record.client.c_str(),
    Escaped(record.method).c_str(), Escaped(record.target).c_str(), record.status,
    static_cast<unsigned long long>(record.bytes), record.seconds * 1000);
  std::fflush(this->Stream);
}

}
