// SPDX-License-Identifier: BSD-3-Clause
// What a viewer knows of a model's tree: the pages along what it looks at, and the exact boxes
// around a tap. Step "choose" and "pick" of the pipeline picture.
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

// Not all of it is held at a time: beyond a limit the least recently used leave, and are missing
// again when they are asked for. What a search needs is noted (TakeMissing).
class KnownTree : public TreeBoxes
{
public:
  // root: the box of the model. limit: bytes of memory.
  KnownTree(const TreeDepths& depths, bool hasLevels, const Box& root, std::size_t limit);

  // Takes a page of the tree or boxes of partitions. A page whose own box is not known any more is
  // passed over. Errors: those of the decoders; InvalidInput where an exact box is not within the
  // page's.
  Status Add(const protocol::BlobId& blob, std::span<const std::uint8_t> bytes);

  const Box* Around(NodeId node) override;
  const Box* OfPartition(NodeId node) override;
  void NeedAround(NodeId node) override;
  void NeedOfPartition(NodeId node) override;

  // What is told of a piece; null where that page is not known. O(log pages + levels).
  const PieceFacts* FactsOf(PieceId piece);
  void NeedFactsOf(PieceId piece);
  // So many pages can be known at a time, whatever they tell.
  std::size_t MostPages() const;

  // Looks up the pages whose node's box passes `enter`, from the root down, depth by depth, as far
  // as they are known: the next ones are missing. At most half of MostPages.
  void Walk(const std::function<bool(NodeId page, const Box& box)>& enter);

  // What was needed and is not there, since the last call; pages first, coarse before fine.
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
  const Box* AroundIfLoaded(NodeId node) const; // as Around, but is no use and notes nothing
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
