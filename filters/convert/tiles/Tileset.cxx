// SPDX-License-Identifier: BSD-3-Clause
// Steps for a tile:
// 1. read its place and its claims
// 2. walk through what is below it: children, tilesets among its contents, tiles of implicit tiling
// 3. add its own contents, unless the tiles below replace them.
#include "filters/convert/tiles/Tileset.h"

#include "filters/convert/gltf/GltfDocument.h"
#include "filters/convert/tiles/Subtree.h"
#include "filters/convert/tiles/TilesetFolder.h"
#include "filters/core/Texts.h"
#include "filters/core/VectorMath.h"
#include "filters/meshio/FileEnding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <utility>

namespace kdstream
{
namespace
{

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::size_t mostTiles = std::size_t{ 1 } << 20, mostTilesOfSubtree = mostTiles;
constexpr std::size_t mostTileDepth = 512;
constexpr std::uint64_t mostTilesetBytes = std::uint64_t{ 1 } << 30;
constexpr unsigned mostImplicitLevels = 32;

enum class Refinement
{
  Replace,
  Add
};

// Extensions of version 1.0 that became part of 1.1, and extensions for volumes.
bool IsReadExtension(const std::string& name)
{
  static constexpr const char* names[] = { "3DTILES_implicit_tiling", "3DTILES_multiple_contents",
    "3DTILES_content_gltf", "3DTILES_bounding_volume_S2", "3DTILES_bounding_volume_cylinder" };
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

// The numbers of a transform, written column by column.
Result<GltfPlace> PlaceOfTransform(const Json& transform)
{
  GltfPlace place;
  if (transform.is_null())
  {
    return place;
  }
  constexpr std::size_t numbers = 16;
  const auto isNumber = [](const Json& value) { return value.is_number(); };
  if (CountOf(transform) != numbers || !std::all_of(transform.begin(), transform.end(), isNumber))
  {
    return GltfError("has a transform that does not have 16 numbers");
  }
  constexpr double small = 1e-6;
  for (std::size_t k = 3; k < numbers; k += 4)
  {
    if (!(std::abs(transform[k].get<double>() - (k == 15 ? 1 : 0)) <= small))
    {
      return GltfError("has a transform whose last row is not 0 0 0 1 (the numbers 4, 8, 12 and "
                       "16): it must be written column by column");
    }
  }
  for (std::size_t k = 0; k < 3; ++k)
  {
    for (std::size_t axis = 0; axis < 3; ++axis)
    {
      place.axes[axis][k] = transform[4 * axis + k].get<double>();
    }
    place.origin[k] = transform[12 + k].get<double>();
  }
  return place.Determinant() != 0
           ? Result<GltfPlace>(place)
           : GltfError("has a transform that leaves it no volume (its determinant is 0)");
}

// Whether there is a volume of this name with this number of numbers.
bool HasVolume(const Json& volume, const char* name, std::size_t count)
{
  const Json& numbers = Member(volume, name);
  return CountOf(numbers) == count &&
         std::all_of(numbers.begin(), numbers.end(),
           [](const Json& number)
           { return number.is_number() && std::isfinite(number.get<double>()); });
}

Status CheckVolume(const Json& volume)
{
  constexpr double quarter = 1.5708; // of a turn, with a little tolerance
  const auto numberOf = [&](const char* name, std::size_t k)
  { return Member(volume, name)[k].get<double>(); };
  if (HasVolume(volume, "box", 12) ||
      (HasVolume(volume, "sphere", 4) && numberOf("sphere", 3) >= 0) ||
      (HasVolume(volume, "region", 6) && numberOf("region", 1) >= -quarter &&
        numberOf("region", 3) <= quarter && numberOf("region", 1) <= numberOf("region", 3) &&
        numberOf("region", 4) <= numberOf("region", 5)) ||
      Member(volume, "extensions").is_object()) // such as a cell of S2
  {
    return {};
  }
  return GltfError("has an invalid boundingVolume: it must be a box of 12 numbers, a region of 6 "
                   "or a sphere of 4");
}

// A box around the volume, transformed by `place`. Empty if that is not known, as for regions and
// volumes of extensions.
Box BoxOfVolume(const Json& volume, const GltfPlace& place)
{
  const bool isBox = HasVolume(volume, "box", 12);
  if (!isBox && !HasVolume(volume, "sphere", 4))
  {
    return {};
  }
  const Json& numbers = Member(volume, isBox ? "box" : "sphere");
  const auto number = [&](std::size_t i) { return numbers[i].get<double>(); };
  const GltfPlace turned{ place.axes, {} };
  const Vec3 middle = place.Of({ number(0), number(1), number(2) });
  Vec3 half{};
  double longest = 0; // longest axis of `place`
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    longest = std::max(longest, Length(place.axes[axis]));
    for (std::size_t k = 0; isBox && k < 3; ++k)
    {
      const std::size_t first = 3 + 3 * axis;
      half[k] += std::abs(turned.Of({ number(first), number(first + 1), number(first + 2) })[k]);
    }
  }
  if (!isBox)
  {
    const double radius = number(3) * longest;
    half = { radius, radius, radius };
  }
  Box box;
  box.Add(Minus(middle, half));
  box.Add(Plus(middle, half));
  return box;
}

Status CheckGeometricError(const Json& error)
{
  return NumberOf(error, -1) >= 0
           ? Status{}
           : Status(
               GltfError("has a geometricError that is not 0 or more: " + Quoted(error.dump())));
}

// Checks the version, and the required extensions.
Status CheckTilesetHead(const Json& json)
{
  const Json& version = Member(Member(json, "asset"), "version");
  if (version.is_string() && version != "1.1" && version != "1.0" && version != "0.0")
  {
    return Error{ ErrorCode::Unsupported,
      "is a tileset of version " + Quoted(version.get<std::string>()) +
        ", of which 1.0 and 1.1 are read",
      {}, {}, Remedy::SaveOtherwise };
  }
  for (const Json& name : Member(json, "extensionsRequired"))
  {
    if (!name.is_string() || !IsReadExtension(name.get<std::string>()))
    {
      return Error{ ErrorCode::Unsupported,
        "needs the extension " + Quoted(name.is_string() ? name.get<std::string>() : name.dump()) +
          ", which is not read: save it without",
        {}, {}, Remedy::InMessage };
    }
  }
  const Json& error = Member(json, "geometricError");
  return error.is_null() ? Status{} : CheckGeometricError(error);
}

// The transform from glTF's axes, y up, to those of tilesets, z up. An old tileset may name another
// axis of its tiles as up.
GltfPlace TurnedToZ(const Json& asset)
{
  const Json& up = Member(asset, "gltfUpAxis");
  GltfPlace turned;
  if (up == "X" || up == "x")
  {
    turned.axes = { { { 0, 0, 1 }, { 0, 1, 0 }, { -1, 0, 0 } } };
  }
  else if (up != "Z" && up != "z")
  {
    turned.axes = { { { 1, 0, 0 }, { 0, 0, 1 }, { 0, -1, 0 } } };
  }
  return turned;
}

std::vector<const Json*> ContentsOf(const Json& tile)
{
  std::vector<const Json*> contents;
  if (const Json& content = Member(tile, "content"); !content.is_null())
  {
    contents.push_back(&content);
  }
  const Json& extended =
    Member(Member(Member(tile, "extensions"), "3DTILES_multiple_contents"), "contents");
  for (const Json* const several : { &Member(tile, "contents"), &extended })
  {
    for (std::size_t i = 0; i < CountOf(*several); ++i)
    {
      contents.push_back(&(*several)[i]);
    }
  }
  return contents;
}

std::vector<std::string> UrisOf(const Json& tile)
{
  std::vector<std::string> uris;
  for (const Json* const content : ContentsOf(tile))
  {
    const Json& uri = Member(*content, "uri");
    const Json& old = Member(*content, "url"); // as before version 1.0
    const Json& named = uri.is_string() ? uri : old;
    uris.push_back(named.is_string() ? named.get<std::string>() : std::string());
  }
  return uris;
}

std::string WithNumbers(std::string uri, unsigned level, const std::array<std::uint64_t, 3>& at)
{
  for (const auto& [name, number] : { std::pair<const char*, std::uint64_t>{ "{level}", level },
         { "{x}", at[0] }, { "{y}", at[1] }, { "{z}", at[2] } })
  {
    const std::string_view word = name;
    for (std::size_t found = uri.find(word); found != std::string::npos; found = uri.find(word))
    {
      uri.replace(found, word.size(), std::to_string(number));
    }
  }
  return uri;
}

// What a tile inherits from the tile around it.
struct TileAround
{
  fs::path tileset;
  GltfPlace turned, place;
  Refinement refine = Refinement::Replace;
  double error = 0;
  Box volume; // empty if not known
};

struct Implicit
{
  unsigned dimensions = 2, levels = 0, subtreeLevels = 0;
  std::string subtrees; // template of the URIs
  std::vector<std::string> contents;
  SubtreeShape shape;
};

// A tile by its level, and its coordinates in this level.
struct SubtreeRoot
{
  unsigned level = 0;
  std::array<std::uint64_t, 3> at{};
};

class TilesetWalk
{
public:
  TilesetWalk(const TilesetFolder& folder, const Execution& execution)
    : Folder(folder)
    , Runs(execution)
  {
  }

