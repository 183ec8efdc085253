// SPDX-License-Identifier: BSD-3-Clause
// What is known about a model before any of its pieces: one description for all programs, from the
// builder to the page.
//
// A builder fills it in. A store keeps it (row "model"). kdstream-store and kdstream-build print it
// as statistics. A server sends it (model.json, the `opened` answer), and a viewer draws by it.
// ModelJson.h writes and reads it.
#pragma once

#include "filters/codec/CoordinateGrid.h"
#include "filters/codec/PieceCodec.h"
#include "filters/core/Attribute.h"
#include "filters/core/Types.h"
#include "filters/core/pieces/Piece.h"
#include "filters/core/tree/KdTree.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kdstream
{

// The deepest tree that a model may have; nodes have numbers below 2^31.
inline constexpr unsigned maximumDepth = 30;

inline constexpr std::uint32_t mostSpacing = std::uint32_t{ 1 } << 24;

// Counts of one resolution.
struct ResolutionDescription
{
  std::uint64_t vertices = 0;  // own vertices of all pieces
  std::uint64_t triangles = 0; // each counted once
  std::uint64_t pieces = 0;
  std::uint64_t bytes = 0;
  // For a level, in model units; 0 for the original. geometricError: an upper bound of the distance
  // from the original to the level's surface. geometricError99: an estimate that 99 of 100 vertices
  // of the level do not exceed; viewers choose levels by it.
  double geometricError = 0;
  double geometricError99 = 0;
  // For a level: the spacing of its coordinates in steps of the grid, 1 … mostSpacing. For the
  // original: 1.
  std::uint32_t spacing = 1;
  // Only for levels with textures: sums over the tiles of the level's pieces.
  std::uint64_t tileBytes = 0, texels = 0;
  bool operator==(const ResolutionDescription&) const = default;
};

// Which way is up, and the direction from which the model is seen first.
struct HomeView
{
  Vec3 up{ 0, 1, 0 };   // of length 1
  Vec3 view{ 0, 0, 1 }; // from the model's centre towards the eye, of length 1
  bool guessed = false; // at least one direction was guessed by the build
  bool operator==(const HomeView&) const = default;
};

// For a model whose original has textures: one tile for each partition (TextureTile.h), and since
// version 14 of the store also for each piece of a level.
struct TextureDescription
{
  std::string format = "webp"; // of the tiles' images
  bool lossless = false;       // texels and coordinates are those of the input, bit for bit
  std::uint64_t bytes = 0;     // size of the original's tiles
  std::uint64_t texels = 0;    // in the original's tiles
  bool levels = false;         // pieces of levels have tiles too; not in stores before version 14
  bool operator==(const TextureDescription&) const = default;
};

// The vertices of a mesh that no triangle uses. Only the original has them, in a separate list
// (filters/store/UnusedList.h). They are not part of any box, grid or level.
struct UnusedDescription
{
  std::uint64_t vertices = 0; // at least 1
  std::uint64_t bytes = 0;    // size of the list
  Vec3 farthest{};            // the vertex farthest from the model's box; the first if there are
                              // several
  bool operator==(const UnusedDescription&) const = default;
};

// The direction scaled to length 1. Nothing if its length is 0 or not finite.
std::optional<Vec3> DirectionOf(const Vec3& vector);

// The direction of the first view if nothing else is known: +z if y is up, as in glTF; -y if z is
// up, as in CAD; for another up direction, whichever of these two is nearer to horizontal.
Vec3 FrontOf(const Vec3& up);

// The values of an array that viewers can colour by (IsScalar), over the vertices of the original.
// Values that are not finite do not count. If there are no finite values, all members are 0.
struct ScalarDescription
{
  std::string name;           // one of the model's point arrays
  double least = 0, most = 0; // least <= low <= high <= most
  double low = 0, high = 0;   // 2nd and 98th percentile of a sample: ScalarStatistics.h
  struct Class
  {
    double value = 0;
    std::uint64_t vertices = 0; // number of vertices with a value
    bool operator==(const Class&) const = default;
  };
  std::vector<Class> classes; // ascending; empty if the array has no classes (HoldsClasses) or more
                              // than mostClasses
  static constexpr std::size_t mostClasses = 256;
  bool operator==(const ScalarDescription&) const = default;
};

// The descriptions of all arrays of a model. Copies share them.
class ScalarDescriptions
{
public:
  ScalarDescriptions() = default;
  ScalarDescriptions(std::vector<ScalarDescription> all)
    : All(std::make_shared<const std::vector<ScalarDescription>>(std::move(all)))
  {
  }

  std::size_t size() const { return this->All ? this->All->size() : 0; }
  bool empty() const { return this->size() == 0; }
  const ScalarDescription* begin() const { return this->All ? this->All->data() : nullptr; }
  const ScalarDescription* end() const { return this->begin() + this->size(); }
  // The description of the array with this name; null if there is none.
  const ScalarDescription* Find(std::string_view name) const;
  bool operator==(const ScalarDescriptions& other) const
  {
    return this->All == other.All ||
           std::equal(this->begin(), this->end(), other.begin(), other.end());
  }

private:
  std::shared_ptr<const std::vector<ScalarDescription>> All;
};

// How much of a model a client may receive; each value includes those before it.
enum class ModelDetail : std::uint8_t
{
  Preview, // the description, and levels up to the preview's
  Levels,  // all levels, and the tree above them
  Regions  // the original too
};

// The name in messages: "preview", "levels" or "regions".
std::string_view NameOf(ModelDetail detail);

struct ModelDescription
{
  std::string id;     // IsModelId: its name on a server; empty in a store
  std::string digest; // IsDigest: over the content, tree, levels and partitions

  std::uint64_t vertices = 0, triangles = 0; // without unused vertices
  std::uint64_t partitions = 1;              // 1 … 2^depths.partition
  Box box;           // of the original vertices; in a mesh, of those that triangles use
  TreeDepths depths; // P <= S <= L, at most maximumDepth
  CoordinateGrid grid;
  PrimitiveType primitive = PrimitiveType::Triangles;

  std::vector<ResolutionDescription> levels; // 0 … L, or none at all
  ResolutionDescription original;

  // UTF-8, displayed by viewers; may be empty.
  std::string title, credit, license, unit, description;
  std::vector<AttributeInfo> attributes;      // point arrays first
  ScalarDescriptions scalars;                 // also in levels; in the order of attributes
  std::optional<HomeView> homeView;           // nothing: viewers use their default view
  std::optional<TextureDescription> textures; // nothing: no texture tiles

  // How much the client that receives this may have; only from servers with tokens.
  ModelDetail detail = ModelDetail::Regions;

  // How the model was built. Stores keep it and statistics print it; servers do not send it.
  std::string input; // name of the file that it was built from, without its folder
  // IsDigest: over the bytes of that file, the same for all builds of it; empty if not known.
  std::string inputDigest;
  std::uint64_t welded = 0, inconsistentEdges = 0;
  std::uint64_t smallestPartition = 0, largestPartition = 0; // numbers of own vertices
  std::optional<UnusedDescription> unused; // nothing: triangles use all vertices, or it is a cloud
  // Named as in the options of kdstream-build. Partitioners other than kdtree make no levels; then
  // P = S = L, any number of partitions is possible, and levelMaker and representative are empty.
  std::string partitioner = "kdtree";
  std::string levelMaker, representative;
  bool sheets = true, weld = true;

  bool HasLevels() const { return !this->levels.empty(); }
  bool HasPiece(PieceId piece) const;
  CodecContext Codec() const;
  bool operator==(const ModelDescription&) const = default;
};

// The part of a description that a client with this access level gets. It reveals about finer
// resolutions only that they exist.
ModelDescription WithDetail(ModelDescription model, ModelDetail detail);

// An entry of a server's list of models.
struct ModelSummary
{
  std::string id;
  std::string digest;
  std::string title;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::string description{}; // the beginning: at most mostSummaryBytes
  std::uint64_t notes = 0;   // number of notes on the model (Notes.h)
  bool operator==(const ModelSummary&) const = default;
};

// How much of a description is in a list: a few lines, so that long lists stay readable.
inline constexpr std::size_t mostSummaryBytes = 400;

// A server's texts about itself, displayed above its list of models; may be empty.
struct SiteDescription
{
  std::string title, text; // UTF-8
};

ModelSummary Summarize(const ModelDescription& model);

// The level of the preview: min(L, 11).
unsigned PreviewLevel(const ModelDescription& model);

// Whether servers can serve a model by this name. The name becomes part of a URL and of a file's
// path. A name that begins with a dot would be that of a hidden file, or "." or "..".
inline constexpr std::string_view modelIdRule =
  "1 to 128 characters of A-Z a-z 0-9 . _ -, and no dot at the start";
bool IsModelId(std::string_view id);
// The name itself if it is an id; otherwise a similar id, with '_' in place of characters that no
// id has.
std::string ModelIdLike(std::string_view name);

// Whether the text is 32 hexadecimal digits in lower case.
bool IsDigest(std::string_view digest);

}
