// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. Find the error of each piece from the pages of the tree, fine to coarse.
// 2. Write each piece as a tile, fine to coarse, and find its box.
// 3. Write the tilesets that refer to the tiles.
// 4. Give the folder its name.
#include "filters/app/ExportTiles.h"

#include "filters/app/HiddenFolder.h"
#include "filters/app/OutputFolders.h"
#include "filters/core/SystemReason.h"
#include "filters/files/Folders.h"
#include "filters/files/WriteWhole.h"
#include "filters/outofcore/files/LockedFolder.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

namespace fs = std::filesystem;

// How many pieces are encoded at the same time.
constexpr std::size_t tilesAtATime = 64;

// ---- the folder

// The file that viewers open. It appears last.
constexpr const char* rootTileset = "tileset.json";

// The folder of a tileset appears with all its files (HiddenFolder). But if an empty folder exists,
// which may be a mount point, or the only place where files may be written, the files appear in it
// one after the other.
class TilesFolder
{
public:
  explicit TilesFolder(const fs::path& folder)
    : Folder(folder.has_filename() ? folder : folder.parent_path())
  {
  }
  Status Make()
  {
    std::error_code ignored;
    this->IsThere = fs::is_directory(this->Folder, ignored);
    const fs::path around = this->IsThere ? this->Folder : this->Parent();
    RemoveDeadFolders(around);
    KDSTREAM_TRY(this->CheckNew());
    const std::string name = this->Folder.string();
    auto above = OfFile(name, OutputFolders::Make(this->Folder));
    KDSTREAM_TRY(above);
    this->Above = std::move(*above);
    return OfFile(name, this->Hidden.Make(around, "tiles"));
  }

  Status MakeFolder(const fs::path& below) const
  {
    return ::mkdir((this->Hidden.Place() / below).c_str(), 0777) == 0 // the umask still applies
             ? Status{}
             : Status{ SystemError("cannot be written", errno, this->NameOf(below)) };
  }
  Status Put(const fs::path& below, std::string_view bytes)
  {
    const Status written = WriteAnew(this->Hidden.Place() / below, bytes);
    if (!written)
    {
      return Error{ written.GetError().code, written.GetError().message, this->NameOf(below) };
    }
    this->Bytes += bytes.size();
    return {};
  }
  Status Appear()
  {
    if (this->IsThere)
    {
      KDSTREAM_TRY(OfFile(this->Folder.string(), SyncTree(this->Hidden.Place())));
      KDSTREAM_TRY(this->FillFolder());
      return SyncFolder(this->Folder);
    }
    KDSTREAM_TRY(OfFile(this->Folder.string(), this->Hidden.Appear(this->Folder)));
    this->Above.Keep();
    return SyncFolder(this->Parent());
  }

  std::uint64_t Bytes = 0; // of all files

private:
  fs::path Parent() const
  {
    return this->Folder.has_parent_path() ? this->Folder.parent_path() : fs::path(".");
  }
  Status FillFolder() const
  {
    auto names = NamesIn(this->Hidden.Place());
    KDSTREAM_TRY(names);
    std::partition(
      names->begin(), names->end(), [](const std::string& name) { return name != rootTileset; });
    for (auto name = names->begin(); name != names->end(); ++name)
    {
      std::error_code failure;
      fs::rename(this->Hidden.Place() / *name, this->Folder / *name, failure);
      if (failure)
      {
        std::for_each(names->begin(), name,
          [&](const std::string& moved) { RemoveTree(this->Folder / moved); });
        return SystemError("cannot be written", failure.value(), this->NameOf(*name));
      }
    }
    return {};
  }
  std::string NameOf(const fs::path& below) const
  {
    return (below.empty() ? this->Folder : this->Folder / below).string();
  }
  Status CheckNew() const
  {
    struct stat found = {};
    if (::lstat(this->Folder.c_str(), &found) != 0)
    {
      return {};
    }
    const bool isFolder = S_ISDIR(found.st_mode);
    const auto names = isFolder ? NamesIn(this->Folder)
                                : Result<std::vector<std::string>>(std::vector<std::string>());
    KDSTREAM_TRY(names);
    return isFolder && names->empty() ? Status{}
                                      : Status{ Error{ ErrorCode::InputOutput,
                                          "is there already: remove it, or name a new folder",
                                          this->Folder.string(), {}, Remedy::InMessage } };
  }

  fs::path Folder;
  OutputFolders Above;
  bool IsThere = false; // whether Folder exists, and is empty
  HiddenFolder Hidden;  // beside Folder, or in it
};

class TilesExport
{
public:
  TilesExport(const Store& store, const fs::path& folder, const TilesOptions& options,
    const Execution& execution)
    : From(store)
    , Folder(folder)
    , Options(options)
    , Runs(execution)
    , Source{ [&store](PieceId piece) { return store.ReadPiece(piece); },
      [&store](const protocol::BlobId& blob) { return store.Read(blob); } }
    , Tree(store.Info())
    , AllTiles(TileTree::CountTiles(store.Info(), ModelDetail::Regions))
  {
  }