  // Walks through a tileset. Returns whether it has a content.
  Result<bool> Tileset(const fs::path& file, const GltfPlace& place)
  {
    std::error_code failed;
    const fs::path real = fs::canonical(this->Folder.PathOf(file), failed);
    if (std::find(this->Open.begin(), this->Open.end(), real) != this->Open.end())
    {
      return BadInput(this->Where(file) + "contains itself, directly or through another tileset",
        Remedy::Unknown);
    }
    this->Open.push_back(real);
    this->Found.tilesets.push_back(file);
    const Result<Json> json = this->Parse(file);
    if (!json)
    {
      return Within(this->Where(file), json.GetError());
    }
    const Json& root = Member(*json, "root");
    if (!root.is_object())
    {
      return BadInput(
        this->Where(file) + "is not a tileset of 3D Tiles: its JSON has no root", Remedy::Rename);
    }
    if (const Status head = CheckTilesetHead(*json); !head)
    {
      return Within(this->Where(file), head.GetError());
    }
    this->NoteHead(*json);
    TileAround around;
    around.tileset = file;
    around.turned = TurnedToZ(Member(*json, "asset"));
    around.place = place;
    around.error = std::numeric_limits<double>::infinity();
    std::vector<std::size_t> numbers;
    this->Numbers.swap(numbers); // the numbers of the inner tileset's own tiles
    const Result<bool> has = this->Tile(root, around);
    this->Numbers.swap(numbers);
    this->Open.pop_back();
    return has;
  }

