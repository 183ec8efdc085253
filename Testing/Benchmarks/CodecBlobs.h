// SPDX-License-Identifier: BSD-3-Clause
// A file of blobs of pieces. The benchmark that cuts meshes writes it for the benchmark that also
// runs as WebAssembly. It is used on one machine in one run, so numbers are stored as in memory.
#pragma once

#include "filters/codec/PieceCodec.h"

#include <cstdint>
#include <cstdio>
#include <type_traits>
#include <vector>

namespace kdstream::bench
{

struct Blob
{
  PieceId id;
  std::vector<std::uint8_t> bytes;
};

struct BlobFile
{
  CodecContext context;
  std::vector<Blob> blobs;
};

// Reads or writes values, until something fails.
class BlobStream
{
public:
  BlobStream(const char* path, bool reading)
    : Reading(reading)
    , File(std::fopen(path, reading ? "rb" : "wb"))
  {
  }
  ~BlobStream()
  {
    if (this->File)
    {
      std::fclose(this->File);
    }
  }
  BlobStream(const BlobStream&) = delete;
  BlobStream& operator=(const BlobStream&) = delete;

  template <class T>
  void Value(T& value)
  {
    static_assert(std::is_trivially_copyable_v<T>);
    this->Bytes(&value, sizeof(T));
  }
  void Bytes(void* bytes, std::size_t count)
  {
    this->Whole = this->File && this->Whole &&
                  (this->Reading ? std::fread(bytes, 1, count, this->File)
                                 : std::fwrite(bytes, 1, count, this->File)) == count;
  }

  const bool Reading;
  bool Whole = true;

private:
  std::FILE* File;
};

inline bool CodeBlobFile(BlobStream& stream, BlobFile& file)
{
  stream.Value(file.context.depths);
  stream.Value(file.context.grid);
  auto count = static_cast<std::uint32_t>(file.blobs.size());
  stream.Value(count);
  for (std::uint32_t i = 0; stream.Whole && i < count; ++i)
  {
    if (stream.Reading)
    {
      file.blobs.emplace_back();
    }
    Blob& blob = file.blobs[i];
    auto size = static_cast<std::uint32_t>(blob.bytes.size());
    stream.Value(blob.id);
    stream.Value(size);
    if (stream.Whole)
    {
      blob.bytes.resize(size);
      stream.Bytes(blob.bytes.data(), size);
    }
  }
  return stream.Whole;
}

inline bool ReadBlobFile(const char* path, BlobFile& file)
{
  BlobStream stream(path, true);
  return CodeBlobFile(stream, file);
}

inline bool WriteBlobFile(const char* path, BlobFile& file)
{
  BlobStream stream(path, false);
  return CodeBlobFile(stream, file);
}

}
