// SPDX-License-Identifier: BSD-3-Clause
// The blobs of a model that cannot be fetched, and the message about them. Below step "request" of
// the pipeline picture.
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
// and again each time one of them has arrived. So requests end if the server never sends the rest.
class FailedBlobs
{
public:
  // Messages name this model from now on.
  void SetModel(const std::string& model) { this->Model = model; }

  // Forgets all failures, so that the blobs are requested again.
  void Retry();
  // piece: the blob's piece, if it has one. isDoubtful: the view may not need it, so the message
  // waits until ReportMissed finds that it does.
  void Add(const protocol::BlobId& blob, const std::optional<PieceId>& piece,
    const std::string& message, bool isDoubtful);
  // A blob has failed together with its whole request.
  void AddLost(const protocol::BlobId& blob, const std::string& message);

  // A blob has arrived over the connection. Returns the lost blobs that may be requested again;
  // they do not count as failed any more.
  std::vector<protocol::BlobId> TakeLost(const protocol::BlobId& come, const TreeDepths& depths);
  // A blob has failed by itself: waiting for it ends.
  void Settle(const protocol::BlobId& blob) { this->AskedAgain.erase(blob); }
  // Everything wanted has arrived: what is lost next is requested again at once.
  void SettleAll();

  const std::set<PieceId>& Pieces() const { return this->FailedPieces; }
  const std::set<protocol::BlobId>& Tree() const { return this->FailedTree; }
  bool Has(PieceId piece) const { return this->FailedPieces.count(piece) != 0; }
  bool Has(const protocol::BlobId& ofTree) const { return this->FailedTree.count(ofTree) != 0; }

  // Reports the doubtful failures whose piece the view misses. A view that is complete without the
  // failed blobs is not an error.
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
  // The message about the last failure of any kind; empty after Retry.
  const std::string& Message() const { return this->Last; }
  void Report(std::string message) { this->Last = std::move(message); }

private:
  std::string MessageOf(const protocol::BlobId& blob, const std::string& reason) const;

  std::string Model;
  std::set<PieceId> FailedPieces;
  std::set<protocol::BlobId> FailedTree;
  std::map<protocol::BlobId, std::string> Lost; // with the reason
  std::set<protocol::BlobId> AskedAgain;        // until one arrives, lost blobs wait
  std::map<PieceId, std::string> Doubtful;      // with the message
  std::string Last;
};

}
