// SPDX-License-Identifier: BSD-3-Clause
// A server in memory for tests: a model built from a mesh, and requests answered blob by blob in
// any order.
#pragma once

#include "filters/codec/PieceCodec.h"
#include "filters/codec/TextureTile.h"
#include "filters/codec/TreePage.h"
#include "filters/model/ModelDescription.h"
#include "viewer/session/ViewerSession.h"

#include <functional>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace kdstream::testing
{

// A bumpy torus with its hole along z: closed, n × m vertices.
Mesh MakeTorus(std::uint32_t n, std::uint32_t m);
// Gives the torus stripes of colours, and normals.
void AddVertexColors(Mesh& mesh);
// The edges that only one triangle uses.
std::size_t CountBoundaryEdges(const std::vector<Triangle>& triangles);

// Where AddTiles has a vertex: a place in a tile of 100 texels or more, in steps that tiles keep.
TileCoordinate TilePlaceOf(const Vec3& point);

class MemoryServer
{
public:
  MemoryServer(const Mesh& mesh, std::uint32_t verticesPerPartition, std::uint32_t cellVertices);

  const ModelDescription& Description() const { return this->Model; }
  void SetHomeView(const HomeView& homeView) { this->Model.homeView = homeView; }
  const std::vector<Box>& Tree() const { return this->Boxes; }
  const CodecContext& Codec() const { return this->Context; }
  std::vector<std::uint8_t>& Blob(const protocol::BlobId& id) { return this->Blobs.at(id); }
  bool Has(const protocol::BlobId& id) const { return this->Blobs.count(id) != 0; }

  // What the pages of the tree say of pieces.
  const PieceTable& Table() const { return this->Reported; }
  void TellOfPieces(const PieceTable& pieces);

  // Gives each partition a texture tile: with this number of texels a side, three bytes in place of
  // a picture, and the corners of triangles given by TilePlaceOf.
  void AddTiles(std::uint32_t side);
  // The same to each piece of a level. REQUIRES: AddTiles.
  void AddTilesOfLevels(std::uint32_t side);

  std::vector<protocol::BlobId> AllBlobs() const;

  // Called, if set, with each blob that is about to be sent; it may change the bytes; false: the
  // blob is refused.
  std::function<bool(const protocol::BlobId&, std::vector<std::uint8_t>&)> lie;
  // Blobs that the server refuses.
  std::set<protocol::BlobId> refused;

  // Takes what the session has to send; requests are kept in `log` as JSON.
  void Take(ViewerSession& session);
  // Answers one thing: the next in order, or a random one if `random` is given. False if there is
  // nothing.
  bool Answer(ViewerSession& session, std::mt19937* random = nullptr);
  // Answers everything, drawing a frame after each answer; `eachFrame` looks at it.
  void Serve(
    ViewerSession& session, std::mt19937* random = nullptr,
    const std::function<void()>& eachFrame = [] {});

  // Blobs that were asked for and have not been sent.
  std::vector<protocol::BlobId> Outstanding() const;

  std::vector<std::string> log;
  std::multiset<protocol::BlobId> sent;

private:
  struct Pending
  {
    std::uint32_t request = 0;
    bool open = false;
    std::string model;
    protocol::BlobId blob;
  };

  std::size_t AddTile(PieceId id, std::uint32_t side);

  ModelDescription Model;
  CodecContext Context;
  std::vector<Box> Boxes;
  PieceTable Reported;
  std::map<protocol::BlobId, std::vector<std::uint8_t>> Blobs;
  std::vector<Pending> Queue;
};

}
