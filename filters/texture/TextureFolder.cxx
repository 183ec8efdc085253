// SPDX-License-Identifier: BSD-3-Clause
#include "filters/texture/TextureFolder.h"

#include "filters/codec/ByteStream.h"
#include "filters/core/BitCast.h"
#include "filters/core/SystemReason.h"
#include "filters/files/NewFile.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <string>

namespace kdstream
{
namespace
{

constexpr auto squareSide = static_cast<std::int64_t>(TexelLayout::squareSide);
constexpr std::size_t squareBytes = TexelLayout::squareBytes;
constexpr std::uint64_t mostIndexBytes = std::uint64_t{ 1 } << 26;
constexpr std::uint64_t mostSide = std::uint64_t{ 1 } << 31;
// How many pictures stay open: a tileset may have more pictures than a process may have open files.
constexpr std::size_t mostOpenPictures = 512;

std::int64_t SquaresAlong(std::uint64_t texels)
{
  return static_cast<std::int64_t>((texels + squareSide - 1) / squareSide);
}

std::filesystem::path PictureFile(const std::filesystem::path& folder, std::size_t number)
{
  return folder / ("picture-" + std::to_string(number));
}

Error CannotWrite(const std::filesystem::path& file)
{
  return { ErrorCode::InputOutput, "cannot be written: " + SystemReason(errno), file.string() };
}

void PutDouble(ByteWriter& writer, double value)
{
  std::uint64_t bits = BitCast<std::uint64_t>(value);
  for (int i = 0; i < 8; ++i, bits >>= 8)
  {
    writer.Byte(static_cast<std::uint8_t>(bits));
  }
}

double TakeDouble(ByteReader& reader)
{
  std::uint64_t bits = 0;
  for (int i = 0; i < 8; ++i)
  {
    bits |= std::uint64_t{ reader.Byte() } << (8 * i);
  }
  return BitCast<double>(bits);
}

// Visits the numbers of a material in the order of the index.
template <class Visit, class Material>
void ForEachNumber(Material& material, const Visit& visit)
{
  std::for_each(material.color.begin(), material.color.end(), visit);
  std::for_each(material.factor.begin(), material.factor.end(), visit);
  std::for_each(material.transform.u.begin(), material.transform.u.end(), visit);
  std::for_each(material.transform.v.begin(), material.transform.v.end(), visit);
}

// Writes rows into the file; a row of squares is in memory.
class SquareRows : public PictureRows
{
public:
  explicit SquareRows(const std::filesystem::path& file)
    : Name(file.string())
    , File(OfFile(this->Name, NewFile::Create(file)))
    , Failure(this->File ? Status{} : Status(this->File.GetError()))
  {
  }

  bool Begin(std::size_t width, std::size_t height, std::size_t components) override
  {
    this->PictureWidth = width;
    this->PictureHeight = height;
    this->Components = components;
    this->Squares.assign(static_cast<std::size_t>(SquaresAlong(width)) * squareBytes, 0);
    return bool(this->Failure);
  }

  bool AddRow(const std::uint8_t* texels) override
  {
    const std::size_t side = TexelLayout::squareSide, row = this->Rows % side;
    for (std::size_t x = 0; x < this->PictureWidth; ++x, texels += this->Components)
    {
      const auto rgba = RgbaOf(texels, this->Components);
      const std::size_t at = x / side * squareBytes + 4 * (row * side + x % side);
      std::copy(rgba.begin(), rgba.end(), this->Squares.begin() + static_cast<std::ptrdiff_t>(at));
    }
    ++this->Rows;
    return this->Rows % side == 0 || this->Rows == this->PictureHeight ? this->Write()
                                                                       : bool(this->Failure);
  }

  Status Why() const override { return this->Failure; }

  Status Finish()
  {
    return this->Failure ? OfFile(this->Name, this->File->Finish(NewFile::Lasts::Processes))
                         : this->Failure;
  }
  std::size_t Width() const { return this->PictureWidth; }
  std::size_t Height() const { return this->PictureHeight; }

private:
  bool Write()
  {
    if (this->Failure)
    {
      const std::string_view squares(
        reinterpret_cast<const char*>(this->Squares.data()), this->Squares.size());
      this->Failure = OfFile(this->Name, this->File->Write(squares));
    }
    std::fill(this->Squares.begin(), this->Squares.end(), std::uint8_t{ 0 });
    return bool(this->Failure);
  }

