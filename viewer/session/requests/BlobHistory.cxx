// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/session/requests/BlobHistory.h"

#include <utility>

namespace kdstream
{
namespace
{

// The number of triangles plus one, so that a piece without triangles also has a share in its
// frame.
double WeightOf(const BlobStatistics& blob)
{
  return static_cast<double>(blob.triangles + 1);
}

}

BlobHistory::BlobHistory(std::size_t most)
  : Most(most)
{
}

BlobStatistics* BlobHistory::Find(std::uint64_t number)
{
  return number < this->Forgotten
           ? nullptr
           : &this->Newest[static_cast<std::size_t>(number - this->Forgotten)];
}

void BlobHistory::Count(std::size_t bytes, bool isWasted)
{
  ++this->Sum.blobs;
  this->Sum.bytes += bytes;
  this->Sum.wasted += isWasted ? bytes : 0;
}

void BlobHistory::Add(PieceId piece, BlobStatistics entry)
{
  this->NeverShown[piece] += static_cast<std::size_t>(entry.bytes);
  this->Sum.wasted += entry.bytes;
  this->NotShown[piece] = this->Forgotten + this->Newest.size();
  this->Newest.push_back(std::move(entry));
  if (this->Newest.size() > this->Most)
  {
    this->Newest.pop_front();
    ++this->Forgotten;
  }
}

void BlobHistory::BeginFrame(const std::set<PieceId>& shown)
{
  for (const PieceId piece : shown)
  {
    const auto found = this->NotShown.find(piece);
    if (found != this->NotShown.end())
    {
      this->JustShown.push_back(found->second);
      this->NotShown.erase(found);
    }
  }
  std::erase_if(this->NeverShown,
    [&](const auto& entry)
    {
      const bool isShown = shown.count(entry.first) != 0;
      this->Sum.wasted -= isShown ? entry.second : 0;
      return isShown;
    });
}

void BlobHistory::EndFrame(double seconds)
{
  std::vector<BlobStatistics*> blobs;
  double sum = 0;
  for (const std::uint64_t number : std::exchange(this->JustShown, {}))
  {
    if (BlobStatistics* const blob = this->Find(number))
    {
      blobs.push_back(blob);
      sum += WeightOf(*blob);
    }
  }
  for (BlobStatistics* const blob : blobs)
  {
    blob->renderingSeconds = seconds * WeightOf(*blob) / sum;
  }
}

void BlobHistory::CloseModel()
{
  this->NotShown.clear();
  this->JustShown.clear();
  this->NeverShown.clear();
}

}
