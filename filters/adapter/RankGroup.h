// SPDX-License-Identifier: BSD-3-Clause
// The processes of a vtkMultiProcessController that run one filter together: sums, lists from each
// to each, and how an error of one becomes the error of all.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

class vtkMultiProcessController;

namespace kdstream
{

// All calls are made by all ranks together, in the same order.
class RankGroup
{
public:
  using Bytes = std::vector<unsigned char>;

  // REQUIRES: a controller that outlives this.
  explicit RankGroup(vtkMultiProcessController& controller);

  std::size_t Rank() const { return this->Own; }
  std::size_t Count() const { return this->Ranks; }

  // What each rank has come to: the error of the lowest rank that has one, which it names.
  Status Agree(const Status& own) const;
  // Adds over the ranks, element by element.
  Status Sum(std::span<std::uint64_t> numbers) const;
  // The smallest lower and greatest upper ends, box by box.
  Status Join(std::span<Box> boxes) const;
  // A number of each rank, by rank. They are below 2^63.
  Result<std::vector<std::uint64_t>> Gather(std::uint64_t number) const;
  // Sends bytes to each rank and gets those of each, by rank.
  Result<std::vector<Bytes>> Exchange(std::vector<Bytes> out) const;
  // The same with elements of a type.
  template <class T>
  Result<std::vector<std::vector<T>>> ExchangeLists(const std::vector<std::vector<T>>& out) const
  {
    static_assert(std::is_trivially_copyable_v<T>);
    std::vector<Bytes> bytes;
    for (const std::vector<T>& list : out)
    {
      const auto* const begin = reinterpret_cast<const unsigned char*>(list.data());
      bytes.emplace_back(begin, begin + list.size() * sizeof(T));
    }
    const Result<std::vector<Bytes>> came = this->Exchange(std::move(bytes));
    KDSTREAM_TRY(came);
    std::vector<std::vector<T>> in;
    for (const Bytes& each : *came)
    {
      in.emplace_back(each.size() / sizeof(T));
      std::memcpy(in.back().data(), each.data(), in.back().size() * sizeof(T));
    }
    return in;
  }

private:
  bool Send(std::span<const unsigned char> bytes, std::size_t to) const;
  bool Receive(std::span<unsigned char> bytes, std::size_t from) const;

  vtkMultiProcessController& Controller;
  std::size_t Own, Ranks;
};

// Lists, one after the other, each behind its length.
class RankMessage
{
public:
  explicit RankMessage(RankGroup::Bytes bytes = {})
    : Bytes(std::move(bytes))
  {
  }
  template <class T>
  void Put(const std::vector<T>& list)
  {
    const std::uint64_t size = list.size() * sizeof(T);
    this->Append(&size, sizeof(size));
    this->Append(list.data(), size);
  }
  template <class T>
  std::vector<T> Take()
  {
    std::uint64_t size = 0;
    this->Copy(&size, sizeof(size));
    std::vector<T> list(size / sizeof(T));
    this->Copy(list.data(), size);
    return list;
  }
  bool AtEnd() const { return this->At == this->Bytes.size(); }
  RankGroup::Bytes Release() { return std::move(this->Bytes); }

private:
  void Append(const void* from, std::size_t size)
  {
    const auto* const begin = static_cast<const unsigned char*>(from);
    this->Bytes.insert(this->Bytes.end(), begin, begin + size);
  }
  void Copy(void* to, std::size_t size)
  {
    std::copy_n(
      this->Bytes.begin() + std::ptrdiff_t(this->At), size, static_cast<unsigned char*>(to));
    this->At += size;
  }

  RankGroup::Bytes Bytes;
  std::size_t At = 0;
};

}
