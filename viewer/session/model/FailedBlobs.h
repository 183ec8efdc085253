// SPDX-License-Identifier: BSD-3-Clause
// What cannot be fetched of a model, and the message about it. Below step "request" of the pipeline
// picture.
#pragma once

#include "filters/core/pieces/Piece.h"
#include "filters/protocol/BlobId.h"

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{

// A failed blob is not requested again before Retry. Exception: blobs that failed together with
// their request, as when the connection is lost, are requested again as soon as something arrives,
// and again each time one of them has arrived. So this ends if the server never sends the rest.
class FailedBlobs
{
public:
  // Messages name this model from now on.
  void SetModel(const std::string& model) { this->Model = model; }

  // Forgets all, so that it is asked for again.
  void Retry();
  // piece: the blob's piece, if it has one. isDoubtful: the view may not need it, so the message
  // waits until ReportMissed finds that it does.
  void Add(const protocol::BlobId& blob, const std::optional<PieceId>& piece,
    const std::string& message, bool isDoubtful);
  // All of its request has failed.
  void AddLost(const protocol::BlobId& blob, const std::string& message);

  // A blob has come over the connection: what was lost is returned, and has not failed any more.
  std::vector<protocol::BlobId> TakeLost(const protocol::BlobId& come, const TreeDepths& depths);
  // A blob has failed by itself: waiting for it ends.
  void Settle(const protocol::BlobId& blob) { this->AskedAgain.erase(blob); }
  // All is there that was wanted: what is lost next is asked for again at once.
  void SettleAll();

  const std::set<PieceId>& Pieces() const { return this->FailedPieces; }
  const std::set<protocol::BlobId>& Tree() const { return this->FailedTree; }
  bool Has(PieceId piece) const { return this->FailedPieces.count(piece) != 0; }
  bool Has(const protocol::BlobId& ofTree) const { return this->FailedTree.count(ofTree) != 0; }

  // A view that is complete without the failed blobs is not an error.
  template <typename IsMissed>
  void ReportMissed(const IsMissed& isMissed)
  {
    for (auto each = this->Doubtful.begin(); each != this->Doubtful.end();)
    {
      if (isMissed(each->first))
      {
        this->Last = std::move(each->second);
        each = this->Doubtful.erase(each);
      }
      else
      {
        ++each;
      }
    }
  }
  // About the last failure, of whatever kind; empty after Retry.
  const std::string& Message() const { return this->Last; }
  void Report(std::string message) { this->Last = std::move(message); }

private:
  std::string MessageOf(const protocol::BlobId& blob, const std::string& reason) const;

  std::string Model;
  std::set<PieceId> FailedPieces;
  std::set<protocol::BlobId> FailedTree;
  std::map<protocol::BlobId, std::string> Lost; // and why
  std::set<protocol::BlobId> AskedAgain;        // until one of these has arrived
  std::map<PieceId, std::string> Doubtful;      // and the message
  std::string Last;
};

}
