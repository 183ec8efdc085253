// SPDX-License-Identifier: BSD-3-Clause
// Steps: 1. how large the error of each piece is, from the pages of the tree, fine to coarse
// 2. each piece as a tile, fine to coarse, and its box  3. the tilesets that name them  4. the
// folder takes its name.
//
// The tree of tiles is that of the nodes: a piece's children are the pieces of the next resolution
// in its node. So each piece is in one tile, and its children show the same part of the surface.
#include "filters/app/ExportTiles.h"

#include "filters/app/HiddenFolder.h"
#include "filters/app/OutputFolders.h"
#include "filters/codec/TextureTile.h"
#include "filters/codec/TreePage.h"
#include "filters/core/SystemReason.h"
#include "filters/core/VectorMath.h"
#include "filters/files/Folders.h"
#include "filters/files/WriteWhole.h"
#include "filters/model/JsonWriter.h"
#include "filters/model/Units.h"
#include "filters/outofcore/files/LockedFolder.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

namespace fs = std::filesystem;

// A tileset's file describes this many resolutions; the first one's up to twice as many less one.
constexpr std::size_t stepsOfTileset = 4;
// Pieces that are encoded at a time.
constexpr std::size_t tilesAtATime = 64;

// ---- the folder

// The file that viewers open: it appears last.
constexpr const char* rootTileset = "tileset.json";

// The folder of a tileset appears with all that is in it (HiddenFolder); in an empty folder, which
// may be a mount point or lie where nothing else may be written, the files appear one after the
// other.
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
    return ::mkdir((this->Hidden.Place() / below).c_str(), 0777) == 0 // less the umask, as it stays
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
  bool IsThere = false; // Folder, empty
  HiddenFolder Hidden;  // beside Folder, or in it
};

// ---- the tree of tiles

struct Tile
{
  double error = 0; // model units
  Box box;          // of what it shows, and of all below; model units
  bool shows = false;
  bool stays = false; // it shows something, or one below it does
};

// The pieces of one resolution.
struct Step
{
  Resolution resolution;
  unsigned depth = 0; // of its nodes
  std::string folder; // its name
  std::vector<Tile> tiles;

  NodeId First() const { return NodeId{ 1 } << this->depth; }
};

// Light and colours are interpolated between vertices: the part of their distance that counts as an
// error. For clouds and coloured surfaces all of it; but textures of levels have the colours
// between vertices.
double TilePartOfSpacing(const ModelDescription& model)
{
  const bool colored = std::any_of(model.attributes.begin(), model.attributes.end(),
    [](const AttributeInfo& array) { return RoleOf(array) == AttributeRole::Colors; });
  const bool texturedOriginal = model.textures && !model.textures->levels;
  return colored || texturedOriginal || model.primitive == PrimitiveType::Points ? 1 : 1.0 / 3;
}

// The box of the points and of the places that they may be rounded to: skirts are off the lattice.
Box BoundsOfTile(const std::vector<Vec3>& points, double latticeStep)
{
  Box box;
  std::for_each(points.begin(), points.end(), [&](const Vec3& point) { box.Add(point); });
  const Vec3 sides = Minus(box.hi, box.lo);
  const double most =
    std::max(*std::max_element(sides.begin(), sides.end()) * mostTileRounding, latticeStep / 2);
  const Box inner = box;
  box.Add(Minus(inner.lo, { most, most, most }));
  box.Add(Plus(inner.hi, { most, most, most }));
  return box;
}

