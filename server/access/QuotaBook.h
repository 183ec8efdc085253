// SPDX-License-Identifier: BSD-3-Clause
// How much of each model each subject may receive in a given time, and how much it has received.
// The numbers are kept in an SQLite file, which several servers may share.
//
// Every entry is one transaction of that file. So servers that share the file together never give
// more than a single server would, and entries survive a restart (after a power cut the last ones
// may be missing).
#pragma once

#include "filters/core/Result.h"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace kdstream
{

// In each quota, 0 means: no limit.
struct QuotaLimits
{
  // The share of a model's partitions, 0 to 1, rounded down, but at least one partition. Each
  // partition counts once, from its first delivery until the window has passed.
  double share = 0;
  std::chrono::seconds window{ 86400 };
  std::uint64_t bytesPerSecond = 0;   // bytes of partitions, averaged over ten seconds
  std::uint32_t regionsPerMinute = 0; // regions that the server looks up
};

// A model, as quotas count it. Models of one original count together: those with equal digests, and
// those that were built from the same input.
struct CountedModel
{
  std::string_view digest;      // of the model's content
  std::string_view inputDigest; // of the model's input; empty if the store does not have it
  // How the original is divided: models of one original with the same division have the same
  // partitions, with the same numbers.
  std::string_view division;
  std::uint64_t partitions = 1;
};

struct QuotaRefusal
{
  std::string message; // says when the quota is renewed
  std::chrono::seconds endsIn{ 1 };
  bool isShare = false; // true: the share is used up; false: requests came too fast
};

class QuotaBook
{
public:
  using Clock = std::function<std::int64_t()>; // microseconds since 1970
  // When another process holds the file's lock, the file is not tried again for this time.
  // Meanwhile requests are refused at once.
  static constexpr std::chrono::milliseconds pauseOfLocked{ 100 };

  // Opens the file, or creates it, readable only by this user. Without a clock, the system's clock
  // is used. Errors: InputOutput.
  static Result<std::unique_ptr<QuotaBook>> Open(
    const std::filesystem::path& file, QuotaLimits limits, Clock clock = {});
  ~QuotaBook();

  // Closes the file; a later call opens it again. Waits for the disk.
  void Close();

  using Taken = Result<std::optional<QuotaRefusal>>; // empty: allowed
  // Records that the subject receives a partition of `bytes` bytes. From any thread; waits for the
  // disk, and at most 2 s for other servers. A call that throws (lack of memory) records nothing.
  // Errors: InputOutput. After an error the next call opens the file again, so quotas count as soon
  // as the file is usable again.
  // - If the file was removed or replaced, one call fails and says so. Later calls use the file
  //   that now has that name, or create it if there is none; but not if its file system was
  //   unmounted.
  // - If only the file's log or index was removed, nothing fails: all entries are in the file, and
  //   the log and the index are created again.
  Taken TakePartition(std::string_view subject, const CountedModel& model, std::uint32_t partition,
    std::uint64_t bytes);
  // Records that the subject receives a region. The rest is as for TakePartition.
  Taken TakeRegion(std::string_view subject, const CountedModel& model);

private:
  struct File;
  struct Connection;
  QuotaBook(std::unique_ptr<File> file, QuotaLimits limits, Clock clock);
  struct Holder;
  Taken EnterPartition(const Holder& holder, std::uint32_t partition, std::int64_t now) const;
  Taken EnterBytes(const Holder& holder, std::uint64_t bytes, std::int64_t now) const;
  Taken EnterRegion(const Holder& holder, std::int64_t now) const;
  static Result<std::int64_t> DueOf(
    const Holder& holder, std::string_view what, std::int64_t now, std::int64_t latest);
  template <class Work>
  Taken InTransaction(const CountedModel& model, const Work& work);
  template <class Work>
  Taken TryTransaction(const CountedModel& model, const Work& work);

  std::unique_ptr<File> Kept;
  QuotaLimits Limits;
  Clock Now;
};

}
