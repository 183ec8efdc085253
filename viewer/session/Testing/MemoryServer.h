// SPDX-License-Identifier: BSD-3-Clause
// A server in memory, for tests: builds a model from a mesh, and answers requests blob by blob, in
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

// The place in a tile that AddTiles gives a vertex. For tiles of at least 100 texels a side; tiles
// store such a place exactly.
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

  // What the pages of the tree say about pieces.
  const PieceTable& Table() const { return this->Reported; }
  void TellOfPieces(const PieceTable& pieces);

  // Gives each partition a texture tile. It has this number of texels a side, three bytes in place
  // of a picture, and places of the triangles' corners by TilePlaceOf.
  void AddTiles(std::uint32_t side);
  // The same for each piece of a level. REQUIRES: AddTiles was called.
  void AddTilesOfLevels(std::uint32_t side);

  std::vector<protocol::BlobId> AllBlobs() const;

  // If set, this is called with each blob before it is sent, and may change the bytes. If it
  // returns false, the blob is refused.
  std::function<bool(const protocol::BlobId&, std::vector<std::uint8_t>&)> lie;
  // Blobs that the server refuses.
  std::set<protocol::BlobId> refused;

  // Takes the session's requests, and writes them to `log` as JSON.
  void Take(ViewerSession& session);
  // Sends one answer: the next in order, or a random one if `random` is given. False if nothing is
  // outstanding.
  bool Answer(ViewerSession& session, std::mt19937* random = nullptr);
  // Answers everything, draws a frame after each answer, and calls `eachFrame` after each frame.
  void Serve(
    ViewerSession& session, std::mt19937* random = nullptr,
    const std::function<void()>& eachFrame = [] {});

  // Blobs that were requested and have not been sent.
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
