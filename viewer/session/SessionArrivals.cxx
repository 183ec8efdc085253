// SPDX-License-Identifier: BSD-3-Clause
// What the server sends a session: its list, a model, blobs, and that it has none. What has come is
// decoded and kept; what has failed is told where somebody misses it.
#include "viewer/session/ViewerSession.h"

#include <algorithm>
#include <utility>

namespace kdstream
{
namespace
{

using protocol::BlobId;
using protocol::BlobKind;

// As statistics name it.
const char* NameOf(const BlobId& blob, bool isPreview)
{
  return isPreview                          ? "preview"
         : blob.kind == BlobKind::Partition ? "partition"
         : blob.kind == BlobKind::Texture   ? "texture"
                                            : "level";
}

// Why this viewer cannot show the model; empty if it can.
std::string Objection(const ModelDescription& model)
{
  if (model.levels.size() != model.depths.finest + std::size_t{ 1 })
  {
    return "it has no levels of detail, only partitions";
  }
  return {};
}

}

void ViewerSession::SetModels(std::vector<ModelSummary> models)
{
  this->ModelList = std::move(models);
  this->HasModelList = true;
  this->Trace("models");
}

void ViewerSession::Opened(std::uint32_t request, const ModelDescription& model)
{
  if (!this->Wanted.Opened(request))
  {
    return;
  }
  const std::string objection = Objection(model);
  if (!objection.empty())
  {
    this->LastError = this->ModelId + " cannot be shown: " + objection + ".";
    this->Trace("opened", this->ModelId);
    return;
  }
  this->Current.emplace(
    Model{ model, model.Codec(), LevelPolicy(LevelFactsOf(model), this->Options.policy), model.box,
      KnownTree(model.depths, model.HasLevels(), model.box, this->Options.treeBytes),
      ViewRefinement(model, this->Options.refinement),
      ViewRefinement(model, this->Options.refinement), SeenPartitions(model.depths) });
  this->Shown.Reset(model.depths);
  this->Tiles.Reset(model, VertexSpacing(model.box, static_cast<double>(model.vertices)));
  this->Shown.KeepCorners(this->Tiles.AreThere());
  this->Section.Reset(model.box);
  this->FitModel();
  this->Target = this->Current->policy.PreviewLevel();
  if (this->Followed)
  {
    this->TakeLink();
  }
  this->FollowZoom(); // full screen may have been asked for already
  this->Update();
  this->Trace("opened", this->ModelId);
}

BlobArrival ViewerSession::BlobArrived(std::uint32_t request, const BlobId& blob,
  std::span<const std::uint8_t> bytes, double transmissionSeconds, bool fromCache)
{
  ++this->Traffic.blobs;
  this->Traffic.bytes += bytes.size();
  if (!this->Current ||
      !this->Wanted.Arrived(request, blob, bytes.size(), transmissionSeconds, fromCache))
  {
    this->Traffic.wasted += bytes.size();
    return this->TakeLate(request, blob, bytes);
  }
  BlobStatistics entry;
  entry.what = NameOf(blob, blob == this->PreviewBlob());
  entry.id = protocol::BlobName(blob);
  entry.bytes = bytes.size();
  entry.transmissionSeconds = transmissionSeconds;
  entry.fromCache = fromCache;
  if (!fromCache)
  {
    this->AskForLost(blob);
  }
  const Status decoded = this->Decode(blob, bytes, entry);
  if (!decoded)
  {
    this->Fail(blob, decoded.GetError().message);
  }
  else if (IsOfPiece(blob))
  {
    const PieceId piece = PieceOfBlob(blob, this->Current->codec.depths);
    this->NeverShown[piece] += bytes.size();
    this->Traffic.wasted += bytes.size();
    this->History.Add(piece, std::move(entry));
  }
  this->Update();
  this->SettleLost();
  this->Trace("blob", protocol::BlobName(blob));
  return decoded ? BlobArrival::Taken : BlobArrival::Damaged;
}

// What was on the line when it was called back is kept for the next look, as far as the cache goes.
BlobArrival ViewerSession::TakeLate(
  std::uint32_t request, const BlobId& blob, std::span<const std::uint8_t> bytes)
{
  if (!this->Current || !this->Wanted.TakeLate(request, blob))
  {
    return BlobArrival::Unwanted;
  }
  if (!IsOfPiece(blob))
  {
    return BlobArrival::Taken;
  }
  const PieceId piece = PieceOfBlob(blob, this->Current->codec.depths);
  BlobArrival arrival = BlobArrival::Taken;
  if (!this->Pieces.Peek(piece))
  {
    BlobStatistics unused;
    if (this->Decode(blob, bytes, unused))
    {
      this->NeverShown[piece] += bytes.size();
      this->Update();
    }
    else
    {
      arrival = BlobArrival::Damaged;
    }
  }
  this->Trace("late", protocol::BlobName(blob));
  return arrival;
}

Status ViewerSession::Decode(
  const BlobId& blob, std::span<const std::uint8_t> bytes, BlobStatistics& entry)
{
  Model& model = *this->Current;
  if (IsOfTree(blob))
  {
    return model.tree.Add(blob, bytes);
  }
  if (blob.kind == BlobKind::Texture)
  {
    return this->Tiles.Add(blob, bytes, this->Pieces.Peek(PieceOfBlob(blob, model.codec.depths)));
  }
  const double begin = this->Options.clock ? this->Options.clock() : 0;
  auto piece = DecodePiece(bytes, PieceOfBlob(blob, model.codec.depths), model.codec);
  entry.parsingSeconds = this->Options.clock ? this->Options.clock() - begin : 0;
  KDSTREAM_TRY(piece);
  entry.vertices = piece->ownVertices;
  entry.triangles = piece->triangles.size();
  if (this->ByView())
  {
    model.seen.Add(*piece);
  }
  if (piece->id.resolution == Resolution::Level(model.policy.PreviewLevel()))
  {
    model.isClosed = SeenPartitions::IsNearlyClosed(*piece);
  }
  this->Pieces.Add(std::move(*piece));
  return {};
}

// Something comes over the line again: what it took is asked for anew, at once; after that, each
// time one of what was asked for anew has come. So it ends where nobody is given the rest.
void ViewerSession::AskForLost(const BlobId& come)
{
  if (this->AskedAgain.count(come) != 0)
  {
    this->AskedAgain.clear();
  }
  if (!this->AskedAgain.empty())
  {
    return;
  }
  for (const auto& [blob, message] : std::exchange(this->Lost, {}))
  {
    if (this->LastError == this->SentenceOf(blob, message))
    {
      this->LastError.clear();
    }
    if (IsOfPiece(blob))
    {
      const PieceId piece = PieceOfBlob(blob, this->Current->codec.depths);
      this->FailedPieces.erase(piece);
      this->Doubtful.erase(piece);
    }
    this->FailedTree.erase(blob);
    this->Tiles.Retry(blob);
    this->AskedAgain.insert(blob);
  }
}

// The next loss is one by itself.
void ViewerSession::SettleLost()
{
  if (this->Lost.empty() && this->IsIdle())
  {
    this->AskedAgain.clear();
  }
}

std::string ViewerSession::SentenceOf(const BlobId& blob, const std::string& message) const
{
  return protocol::BlobName(blob) + " of " + this->ModelId + " cannot be had: " + message;
}

void ViewerSession::Fail(const BlobId& blob, const std::string& message)
{
  if (this->Wanted.GiveUpAhead(blob))
  {
    return; // nobody has missed it
  }
  const std::string sentence = this->SentenceOf(blob, message);
  if (blob.kind == BlobKind::Texture)
  {
    this->Tiles.Fail(blob);
    this->LastError = sentence;
    return;
  }
  if (IsOfTree(blob))
  {
    this->FailedTree.insert(blob);
    this->DropPick();
    this->LastError = sentence;
    return;
  }
  const PieceId piece = PieceOfBlob(blob, this->Current->codec.depths);
  this->FailedPieces.insert(piece);
  if (this->ByView() && this->Current->refinement.MayDoWithout(piece))
  {
    this->Doubtful.emplace(piece, sentence);
    return;
  }
  this->LastError = sentence;
}

// Where a view is complete without what failed, nothing is wrong with it.
void ViewerSession::TellWhatIsMissed()
{
  for (auto each = this->Doubtful.begin(); each != this->Doubtful.end();)
  {
    if (this->Current->refinement.IsMissed(each->first))
    {
      this->LastError = std::move(each->second);
      each = this->Doubtful.erase(each);
    }
    else
    {
      ++each;
    }
  }
}

void ViewerSession::BlobFailed(
  std::uint32_t request, const BlobId& blob, const std::string& message)
{
  if (this->Current && this->Wanted.Failed(request, blob))
  {
    this->AskedAgain.erase(blob);
    this->Fail(blob, message);
    this->Update();
    this->SettleLost();
    this->Trace("failed", protocol::BlobName(blob));
  }
}

void ViewerSession::RequestFailed(std::uint32_t request, const std::string& message)
{
  const SessionRequest* asked = this->Wanted.Book().Find(request);
  if (!asked)
  {
    return;
  }
  const bool open = asked->kind == SessionRequest::Kind::Open;
  const std::vector<BlobId> owed = this->Wanted.Close(request);
  for (const BlobId& blob : owed)
  {
    if (!this->Wanted.IsAhead(blob))
    {
      this->Lost.insert_or_assign(blob, message);
    }
    this->Fail(blob, message);
  }
  if (open)
  {
    this->LastError = this->ModelId + " cannot be opened: " + message;
  }
  this->Update();
  this->SettleLost();
  this->Trace("request failed");
}

void ViewerSession::RequestEnded(std::uint32_t request)
{
  this->RequestFailed(request, "the server ended without sending it");
}

}