  FinestTiles Take()
  {
    if (this->LargerErrors > 0)
    {
      this->Found.warnings.push_back(std::to_string(this->LargerErrors) +
                                     (this->LargerErrors == 1 ? " tile claims" : " tiles claim") +
                                     " a larger geometricError than the tile above");
    }
    const auto named = [](const std::set<std::string>& names)
    {
      std::string all;
      for (const std::string& name : names)
      {
        all += (all.empty() ? "" : ", ") + Quoted(name);
      }
      return all;
    };
    if (!this->NotCarried.empty())
    {
      this->Found.warnings.push_back(
        "members of tilesets that are left out: " + named(this->NotCarried));
    }
    if (!this->NotRead.empty())
    {
      this->Found.warnings.push_back("extensions that are not read: " + named(this->NotRead));
    }
    return std::move(this->Found);
  }

private:
  static constexpr std::size_t mostNames = 20; // in each set

  void NoteMember(const Json& of, const char* name)
  {
    if (!Member(of, name).is_null())
    {
      this->NotCarried.insert(name);
    }
  }
  void NoteHead(const Json& json)
  {
    for (const char* const name : { "metadata", "schema", "schemaUri", "groups" })
    {
      this->NoteMember(json, name);
    }
    for (const Json& used : Member(json, "extensionsUsed"))
    {
      const std::string name = used.is_string() ? used.get<std::string>() : used.dump();
      if (!IsReadExtension(name) && this->NotRead.size() < mostNames)
      {
        this->NotRead.insert(name);
      }
    }
  }

