// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/gltf/GltfBuffers.h"

#include "filters/convert/gltf/GltfCompression.h"
#include "filters/core/SystemReason.h"
#include "filters/core/Texts.h"
#include "filters/meshio/QuotedText.h"
#include "filters/texture/FilesBeside.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>

namespace kdstream
{
namespace
{

using Json = nlohmann::json;

// Whether this is a data URI, which holds the bytes in the .gltf itself.
bool IsData(const std::string& uri)
{
  return uri.starts_with("data:");
}

// The file that a URI names. Tries the URI with %HH decoded; then the exact name; then, as for
// pictures, the name as other systems write it.
Result<std::filesystem::path> PlaceOf(const std::string& uri, FilesBeside& files)
{
  const std::string decoded = PercentDecoded(uri).value_or(uri);
  const std::string withoutQuery = decoded.substr(0, decoded.find('?'));
  for (const std::string& name : { decoded, uri, withoutQuery })
  {
    std::filesystem::path found = files.Find(name);
    std::error_code failure;
    if (std::filesystem::is_regular_file(found, failure))
    {
      return found;
    }
  }
  return BadInput("the file " + QuotedText(uri) + ", in which its geometry is, " + WhyMissing(uri) +
                    ": put it into the folder of the glTF, under this name",
    Remedy::InMessage);
}

}

// A memory-mapped file: its bytes are read when they are used.
class GltfBuffers::Mapping
{
public:
  explicit Mapping(const std::filesystem::path& file)
  {
    const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status
    {
    };
    if (descriptor < 0 || ::fstat(descriptor, &status) != 0)
    {
      this->Reason = errno;
    }
    else if (status.st_size > 0)
    {
      this->Size = static_cast<std::size_t>(status.st_size);
      this->Bytes = ::mmap(nullptr, this->Size, PROT_READ, MAP_PRIVATE, descriptor, 0);
      this->Reason = this->Bytes == MAP_FAILED ? errno : 0;
    }
    if (descriptor >= 0)
    {
      ::close(descriptor);
    }
  }
  ~Mapping()
  {
    if (this->Size > 0 && this->Bytes != MAP_FAILED)
    {
      ::munmap(this->Bytes, this->Size);
    }
  }
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;

  Result<GltfBytes> Get() const
  {
    return this->Reason != 0 ? Result<GltfBytes>(Error{ ErrorCode::InputOutput,
                                 "cannot be read: " + SystemReason(this->Reason) })
                             : GltfBytes(static_cast<const std::uint8_t*>(this->Bytes), this->Size);
  }

private:
  void* Bytes = nullptr;
  std::size_t Size = 0;
  int Reason = 0;
};

Result<GltfBytes> GltfBuffers::Map(const std::filesystem::path& file)
{
  std::shared_ptr<Mapping>& mapping = this->Mappings[file];
  if (!mapping)
  {
    mapping = std::make_shared<Mapping>(file);
  }
  return OfFile(file.string(), mapping->Get());
}

Status GltfBuffers::Find(std::size_t number, const std::filesystem::path& file, FilesBeside& files)
{
  const Json& buffer = Member(this->Document->json, "buffers")[number];
  const Json& uri = Member(buffer, "uri");
  const std::string name = uri.is_string() ? uri.get<std::string>() : std::string();
  const std::string named = "buffer " + std::to_string(number);
  Buffer& found = this->Buffers[number];
  found.isThere = true;
  std::string place = named;
  if (IsData(name))
  {
    std::optional<std::vector<std::uint8_t>> data = DataOf(name);
    if (!data)
    {
      return Error{ ErrorCode::InvalidInput, named + " is a data URI that is not base64" };
    }
    found.bytes = this->Decoded.emplace_back(std::move(*data));
  }
  else if (uri.is_string())
  {
    const Result<std::filesystem::path> path = PlaceOf(name, files);
    KDSTREAM_TRY(path);
    const Result<GltfBytes> bytes = this->Map(*path);
    KDSTREAM_TRY(bytes);
    this->Named.push_back(*path);
    found.bytes = *bytes;
    place = "the file " + QuotedText(name);
  }
  else if (this->Document->isGlb && number == 0)
  {
    if (this->Document->binary == 0 && NumberOf(Member(buffer, "byteLength"), 0) > 0)
    {
      return BadInput(named + " is in the binary chunk (BIN), which is missing" +
                        (this->Document->otherChunk.empty()
                            ? std::string()
                            : ": the second chunk is " + this->Document->otherChunk),
        Remedy::CopyAgain);
    }
    const Result<GltfBytes> bytes = this->Map(file);
    KDSTREAM_TRY(bytes);
    const auto begin = std::min<std::size_t>(this->Document->binary, bytes->size());
    found.bytes = bytes->subspan(
      begin, std::min<std::size_t>(this->Document->binaryBytes, bytes->size() - begin));
    place = "its binary chunk (BIN)";
  }
  else
  {
    found.isThere = false;
    return {};
  }
  const Json& written = Member(buffer, "byteLength");
  const double length = NumberOf(written, 0);
  if (length > double(found.bytes.size()))
  {
    return BadInput("claims " + written.dump() + " bytes of " + place + "; it has " +
                      std::to_string(found.bytes.size()),
      Remedy::CopyAgain);
  }
  found.bytes = found.bytes.first(static_cast<std::size_t>(std::max(0.0, length)));
  this->BytesInAll += found.bytes.size();
  return {};
}

GltfBuffers GltfBuffers::Open(const GltfDocument& document, const std::filesystem::path& file)
{
  GltfBuffers buffers;
  buffers.Document = &document;
  buffers.Buffers.resize(CountOf(Member(document.json, "buffers")));
  FilesBeside files(file);
  for (std::size_t i = 0; i < buffers.Buffers.size(); ++i)
  {
    if (const Status found = buffers.Find(i, file, files); !found)
    {
      buffers.Buffers[i].wrong = found.GetError();
    }
  }
  return buffers;
}

std::vector<std::filesystem::path> GltfBuffers::Files() const
{
  return this->Named;
}

std::vector<std::size_t> GltfBuffers::WrongOnes() const
{
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < this->Buffers.size(); ++i)
  {
    if (this->Buffers[i].wrong)
    {
      numbers.push_back(i);
    }
  }
  return numbers;
}