  const std::string Name;
  Result<NewFile> File;
  std::vector<std::uint8_t> Squares;
  std::size_t PictureWidth = 0, PictureHeight = 0, Components = 0, Rows = 0;
  Status Failure;
};

TextureWrap TakeWrap(ByteReader& reader)
{
  const std::uint8_t wrap = reader.Byte();
  if (wrap > static_cast<std::uint8_t>(TextureWrap::Clamp))
  {
    reader.Fail("an unknown wrap mode");
    return TextureWrap::Repeat;
  }
  return static_cast<TextureWrap>(wrap);
}

}

Result<TextureFolderWriter> TextureFolderWriter::Create(
  const std::filesystem::path& folder, std::size_t pictures)
{
  if (::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST)
  {
    return CannotWrite(folder);
  }
  return TextureFolderWriter(folder, pictures);
}

Result<MappedPicture> TextureFolderWriter::AddPicture(
  std::uint32_t number, std::span<const std::uint8_t> bytes, std::uint64_t mostPixels)
{
  const std::filesystem::path file = PictureFile(this->Folder, number);
  SquareRows rows(file);
  KDSTREAM_TRY(rows.Why());
  KDSTREAM_TRY(DecodePictureRows(bytes, mostPixels, rows));
  KDSTREAM_TRY(rows.Finish());
  Result<MappedPicture> picture = MappedPicture::Open(file, rows.Width(), rows.Height());
  KDSTREAM_TRY(picture);
  this->Sizes[number] = { static_cast<std::uint32_t>(rows.Width()),
    static_cast<std::uint32_t>(rows.Height()) };
  return picture;
}

Result<std::uint32_t> TextureFolderWriter::AddTexels(const Picture& picture)
{
  const auto number = static_cast<std::uint32_t>(this->Sizes.size());
  SquareRows rows(PictureFile(this->Folder, number));
  rows.Begin(picture.width, picture.height, picture.components);
  for (std::size_t y = 0; y < picture.height; ++y)
  {
    rows.AddRow(&picture.texels[y * picture.width * picture.components]);
  }
  KDSTREAM_TRY(rows.Why());
  KDSTREAM_TRY(rows.Finish());
  this->Sizes.push_back(
    { static_cast<std::uint32_t>(picture.width), static_cast<std::uint32_t>(picture.height) });
  return number;
}

Result<MappedPicture> MappedPicture::Open(
  const std::filesystem::path& file, std::size_t width, std::size_t height)
{
  MappedPicture picture;
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  const auto bytes =
    static_cast<std::size_t>(SquaresAlong(width) * SquaresAlong(height)) * squareBytes;
  void* const texels =
    descriptor < 0 ? MAP_FAILED : ::mmap(nullptr, bytes, PROT_READ, MAP_SHARED, descriptor, 0);
  const int reason = errno;
  if (descriptor >= 0)
  {
    ::close(descriptor);
  }
  if (texels == MAP_FAILED)
  {
    return Error{ ErrorCode::InputOutput, "cannot be read: " + SystemReason(reason),
      file.string() };
  }
  picture.Layout = { width, height, 4, static_cast<const std::uint8_t*>(texels), true };
  picture.Bytes = bytes;
  return picture;
}

MappedPicture::~MappedPicture()
{
  if (this->Bytes > 0)
  {
    ::munmap(const_cast<std::uint8_t*>(this->Layout.texels), this->Bytes);
  }
}

Status TextureFolderWriter::Finish(const std::vector<TexturedMaterial>& materials)
{
  ByteWriter writer;
  writer.Varint(this->Sizes.size());
  for (const auto& [width, height] : this->Sizes)
  {
    writer.Varint(width);
    writer.Varint(height);
  }
  writer.Varint(materials.size());
  for (const TexturedMaterial& material : materials)
  {
    ForEachNumber(material, [&](double value) { PutDouble(writer, value); });
    writer.Varint(material.picture);
    writer.Byte(static_cast<std::uint8_t>(material.wrapU));
    writer.Byte(static_cast<std::uint8_t>(material.wrapV));
    writer.Byte(material.opaque ? 1 : 0);
  }
  const std::vector<std::uint8_t> bytes = writer.Take();
  const std::filesystem::path file = this->Folder / "paint";
  auto output = OfFile(file.string(), NewFile::Create(file));
  KDSTREAM_TRY(output);
  KDSTREAM_TRY(OfFile(
    file.string(), output->Write({ reinterpret_cast<const char*>(bytes.data()), bytes.size() })));
  return OfFile(file.string(), output->Finish(NewFile::Lasts::Processes));
}

Result<std::shared_ptr<const TextureFolder>> TextureFolder::Open(
  const std::filesystem::path& folder)
{
  const std::filesystem::path index = folder / "paint";
  std::error_code failure;
  const std::uintmax_t size = std::filesystem::file_size(index, failure);
  if (failure || size > mostIndexBytes)
  {
    return Error{ failure ? ErrorCode::NotFound : ErrorCode::LimitExceeded,
      failure ? "is not there" : "is far too long", index.string() };
  }
  std::ifstream stream(index, std::ios::binary);
  const std::vector<char> content{ std::istreambuf_iterator<char>(stream), {} };
  ByteReader reader({ reinterpret_cast<const std::uint8_t*>(content.data()), content.size() });
  std::shared_ptr<TextureFolder> textures(new TextureFolder);
  textures->Folder = folder;
  const std::size_t pictures = reader.Count(content.size());
  textures->Textures.pictures = pictures;
  for (std::size_t i = 0; i < pictures && !reader.Failed(); ++i)
  {
    const auto width = static_cast<std::uint32_t>(reader.Varint(mostSide));
    const auto height = static_cast<std::uint32_t>(reader.Varint(mostSide));
    KDSTREAM_TRY(textures->OpenPicture(PictureFile(folder, i), { width, height }));
  }
  const std::size_t materials = reader.Count(content.size());
  for (std::size_t i = 0; i < materials && !reader.Failed(); ++i)
  {
    TexturedMaterial& material = textures->Textures.materials.emplace_back();
    ForEachNumber(material, [&](double& value) { value = TakeDouble(reader); });
    material.picture = static_cast<std::uint32_t>(reader.Varint(noPicture));
    material.wrapU = TakeWrap(reader);
    material.wrapV = TakeWrap(reader);
    material.opaque = reader.Byte() != 0;
    if (material.picture != noPicture && material.picture >= pictures)
    {
      reader.Fail("a material whose picture does not exist");
    }
  }
  if (reader.Failed() || reader.Remaining() > 0)
  {
    Error error =
      reader.Failed() ? reader.Why() : Error{ ErrorCode::InvalidInput, "bytes beyond the end" };
    return OfFile(index.string(), Status(error)).GetError();
  }
  textures->Textures.shown = NumberShownPictures(textures->Textures);
  return std::shared_ptr<const TextureFolder>(std::move(textures));
}

Status TextureFolder::OpenPicture(
  const std::filesystem::path& file, std::array<std::uint32_t, 2> size)
{
  this->Sizes.push_back(size);
  this->Descriptors.push_back(-1);
  if (size[0] == 0 || size[1] == 0)
  {
    this->Sizes.back() = {};
    return {};
  }
  struct stat state = {};
  const bool stays = this->Descriptors.size() <= mostOpenPictures;
  this->Descriptors.back() = stays ? ::open(file.c_str(), O_RDONLY | O_CLOEXEC) : -1;
  if ((stays && this->Descriptors.back() < 0) || ::stat(file.c_str(), &state) != 0)
  {
    return Error{ ErrorCode::InputOutput, "cannot be read: " + SystemReason(errno), file.string() };
  }
  const auto squares = static_cast<std::uint64_t>(SquaresAlong(size[0]) * SquaresAlong(size[1]));
  if (static_cast<std::uint64_t>(state.st_size) != squares * squareBytes)
  {
    return Error{ ErrorCode::InvalidInput, "has another size than its picture", file.string() };
  }
  return {};
}

TextureFolder::~TextureFolder()
{
  for (const int descriptor : this->Descriptors)
  {
    if (descriptor >= 0)
    {
      ::close(descriptor);
    }
  }
}

Status TextureFolder::Read(std::uint32_t picture, const TexelBox& box, std::uint8_t* rgba) const
{
  const bool isOpen = this->Descriptors[picture] >= 0;
  const int descriptor =
    isOpen ? this->Descriptors[picture]
           : ::open(PictureFile(this->Folder, picture).c_str(), O_RDONLY | O_CLOEXEC);
  const Status read = this->ReadFrom(descriptor, picture, box, rgba);
  if (!isOpen && descriptor >= 0)
  {
    ::close(descriptor);
  }
  return read;
}

Status TextureFolder::ReadFrom(
  int descriptor, std::uint32_t picture, const TexelBox& box, std::uint8_t* rgba) const
{
  const std::int64_t columns = SquaresAlong(this->Sizes[picture][0]);
  std::array<std::uint8_t, squareBytes> square;
  for (std::int64_t row = box.lo[1] / squareSide; row * squareSide < box.hi[1]; ++row)
  {
    for (std::int64_t column = box.lo[0] / squareSide; column * squareSide < box.hi[0]; ++column)
    {
      const off_t at = (row * columns + column) * std::int64_t{ squareBytes };
      if (::pread(descriptor, square.data(), square.size(), at) !=
          static_cast<ssize_t>(square.size()))
      {
        return Error{ ErrorCode::InputOutput,
          "the decoded picture " + std::to_string(picture) + " cannot be read" };
      }
      const std::int64_t left = std::max(box.lo[0], column * squareSide);
      const std::int64_t right = std::min(box.hi[0], (column + 1) * squareSide);
      for (std::int64_t y = std::max(box.lo[1], row * squareSide);
           y < std::min(box.hi[1], (row + 1) * squareSide); ++y)
      {
        const std::uint8_t* const from =
          square.data() + 4 * ((y - row * squareSide) * squareSide + left - column * squareSide);
        std::copy_n(
          from, 4 * (right - left), rgba + 4 * ((y - box.lo[1]) * box.Width() + left - box.lo[0]));
      }
    }
  }
  return {};
}

}
