// A store: one SQLite file NAME.kds that holds tree and pieces of one model. Reading. Layout:
// doc/formats.md.
#pragma once

#include "filters/codec/PieceCodec.h"
#include "filters/core/Result.h"
#include "filters/core/pieces/Piece.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace kdstream
{

// What a store says of one resolution.
struct ResolutionInfo
{
  Resolution resolution;
  std::uint64_t vertices = 0;  // own vertices of all pieces
  std::uint64_t triangles = 0; // each once
  std::uint64_t pieces = 0;
  std::uint64_t bytes = 0;
  double deviation = 0; // largest of its vertices, model units; 0 for the original
  double deviation99 =
    0; // that 99 of 100 of its vertices do not exceed: a single spike does not decide it
};

// The metadata of a store.
struct StoreInfo
{
  std::string digest; // 32 hexadecimal digits over tree, levels and partitions
  std::string input;  // name of the file it was built from, without its folder
  TreeDepths depths;
  CoordinateGrid grid;
  PrimitiveType primitive = PrimitiveType::Triangles;
  Box box; // of the original vertices
  std::uint64_t vertices = 0, triangles = 0, partitions = 1;
  std::uint64_t welded = 0, inconsistentEdges = 0;
  std::uint64_t smallestPartition = 0, largestPartition = 0; // own vertices
  std::vector<ResolutionInfo> levels;                        // 0 … L
  ResolutionInfo original;
  std::vector<AttributeInfo> attributes;
  std::string title, credit, license, unit;
  std::string partitioner = "kdtree";     // as the options of kdstream-build name them; the others
                                          // have no levels, P = S = L, and any number of partitions
  std::string levelMaker, representative; // likewise; empty where there are no levels
  bool sheets = true, weld = true;

  bool HasLevels() const { return this->partitioner == "kdtree"; }
  bool HasPiece(PieceId id) const;
  CodecContext Codec() const { return { this->depths, this->grid }; }
};

// Reads one store. Any number of threads may read at once. The file must not change while it is
// open: it is opened read-only and immutable.
class Store
{
public:
  // Opens and checks the metadata. Errors: NotFound; Damaged, naming what; Unsupported for another
  // store version.
  static Result<std::shared_ptr<Store>> Open(const std::filesystem::path& file);
  ~Store();

  const StoreInfo& Info() const { return this->Information; }

  // The encoded piece / tree page, its checksum verified.
  // Errors: NotFound where the model has no such piece; Damaged (message names the blob) where
  // bytes are wrong.
  Result<std::vector<std::uint8_t>> ReadPieceBlob(PieceId id) const;
  Result<std::vector<std::uint8_t>> ReadTreePageBlob(NodeId page) const;

  // Decoded.
  Result<Piece> ReadPiece(PieceId id) const;
  // The boxes of nodes 1 … 2^(P+1) - 1, heap order.
  Result<std::vector<Box>> ReadTree() const;

  // Ids of every piece the model has, coarse to fine, nodes ascending.
  std::vector<PieceId> PieceIds() const;

  // What a damaged blob is called: "tree/1", "levels/7/1", "partitions/12".
  static std::string BlobName(PieceId id, const TreeDepths& depths);
  static std::string TreePageName(NodeId page);

  // Reads and checks everything, digest included; the names and reasons of what is damaged, empty
  // if whole.
  std::vector<Error> Verify(const Execution& execution = {}) const;

private:
  struct Connection;
  Store();
  Result<Piece> Decode(std::span<const std::uint8_t> blob, PieceId id) const;
  bool AttributesFit(const Piece& piece) const;
  std::string NameOfRow(std::int64_t row) const;
  std::unique_ptr<Connection> Database;
  StoreInfo Information;
};

}
