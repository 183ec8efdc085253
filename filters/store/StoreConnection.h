// SPDX-License-Identifier: BSD-3-Clause
// The connections to the file of one store, and the rows that they read. Only for Store.
#pragma once

#include "filters/model/ModelDescription.h"
#include "filters/store/Store.h"
#include "filters/store/StoreBlobs.h"
#include "filters/store/StoreFile.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

// Reads and checks the description of the model in the file of an open store, except the
// description's claims about the file. Memory: 32 MiB, and twice what SQLite reads at once. Errors:
// those of CheckStoreHead; Damaged; InputOutput and LimitExceeded.
Result<ModelDescription> ReadStoredModel(int descriptor);

// Holds as many connections as threads have read at the same time. Any number of threads may read;
// every read fails once the file is no longer the one that was opened. Errors of all functions:
// Changed; Damaged, naming the blob; InputOutput and LimitExceeded if the same call may succeed
// later.
class Store::Connection
{
public:
  // state: of the file when the model was read. model: a reference is kept.
  Connection(
    std::unique_ptr<const StoreFile> file, const FileState& state, const ModelDescription& model);
  ~Connection();

  // Checks that the data just read belong to the model that was opened: a program that writes to
  // the file changes its state first. Errors: Changed; InputOutput and LimitExceeded if the check
  // fails.
  Status CheckUnchanged();
  // Checks only the file's state, as far as the kernel knows it; nothing if it does not. Does not
  // wait for a disk.
  std::optional<bool> LooksUnchanged();
  FileState State();
  // The bytes of all blobs read so far, damaged ones too.
  std::uint64_t BytesRead() const { return this->Bytes; }

  // Returns the blob of a row; its checksum is verified.
  Result<std::vector<std::uint8_t>> Read(const BlobRow& blob);
  // The size of a blob in bytes; the blob is neither read nor checked.
  Result<std::uint64_t> Size(const BlobRow& blob);
  // Calls note(id, error) for each row of a piece whose other columns contradict its id. Stops when
  // note returns false.
  Status VisitMislabelled(const std::function<bool(std::int64_t id, const Error& error)>& note);

private:
  std::optional<bool> Compare(const FileState& now);
  Result<std::string> ReadDigest() const;
  Result<std::unique_ptr<StoreBlobs>> Take();
  void Return(std::unique_ptr<StoreBlobs> blobs);
  template <class Value, class ReadBlob>
  Result<Value> ReadUnchanged(const BlobRow& blob, const ReadBlob& read);

  const std::unique_ptr<const StoreFile> File;
  const ModelDescription& Model;
  std::atomic<std::uint64_t> Bytes{ 0 };
  std::mutex Mutex; // for the members below
  FileState LastState;
  bool Changed = false;
  std::vector<std::unique_ptr<StoreBlobs>> Idle;
};

}
