// SPDX-License-Identifier: BSD-3-Clause
#include "filters/texture/PictureReader.h"

#include "filters/core/TakeResult.h"
#include "filters/meshio/ByteSource.h"

#include <algorithm>

namespace kdstream
{
namespace
{

constexpr std::size_t mostWarnings = 20; // of pictures that cannot be read

Result<std::vector<std::uint8_t>> BytesOf(const PictureSource& source)
{
  if (source.file.empty())
  {
    return source.bytes;
  }
  Result<ByteSource> file = ByteSource::Open(source.file);
  KDSTREAM_TRY(file);
  const std::uint64_t offset = std::min(source.offset, file->Size());
  const std::uint64_t size = std::min(source.size, file->Size() - offset);
  file->Seek(offset);
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

Result<std::optional<ReadablePicture>> PictureReader::Read(std::uint32_t number)
{
  const PictureSource& source = this->Pictures[number];
  const Result<std::vector<std::uint8_t>> bytes = BytesOf(source);
  Result<ReadablePicture> picture =
    bytes ? this->Decode(number, *bytes) : Result<ReadablePicture>(bytes.GetError());
  if (bytes && !picture && picture.GetError().code == ErrorCode::InputOutput)
  {
    return picture.GetError();
  }
  if (!picture)
  {
    const bool missing = !bytes && bytes.GetError().code == ErrorCode::NotFound;
    if (++this->Unread <= mostWarnings)
    {
      this->Told.push_back(source.name +
                           (missing ? " is not there" : ": " + picture.GetError().message) +
                           ": the material's colour is taken");
    }
    return std::optional<ReadablePicture>();
  }
  const PictureType is = TypeOfPicture(*bytes), named = TypeOfName(source.file.string());
  if (named != PictureType::Unknown && named != is)
  {
    this->Told.push_back(
      source.name + ": is named as " + NameOf(named).substr(2) + ", but is " + NameOf(is));
  }
  return std::optional(std::move(*picture));
}

std::vector<std::string> PictureReader::Warnings() const
{
  std::vector<std::string> warnings = this->Told;
  if (this->Unread > mostWarnings)
  {
    warnings.push_back(
      std::to_string(this->Unread - mostWarnings) + " further pictures cannot be read");
  }
  return warnings;
}

}
