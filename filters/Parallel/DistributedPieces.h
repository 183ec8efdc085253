// SPDX-License-Identifier: BSD-3-Clause
// Step "store" of a parallel build: rank 0 receives the encoded pieces of all ranks, in their
// order, and writes them. For DistributedBuilder.
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/build/PieceWriting.h"
#include "filters/core/pieces/Piece.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/store/ScalarStatistics.h"
#include "filters/store/StoreWriter.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Takes the pieces of a resolution on each rank. Rank 0, whose pieces come first, writes its pieces
// at once. The other ranks keep theirs in a file until the resolution is complete.
class DistributedPieces
{
public:
  // attributes: of the model. writer: on rank 0; null on the others.
  DistributedPieces(MpiGroup& group, SpillFolder& folder, std::span<const AttributeInfo> attributes,
    StoreWriter* writer)
    : Group(group)
    , Folder(folder)
    , Scalars(ScalarStatistics::ArraysOf(attributes))
    , Writer(writer)
  {
  }

  // Errors: those of the writer; InputOutput.
  Status Add(const EncodedPiece& encoded);
  // Called when all pieces of this rank of a resolution have been added. The other ranks send
  // theirs to rank 0, one rank after the other, about 4 MiB at a time; so they arrive in the order
  // of nodes. triangles: of this rank's pieces.
  Status Finish(Resolution resolution, std::uint64_t triangles, const Execution& execution);

private:
  Status Write(std::span<const std::byte> bytes, Resolution resolution);

  MpiGroup& Group;
  SpillFolder& Folder;
  std::vector<AttributeInfo> Scalars; // arrays whose ranges the writer gathers
  StoreWriter* Writer;
  SpillFile Kept;
  std::vector<std::uint64_t> BatchBegin{ 0 }; // offsets in the file, and the end
};

}
