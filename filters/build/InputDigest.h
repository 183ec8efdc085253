// SPDX-License-Identifier: BSD-3-Clause
// Identifies the input that a store was built from: a digest of its bytes. The digest is the same
// for all builds of an input, whatever their options. Step "read" of the pipeline picture.
#pragma once

#include "filters/build/Builder.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace kdstream
{

// The files whose bytes identify the input of a build: options.inputFiles, or `input` itself.
std::vector<std::filesystem::path> FilesOfInput(
  const std::filesystem::path& input, const BuildOptions& options);

// The digest of files, one after the other. A separate thread computes it during the build. It
// reads the files a second time, mostly from the system's page cache. Memory: 1 MiB.
class InputDigest
{
public:
  explicit InputDigest(std::vector<std::filesystem::path> files);
  InputDigest(const InputDigest&) = delete;
  InputDigest& operator=(const InputDigest&) = delete;
  ~InputDigest(); // does not wait until all files are read

  // Returns XXH3-128, as 32 hexadecimal digits. Waits until it is ready; call it once. Errors:
  // those of ByteSource, with the name of the file.
  Result<std::string> Take();

private:
  void Work();

  const std::vector<std::filesystem::path> Files;
  std::atomic<bool> Stops{ false };
  Result<std::string> Digest = Error{};
  std::thread Thread;
};

// Computes the digest of bytes in memory: XXH3-128.
class ByteDigest
{
public:
  ByteDigest();
  ~ByteDigest();
  ByteDigest(const ByteDigest&) = delete;
  ByteDigest& operator=(const ByteDigest&) = delete;

  void Add(std::span<const std::byte> bytes);
  void AddNumber(std::uint64_t number);
  // The digest as 32 hexadecimal digits.
  std::string Text() const;

private:
  struct Sum;
  std::unique_ptr<Sum> Bytes;
};

// Passes on the data for the digest of a mesh that does not come from a file: calls visit(head,
// values, elementBytes) for coordinates, triangles, and each array. The digest takes the head, then
// the number of elements, then the elements. A part of a mesh has the same arrays, so its heads are
// those of the whole mesh.
Status ForEachDigested(
  const Mesh& mesh, const std::function<Status(std::span<const std::byte> head,
                      std::span<const std::byte> values, std::size_t elementBytes)>& visit);

// The digest of a mesh that does not come from a file.
std::string InputDigestOf(const Mesh& mesh);

}
