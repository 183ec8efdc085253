// SPDX-License-Identifier: BSD-3-Clause
// Stores as earlier builds wrote them, when only the original had arrays of numbers.
#pragma once

#include "filters/build/PieceWriting.h"
#include "filters/codec/PieceCodec.h"
#include "filters/store/Store.h"
#include "filters/store/StoreSchema.h"
#include "filters/store/StoreWriter.h"
#include "filters/store/Testing/StoreContent.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace kdstream::fixtures
{

// Removes the ranges of numbers from the metadata.
inline void ForgetScalars(const std::filesystem::path& file, ModelDescription info)
{
  info.scalars = {};
  Sql(file, PutMetadata(WriteStoredModel(info)));
}

// Writes `old`: the model of the store `now`, but with numbers only in the original.
inline void WriteOldStore(const std::filesystem::path& now, const std::filesystem::path& old)
{
  const auto store = Store::Open(now);
  ASSERT_TRUE(store) << store.GetError().message;
  const ModelDescription model = (*store)->Info();
  ModelDescription info = model;
  info.digest.clear();
  info.scalars = {};
  info.levels.assign(model.levels.size(), {});
  for (std::size_t depth = 0; depth < model.levels.size(); ++depth)
  {
    info.levels[depth].spacing = model.levels[depth].spacing;
  }
  info.original = {};
  auto writer = StoreWriter::Create(old, info);
  ASSERT_TRUE(writer) << writer.GetError().message;
  const std::vector<PieceId> ids = (*store)->PieceIds();
  for (std::size_t i = 0; i < ids.size(); ++i)
  {
    Result<Piece> piece = (*store)->ReadPiece(ids[i]);
    ASSERT_TRUE(piece) << piece.GetError().message;
    const Resolution resolution = ids[i].resolution;
    if (!resolution.IsOriginal())
    {
      std::erase_if(
        piece->attributes, [](const Attribute& array) { return IsScalar(array.Info()); });
    }
    ASSERT_TRUE((*writer)->AddPiece(*piece, EncodePiece(*piece, info.Codec())));
    if (i + 1 == ids.size() || ids[i + 1].resolution != resolution)
    {
      const ResolutionDescription& before =
        resolution.IsOriginal() ? model.original : model.levels[resolution.Depth()];
      ASSERT_TRUE((*writer)->FinishResolution(resolution, before.triangles));
    }
  }
  const auto boxes = (*store)->ReadBoxes();
  ASSERT_TRUE(boxes);
  ASSERT_TRUE(WriteTreePages(*boxes, model.depths, **writer));
  const Result<ModelDescription> written = (*writer)->Finish();
  ASSERT_TRUE(written) << written.GetError().message;
  ForgetScalars(old, *written);
}

}