class TilesExport
{
public:
  TilesExport(const Store& store, const fs::path& folder, const TilesOptions& options,
    const Execution& execution)
    : From(store)
    , Info(store.Info())
    , Folder(folder)
    , Options(options)
    , Runs(execution)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      this->Frame.origin[k] =
        this->Info.box.lo[k] + (this->Info.box.hi[k] - this->Info.box.lo[k]) / 2;
    }
    // Contents of tiles have y up; clients turn them so that y becomes z.
    this->Frame.axes = { Vec3{ 1, 0, 0 }, Vec3{ 0, 0, 1 }, Vec3{ 0, -1, 0 } };
    this->Frame.scale = MetresOfUnit(this->Info.unit).value_or(1);
    this->Frame.copyright = this->Info.credit;
  }

  Result<TilesReport> Export()
  {
    if (!this->Info.HasLevels())
    {
      return Error{ ErrorCode::Unsupported,
        "a store by --partitioner " + this->Info.partitioner +
          " has no levels: build it anew without this option",
        {}, {}, Remedy::InMessage };
    }
    this->MakeSteps();
    KDSTREAM_TRY(this->FindErrors());
    KDSTREAM_TRY(this->Folder.Make());
    for (std::size_t s = this->Steps.size(); s-- > 0;)
    {
      KDSTREAM_TRY(this->WriteTiles(s));
    }
    KDSTREAM_TRY(this->WriteTilesets());
    KDSTREAM_TRY(this->Folder.Appear());
    this->Report.bytes = this->Folder.Bytes;
    return this->Report;
  }

