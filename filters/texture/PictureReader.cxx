// SPDX-License-Identifier: BSD-3-Clause
#include "filters/texture/PictureReader.h"

#include "filters/core/TakeResult.h"
#include "filters/meshio/ByteSource.h"

#include <algorithm>

namespace kdstream
{
namespace
{

constexpr std::size_t mostWarnings = 20;  // about pictures that cannot be read
constexpr std::size_t picturesAtOnce = 8; // the maximum between two reports of progress
constexpr std::size_t typeBytes = 12;     // bytes that TypeOfPicture needs
// Upper bounds for the file of the largest picture: texels of four 16-bit channels, and profiles.
constexpr std::uint64_t bytesPerPixel = 8, bytesBeside = std::uint64_t{ 1 } << 24;

// The bytes of the picture's file; if the file is not a picture, only the beginning.
Result<std::vector<std::uint8_t>> BytesOf(const PictureSource& source, std::uint64_t mostPixels)
{
  if (!source.wrong.empty())
  {
    return Error{ ErrorCode::InvalidInput, source.wrong };
  }
  if (source.file.empty())
  {
    return source.bytes;
  }
  Result<ByteSource> file = ByteSource::Open(source.file);
  KDSTREAM_TRY(file);
  const std::uint64_t offset = std::min(source.offset, file->Size());
  std::uint64_t size = std::min(source.size, file->Size() - offset);
  file->Seek(offset);
  const Result<std::string_view> begin = file->Peek(typeBytes);
  KDSTREAM_TRY(begin);
  if (TypeOfPicture({ reinterpret_cast<const std::uint8_t*>(begin->data()), begin->size() }) ==
      PictureType::Unknown)
  {
    size = std::min<std::uint64_t>(size, typeBytes);
  }
  if (size > bytesBeside && (size - bytesBeside) / bytesPerPixel > mostPixels)
  {
    return Error{ ErrorCode::LimitExceeded, "it has " + std::to_string(size) +
                                              " bytes, more than a picture of the limit of " +
                                              std::to_string(mostPixels) + " pixels" };
  }
  std::vector<std::uint8_t> bytes;
  while (bytes.size() < size)
  {
    const Result<std::string_view> block = file->Peek(1);
    KDSTREAM_TRY(block);
    const auto take =
      static_cast<std::size_t>(std::min<std::uint64_t>(block->size(), size - bytes.size()));
    if (take == 0)
    {
      break;
    }
    bytes.insert(bytes.end(), block->begin(), block->begin() + static_cast<std::ptrdiff_t>(take));
    file->Consume(take);
  }
  return bytes;
}

}

Result<ReadablePicture> PictureReader::Decode(
  std::uint32_t number, std::span<const std::uint8_t> bytes) const
{
  ReadablePicture picture;
  if (this->Folder)
  {
    Result<MappedPicture> mapped = this->Folder->AddPicture(number, bytes, this->MostPixels);
    KDSTREAM_TRY(mapped);
    picture.mapped.emplace(std::move(*mapped));
    return picture;
  }
  KDSTREAM_TRY(Take(DecodePicture(bytes, this->MostPixels), picture.memory));
  return picture;
}

std::optional<PictureReader::Outcome> PictureReader::Load(std::uint32_t number, bool byRows) const
{
  const Result<std::vector<std::uint8_t>> bytes = BytesOf(this->Pictures[number], this->MostPixels);
  if (!bytes)
  {
    return Outcome{ bytes.GetError(), bytes.GetError().code == ErrorCode::NotFound };
  }
  if (byRows && !IsDecodedByRows(*bytes))
  {
    return std::nullopt;
  }
  return Outcome{ this->Decode(number, *bytes), false, true, TypeOfPicture(*bytes) };
}

Status PictureReader::ReadAhead(
  const std::vector<std::uint32_t>& numbers, double share, const Execution& execution)
{
  if (!this->Folder)
  {
    return {};
  }
  this->Ahead.resize(this->Pictures.size());
  for (std::size_t first = 0; first < numbers.size(); first += picturesAtOnce)
  {
    KDSTREAM_TRY(execution.Report("textures", share * double(first) / double(numbers.size())));
    execution.parallelFor(std::min(picturesAtOnce, numbers.size() - first), 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = first + begin; i < first + end; ++i)
        {
          if (std::optional<Outcome> read = this->Load(numbers[i], true))
          {
            this->Ahead[numbers[i]].emplace(std::move(*read));
          }
        }
      });
  }
  return {};
}

Result<std::optional<ReadablePicture>> PictureReader::Read(std::uint32_t number)
{
  const PictureSource& source = this->Pictures[number];
  const bool ahead = number < this->Ahead.size() && this->Ahead[number];
  Outcome read = ahead ? std::move(*this->Ahead[number]) : *this->Load(number, false);
  if (ahead)
  {
    this->Ahead[number].reset();
  }
  if (!read.picture && read.wasRead && read.picture.GetError().code == ErrorCode::InputOutput)
  {
    return read.picture.GetError();
  }
  if (!read.picture)
  {
    if (++this->Unread <= mostWarnings)
    {
      this->Reported.push_back(
        source.name + (read.missing ? " is not there" : ": " + read.picture.GetError().message) +
        ": the material's colour is used");
    }
    return std::optional<ReadablePicture>();
  }
  const PictureType named = TypeOfName(source.file.string());
  if (named != PictureType::Unknown && named != read.type)
  {
    this->Reported.push_back(
      source.name + " is named as " + NameOf(named) + " file but contains " + NameOf(read.type));
  }
  return std::optional(std::move(*read.picture));
}

std::vector<std::string> PictureReader::Warnings() const
{
  std::vector<std::string> warnings = this->Reported;
  if (this->Unread > mostWarnings)
  {
    warnings.push_back(
      std::to_string(this->Unread - mostWarnings) + " further pictures cannot be read");
  }
  return warnings;
}

}
