// SPDX-License-Identifier: BSD-3-Clause
// Shared by tests of a session's parts: the torus of a server as an open model, with as much of it
// as a test needs, without a session.
#pragma once

#include "viewer/session/Testing/SessionsByLevel.h"
#include "viewer/session/Testing/SessionsByView.h"
#include "viewer/session/model/ShownModel.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace kdstream::testing
{

struct TorusModel
{
  MemoryServer server;
  ShownModel model{ std::size_t{ 256 } << 20, std::size_t{ 256 } << 20 };

  explicit TorusModel(const MemoryServer& torus = SmallTorus())
    : server(torus)
  {
    this->model.Select("torus");
    this->model.Open(this->server.Description(), standardTreeBytes);
  }

  Status TakeOfTree(const protocol::BlobId& blob)
  {
    return this->model.open->tree.Add(blob, this->server.Blob(blob));
  }
  // Adds all pages of the tree, and all boxes.
  void TakeTree()
  {
    for (const protocol::BlobId& blob : this->server.AllBlobs()) // coarse before fine
    {
      EXPECT_TRUE(!IsOfTree(blob) || this->TakeOfTree(blob));
    }
  }
  void Take(PieceId piece)
  {
    auto decoded = DecodePiece(
      this->server.Blob(BlobOfPiece(piece, this->model.Depths())), piece, this->model.open->codec);
    ASSERT_TRUE(decoded) << decoded.GetError().message;
    this->model.Add(std::move(*decoded));
  }
  // Loads and draws the preview and these pieces.
  void Show(const std::vector<PieceId>& pieces = {})
  {
    this->Take(this->model.Preview());
    for (const PieceId piece : pieces)
    {
      this->Take(piece);
    }
    const SurfaceWish wish{ this->model.Preview().resolution, pieces };
    for (ShownSurface::Needs needs = this->model.surface.ShowLoaded(wish, this->model.pieces);
         !needs.missing.empty(); needs = this->model.surface.ShowLoaded(wish, this->model.pieces))
    {
      for (const PieceId piece : needs.missing)
      {
        this->Take(piece);
      }
    }
    ASSERT_TRUE(this->model.surface.Draw(this->model.pieces));
  }
};

}
