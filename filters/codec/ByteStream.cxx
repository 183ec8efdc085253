// SPDX-License-Identifier: BSD-3-Clause
#include "filters/codec/ByteStream.h"

#include "filters/core/BitCast.h"

#include <algorithm>
#include <bit>
#include <string>

namespace kdstream
{

std::uint32_t OrderedBits(float value)
{
  const auto bits = BitCast<std::uint32_t>(value);
  return bits >> 31 ? ~bits : bits | 0x80000000U;
}

float FloatOfOrderedBits(std::uint32_t bits)
{
  return BitCast<float>(bits >> 31 ? bits & 0x7FFFFFFFU : ~bits);
}

std::uint64_t OrderedBits(double value)
{
  const auto bits = BitCast<std::uint64_t>(value);
  return bits >> 63 ? ~bits : bits | 0x8000000000000000U;
}

double DoubleOfOrderedBits(std::uint64_t bits)
{
  return BitCast<double>(bits >> 63 ? bits & 0x7FFFFFFFFFFFFFFFU : ~bits);
}

void ByteWriter::Raw(std::span<const std::uint8_t> bytes)
{
  this->Bytes.insert(this->Bytes.end(), bytes.begin(), bytes.end());
}

void ByteWriter::Varint(std::uint64_t value)
{
  while (value >= 0x80)
  {
    this->Byte(static_cast<std::uint8_t>(value | 0x80));
    value >>= 7;
  }
  this->Byte(static_cast<std::uint8_t>(value));
}

Error ByteReader::Why() const
{
  return { ErrorCode::InvalidInput,
    std::string(this->FailureReason) + " at byte " + std::to_string(this->FailureOffset) };
}

void ByteReader::Fail(std::string_view what)
{
  if (!this->Failure)
  {
    this->Failure = true;
    this->FailureOffset = this->Offset;
    this->FailureReason = what;
  }
}

std::uint8_t ByteReader::Byte()
{
  const auto bytes = this->Raw(1);
  return bytes.empty() ? std::uint8_t{ 0 } : bytes[0];
}

std::span<const std::uint8_t> ByteReader::Raw(std::size_t count)
{
  if (this->Failure || count > this->Remaining())
  {
    this->Fail("truncated");
    return {};
  }
  const auto bytes = this->Bytes.subspan(this->Offset, count);
  this->Offset += count;
  return bytes;
}

std::uint64_t ByteReader::Varint(std::uint64_t most)
{
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64; shift += 7)
  {
    const std::uint8_t byte = this->Byte();
    const std::uint64_t bits = byte & 0x7FU;
    if (shift == 63 && bits > 1)
    {
      break;
    }
    value |= bits << shift;
    if ((byte & 0x80U) == 0)
    {
      if (value > most)
      {
        this->Fail("number too large");
        return 0;
      }
      return value;
    }
  }
  this->Fail("number too long");
  return 0;
}

}
