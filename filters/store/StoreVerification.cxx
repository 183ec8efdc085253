// SPDX-License-Identifier: BSD-3-Clause
// Whether a store is whole: Store::Verify.
#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/TreePage.h"
#include "filters/store/Store.h"
#include "filters/store/StoreConnection.h"
#include "filters/store/StoreSchema.h"

#include <algorithm>
#include <utility>

namespace kdstream
{

// Reads all that a store has, in the order of its digest, and notes what is wrong.
class Store::Verification
{
public:
  Verification(const Store& store, const Execution& execution)
    : Whole(store)
    , Progress(execution)
    , Digest(store.Information)
  {
  }

  std::vector<Error> Run()
  {
    const Status labels =
      this->Whole.Database->VisitMislabelled([this](std::int64_t row, const Error& error)
        { this->Note(this->Whole.NameOfRow(row), error); });
    this->Note("pieces", labels);
    if (const Status pieces = this->CheckPieces(); !pieces)
    {
      this->Found.push_back(pieces.GetError()); // cancelled
      return std::move(this->Found);
    }
    this->CheckTree();
    if (this->Found.empty() && this->Digest.Hexadecimal() != this->Whole.Information.digest)
    {
      this->Found.push_back(DamagedBlob("metadata", "the digest does not match the content"));
    }
    return std::move(this->Found);
  }

private:
  void Note(const std::string& name, const Status& status)
  {
    if (!status)
    {
      const Error& error = status.GetError();
      const bool named = error.message.rfind(name, 0) == 0;
      this->Found.push_back({ error.code, named ? error.message : name + ": " + error.message });
    }
  }

  Status CheckPieces()
  {
    const std::vector<PieceId> ids = this->Whole.PieceIds();
    for (std::size_t i = 0; i < ids.size(); ++i)
    {
      const std::string name = BlobName(ids[i], this->Whole.Information.depths);
      const auto blob = this->Whole.ReadPieceBlob(ids[i]);
      this->Note(name, OnlyStatus(blob));
      if (blob)
      {
        this->Digest.AddPiece(ids[i], *blob);
        this->Note(name, OnlyStatus(this->Whole.Decode(*blob, ids[i])));
      }
      KDSTREAM_TRY(this->Progress.Report("verify", double(i + 1) / double(ids.size())));
    }
    return {};
  }

  void CheckTree()
  {
    const TreeDepths& depths = this->Whole.Information.depths;
    std::vector<Box> boxes(std::size_t{ 2 } << depths.partition);
    const std::size_t before = this->Found.size();
    for (const NodeId node : AllPartitionBoxes(depths))
    {
      const auto blob = this->Whole.ReadBoxesBlob(node);
      this->Note(BoxesName(node), OnlyStatus(blob));
      if (!blob)
      {
        continue;
      }
      this->Digest.AddBoxes(node, *blob);
      const auto told = DecodePartitionBoxes(*blob, node, depths);
      this->Note(BoxesName(node), OnlyStatus(told));
      if (told)
      {
        std::copy(told->begin(), told->end(),
          boxes.begin() + (node << (depths.partition - DepthOfNode(node))));
      }
    }
    UniteBoxes(boxes);
    const bool boxesKnown = this->Found.size() == before; // pages are told within them
    PieceTable pieces(depths, this->Whole.Information.HasLevels());
    for (const NodeId page : TreePages(depths))
    {
      const auto blob = this->Whole.ReadTreePageBlob(page);
      this->Note(TreePageName(page),
        blob && boxesKnown ? this->Whole.DecodePage(*blob, page, boxes, pieces) : OnlyStatus(blob));
      if (blob)
      {
        this->Digest.AddTreePage(page, *blob);
      }
    }
  }

  template <class Value>
  static Status OnlyStatus(const Result<Value>& result)
  {
    return result ? Status{} : Status{ result.GetError() };
  }

  const Store& Whole;
  const Execution& Progress;
  ContentDigest Digest;
  std::vector<Error> Found;
};

std::vector<Error> Store::Verify(const Execution& execution) const
{
  return Verification(*this, execution).Run();
}

}
