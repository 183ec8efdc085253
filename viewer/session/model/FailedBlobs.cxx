// SPDX-License-Identifier: BSD-3-Clause
// The blobs of a model that cannot be fetched: see FailedBlobs.h.
#include "viewer/session/model/FailedBlobs.h"

#include <utility>

namespace kdstream
{

using protocol::BlobId;

void FailedBlobs::Retry()
{
  this->Lost.clear();
  this->AskedAgain.clear();
  this->FailedPieces.clear();
  this->FailedTree.clear();
  this->Doubtful.clear();
  this->Last.clear();
}

std::string FailedBlobs::MessageOf(const BlobId& blob, const std::string& message) const
{
  return protocol::BlobName(blob) + " of " + this->Model + " cannot be loaded: " + message;
}

void FailedBlobs::Add(const BlobId& blob, const std::optional<PieceId>& piece,
  const std::string& message, bool isDoubtful)
{
  if (piece)
  {
    this->FailedPieces.insert(*piece);
  }
  else if (IsOfTree(blob))
  {
    this->FailedTree.insert(blob);
  }
  if (piece && isDoubtful)
  {
    this->Doubtful.emplace(*piece, this->MessageOf(blob, message));
    return;
  }
  this->Last = this->MessageOf(blob, message);
}

void FailedBlobs::AddLost(const BlobId& blob, const std::string& message)
{
  this->Lost.insert_or_assign(blob, message);
}

std::vector<BlobId> FailedBlobs::TakeLost(const BlobId& come, const TreeDepths& depths)
{
  if (this->AskedAgain.count(come) != 0)
  {
    this->AskedAgain.clear();
  }
  if (!this->AskedAgain.empty())
  {
    return {};
  }
  std::vector<BlobId> lost;
  for (const auto& [blob, message] : std::exchange(this->Lost, {}))
  {
    if (this->Last == this->MessageOf(blob, message))
    {
      this->Last.clear();
    }
    if (IsOfPiece(blob))
    {
      const PieceId piece = PieceOfBlob(blob, depths);
      this->FailedPieces.erase(piece);
      this->Doubtful.erase(piece);
    }
    this->FailedTree.erase(blob);
    this->AskedAgain.insert(blob);
    lost.push_back(blob);
  }
  return lost;
}

void FailedBlobs::SettleAll()
{
  if (this->Lost.empty())
  {
    this->AskedAgain.clear();
  }
}

}
