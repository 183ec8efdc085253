// SPDX-License-Identifier: BSD-3-Clause
// A source of the pieces of a model: a store, or a server from which they are requested.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/pieces/Piece.h"
#include "filters/model/ModelDescription.h"
#include "filters/protocol/BlobId.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

class PieceSource
{
public:
  virtual ~PieceSource() = default;

  virtual const ModelDescription& Info() const = 0;

  // Returns decoded pieces, in the order of the ids. Reports the step "pieces". Errors: NotFound if
  // the model has no such piece; Damaged, naming the blob; those of the source; Cancelled.
  virtual Result<std::vector<Piece>> ReadPieces(
    std::span<const PieceId> ids, const Execution& execution = {}) const = 0;

  // Returns a blob, encoded as in doc/formats.md. Errors: as above.
  virtual Result<std::vector<std::uint8_t>> Read(
    const protocol::BlobId& blob, const Execution& execution = {}) const = 0;

  // Returns the exact boxes of nodes 1 … 2^(P+1) - 1 in heap order. Errors: as above.
  virtual Result<std::vector<Box>> ReadBoxes(const Execution& execution = {}) const = 0;
};

}