  Result<Json> Parse(const fs::path& file) const
  {
    const Result<std::string> text = ReadTileText(this->Folder.PathOf(file), mostTilesetBytes);
    KDSTREAM_TRY(text);
    return ParseTileJson(*text);
  }

  // The beginning of a message. It is empty for the root tileset, because every message begins with
  // its name.
  std::string Where(const fs::path& file) const
  {
    return this->Open.size() <= 1 ? std::string() : "tileset " + Quoted(file.string()) + ": ";
  }
  Error OfTile(const TileAround& around, Error error) const
  {
    std::string where = this->Where(around.tileset) + "tile root";
    constexpr std::size_t mostNamed = 20;
    for (std::size_t i = 0; i < std::min(this->Numbers.size(), mostNamed); ++i)
    {
      where += "/" + std::to_string(this->Numbers[i]);
    }
    where += this->Numbers.size() > mostNamed ? "/…" : "";
    return Within(where + " ", std::move(error));
  }

  Status CountTiles(std::size_t tiles)
  {
    this->Tiles += tiles;
    if (this->Tiles > mostTiles)
    {
      return Error{ ErrorCode::LimitExceeded,
        "has more than " + std::to_string(mostTiles) + " tiles, the maximum" };
    }
    constexpr std::size_t often = 1024;
    const bool isDue = this->Tiles >= this->Reported + often;
    this->Reported = isDue ? this->Tiles : this->Reported;
    return isDue ? this->Runs.Report("read", 0) : Status{};
  }

  Result<bool> Tile(const Json& tile, const TileAround& above)
  {
    TileAround around = above;
    if (++this->Depth > mostTileDepth)
    {
      return this->OfTile(above,
        { ErrorCode::LimitExceeded,
          "is nested in " + std::to_string(mostTileDepth) + " others; this is the maximum" });
    }
    const Status claims = this->ReadClaims(tile, around);
    if (!claims)
    {
      return this->OfTile(above, claims.GetError());
    }
    const Json& old =
      Member(Member(tile, "extensions"), "3DTILES_implicit_tiling"); // as before version 1.1
    const Json& implicit = old.is_null() ? Member(tile, "implicitTiling") : old;
    const Result<bool> has = implicit.is_null() ? this->ExplicitTile(tile, around)
                                                : this->ImplicitTiles(tile, implicit, around);
    --this->Depth;
    return has;
  }

  Status ReadClaims(const Json& tile, TileAround& around)
  {
    KDSTREAM_TRY(this->CountTiles(1));
    if (!tile.is_object())
    {
      return GltfError("is not an object");
    }
    const Result<GltfPlace> place = PlaceOfTransform(Member(tile, "transform"));
    KDSTREAM_TRY(place);
    around.place = CombinedFarAway(around.place, *place);
    const Json& volume = Member(tile, "boundingVolume");
    KDSTREAM_TRY(CheckVolume(volume));
    around.volume = BoxOfVolume(volume, around.place);
    for (const Json* const content : ContentsOf(tile))
    {
      if (const Json& own = Member(*content, "boundingVolume"); !own.is_null())
      {
        KDSTREAM_TRY(CheckVolume(own));
      }
      this->NoteMember(*content, "metadata");
    }
    this->NoteMember(tile, "metadata");
    this->NoteMember(tile, "viewerRequestVolume");
    const Json& error = Member(tile, "geometricError");
    KDSTREAM_TRY(CheckGeometricError(error));
    const double number = NumberOf(error, 0);
    this->LargerErrors += number > around.error ? 1 : 0;
    around.error = number;
    const Json& refine = Member(tile, "refine");
    if (refine == "ADD" || refine == "add")
    {
      around.refine = Refinement::Add;
    }
    else if (refine == "REPLACE" || refine == "replace")
    {
      around.refine = Refinement::Replace;
    }
    else if (!refine.is_null())
    {
      return GltfError("has an unknown refinement: " + Quoted(refine.dump()));
    }
    return {};
  }

