// SPDX-License-Identifier: BSD-3-Clause
#include "filters/build/InputDigest.h"

#include "filters/core/CaughtError.h"
#include "filters/meshio/ByteSource.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

namespace kdstream
{
namespace
{

class Xxh128
{
public:
  Xxh128()
    : State(XXH3_createState(), XXH3_freeState)
  {
    if (!this->State)
    {
      throw std::bad_alloc();
    }
    XXH3_128bits_reset(this->State.get());
  }

  void Add(const void* data, std::size_t bytes)
  {
    XXH3_128bits_update(this->State.get(), data, bytes);
  }
  template <class Value>
  void AddAll(std::span<const Value> values)
  {
    this->AddNumber(values.size());
    this->Add(values.data(), values.size_bytes());
  }
  void AddNumber(std::uint64_t number) { this->Add(&number, sizeof number); }

  std::string Hexadecimal() const
  {
    XXH128_canonical_t bytes; // high half first, as `xxhsum -H2` prints it
    XXH128_canonicalFromHash(&bytes, XXH3_128bits_digest(this->State.get()));
    std::string text;
    for (const unsigned char byte : bytes.digest)
    {
      text += "0123456789abcdef"[byte >> 4];
      text += "0123456789abcdef"[byte & 15];
    }
    return text;
  }

private:
  std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> State;
};

Status AddFile(const std::filesystem::path& file, const std::atomic<bool>& stops, Xxh128& digest)
{
  auto source = ByteSource::Open(file);
  KDSTREAM_TRY(source);
  while (true)
  {
    const auto bytes = source->Peek(ByteSource::blockSize);
    KDSTREAM_TRY(bytes);
    if (stops)
    {
      return Error{ ErrorCode::Cancelled, "cancelled" };
    }
    if (bytes->empty())
    {
      return {};
    }
    digest.Add(bytes->data(), bytes->size());
    source->Consume(bytes->size());
  }
}

Result<std::string> DigestOfFiles(
  const std::vector<std::filesystem::path>& files, const std::atomic<bool>& stops)
{
  Xxh128 digest;
  for (const std::filesystem::path& file : files)
  {
    KDSTREAM_TRY(OfFile(file.string(), AddFile(file, stops, digest)));
  }
  return digest.Hexadecimal();
}

}

std::vector<std::filesystem::path> FilesOfInput(
  const std::filesystem::path& input, const BuildOptions& options)
{
  return options.inputFiles.empty() ? std::vector{ input } : options.inputFiles;
}

InputDigest::InputDigest(std::vector<std::filesystem::path> files)
  : Files(std::move(files))
{
  try
  {
    this->Thread = std::thread([this] { this->Work(); });
  }
  catch (const std::system_error&)
  {
    // No further thread is to be had: Take does it.
  }
}

InputDigest::~InputDigest()
{
  this->Stops = true;
  if (this->Thread.joinable())
  {
    this->Thread.join();
  }
}

void InputDigest::Work()
{
  try
  {
    this->Digest = DigestOfFiles(this->Files, this->Stops);
  }
  catch (...)
  {
    this->Digest = CaughtError();
  }
}

Result<std::string> InputDigest::Take()
{
  if (this->Thread.joinable())
  {
    this->Thread.join();
  }
  else
  {
    this->Work();
  }
  return std::move(this->Digest);
}

std::string InputDigestOf(const Mesh& mesh)
{
  Xxh128 digest;
  digest.AddNumber(static_cast<std::uint64_t>(mesh.scalarType));
  digest.AddAll(std::span(mesh.points));
  digest.AddAll(std::span(mesh.triangles));
  for (const Attribute& attribute : mesh.attributes)
  {
    digest.AddAll(std::span<const char>(attribute.name));
    digest.AddNumber(static_cast<std::uint64_t>(attribute.type));
    digest.AddNumber(static_cast<std::uint64_t>(attribute.association));
    digest.AddNumber(attribute.components);
    digest.AddAll(std::span(attribute.values));
  }
  return digest.Hexadecimal();
}

}
