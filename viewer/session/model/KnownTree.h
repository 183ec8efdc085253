// SPDX-License-Identifier: BSD-3-Clause
// What a viewer knows of a model's tree: the pages around its view, and the exact boxes around a
// tap. Steps "choose" and "pick" of the pipeline picture.
#pragma once

#include "filters/codec/TreePage.h"
#include "filters/core/tree/Region.h"
#include "filters/protocol/BlobId.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <vector>

namespace kdstream
{

// Not all of the tree is in memory at a time: beyond a limit the least recently used pages are
// dropped, and are missing when they are needed again. What a search needs and cannot find is
// recorded (TakeMissing).
class KnownTree : public TreeBoxes
{
public:
  // root: the box of the model. limit: bytes of memory.
  KnownTree(const TreeDepths& depths, bool hasLevels, const Box& root, std::size_t limit);

  // Takes a page of the tree or boxes of partitions. A page whose own box is not known any more is
  // ignored. Errors: those of the decoders; InvalidInput if an exact box is not within the box that
  // the page has.
  Status Add(const protocol::BlobId& blob, std::span<const std::uint8_t> bytes);

  const Box* Around(NodeId node) override;
  const Box* OfPartition(NodeId node) override;
  void NeedAround(NodeId node) override;
  void NeedOfPartition(NodeId node) override;

  // The facts about a piece; null if its page is not known. O(log pages + levels).
  const PieceFacts* FactsOf(PieceId piece);
  void NeedFactsOf(PieceId piece);
  // The number of pages that can be known at a time, whatever their content.
  std::size_t MostPages() const;

  // Visits the pages whose node's box passes `enter`, from the root down, depth by depth, as far as
  // they are known; the unknown ones after these are recorded as missing. Visits at most half of
  // MostPages.
  void Walk(const std::function<bool(NodeId page, const Box& box)>& enter);

  // The missing pages and boxes since the last call; pages first, coarse before fine.
  std::set<protocol::BlobId> TakeMissing();

  std::size_t Bytes() const { return this->Sum; }
  // Grows whenever more is known.
  std::uint64_t Version() const { return this->Changes; }

private:
  struct Entry
  {
    TreePage page;                 // of a page
    std::vector<Box> ofPartitions; // of boxes
    std::size_t bytes = 0;
    std::uint64_t lastUse = 0;
  };
  const Entry* Find(const protocol::BlobId& blob);
  NodeId PageOfFacts(PieceId piece) const;
  const Box* AroundIfLoaded(NodeId node) const; // as Around, without recording a use
  void Touch(const protocol::BlobId& blob, Entry& entry);
  Status AddPage(NodeId page, std::span<const std::uint8_t> bytes);
  Status AddBoxes(NodeId node, std::span<const std::uint8_t> bytes);
  void Keep(const protocol::BlobId& blob, Entry entry);

  TreeDepths Depths;
  bool HasLevels;
  Box Root;
  std::size_t Limit;
  std::size_t Sum = 0;
  std::uint64_t Uses = 0;
  std::uint64_t Changes = 0;
  std::map<protocol::BlobId, Entry> Entries;
  std::map<std::uint64_t, protocol::BlobId> ByUse; // oldest first
  std::set<protocol::BlobId> Missing;
};

}