  Result<bool> ExplicitTile(const Json& tile, const TileAround& around)
  {
    const Json& children = Member(tile, "children");
    if (!children.is_null() && !children.is_array())
    {
      return this->OfTile(around, GltfError("has children that are not a list"));
    }
    bool below = false;
    for (std::size_t i = 0; i < CountOf(children); ++i)
    {
      this->Numbers.push_back(i);
      const Result<bool> has = this->Tile(children[i], around);
      KDSTREAM_TRY(has);
      this->Numbers.pop_back();
      below = below || *has;
    }
    std::vector<fs::path> files;
    for (const std::string& uri : UrisOf(tile))
    {
      const Result<fs::path> file = this->Folder.Find(around.tileset, uri);
      if (!file)
      {
        return this->OfTile(around, file.GetError());
      }
      if (!this->IsTileset(*file))
      {
        files.push_back(*file);
        continue;
      }
      const Result<bool> has = this->Tileset(*file, around.place);
      KDSTREAM_TRY(has);
      below = below || *has;
    }
    if (around.refine == Refinement::Add || !below)
    {
      for (const fs::path& file : files)
      {
        this->Found.tiles.push_back({ file, { around.turned, around.place }, around.volume });
      }
    }
    return below || !files.empty();
  }

  // Whether the file is a tileset, by its name, or else by its first byte.
  bool IsTileset(const fs::path& file) const
  {
    const std::string ending = FileEnding(file);
    if (ending == ".json")
    {
      return true;
    }
    if (ending == ".gltf" || ending == ".glb" || ending == ".b3dm")
    {
      return false;
    }
    std::ifstream input(this->Folder.PathOf(file), std::ios::binary);
    return input.get() == '{';
  }

  // ---- implicit tiling

  Result<bool> ImplicitTiles(const Json& tile, const Json& implicit, const TileAround& around)
  {
    const Result<Implicit> read = ReadImplicit(tile, implicit);
    if (!read)
    {
      return this->OfTile(around, read.GetError());
    }
    return this->SubtreeTiles(*read, {}, around);
  }

  static Result<Implicit> ReadImplicit(const Json& tile, const Json& json)
  {
    Implicit read;
    const Json& scheme = Member(json, "subdivisionScheme");
    read.dimensions = scheme == "OCTREE" ? 3 : scheme == "QUADTREE" ? 2 : 0;
    const Json& last = Member(json, "maximumLevel"); // as before version 1.1
    const double levels =
      last.is_null() ? WholeOf(Member(json, "availableLevels"), -1) : WholeOf(last, -1) + 1;
    const double ofSubtree = WholeOf(Member(json, "subtreeLevels"), -1);
    const Json& uri = Member(Member(json, "subtrees"), "uri");
    if (read.dimensions == 0 || !uri.is_string() || levels < 1 || ofSubtree < 1)
    {
      return GltfError("has implicitTiling without a subdivisionScheme (QUADTREE or OCTREE), "
                       "availableLevels, subtreeLevels or subtrees' uri");
    }
    if (levels > mostImplicitLevels || ofSubtree > mostImplicitLevels)
    {
      return Error{ ErrorCode::LimitExceeded,
        "has implicitTiling of more than " + std::to_string(mostImplicitLevels) + " levels" };
    }
    read.levels = static_cast<unsigned>(levels);
    read.subtreeLevels = static_cast<unsigned>(ofSubtree);
    std::size_t ofLevel = 1;
    for (unsigned level = 0; level < read.subtreeLevels; ++level, ofLevel <<= read.dimensions)
    {
      read.shape.tiles += ofLevel;
      if (read.shape.tiles > mostTilesOfSubtree)
      {
        return Error{ ErrorCode::LimitExceeded, "has implicitTiling of more than " +
                                                  std::to_string(mostTilesOfSubtree) +
                                                  " tiles a subtree" };
      }
    }
    read.shape.children = ofLevel;
    read.subtrees = uri.get<std::string>();
    read.contents = UrisOf(tile);
    return read;
  }

