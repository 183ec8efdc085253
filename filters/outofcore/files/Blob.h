// SPDX-License-Identifier: BSD-3-Clause
// The values that a finished phase of a build leaves for --resume besides its files: a few counts,
// boxes and lists, written as bytes and read back. For the journal and the phases (PhaseValues of
// filters/build). These are not the blobs of a store (doc/formats.md).
//
// A blob is written and read by the same program on the same machine (the build folder's
// fingerprint makes sure of that). Therefore values are stored as they are in memory.
#pragma once

#include "filters/core/Result.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace kdstream
{

class BlobWriter
{
public:
  template <class T>
  void Add(const T& value)
  {
    static_assert(std::is_trivially_copyable_v<T>);
    this->AddBytes(std::as_bytes(std::span(&value, 1)));
  }

  // Adds the length of the list, then its values.
  template <class T>
  void AddList(std::span<const T> values)
  {
    static_assert(std::is_trivially_copyable_v<T>);
    this->Add(static_cast<std::uint64_t>(values.size()));
    this->AddBytes(std::as_bytes(values));
  }
  template <class T>
  void AddList(const std::vector<T>& values)
  {
    this->AddList(std::span<const T>(values));
  }
  void AddText(std::string_view text) { this->AddList(std::span<const char>(text)); }

  // Adds the bytes without their number.
  void AddBytes(std::span<const std::byte> bytes)
  {
    // Not insert: g++ 12 then gives an unfounded warning.
    const std::size_t before = this->Content.size();
    this->Content.resize(before + bytes.size());
    std::copy(bytes.begin(), bytes.end(), this->Content.data() + before);
  }

  const std::vector<std::byte>& Bytes() const { return this->Content; }

private:
  std::vector<std::byte> Content;
};

// Reads what a BlobWriter wrote, in the same order. Missing values are read as zeros, empty lists
// and empty texts; Finish reports them. No memory is allocated for a list that claims to be longer
// than the remaining bytes.
class BlobReader
{
public:
  explicit BlobReader(std::span<const std::byte> bytes)
    : Content(bytes)
  {
  }

  template <class T>
  T Read()
  {
    static_assert(std::is_trivially_copyable_v<T>);
    T value{};
    if (this->CanRead(1, sizeof(T)))
    {
      std::memcpy(&value, this->Content.data() + this->At, sizeof(T));
      this->At += sizeof(T);
    }
    return value;
  }

  template <class T>
  std::vector<T> ReadList()
  {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto count = this->Read<std::uint64_t>();
    std::vector<T> values;
    if (this->CanRead(count, sizeof(T)) && count > 0)
    {
      values.resize(static_cast<std::size_t>(count));
      std::memcpy(values.data(), this->Content.data() + this->At, values.size() * sizeof(T));
      this->At += values.size() * sizeof(T);
    }
    return values;
  }

  std::string ReadText()
  {
    const std::vector<char> text = this->ReadList<char>();
    return { text.begin(), text.end() };
  }

  // False as soon as a value was missing. A loop over a count that was read must stop then.
  bool Good() const { return this->FirstError.HasValue(); }

  // Errors: Damaged, with the offset, if a value was missing or if bytes are left over.
  Status Finish() const
  {
    if (this->Good() && this->At < this->Content.size())
    {
      return Error{ ErrorCode::Damaged, std::to_string(this->Content.size() - this->At) +
                                          " bytes too many at offset " + std::to_string(this->At) };
    }
    return this->FirstError;
  }

private:
  bool CanRead(std::uint64_t count, std::size_t bytes)
  {
    if (this->Good() && count > (this->Content.size() - this->At) / bytes)
    {
      this->FirstError =
        Error{ ErrorCode::Damaged, std::to_string(count) + " values of " + std::to_string(bytes) +
                                     " bytes are missing at offset " + std::to_string(this->At) };
    }
    return this->Good();
  }

  std::span<const std::byte> Content;
  std::size_t At = 0;
  Status FirstError;
};

}
