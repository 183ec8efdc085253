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

struct ByteDigest::Sum
{
  std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state{ XXH3_createState(),
    XXH3_freeState };
};

ByteDigest::ByteDigest()
  : Bytes(std::make_unique<Sum>())
{
  if (!this->Bytes->state)
  {
    throw std::bad_alloc();
  }
  XXH3_128bits_reset(this->Bytes->state.get());
}

ByteDigest::~ByteDigest() = default;

void ByteDigest::Add(std::span<const std::byte> bytes)
{
  XXH3_128bits_update(this->Bytes->state.get(), bytes.data(), bytes.size());
}

void ByteDigest::AddNumber(std::uint64_t number)
{
  this->Add(std::as_bytes(std::span(&number, 1)));
}

std::string ByteDigest::Text() const
{
  XXH128_canonical_t bytes; // high half first, as `xxhsum -H2` prints it
  XXH128_canonicalFromHash(&bytes, XXH3_128bits_digest(this->Bytes->state.get()));
  std::string text;
  for (const unsigned char byte : bytes.digest)
  {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text;
}

namespace
{

void AppendNumber(std::uint64_t number, std::vector<std::byte>& bytes)
{
  const auto more = std::as_bytes(std::span(&number, 1));
  bytes.insert(bytes.end(), more.begin(), more.end());
}

Status AddFile(
  const std::filesystem::path& file, const std::atomic<bool>& stops, ByteDigest& digest)
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
    digest.Add(std::as_bytes(std::span(*bytes)));
    source->Consume(bytes->size());
  }
}

Result<std::string> DigestOfFiles(
  const std::vector<std::filesystem::path>& files, const std::atomic<bool>& stops)
{
  ByteDigest digest;
  for (const std::filesystem::path& file : files)
  {
    KDSTREAM_TRY(OfFile(file.string(), AddFile(file, stops, digest)));
  }
  return digest.Text();
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
    // If no thread can be started, Take does the work.
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

Status ForEachDigested(
  const Mesh& mesh, const std::function<Status(std::span<const std::byte> head,
                      std::span<const std::byte> values, std::size_t elementBytes)>& visit)
{
  std::vector<std::byte> head;
  AppendNumber(static_cast<std::uint64_t>(mesh.scalarType), head);
  KDSTREAM_TRY(visit(head, std::as_bytes(std::span(mesh.points)), sizeof(Vec3)));
  KDSTREAM_TRY(visit({}, std::as_bytes(std::span(mesh.triangles)), sizeof(Triangle)));
  for (const Attribute& attribute : mesh.attributes)
  {
    head.clear();
    AppendNumber(attribute.name.size(), head);
    const auto name = std::as_bytes(std::span(attribute.name));
    head.insert(head.end(), name.begin(), name.end());
    AppendNumber(static_cast<std::uint64_t>(attribute.type), head);
    AppendNumber(static_cast<std::uint64_t>(attribute.association), head);
    AppendNumber(attribute.components, head);
    KDSTREAM_TRY(visit(head, std::as_bytes(std::span(attribute.values)), 1));
  }
  return {};
}

std::string InputDigestOf(const Mesh& mesh)
{
  ByteDigest digest;
  (void)ForEachDigested(mesh,
    [&](std::span<const std::byte> head, std::span<const std::byte> values, std::size_t size)
    {
      digest.Add(head);
      digest.AddNumber(values.size() / size);
      digest.Add(values);
      return Status();
    });
  return digest.Text();
}

}
