// SPDX-License-Identifier: BSD-3-Clause
// A file read from front to back in large blocks: the lowest layer of step "read". Memory is one
// block, whatever the size of the file.
#pragma once

#include "filters/core/Result.h"

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

namespace kdstream
{

class ByteSource
{
public:
  // The largest number of bytes that one Peek can ask for.
  static constexpr std::size_t blockSize = std::size_t{ 1 } << 20;

  // Errors: NotFound; InputOutput with the system's reason; InvalidInput for anything except a
  // regular file.
  static Result<ByteSource> Open(const std::filesystem::path& file);

  // Opens the same file again at its beginning, even if its name now refers to another file.
  // Errors: InputOutput.
  Result<ByteSource> Again() const;

  ByteSource(ByteSource&& other) noexcept;
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;
  ByteSource& operator=(ByteSource&&) = delete;
  ~ByteSource();

  // The bytes ahead that are in memory: at least `wanted` of them, unless the file ends earlier.
  // The view stays valid until the next call other than Consume, Size or Position. REQUIRES: wanted
  // <= blockSize.
  Result<std::string_view> Peek(std::size_t wanted);

  // Skips `count` bytes. REQUIRES: count <= the size of the last Peek's view, minus the bytes
  // consumed since.
  void Consume(std::size_t count) { this->Begin += count; }

  // Goes to any place of the file. REQUIRES: Start() <= position <= Size().
  void Seek(std::uint64_t position);

  // Restricts the source to the bytes [begin, end), and goes to `begin`. Positions still count from
  // the beginning of the file. REQUIRES: Start() <= begin <= end <= Size().
  void Crop(std::uint64_t begin, std::uint64_t end);
  std::uint64_t Start() const { return this->First; }

  // The size when the file was opened, or the end at which it was cropped. Peek's view may end
  // earlier if the file has been truncated since.
  std::uint64_t Size() const { return this->FileSize; }
  std::uint64_t Position() const { return this->BufferOffset + this->Begin; }
  // REQUIRES: all consumed bytes lay inside the file (it does if every view came from Peek).
  std::uint64_t Remaining() const { return this->FileSize - this->Position(); }

private:
  ByteSource(int descriptor, std::uint64_t size);

  int Descriptor = -1;
  std::uint64_t First = 0, FileSize = 0;
  std::uint64_t BufferOffset = 0; // offset of Buffer[0] in the file
  std::size_t Begin = 0;          // Buffer[Begin, End) are the bytes ahead
  std::size_t End = 0;
  std::vector<char> Buffer;
};

}