private:
  void MakeSteps()
  {
    const TreeDepths& depths = this->Info.depths;
    const auto add = [&](Resolution resolution, std::string name, std::uint64_t pieces)
    {
      Step step{ resolution, PieceDepth(resolution, depths), std::move(name), {} };
      step.tiles.resize(pieces);
      this->Steps.push_back(std::move(step));
      this->AllTiles += pieces;
    };
    for (unsigned level = PreviewLevel(depths); level < this->Info.levels.size(); ++level)
    {
      const Resolution resolution = Resolution::Level(level);
      add(resolution, std::to_string(level), std::uint64_t{ 1 } << PieceDepth(resolution, depths));
    }
    add(Resolution::Original(), "original", this->Info.partitions);
  }

  // The tiles of the next step that are below one: first and last but one, by number.
  std::pair<std::size_t, std::size_t> ChildrenOf(std::size_t step, std::size_t tile) const
  {
    if (step + 1 == this->Steps.size())
    {
      return { 0, 0 };
    }
    const unsigned below = this->Steps[step + 1].depth - this->Steps[step].depth;
    const std::size_t all = this->Steps[step + 1].tiles.size();
    return { std::min(tile << below, all), std::min((tile + 1) << below, all) };
  }

  // ---- errors

  // Calls visit(piece, its facts, its node's box) for the pieces of all pages.
  template <class Visit>
  Status VisitFacts(const Visit& visit) const
  {
    std::map<NodeId, Box> around{ { 1, this->Info.box } };
    for (const NodeId page : TreePages(this->Info.depths))
    {
      const auto blob = this->From.Read(protocol::BlobId::TreePage(page));
      KDSTREAM_TRY(blob);
      const auto facts = DecodeTreePage(*blob, page, around[page], this->Info.depths, true);
      if (!facts)
      {
        return Error{ ErrorCode::Damaged,
          BlobName(protocol::BlobId::TreePage(page)) + ": " + facts.GetError().message };
      }
      const auto boxOf = [&](NodeId node) -> const Box&
      { return node == page ? around[page] : facts->BoxOf(node); };
      const std::vector<PieceId> pieces = PiecesOfTreePage(page, this->Info.depths, true);
      for (std::size_t i = 0; i < pieces.size(); ++i)
      {
        visit(pieces[i], facts->facts[i], boxOf(pieces[i].node));
      }
      const unsigned below = DepthsOfTreePage(page, this->Info.depths);
      for (NodeId node = page << below; below > 0 && node < (page + 1) << below; ++node)
      {
        if (IsTreePage(node, this->Info.depths))
        {
          around[node] = facts->BoxOf(node);
        }
      }
    }
    return {};
  }

  Status FindErrors()
  {
    const double part = TilePartOfSpacing(this->Info);
    const unsigned first = PreviewLevel(this->Info.depths);
    KDSTREAM_TRY(this->VisitFacts(
      [&](PieceId piece, const PieceFacts& facts, const Box& box)
      {
        if (piece.resolution.IsOriginal() || piece.resolution.Depth() < first)
        {
          return;
        }
        Step& step = this->Steps[piece.resolution.Depth() - first];
        const Vec3 s = box.Empty() ? Vec3{} : Minus(box.hi, box.lo);
        const double area = s[0] * s[1] + s[1] * s[2] + s[2] * s[0];
        const auto vertices =
          double(this->Info.levels[piece.resolution.Depth()].vertices) / double(step.tiles.size());
        step.tiles[piece.node - step.First()].error =
          std::max(double(facts.most), part * std::sqrt(area / std::max(vertices, 1.0)));
      }));
    for (std::size_t s = this->Steps.size() - 1; s-- > 0;)
    {
      for (std::size_t t = 0; t < this->Steps[s].tiles.size(); ++t)
      {
        double& error = this->Steps[s].tiles[t].error;
        const auto [begin, end] = this->ChildrenOf(s, t);
        for (std::size_t child = begin; child < end; ++child)
        {
          error = std::max(error, this->Steps[s + 1].tiles[child].error);
        }
      }
    }
    return {};
  }

  // ---- contents

  // A tile that shows nothing has no bytes.
  struct Encoded
  {
    std::string bytes;
    Box box;
  };

  TileFrame FrameOf(const Step& step) const
  {
    TileFrame frame = this->Frame;
    if (!this->Info.grid.Lossless())
    {
      const bool isLevel = !step.resolution.IsOriginal();
      frame.latticeStep =
        this->Info.grid.step * (isLevel ? this->Info.levels[step.resolution.Depth()].spacing : 1);
      frame.latticeOrigin = this->Info.grid.origin;
    }
    return frame;
  }

  Result<Encoded> Encode(std::size_t s, std::size_t t) const
  {
    const Step& step = this->Steps[s];
    const Result<Piece> piece =
      this->From.ReadPiece({ step.resolution, step.First() + static_cast<NodeId>(t) });
    KDSTREAM_TRY(piece);
    std::optional<TextureTile> texture;
    if (this->Info.textures && (step.resolution.IsOriginal() || this->Info.textures->levels))
    {
      const protocol::BlobId id = TextureOfPiece(piece->id, this->Info.depths);
      const auto blob = this->From.Read(id);
      KDSTREAM_TRY(blob);
      auto decoded = DecodeTextureTile(*blob, piece->triangles);
      if (!decoded)
      {
        return Error{ ErrorCode::Damaged, BlobName(id) + ": " + decoded.GetError().message };
      }
      texture = std::move(*decoded);
    }
    // As deep as the tile is wrong that stands here where its children are not loaded: a neighbour
    // is mostly of this level, or of the one above.
    const unsigned below = s == 0 ? 0 : step.depth - this->Steps[s - 1].depth;
    const double depth = s == 0 ? 0 : this->Steps[s - 1].tiles[t >> below].error;
    const TileMesh mesh = CutTileMesh(
      *piece, texture ? &*texture : nullptr, { this->Options.normals, depth, this->Borders });
    Encoded encoded;
    if (!mesh.Empty())
    {
      const TileFrame frame = this->FrameOf(step);
      auto bytes = EncodeTileGlb(mesh, frame, this->Options.compression);
      KDSTREAM_TRY(bytes);
      encoded.bytes = std::move(*bytes);
      encoded.box = BoundsOfTile(mesh.points, frame.latticeStep);
    }
    return encoded;
  }

  static std::string FileOf(const Step& step, std::size_t tile, const char* ending)
  {
    return step.folder + "/" + std::to_string(tile) + ending;
  }

  // Whether tiles beside each other would be lit differently along their border.
  bool NeedsBorders(const Step& step) const
  {
    return this->Options.normals && step.tiles.size() > 1 &&
           this->Info.primitive == PrimitiveType::Triangles &&
           std::none_of(this->Info.attributes.begin(), this->Info.attributes.end(),
             [](const AttributeInfo& array) { return RoleOf(array) == AttributeRole::Normals; });
  }

  // Calls make(piece's number), on threads, and take(piece's number, result), in their order.
  template <class Make, class Take>
  Status ForPieces(const Step& step, const Make& make, const Take& take)
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

  Status FindBorders(const Step& step)
  {
    this->Borders.clear();
    if (!this->NeedsBorders(step))
    {
      this->Done += step.tiles.size();
      return {};
    }
    using Normals = std::vector<BorderNormal>;
    return this->ForPieces(
      step,
      [&](std::size_t t) -> Result<Normals>
      {
        const Result<Piece> piece =
          this->From.ReadPiece({ step.resolution, step.First() + static_cast<NodeId>(t) });
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
    Step& step = this->Steps[s];
    KDSTREAM_TRY(this->Folder.MakeFolder(step.folder));
    KDSTREAM_TRY(this->FindBorders(step));
    return this->ForPieces(
      step, [&](std::size_t t) { return this->Encode(s, t); },
      [&](std::size_t t, const Encoded& encoded) { return this->WriteTile(s, t, encoded); });
  }

  Status WriteTile(std::size_t s, std::size_t t, const Encoded& encoded)
  {
    Step& step = this->Steps[s];
    Tile& tile = step.tiles[t];
    tile.box = encoded.box;
    tile.shows = !encoded.bytes.empty();
    tile.stays = tile.shows;
    const auto [begin, end] = this->ChildrenOf(s, t);
    for (std::size_t child = begin; child < end; ++child)
    {
      const Tile& below = this->Steps[s + 1].tiles[child];
      tile.box.Add(below.box);
      tile.stays = tile.stays || below.stays;
    }
    if (!tile.shows)
    {
      return {};
    }
    ++this->Report.tiles;
    return this->Folder.Put(FileOf(step, t, ".glb"), encoded.bytes);
  }

  // ---- tilesets

  // Whether the tiles of a step are the roots of tilesets of their own.
  bool BeginsTileset(std::size_t s) const
  {
    const std::size_t steps = this->Steps.size();
    return s == 0 || ((steps - s) % stepsOfTileset == 0 && s >= stepsOfTileset);
  }

  Status WriteTilesets()
  {
    for (std::size_t s = 0; s < this->Steps.size(); ++s)
    {
      for (std::size_t t = 0; this->BeginsTileset(s) && t < this->Steps[s].tiles.size(); ++t)
      {
        if (this->Steps[s].tiles[t].stays)
        {
          KDSTREAM_TRY(this->Runs.Report("export", 1));
          KDSTREAM_TRY(this->Folder.Put(
            s == 0 ? rootTileset : FileOf(this->Steps[s], t, ".json"), this->TilesetOf(s, t)));
        }
      }
    }
    return {};
  }

  std::string TilesetOf(std::size_t s, std::size_t t) const
  {
    JsonWriter json;
    json.BeginObject().Key("asset").BeginObject().Member("version", "1.1");
    json.Member("tilesetVersion", this->Info.digest);
    if (s == 0)
    {
      json.Key("extras").BeginObject().Member("generator", "KdStream");
      for (const auto& [name, text] : { std::pair{ "title", &this->Info.title },
             { "credit", &this->Info.credit }, { "license", &this->Info.license } })
      {
        if (!text->empty())
        {
          json.Member(name, *text);
        }
      }
      json.EndObject();
    }
    json.EndObject();
    const Tile& root = this->Steps[s].tiles[t];
    json.Member("geometricError", s == 0 ? this->Diagonal() : this->ErrorOf(root));
    json.Key("root");
    this->PutTile(json, s, t, s, s == 0 ? "" : "../");
    json.EndObject();
    return json.Text();
  }

  double ErrorOf(const Tile& tile) const { return tile.error * this->Frame.scale; }

  // The diagonal of the model in metres: the error while nothing is shown, at least the root's.
  double Diagonal() const
  {
    const Tile& root = this->Steps[0].tiles[0];
    return std::max(
      Length(Minus(root.box.hi, root.box.lo)) * this->Frame.scale, this->ErrorOf(root));
  }

  // root: the step of the tileset's root. up: from the tileset's folder to that of all.
  void PutTile(
    JsonWriter& json, std::size_t s, std::size_t t, std::size_t root, const std::string& up) const
  {
    const Tile& tile = this->Steps[s].tiles[t];
    const bool isElsewhere = s > root && this->BeginsTileset(s);
    json.BeginObject();
    this->PutBox(json, tile.box);
    json.Member("geometricError", this->ErrorOf(tile));
    if (s == root)
    {
      json.Member("refine", "REPLACE");
    }
    if (s == 0)
    {
      this->PutTransform(json);
    }
    if (isElsewhere || tile.shows)
    {
      json.Key("content").BeginObject();
      json.Member("uri", up + FileOf(this->Steps[s], t, isElsewhere ? ".json" : ".glb"));
      json.EndObject();
    }
    const auto [begin, end] = this->ChildrenOf(s, t);
    const auto& next = begin < end ? this->Steps[s + 1].tiles : this->Steps[s].tiles;
    if (!isElsewhere &&
        std::any_of(next.begin() + std::ptrdiff_t(begin), next.begin() + std::ptrdiff_t(end),
          [](const Tile& child) { return child.stays; }))
    {
      json.Key("children").BeginArray();
      for (std::size_t child = begin; child < end; ++child)
      {
        if (next[child].stays)
        {
          this->PutTile(json, s + 1, child, root, up);
        }
      }
      json.EndArray();
    }
    json.EndObject();
  }

  // A little larger, so that no side has no length, and nothing that is rounded lies outside.
  void PutBox(JsonWriter& json, const Box& box) const
  {
    const double margin = std::max(this->Diagonal() * 1e-7, 1e-9);
    std::vector<double> numbers;
    Vec3 half{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      half[k] = (box.hi[k] - box.lo[k]) / 2;
      numbers.push_back(
        (box.lo[k] - this->Frame.origin[k] + half[k]) * this->Frame.scale + 0.0); // no -0
    }
    for (std::size_t k = 0; k < 3; ++k)
    {
      Vec3 axis{};
      axis[k] = half[k] * this->Frame.scale + margin;
      numbers.insert(numbers.end(), axis.begin(), axis.end());
    }
    json.Key("boundingVolume").BeginObject().Member("box", numbers).EndObject();
  }

  // From metres around the middle of the model to where it stands: z up, its front to -y.
  void PutTransform(JsonWriter& json) const
  {
    const Vec3 up = this->Info.homeView.value_or(HomeView{}).up, front = FrontOf(up);
    const std::array<Vec3, 3> axes{ Cross(up, front), Times(front, -1), up };
    const Vec3 middle = Times(this->Frame.origin, this->Frame.scale);
    GlobeMatrix turned{};
    for (std::size_t row = 0; row < 3; ++row)
    {
      for (std::size_t column = 0; column < 3; ++column)
      {
        turned[4 * column + row] = axes[row][column];
      }
      turned[12 + row] = Dot(axes[row], middle);
    }
    turned[15] = 1;
    if (this->Options.origin)
    {
      const GlobeMatrix there = MatrixOfPlace(*this->Options.origin), here = turned;
      for (std::size_t i = 0; i < 16; ++i)
      {
        turned[i] = 0;
        for (std::size_t k = 0; k < 4; ++k)
        {
          turned[i] += there[4 * k + i % 4] * here[i / 4 * 4 + k];
        }
      }
    }
    json.Key("transform").BeginArray();
    for (const double value : turned)
    {
      json.Put(value + 0.0);
    }
    json.EndArray();
  }

  const Store& From;
  const ModelDescription& Info;
  TilesFolder Folder;
  const TilesOptions& Options;
  const Execution& Runs;
  TileFrame Frame;
  std::vector<Step> Steps;           // coarse to fine
  std::vector<BorderNormal> Borders; // of the step that is written
  std::uint64_t AllTiles = 0, Done = 0;
  TilesReport Report;
};

}

Result<TilesReport> ExportTiles(const Store& store, const fs::path& folder,
  const TilesOptions& options, const Execution& execution)
{
  return TilesExport(store, folder, options, execution).Export();
}

}
