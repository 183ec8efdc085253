// SPDX-License-Identifier: BSD-3-Clause
// A file that appears whole or not at all (NewFile), written piece by piece in large blocks. For
// the writers.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/files/NewFile.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace kdstream
{

// Open, Write…, Finish. After the first error Write does nothing, and Finish returns the error. A
// file that is not finished is removed.
class OutputFile
{
public:
  OutputFile() = default;
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile() = default;

  // Removes temporary files of the same name that killed programs have left. `execution` is asked
  // for cancellation before each block, as step "write". Errors: InputOutput with the system's
  // reason, or for a name of something other than a regular file; Cancelled from Finish.
  Status Open(const std::filesystem::path& file, const Execution& execution = {});

  void Write(std::string_view bytes)
  {
    this->Buffer.append(bytes);
    if (this->Buffer.size() >= blockSize)
    {
      this->Flush();
    }
  }

  // Writes the bytes of a number, the lowest first.
  template <class T>
  void WriteLittleEndian(T value)
  {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if constexpr (std::endian::native == std::endian::big)
    {
      std::reverse(bytes, bytes + sizeof(T));
    }
    this->Write(std::string_view(bytes, sizeof(T)));
  }

  // Writes the shortest decimals that read back to the same value.
  template <class T>
  void WriteText(T value)
  {
    char text[32];
    const std::to_chars_result written = std::to_chars(text, text + sizeof(text), value);
    this->Write(std::string_view(text, static_cast<std::size_t>(written.ptr - text)));
  }

  // Writes what is still in memory, makes the file durable, and gives it its name.
  Status Finish();

private:
  static constexpr std::size_t blockSize = std::size_t{ 1 } << 20;

  void Flush();

  std::optional<NewFile> File;
  Execution Runs;
  std::string Buffer;
  Status FirstError;
};

}