// view: a bufferView, or the uncompressed fallback in it.
Result<GltfBytes> GltfBuffers::BytesOf(const Json& view) const
{
  const Json& buffers = Member(this->Document->json, "buffers");
  const std::size_t number = IndexIn(buffers, Member(view, "buffer"));
  if (number == CountOf(buffers))
  {
    return Error{ ErrorCode::InvalidInput, NamesNone("buffer", Member(view, "buffer"), buffers) };
  }
  const Buffer& buffer = this->Buffers[number];
  if (buffer.wrong)
  {
    return *buffer.wrong;
  }
  const double offset = WholeOf(Member(view, "byteOffset"), 0);
  const double length = WholeOf(Member(view, "byteLength"), 0);
  const double all = buffer.isThere ? double(buffer.bytes.size()) : -1;
  return offset >= 0 && length >= 0 && offset + length <= all
           ? Result<GltfBytes>(buffer.bytes.subspan(
               static_cast<std::size_t>(offset), static_cast<std::size_t>(length)))
           : Error{ ErrorCode::InvalidInput, "reaches beyond its buffer" };
}

Result<GltfBuffers::View> GltfBuffers::ViewOf(std::size_t number)
{
  const Json& view = Member(this->Document->json, "bufferViews")[number];
  const double stride = WholeOf(Member(view, "byteStride"), 0);
  View read{ {}, static_cast<std::uint64_t>(std::max(0.0, stride)) };
  const Json& compressed = MeshoptOf(view);
  if (stride < 0)
  {
    return Error{ ErrorCode::InvalidInput, "has a byteStride that is not a whole number" };
  }
  const Json& place = compressed.is_null() ? view : compressed;
  Result<GltfBytes> bytes = this->BytesOf(place);
  if (const std::size_t buffer =
        IndexIn(Member(this->Document->json, "buffers"), Member(place, "buffer"));
      !bytes && buffer < this->Buffers.size() && !this->Missed)
  {
    this->Missed = this->Buffers[buffer].wrong;
  }
  KDSTREAM_TRY(bytes);
  read.bytes = *bytes;
  if (!compressed.is_null())
  {
    const auto [entry, isNew] = this->Decompressed.try_emplace(number);
    if (isNew)
    {
      // Without a limit, many views could decompress the same bytes again and again.
      this->BytesDecompressed += bytes->size();
      if (this->BytesDecompressed > this->BytesInAll)
      {
        return Error{ ErrorCode::InvalidInput, "is too large once decompressed, together with "
                                               "other bufferViews of the same compressed bytes" };
      }
      Result<std::vector<std::uint8_t>> decoded = DecodeMeshopt(compressed, *bytes);
      if (!decoded)
      {
        this->Decompressed.erase(entry);
        this->BytesDecompressed -= bytes->size();
        // A file may also have the uncompressed bytes, for programs that cannot decompress.
        const Result<GltfBytes> plain = this->BytesOf(view);
        if (!plain)
        {
          return decoded.GetError();
        }
        read.bytes = *plain;
        return read;
      }
      entry->second = std::move(*decoded);
    }
    read.bytes = entry->second;
  }
  return read;
}

}
