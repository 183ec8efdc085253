// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/WriteWhole.h"

#include "filters/core/SystemReason.h"

#include <cerrno>
#include <fstream>
#include <ios>
#include <system_error>

namespace kdstream
{

Status WriteWhole(const std::filesystem::path& file, std::string_view bytes)
{
  const std::filesystem::path unfinished = file.string() + ".new";
  errno = 0;
  std::ofstream output(unfinished, std::ios::binary | std::ios::trunc);
  output.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  output.close();
  std::error_code failure;
  int reason = errno;
  if (output)
  {
    std::filesystem::rename(unfinished, file, failure);
    reason = failure.value();
  }
  if (!output || failure)
  {
    std::filesystem::remove(unfinished, failure);
    return SystemError("cannot be written", reason, file.string());
  }
  return {};
}

}
