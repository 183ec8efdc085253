// What a server says of a model before any of its blobs: model.json, the `opened` answer, and the
// list of models.
//
// Doubles survive the way through JSON bit for bit, so that client and server compute with the same
// grid and box.
#pragma once

#include "filters/core/Result.h"
#include "server/protocol/BlobId.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream::protocol
{

// Counts of one resolution.
struct ResolutionDescription
{
  std::uint64_t vertices = 0;  // own vertices of all pieces
  std::uint64_t triangles = 0; // each once
  std::uint64_t pieces = 0;
  std::uint64_t bytes = 0;
  // Of a level's vertices, model units; 0 for the original: the largest, and what 99 of 100 do not
  // exceed. A single spike keeps the largest up through all levels; viewers steer by the other.
  double deviation = 0;
  double deviation99 = 0;
  bool operator==(const ResolutionDescription&) const = default;
};

struct AttributeDescription
{
  std::string name;
  std::string type;        // "int8" … "uint64", "float32", "float64"
  std::string association; // "point" or "cell"
  std::uint8_t components = 1;
  bool operator==(const AttributeDescription&) const = default;
};

struct ModelDescription
{
  std::string id;     // IsModelId
  std::string digest; // IsDigest

  std::uint64_t vertices = 0; // at least 1
  std::uint64_t triangles = 0;
  std::uint64_t partitions = 1; // 1 … 2^partitionDepth

  std::array<double, 3> boxLo{}; // of the original vertices
  std::array<double, 3> boxHi{};

  // P <= S <= L of doc/design.md#depths, at most maximumDepth.
  std::uint8_t partitionDepth = 0;
  std::uint8_t stitchDepth = 0;
  std::uint8_t finestDepth = 0;

  std::uint8_t bits = 20;             // an axis of the grid: 8-24, or 0 = lossless
  bool doublePrecision = false;       // the input's coordinates were doubles
  std::array<double, 3> gridOrigin{}; // of grid point (0, 0, 0)
  double gridStep = 1;                // positive

  bool hasTriangles = true; // "primitive": triangles, or points

  std::vector<ResolutionDescription> levels; // 0 … L, or none at all
  ResolutionDescription original;

  std::string title, credit, license, unit; // UTF-8, shown by viewers; may be empty
  std::vector<AttributeDescription> attributes;

  bool operator==(const ModelDescription&) const = default;
};

struct ModelSummary
{
  std::string id;
  std::string digest;
  std::string title;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  bool operator==(const ModelSummary&) const = default;
};

ModelSummary Summarize(const ModelDescription& model);

// The depth of the nodes that level `depth` is cut into: min(P, max(0, depth - 11)).
unsigned PieceDepth(const ModelDescription& model, unsigned depth);
// The level of the preview: min(L, 11).
unsigned PreviewLevel(const ModelDescription& model);

// The most bytes of model.json that a parser takes, and of the list of models.
inline constexpr std::size_t maximumModelBytes = std::size_t{ 1 } << 20;
inline constexpr std::size_t maximumModelListBytes = std::size_t{ 16 } << 20;

std::string WriteModel(const ModelDescription& model);
std::string WriteModelList(const std::vector<ModelSummary>& models);

// Errors: LimitExceeded for too many bytes; InvalidInput naming the member that is missing, of
// another type or out of its range. Unknown members are ignored.
Result<ModelDescription> ParseModel(std::string_view text);
Result<std::vector<ModelSummary>> ParseModelList(std::string_view text);

}
