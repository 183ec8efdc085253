// SPDX-License-Identifier: BSD-3-Clause
// Joins the finest tiles of a tileset into one mesh: step "convert" of the pipeline picture.
//
// Steps:
// 1. walk through the tree of tiles: which files are the finest, and where they are placed
//    (Tileset.h)
// 2. count each tile's claims, and note what is not carried
// 3. append each tile, at its place, to one mesh; only one tile at a time is in memory
// 4. bake pictures, as for other scenes.
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/gltf/JoinScenes.h"
#include "filters/convert/tiles/TileParts.h"
#include "filters/convert/tiles/Tileset.h"
#include "filters/core/Texts.h"
#include "filters/core/UnitVector.h"
#include "filters/core/VectorMath.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace kdstream
{
namespace
{

namespace fs = std::filesystem;

constexpr const char* batchNumbers = "_BATCHID";
constexpr std::size_t mostTileNotes = 20;

// Warnings about tiles: each sentence once, with the number of tiles that it concerns.
class TileNotes
{
public:
  void Add(const std::string& sentence, const fs::path& tile)
  {
    const auto found = std::find_if(this->Notes.begin(), this->Notes.end(),
      [&](const Note& note) { return note.sentence == sentence; });
    if (found != this->Notes.end())
    {
      ++found->tiles;
    }
    else if (this->Notes.size() < mostTileNotes)
    {
      this->Notes.push_back({ sentence, tile });
    }
    else
    {
      ++this->More;
    }
  }

  std::vector<std::string> Take() const
  {
    std::vector<std::string> all;
    for (const Note& note : this->Notes)
    {
      all.push_back("tile " + Quoted(note.first.string()) +
                    (note.tiles > 1 ? ", and " + std::to_string(note.tiles - 1) + " more" : "") +
                    ": " + note.sentence);
    }
    if (this->More > 0)
    {
      all.push_back(std::to_string(this->More) + " further warnings about tiles are left out");
    }
    return all;
  }

private:
  struct Note
  {
    std::string sentence;
    fs::path first;
    std::size_t tiles = 1;
  };
  std::vector<Note> Notes;
  std::size_t More = 0;
};

// The upward direction where the mesh is, if it is on the globe: its coordinates are then metres
// from the centre of the earth.
std::optional<Vec3> UpOnGlobe(const Box& box)
{
  constexpr double polar = 6356752.3142, equator = 6378137, highest = 20000;
  if (box.Empty())
  {
    return std::nullopt;
  }
  Vec3 middle;
  for (std::size_t k = 0; k < 3; ++k)
  {
    middle[k] = box.lo[k] + (box.hi[k] - box.lo[k]) / 2;
  }
  const double distance = Length(middle);
  if (distance < polar - highest || distance > equator + highest ||
      Length(Minus(box.hi, box.lo)) > polar / 2)
  {
    return std::nullopt;
  }
  constexpr double flat = equator / polar * (equator / polar);
  return UnitVector(Vec3{ middle[0], middle[1], middle[2] * flat });
}

// Whether a tile lies outside the volume that its tileset claims, by more than rounding errors.
bool ReachesOut(const Box& tile, const Box& volume)
{
  if (tile.Empty() || volume.Empty())
  {
    return false;
  }
  const Vec3 sides = Minus(volume.hi, volume.lo);
  double largest = 0; // largest coordinate
  for (std::size_t k = 0; k < 3; ++k)
  {
    largest = std::max({ largest, std::abs(volume.lo[k]), std::abs(volume.hi[k]) });
  }
  const double margin = *std::max_element(sides.begin(), sides.end()) / 100 + largest * 1e-6;
  for (std::size_t k = 0; k < 3; ++k)
  {
    if (tile.lo[k] < volume.lo[k] - margin || tile.hi[k] > volume.hi[k] + margin)
    {
      return true;
    }
  }
  return false;
}

std::string ShortNumber(double value)
{
  std::string text = std::to_string(std::round(value * 1e4) / 1e4 + 0.0);
  text.resize(text.size() - 2); // keep four of six digits after the point
  return text;
}

class TilesetReader
{
public:
  TilesetReader(const fs::path& file, const TextureOptions& textures, const Execution& execution)
    : File(file)
    , Folder(file.has_parent_path() ? file.parent_path() : fs::path("."))
    , Runs(execution)
    , Joined(textures, JoinedScenes::Parts::OfTiles, { batchNumbers })
  {
  }

  Result<ForeignMesh> Read()
  {
    Result<FinestTiles> finest = FindFinestTiles(this->File, this->Runs);
    KDSTREAM_TRY(finest);
    this->Finest = std::move(*finest);
    this->AddNamed();
    KDSTREAM_TRY(this->ForScenes(
      [&](const TileFile& tile, GltfSource& scene) -> Status
      {
        KDSTREAM_TRY(this->Joined.Count(scene));
        this->Note(tile, scene);
        return {};
      },
      true));
    this->Joined.Begin();
    KDSTREAM_TRY(this->ForScenes(
      [&](const TileFile& tile, GltfSource& scene) -> Status
      {
        KDSTREAM_TRY(this->Joined.Append(scene, this->Runs));
        if (ReachesOut(this->Joined.LastBounds(), tile.volume))
        {
          this->Notes.Add("it reaches out of its boundingVolume, beyond which viewers do not look "
                          "for it",
            tile.file);
        }
        return {};
      },
      false));
    std::vector<std::string> notes = std::move(this->Finest.warnings);
    const std::vector<std::string> ofTiles = this->Notes.Take();
    notes.insert(notes.end(), ofTiles.begin(), ofTiles.end());
    if (const std::optional<Vec3> up = UpOnGlobe(this->Joined.Bounds()))
    {
      notes.push_back(
        "its coordinates are relative to the centre of the earth (ECEF): kdstream-build --up " +
        ShortNumber((*up)[0]) + "," + ShortNumber((*up)[1]) + "," + ShortNumber((*up)[2]) +
        " sets it upright");
    }
    Result<ForeignMesh> mesh = this->Joined.Finish(notes, {}, this->Runs);
    KDSTREAM_TRY(mesh);
    mesh->named = std::move(this->Named);
    return mesh;
  }

private:
  // Calls visit with each scene of each tile. isFirst: note what is not read.
  template <class Visit>
  Status ForScenes(const Visit& visit, bool isFirst)
  {
    for (const TileFile& tile : this->Finest.tiles)
    {
      KDSTREAM_TRY(this->Runs.Report("read", 0));
      const Status read = this->ForScenesOf(tile, visit, isFirst);
      if (!read && read.GetError().code != ErrorCode::Cancelled)
      {
        return Within("tile " + Quoted(tile.file.string()) + ": ", read.GetError());
      }
      KDSTREAM_TRY(read);
    }
    return {};
  }

  template <class Visit>
  Status ForScenesOf(const TileFile& tile, const Visit& visit, bool isFirst)
  {
    const fs::path file = this->Folder / tile.file;
    const Result<TileParts> parts = FindTileParts(file);
    KDSTREAM_TRY(parts);
    if (isFirst)
    {
      this->NoteParts(tile, *parts);
    }
    for (const TilePart& part : parts->parts)
    {
      GltfStand stand = tile.stand;
      stand.outer = CombinedFarAway(stand.outer, GltfPlace{ GltfPlace{}.axes, part.center });
      const auto scene = GltfSource::Open(file, part.range, stand);
      KDSTREAM_TRY(scene);
      const Status visited = visit(tile, **scene);
      if (!visited)
      {
        return (*scene)->Explained(visited.GetError());
      }
    }
    return {};
  }

  void AddNamed()
  {
    for (std::size_t i = 1; i < this->Finest.tilesets.size(); ++i) // the first one is the input
    {
      this->Named.push_back(this->Folder / this->Finest.tilesets[i]);
    }
    for (const TileFile& tile : this->Finest.tiles)
    {
      this->Named.push_back(this->Folder / tile.file);
    }
  }

  void NoteParts(const TileFile& tile, const TileParts& parts)
  {
    for (const std::string& kind : parts.notRead)
    {
      this->Notes.Add("left out: tiles of the unsupported kind " + kind, tile.file);
    }
    if (!parts.properties.empty())
    {
      constexpr std::size_t mostNames = 10;
      std::string names;
      std::size_t count = 0;
      for (const std::string& name : parts.properties)
      {
        names += count == mostNames  ? ", …"
                 : count > mostNames ? ""
                                     : (count > 0 ? ", " : "") + Quoted(name);
        ++count;
      }
      this->Notes.Add("its batch table is left out: " + names, tile.file);
    }
  }

  void Note(const TileFile& tile, const GltfSource& scene)
  {
    for (const std::vector<std::string>& notes :
      { scene.SceneNotes(), scene.MaterialNotes(), scene.OtherNotes() })
    {
      for (const std::string& note : notes)
      {
        this->Notes.Add(note, tile.file);
      }
    }
    const std::vector<fs::path> named = scene.Named();
    this->Named.insert(this->Named.end(), named.begin(), named.end());
  }

  const fs::path File, Folder;
  const Execution& Runs;
  JoinedScenes Joined;
  FinestTiles Finest;
  TileNotes Notes;
  std::vector<fs::path> Named;
};

}

Result<ForeignMesh> ReadTileset(
  const fs::path& file, const TextureOptions& textures, const Execution& execution)
{
  KDSTREAM_TRY(execution.Report("read", 0));
  return TilesetReader(file, textures, execution).Read();
}

}