  Result<TilesReport> Export()
  {
    KDSTREAM_TRY(this->Tree.FindErrors(this->Source));
    KDSTREAM_TRY(this->Folder.Make());
    for (std::size_t s = this->Tree.Steps().size(); s-- > 0;)
    {
      KDSTREAM_TRY(this->WriteTiles(s));
    }
    KDSTREAM_TRY(this->WriteTilesets());
    KDSTREAM_TRY(this->Folder.Appear());
    this->Report.bytes = this->Folder.Bytes;
    return this->Report;
  }

private:
  // Calls make(number of the piece) on threads, and take(number, result) in order.
  template <class Make, class Take>
  Status ForPieces(const TileStep& step, const Make& make, const Take& take)
  {
    using Made = decltype(make(std::size_t{}));
    for (std::size_t begin = 0; begin < step.tiles.size(); begin += tilesAtATime)
    {
      KDSTREAM_TRY(this->Runs.Report("export", double(this->Done) / double(2 * this->AllTiles)));
      const std::size_t count = std::min(tilesAtATime, step.tiles.size() - begin);
      std::vector<std::optional<Made>> made(count);
      this->Runs.parallelFor(count, 1,
        [&](std::size_t from, std::size_t to)
        {
          for (std::size_t i = from; i < to; ++i)
          {
            made[i] = make(begin + i);
          }
        });
      for (std::size_t i = 0; i < count; ++i)
      {
        KDSTREAM_TRY(*made[i]);
        KDSTREAM_TRY(take(begin + i, **made[i]));
      }
      this->Done += count;
    }
    return {};
  }

  Status FindBorders(std::size_t s)
  {
    const TileStep& step = this->Tree.Steps()[s];
    this->Borders.clear();
    if (!this->Tree.NeedsBorders(s, this->Options))
    {
      this->Done += step.tiles.size();
      return {};
    }
    using Normals = std::vector<BorderNormal>;
    return this->ForPieces(
      step,
      [&](std::size_t t) -> Result<Normals>
      {
        const Result<Piece> piece = this->From.ReadPiece(step.PieceOf(t));
        KDSTREAM_TRY(piece);
        return BorderNormalsOf(*piece);
      },
      [&](std::size_t, const Normals& normals) -> Status
      {
        this->Borders.insert(this->Borders.end(), normals.begin(), normals.end());
        return {};
      });
  }

  Status WriteTiles(std::size_t s)
  {
    const TileStep& step = this->Tree.Steps()[s];
    if (step.isGroup)
    {
      for (std::size_t t = 0; t < step.tiles.size(); ++t)
      {
        this->Tree.Place(s, t, {});
      }
      return {};
    }
    KDSTREAM_TRY(this->Folder.MakeFolder(step.folder));
    KDSTREAM_TRY(this->FindBorders(s));
    return this->ForPieces(
      step,
      [&](std::size_t t)
      { return this->Tree.MakeTile(this->Source, s, t, this->Options, this->Borders); },
      [&](std::size_t t, const EncodedTile& made) -> Status
      {
        this->Tree.Place(s, t, made.box);
        if (made.bytes.empty())
        {
          return {};
        }
        ++this->Report.tiles;
        return this->Folder.Put(TileTree::FileOf(step, t, ".glb"), made.bytes);
      });
  }

  Status WriteTilesets()
  {
    const auto& steps = this->Tree.Steps();
    for (std::size_t s = 0; s < steps.size(); ++s)
    {
      for (std::size_t t = 0; steps[s].begins && t < steps[s].tiles.size(); ++t)
      {
        if (steps[s].tiles[t].stays)
        {
          KDSTREAM_TRY(this->Runs.Report("export", 1));
          KDSTREAM_TRY(
            this->Folder.Put(s == 0 ? rootTileset : TileTree::FileOf(steps[s], t, ".json"),
              this->Tree.TilesetOf(s, t, this->Options, s == 0 ? "" : "../")));
        }
      }
    }
    return {};
  }

  const Store& From;
  TilesFolder Folder;
  const TilesOptions& Options;
  const Execution& Runs;
  const TileInput Source;
  TileTree Tree;
  std::vector<BorderNormal> Borders; // of the step that is being written
  const std::uint64_t AllTiles;
  std::uint64_t Done = 0;
  TilesReport Report;
};

}

Result<TilesReport> ExportTiles(const Store& store, const fs::path& folder,
  const TilesOptions& options, const Execution& execution)
{
  if (!store.Info().HasLevels())
  {
    return Error{ ErrorCode::Unsupported,
      "a store by --partitioner " + store.Info().partitioner +
        " has no levels: build it anew without this option",
      {}, {}, Remedy::InMessage };
  }
  return TilesExport(store, folder, options, execution).Export();
}

}
