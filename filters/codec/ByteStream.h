// SPDX-License-Identifier: BSD-3-Clause
// Bytes in and out: fixed and variable-length integers, and streams of integers as byte planes.
// Lengths are never trusted: a reader that runs out of bytes reports the place, and allocates
// nothing for the missing bytes.
#pragma once

#include "filters/core/Result.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace kdstream
{

// Maps floating-point numbers to integers of the same order, and back: a < b if and only if this is
// true of their integers (where -0.0 < 0.0).
std::uint32_t OrderedBits(float value);
float FloatOfOrderedBits(std::uint32_t bits);
std::uint64_t OrderedBits(double value);
double DoubleOfOrderedBits(std::uint64_t bits);

// Maps signed numbers to unsigned ones, and back. Numbers near 0 of either sign stay small: 0, -1,
// 1, -2 … become 0, 1, 2, 3 ….
constexpr std::uint64_t Zigzag(std::int64_t number)
{
  const auto bits = static_cast<std::uint64_t>(number);
  return (bits << 1) ^ (std::uint64_t{ 0 } - (bits >> 63));
}
constexpr std::int64_t Unzigzag(std::uint64_t number)
{
  return static_cast<std::int64_t>((number >> 1) ^ (std::uint64_t{ 0 } - (number & 1)));
}

class ByteWriter
{
public:
  void Byte(std::uint8_t value) { this->Bytes.push_back(value); }
  void Raw(std::span<const std::uint8_t> bytes);
  // LEB128: seven bits a byte, lowest first.
  void Varint(std::uint64_t value);

  std::vector<std::uint8_t> Take() { return std::move(this->Bytes); }

private:
  std::vector<std::uint8_t> Bytes;
};

class ByteReader
{
public:
  explicit ByteReader(std::span<const std::uint8_t> bytes)
    : Bytes(bytes)
  {
  }

  std::size_t Position() const { return this->Offset; }
  std::size_t Remaining() const { return this->Bytes.size() - this->Offset; }

  // Whether a read has failed. The error is that of the first failed read, and names the byte
  // offset; later reads give zeros and empty spans.
  bool Failed() const { return this->Failure; }
  Error Why() const;
  void Fail(std::string_view what);

  std::uint8_t Byte();
  std::span<const std::uint8_t> Raw(std::size_t count);
  // A varint that must not be above `most`.
  std::uint64_t Varint(std::uint64_t most);
  // The same for a number of things that are held in memory.
  std::size_t Count(std::size_t most) { return static_cast<std::size_t>(this->Varint(most)); }

private:
  std::span<const std::uint8_t> Bytes;
  std::size_t Offset = 0;
  bool Failure = false;
  std::size_t FailureOffset = 0;
  std::string_view FailureReason;
};

}
