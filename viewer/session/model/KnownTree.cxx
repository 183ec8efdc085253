// SPDX-License-Identifier: BSD-3-Clause
// What a viewer knows of a model's tree: see KnownTree.h.
#include "viewer/session/model/KnownTree.h"

#include "filters/codec/PartitionBoxes.h"

#include <string>
#include <utility>

namespace kdstream
{

using protocol::BlobId;
using protocol::BlobKind;

namespace
{

bool Holds(const Box& outer, const Box& inner)
{
  bool holds = true;
  for (std::size_t k = 0; k < 3; ++k)
  {
    holds = holds && outer.lo[k] <= inner.lo[k] && inner.hi[k] <= outer.hi[k];
  }
  return holds || inner.Empty();
}

}

KnownTree::KnownTree(const TreeDepths& depths, bool hasLevels, const Box& root, std::size_t limit)
  : Depths(depths)
  , HasLevels(hasLevels)
  , Root(root)
  , Limit(limit)
{
}

// ---- looking for boxes

// Counts as a use.
const KnownTree::Entry* KnownTree::Find(const BlobId& blob)
{
  const auto found = this->Entries.find(blob);
  if (found == this->Entries.end())
  {
    return nullptr;
  }
  this->Touch(blob, found->second);
  return &found->second;
}

void KnownTree::Touch(const BlobId& blob, Entry& entry)
{
  this->ByUse.erase(entry.lastUse);
  entry.lastUse = ++this->Uses;
  this->ByUse.emplace(entry.lastUse, blob);
}

const Box* KnownTree::Around(NodeId node)
{
  if (node == 1)
  {
    return &this->Root;
  }
  const NodeId page = TreePageOfNode(node, this->Depths);
  const Entry* entry = this->Find(BlobId::TreePage(page));
  return entry ? &entry->page.BoxOf(node) : nullptr;
}

const Box* KnownTree::AroundIfLoaded(NodeId node) const
{
  if (node == 1)
  {
    return &this->Root;
  }
  const auto found = this->Entries.find(BlobId::TreePage(TreePageOfNode(node, this->Depths)));
  return found == this->Entries.end() ? nullptr : &found->second.page.BoxOf(node);
}

const Box* KnownTree::OfPartition(NodeId node)
{
  const NodeId boxes = BoxesOfPartition(node, this->Depths);
  const Entry* entry = this->Find(BlobId::PartitionBoxes(boxes));
  const NodeId first = boxes << (this->Depths.partition - DepthOfNode(boxes));
  return entry ? &entry->ofPartitions[node - first] : nullptr;
}

void KnownTree::NeedAround(NodeId node)
{
  this->Missing.insert(BlobId::TreePage(TreePageOfNode(node, this->Depths)));
}

void KnownTree::NeedOfPartition(NodeId node)
{
  this->Missing.insert(BlobId::PartitionBoxes(BoxesOfPartition(node, this->Depths)));
}

// The root's own page describes the pieces of the root.
NodeId KnownTree::PageOfFacts(PieceId piece) const
{
  return TreePageOfNode(piece.node, this->Depths);
}

const PieceFacts* KnownTree::FactsOf(PieceId piece)
{
  const NodeId page = this->PageOfFacts(piece);
  const Entry* entry = this->Find(BlobId::TreePage(page));
  return entry ? &entry->page.facts[PlaceInTreePage(page, piece, this->Depths, this->HasLevels)]
               : nullptr;
}

void KnownTree::NeedFactsOf(PieceId piece)
{
  this->Missing.insert(BlobId::TreePage(this->PageOfFacts(piece)));
}

std::size_t KnownTree::MostPages() const
{
  constexpr std::size_t largestPage =
    sizeof(Entry) + (std::size_t{ 4 } << treePageDepths) * (sizeof(Box) + sizeof(PieceFacts));
  return this->Limit / largestPage;
}

void KnownTree::Walk(const std::function<bool(NodeId page, const Box& box)>& enter)
{
  std::vector<NodeId> pages{ 1 }, below;
  for (std::size_t looked = 0; !pages.empty(); pages = std::exchange(below, {}))
  {
    for (const NodeId page : pages)
    {
      const Box* box = this->Around(page);
      ++looked;
      if (!box || box->Empty() || looked > this->MostPages() / 2 || !enter(page, *box))
      {
        continue;
      }
      if (!this->Find(BlobId::TreePage(page)))
      {
        this->Missing.insert(BlobId::TreePage(page));
        continue;
      }
      const unsigned deep = DepthsOfTreePage(page, this->Depths);
      const NodeId first = page << deep;
      for (NodeId i = 0; IsTreePage(first, this->Depths) && i < NodeId{ 1 } << deep; ++i)
      {
        below.push_back(first + i);
      }
    }
  }
}

std::set<BlobId> KnownTree::TakeMissing()
{
  return std::exchange(this->Missing, {});
}

// ---- taking blobs

Status KnownTree::Add(const BlobId& blob, std::span<const std::uint8_t> bytes)
{
  return blob.kind == BlobKind::Tree ? this->AddPage(blob.number, bytes)
                                     : this->AddBoxes(blob.number, bytes);
}

Status KnownTree::AddPage(NodeId page, std::span<const std::uint8_t> bytes)
{
  const Box* around = this->AroundIfLoaded(page);
  if (!around)
  {
    return {};
  }
  Result<TreePage> decoded = DecodeTreePage(bytes, page, *around, this->Depths, this->HasLevels);
  KDSTREAM_TRY(decoded);
  Entry entry;
  entry.bytes = sizeof(Entry) + decoded->boxes.capacity() * sizeof(Box) +
                decoded->facts.capacity() * sizeof(PieceFacts);
  entry.page = std::move(*decoded);
  this->Keep(BlobId::TreePage(page), std::move(entry));
  return {};
}

Status KnownTree::AddBoxes(NodeId node, std::span<const std::uint8_t> bytes)
{
  Result<std::vector<Box>> decoded = DecodePartitionBoxes(bytes, node, this->Depths);
  KDSTREAM_TRY(decoded);
  const NodeId first = node << (this->Depths.partition - DepthOfNode(node));
  for (std::size_t i = 0; i < decoded->size(); ++i)
  {
    const Box* around = this->AroundIfLoaded(first + static_cast<NodeId>(i));
    if (around && !Holds(*around, (*decoded)[i]))
    {
      return Error{ ErrorCode::InvalidInput,
        "boxes " + std::to_string(node) + ": the box of partition " +
          std::to_string(first + i - (NodeId{ 1 } << this->Depths.partition)) +
          " is not within the bounds of the tree's page" };
    }
  }
  Entry entry;
  entry.bytes = sizeof(Entry) + decoded->capacity() * sizeof(Box);
  entry.ofPartitions = std::move(*decoded);
  this->Keep(BlobId::PartitionBoxes(node), std::move(entry));
  return {};
}

void KnownTree::Keep(const BlobId& blob, Entry entry)
{
  ++this->Changes;
  this->Missing.erase(blob);
  auto [place, isNew] = this->Entries.try_emplace(blob);
  this->Sum -= place->second.bytes;
  this->Sum += entry.bytes;
  entry.lastUse = place->second.lastUse;
  place->second = std::move(entry);
  this->Touch(blob, place->second);
  while (this->Sum > this->Limit && this->Entries.size() > 1)
  {
    const auto oldest = this->Entries.find(this->ByUse.begin()->second);
    this->ByUse.erase(this->ByUse.begin());
    this->Sum -= oldest->second.bytes;
    this->Entries.erase(oldest);
  }
}

}
