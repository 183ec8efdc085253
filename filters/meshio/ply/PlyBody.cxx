// SPDX-License-Identifier: BSD-3-Clause
// The records of a PLY file's body: the messages that the ascii and the binary encodings share.
// Part of step "read".
#include "filters/meshio/ply/PlyBody.h"

namespace kdstream
{

namespace
{

// A hint for a 4-byte number that is too large, if it would fit with its bytes in the other order;
// else empty.
std::string OtherByteOrder(std::int64_t number, std::uint64_t limit)
{
  constexpr std::int64_t large = 1 << 16;
  const std::uint32_t other = __builtin_bswap32(static_cast<std::uint32_t>(number));
  return number < 0 || (number >= large && number <= 0xFFFFFFFF)
           ? (other < limit ? "; with its bytes swapped it is " + std::to_string(other) +
                                ": the header's format may be wrong"
                            : "")
           : "";
}

}

std::unique_ptr<PlyBody> PlyBody::Make(const PlyHeader& header, ByteSource& source)
{
  return header.encoding == PlyEncoding::Ascii
           ? MakePlyAsciiBody(header, source)
           : MakePlyBinaryBody(source, header.encoding == PlyEncoding::BinaryBigEndian);
}

std::string PlyPlace::Name() const
{
  return this->element.name + " " + std::to_string(this->record) +
         (this->line > 0 ? " (line " + std::to_string(this->line) + ")" : "");
}

Error PlyPlace::Bad(const std::string& what) const
{
  return Error{ ErrorCode::InvalidInput, this->Name() + ": " + what };
}

Error PlyPlace::Truncated(std::uint64_t byte) const
{
  return BadInput("truncated: " + this->element.name + " " + std::to_string(this->record) + " of " +
                    std::to_string(this->element.count) + " expected at byte " +
                    std::to_string(byte),
    Remedy::CopyAgain);
}

Error PlyPlace::BadIndex(std::int64_t index, const PlyFaceSink& sink) const
{
  const std::uint64_t count = sink.GetVertexCount();
  return Error{ ErrorCode::InvalidInput,
    this->Name() + " names vertex " + std::to_string(index) +
      (count == 0    ? ", but there are none"
        : count == 1 ? ", but there is only 1, counted from 0"
                     : ", but there are only " + std::to_string(count) + ", counted from 0") +
      OtherByteOrder(index, count) };
}

Error PlyPlace::BadListCount(const PlyProperty& property, std::int64_t count) const
{
  return this->Bad("list " + property.name + " claims " + std::to_string(count) + " values");
}

Error PlyPlace::ListPastEnd(
  const PlyProperty& property, std::int64_t count, std::uint64_t byte) const
{
  return BadInput("truncated: " + this->element.name + " " + std::to_string(this->record) + " of " +
                    std::to_string(this->element.count) + ": list " + property.name + " at byte " +
                    std::to_string(byte) + " claims " + std::to_string(count) +
                    " values, which run past the end of the file" +
                    OtherByteOrder(count, std::uint64_t{ 1 } << 16U),
    Remedy::CopyAgain);
}

Error PlyPlace::RepeatsTooMuch() const
{
  return Error{ ErrorCode::LimitExceeded,
    this->Name() +
      ": its properties, repeated for each of its triangles, take more than the file warrants" };
}

}