  Result<bool> SubtreeTiles(
    const Implicit& implicit, const SubtreeRoot& root, const TileAround& around)
  {
    const std::string uri = WithNumbers(implicit.subtrees, root.level, root.at);
    const Result<fs::path> file = this->Folder.Find(around.tileset, uri);
    if (!file)
    {
      return this->OfTile(around, file.GetError());
    }
    const Result<Subtree> subtree = ReadSubtree(this->Folder, *file, implicit.shape);
    if (!subtree)
    {
      return this->OfTile(
        around, Within("has a subtree " + Quoted(uri) + " that ", subtree.GetError()));
    }
    this->Found.tilesets.push_back(*file);
    // Counts the work for tiles that are not available, too.
    KDSTREAM_TRY(this->CountTiles(1 + implicit.shape.tiles / 64));
    // From the last level up, for each tile of a level: whether the tile, or one below it, has a
    // content.
    std::vector<bool> below(implicit.shape.children);
    for (std::size_t child = 0; child < below.size(); ++child)
    {
      if (subtree->children[child] && root.level + implicit.subtreeLevels < implicit.levels)
      {
        const Result<bool> has = this->SubtreeTiles(
          implicit, Below(implicit, root, implicit.subtreeLevels, child), around);
        KDSTREAM_TRY(has);
        below[child] = *has;
      }
    }
    std::size_t first = implicit.shape.tiles;
    for (unsigned level = implicit.subtreeLevels; level-- > 0;)
    {
      const std::size_t count = std::size_t{ 1 } << (implicit.dimensions * level);
      first -= count;
      std::vector<bool> here(count);
      for (std::size_t t = 0; t < count && root.level + level < implicit.levels; ++t)
      {
        if (!subtree->tiles[first + t])
        {
          continue;
        }
        KDSTREAM_TRY(this->CountTiles(1));
        bool isReplaced = false;
        const std::size_t children = std::size_t{ 1 } << implicit.dimensions;
        for (std::size_t child = t * children; child < (t + 1) * children; ++child)
        {
          isReplaced = isReplaced || below[child];
        }
        here[t] = isReplaced;
        for (std::size_t i = 0; i < std::min(implicit.contents.size(), subtree->contents.size());
             ++i)
        {
          if (subtree->contents[i][first + t])
          {
            here[t] = true;
            KDSTREAM_TRY(this->AddImplicit(implicit, i, Below(implicit, root, level, t), around,
              isReplaced && around.refine == Refinement::Replace));
          }
        }
      }
      below = std::move(here);
    }
    return bool(below[0]);
  }

  // The tile with this Morton index, `levels` levels below a subtree's root.
  static SubtreeRoot Below(
    const Implicit& implicit, const SubtreeRoot& root, unsigned levels, std::size_t index)
  {
    SubtreeRoot tile{ root.level + levels, root.at };
    for (std::size_t k = 0; k < implicit.dimensions; ++k)
    {
      tile.at[k] <<= levels;
      for (unsigned bit = 0; bit < levels; ++bit)
      {
        tile.at[k] |= std::uint64_t{ index >> (bit * implicit.dimensions + k) & 1U } << bit;
      }
    }
    return tile;
  }

  Status AddImplicit(const Implicit& implicit, std::size_t content, const SubtreeRoot& tile,
    const TileAround& around, bool isReplaced)
  {
    const std::string uri = WithNumbers(implicit.contents[content], tile.level, tile.at);
    if (isReplaced)
    {
      return {};
    }
    const Result<fs::path> file = this->Folder.Find(around.tileset, uri);
    if (!file)
    {
      return this->OfTile(around, file.GetError());
    }
    this->Found.tiles.push_back({ *file, { around.turned, around.place }, around.volume });
    return {};
  }

  const TilesetFolder& Folder;
  const Execution& Runs;
  FinestTiles Found;
  std::vector<fs::path> Open;       // tilesets from the root to the current one
  std::vector<std::size_t> Numbers; // of children, from the tileset's root to the tile
  std::size_t Tiles = 0, Reported = 0, Depth = 0, LargerErrors = 0;
  std::set<std::string> NotCarried, NotRead; // members of JSON; extensions
};

}

Result<FinestTiles> FindFinestTiles(const fs::path& tileset, const Execution& execution)
{
  const Result<TilesetFolder> folder = TilesetFolder::Open(tileset);
  KDSTREAM_TRY(folder);
  TilesetWalk walk(*folder, execution);
  KDSTREAM_TRY(walk.Tileset(tileset.filename(), GltfPlace{}));
  return walk.Take();
}

}
