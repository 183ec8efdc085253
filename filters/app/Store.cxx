// SPDX-License-Identifier: BSD-3-Clause
// kdstream-store: prints what is in a store, checks it, and extracts meshes.
// doc/cli.md#kdstream-store describes it.
#include "filters/store/Store.h"
#include "filters/app/ConvertedInput.h"
#include "filters/app/DirectionText.h"
#include "filters/app/ExportStore.h"
#include "filters/app/ExportTiles.h"
#include "filters/app/ExtractMesh.h"
#include "filters/app/ExtractTextured.h"
#include "filters/app/OutputFolders.h"
#include "filters/app/PrintStoreInfo.h"
#include "filters/app/WriteTextured.h"
#include "filters/core/CaughtError.h"
#include "filters/core/MeshDistance.h"
#include "filters/core/VectorMath.h"
#include "filters/core/tree/PieceDepth.h"
#include "filters/files/NewFile.h"
#include "filters/files/WriteWhole.h"
#include "filters/meshio/FileEnding.h"
#include "filters/meshio/MeshWriter.h"
#include "filters/model/ModelJson.h"
#include "filters/model/Units.h"
#include "filters/page/PagePlace.h"
#include "filters/program/Program.h"
#include "filters/program/TbbExecution.h"
#include "filters/store/StoreEdit.h"
#include "filters/store/StoreMesh.h"
#include "filters/store/StoreNotes.h"
#include "filters/tiles/TileGlb.h"
#include "filters/tiles/TileMesh.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

namespace
{

using namespace kdstream;

constexpr const char* description =
  "Describes and checks a store, and extracts meshes, the files of a web server or a tileset for "
  "other viewers from it.";

// Examples at the end of each command's help; the program's help has all of them.
constexpr const char* infoExample = "  kdstream-store info dragon.kds\n";
constexpr const char* verifyExample = "  kdstream-store verify dragon.kds\n";
constexpr const char* extractExamples =
  "  kdstream-store extract dragon.kds --level 12 -o dragon12.ply\n"
  "  kdstream-store extract dragon.kds --region 300 --rings 1 --in-context 12 -o region.vtp\n";
constexpr const char* distanceExample =
  "  kdstream-store distance dragon.kds --level 13 --against dragon.ply\n";
constexpr const char* editExample =
  "  kdstream-store edit dragon.kds --title \"Stanford dragon\" --unit mm\n";

constexpr const char* exportExamples =
  "  kdstream-store export dragon.kds /var/www/scans --page /usr/share/kdstream/web\n"
  "  kdstream-store export dragon.kds tiles --format 3dtiles --origin 13.05,47.8,430\n"
  "  kdstream-store export dragon.kds dragon.glb --format glb --level 14\n";

constexpr const char* formatFiles = "files";
constexpr const char* formatTiles = "3dtiles";
constexpr const char* formatGlb = "glb";

struct CommandLine
{
  std::string store, output, against;
  ExportOptions exported;
  std::string format = formatFiles;
  std::string compression = HasMeshoptCompression() ? "meshopt" : "none";
  std::string normals = "on";
  TilesOptions tiles; // only its member origin is an option
  // Options of export, and the formats for which they are valid.
  std::vector<std::pair<const CLI::Option*, std::string>> ofFormats;
  bool json = false, all = false, quiet = false;
  WantedMesh wanted;
  StoreTexts texts;
};

// Names of the texts that are given, such as "title, credit and unit".
std::string NamesOf(const StoreTexts& texts)
{
  std::vector<std::string> names;
  for (const auto& [name, given] : { std::pair{ "title", texts.title.has_value() },
         { "description", texts.description.has_value() }, { "credit", texts.credit.has_value() },
         { "license", texts.license.has_value() }, { "unit", texts.unit.has_value() },
         { "up", texts.up.has_value() }, { "view", texts.view.has_value() } })
  {
    if (given)
    {
      names.emplace_back(name);
    }
  }
  std::string all;
  for (std::size_t i = 0; i < names.size(); ++i)
  {
    all += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  }
  return all;
}

// The names of arrays that neither a .glb nor an .obj with pictures can hold; "" if there are none.
std::string AttributesWithoutPlace(const std::vector<AttributeInfo>& attributes)
{
  std::string names;
  for (const AttributeInfo& attribute : attributes)
  {
    const AttributeRole role = RoleOf(attribute);
    if (role != AttributeRole::Normals && role != AttributeRole::Colors)
    {
      names += (names.empty() ? "" : ", ") + attribute.name;
    }
  }
  return names;
}

// "1 tile", "2 tiles".
std::string CountOf(std::uint64_t number, const std::string& noun)
{
  return std::to_string(number) + " " + noun + (number == 1 ? "" : "s");
}

class Commands
{
public:
  Commands(const std::string& program, CommandLine& line)
    : Program(program)
    , Line(line)
  {
  }

  int Info()
  {
    return this->WithStore(
      [this](const Store& store)
      {
        std::error_code status;
        const std::uintmax_t bytes = std::filesystem::file_size(this->Line.store, status);
        if (this->Line.json)
        {
          JsonWriter json({ 2 });
          json.BeginObject();
          PutStatistics(json, store.Info(), status ? 0 : bytes);
          json.EndObject();
          std::cout << json.Text() << "\n";
        }
        else
        {
          PrintStoreInfo(store.Info(), status ? 0 : bytes);
        }
        return exitDone;
      });
  }

  int Verify()
  {
    return this->WithStore(
      [this](const Store& store)
      {
        EndAtInterrupts(this->Program, "");
        const std::vector<Error> damage = store.Verify();
        for (const Error& error : damage)
        {
          PrintError(this->Program, this->Line.store, error);
        }
        if (damage.empty())
        {
          std::cout << this->Line.store << ": intact, digest " << store.Info().digest << "\n";
        }
        return damage.empty() ? exitDone : exitFailed;
      });
  }

  int Extract()
  {
    return this->WithStore([this](const Store& store) { return this->Extract(store); });
  }

  int Export()
  {
    for (const auto& [option, formats] : this->Line.ofFormats)
    {
      if (!option->empty() && formats.find(this->Line.format) == std::string::npos)
      {
        return PrintError(this->Program, "",
          { ErrorCode::InvalidArgument, option->get_name() + " cannot be used with --format " +
                                          this->Line.format + ", only with " + formats });
      }
    }
    if (this->Line.format == formatGlb && FileEnding(this->Line.output) != ".glb")
    {
      return PrintError(this->Program, this->Line.output,
        { ErrorCode::InvalidArgument, "does not end in .glb, as a file of --format glb does" });
    }
    if (this->Line.format != formatGlb && FileEnding(this->Line.output) == ".glb")
    {
      return PrintError(this->Program, this->Line.output,
        { ErrorCode::InvalidArgument, "ends in .glb, but --format " + this->Line.format +
                                        " makes a folder: use --format glb" });
    }
    return this->WithStore(
      [this](const Store& store)
      {
        if (this->Line.format == formatGlb)
        {
          return this->ExportGlb(store);
        }
        CatchInterrupts();
        const int exitCode =
          this->Line.format == formatTiles ? this->ExportTiles(store) : this->Export(store);
        ReleaseInterrupts();
        return exitCode;
      });
  }

  int Edit()
  {
    // If the store is a link, its target is replaced, not the link.
    const auto store = CheckOutput(this->Line.store, OutputKind::File, {});
    if (!store)
    {
      return PrintError(this->Program, this->Line.store, store.GetError());
    }
    CatchInterrupts();
    const auto begin = std::chrono::steady_clock::now();
    Result<ModelDescription> edited = Error{};
    {
      ProgressReporter progress(this->Program, this->Line.quiet);
      Execution execution;
      execution.progress = std::ref(progress);
      edited = EditStore(*store, this->Line.texts, execution);
    }
    ReleaseInterrupts();
    if (!edited)
    {
      return PrintError(this->Program, this->Line.store, edited.GetError(), this->Line.store);
    }
    this->TellWritten(this->Line.store, "another " + NamesOf(this->Line.texts), begin);
    return exitDone;
  }

  int Distance()
  {
    return this->WithStore(
      [this](const Store& store)
      {
        CatchInterrupts();
        const int exitCode = this->PrintDistance(store);
        ReleaseInterrupts();
        return exitCode;
      });
  }

private:
  using Moment = std::chrono::steady_clock::time_point;

  void TellWritten(const std::string& file, const std::string& content, Moment begin) const
  {
    if (!this->Line.quiet)
    {
      const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
      PrintWritten(this->Program, file, content, seconds.count());
    }
  }

  int Extract(const Store& store) const
  {
    const auto begin = std::chrono::steady_clock::now();
    const auto output = CheckOutputAndFolders(this->Line.output, this->Line.store);
    if (!output)
    {
      return PrintError(this->Program, this->Line.output, output.GetError(), this->Line.output);
    }
    EndAtInterrupts(this->Program, this->Line.output);
    const Result<WantedPartitions> original = store.Info().textures
                                                ? PartitionsOf(store, this->Line.wanted)
                                                : Result<WantedPartitions>(WantedPartitions{});
    if (!original)
    {
      return PrintError(this->Program, this->Line.store, original.GetError());
    }
    const std::string ending = FileEnding(*output);
    const std::vector<PieceId> textured = this->TexturedPieces(store.Info(), *original);
    const bool withPictures = !textured.empty() && (ending == ".obj" || ending == ".glb");
    const int exitCode = withPictures || ending == ".glb"
                           ? this->ExtractTextured(store, *output, textured, begin)
                           : this->ExtractPlain(store, *output, begin);
    if (exitCode == exitDone && (ending == ".stl" || ending == ".glb") &&
        HasUnused(store, this->Line.wanted))
    {
      this->WarnOfLoss(
        "this format cannot hold " + UnusedText(store.Info()) + "; .ply, .vtp, .obj and .wrl can");
    }
    if (exitCode == exitDone && !original->partitions.empty() && !withPictures)
    {
      this->WarnOfLoss(original->alone
                         ? "this format cannot hold the original's textures; .obj and .glb can"
                         : "the original's textures are left out: they can only be written with "
                           "partitions of the original, without levels");
    }
    return exitCode;
  }

  void WarnOfLoss(const std::string& loss) const
  {
    std::cerr << this->Program << ": warning: " << this->Line.output << ": " << loss << "\n";
  }

  // Makes the folders of the output, and calls `write`, which returns a Status. An interrupt
  // cancels it: from here on there are files to remove. Returns an exit code.
  template <class Write>
  int WriteOutput(const Write& write) const
  {
    CatchInterrupts();
    Result<OutputFolders> folders = OutputFolders::Make(this->Line.output);
    const Status written = folders ? write() : Status{ folders.GetError() };
    ReleaseInterrupts();
    if (!written)
    {
      return PrintError(this->Program, this->Line.output, written.GetError(), this->Line.output);
    }
    folders->Keep();
    return exitDone;
  }

  int ExtractPlain(const Store& store, const std::filesystem::path& output, Moment begin) const
  {
    if (!IsWritable(output))
    {
      return PrintError(this->Program, this->Line.output,
        { ErrorCode::InvalidArgument, "the ending '" + FileEnding(output) +
                                        "' names no format that can be written (.ply, .vtp, .stl, "
                                        ".obj, .wrl, .glb)" });
    }
    Result<Mesh> mesh = ExtractMesh(store, this->Line.wanted);
    const bool withUnused = FileEnding(output) != ".stl" && HasUnused(store, this->Line.wanted);
    const Status added = mesh && withUnused ? AddUnused(store, *mesh) : Status{};
    if (!mesh || !added)
    {
      return PrintError(this->Program, this->Line.store, mesh ? added.GetError() : mesh.GetError());
    }
    const int exitCode =
      this->WriteOutput([&]() { return WriteMesh(output, *mesh, UntilInterrupted()); });
    if (exitCode != exitDone)
    {
      return exitCode;
    }
    for (const std::string& loss : LossesOfFormat(output, *mesh))
    {
      this->WarnOfLoss(loss);
    }
    this->TellWritten(this->Line.output,
      mesh->triangles.empty() ? CountOf(mesh->points.size(), "point")
                              : CountOf(mesh->triangles.size(), "triangle"),
      begin);
    return exitDone;
  }

  // The pieces that the mesh consists of, if they have textures. Nothing unless the mesh consists
  // only of partitions, or only of a level.
  std::vector<PieceId> TexturedPieces(
    const ModelDescription& model, const WantedPartitions& original) const
  {
    std::vector<PieceId> pieces;
    for (std::size_t i = 0; original.alone && i < original.partitions.size(); ++i)
    {
      pieces.push_back(
        PieceOfPartition(Resolution::Original(), original.partitions[i], model.depths));
    }
    const std::optional<unsigned> level = this->Line.wanted.level;
    if (model.textures && model.textures->levels && level && *level <= model.depths.finest)
    {
      const Resolution resolution = Resolution::Level(*level);
      const NodeId first = NodeId{ 1 } << PieceDepth(resolution, model.depths);
      for (NodeId node = first; node < 2 * first; ++node)
      {
        pieces.push_back({ resolution, node });
      }
    }
    return pieces;
  }

  // Writes these pieces with their pictures; if there are no pieces, a .glb without pictures.
  int ExtractTextured(const Store& store, const std::filesystem::path& output,
    const std::vector<PieceId>& textured, Moment begin) const
  {
    Result<TexturedMesh> mesh =
      textured.empty() ? this->MakePlain(store) : kdstream::ExtractTextured(store, textured);
    const bool withUnused = FileEnding(output) == ".obj" && HasUnused(store, this->Line.wanted);
    const Status added = mesh && withUnused ? AddUnused(store, mesh->mesh) : Status{};
    if (!mesh || !added)
    {
      return PrintError(this->Program, this->Line.store, mesh ? added.GetError() : mesh.GetError());
    }
    const Vec3 up = store.Info().homeView.value_or(HomeView{}).up;
    const double metres = MetresOfUnit(store.Info().unit).value_or(1);
    const int exitCode = this->WriteOutput(
      [&]()
      {
        return FileEnding(output) == ".glb"
                 ? WriteGlb(output, *mesh, up, metres, UntilInterrupted())
                 : WriteTexturedObj(output, *mesh, UntilInterrupted());
      });
    if (exitCode != exitDone)
    {
      return exitCode;
    }
    const std::string left = AttributesWithoutPlace(store.Info().attributes);
    if (!left.empty())
    {
      this->WarnOfLoss("this format cannot hold these attributes: " + left);
    }
    if (FileEnding(output) == ".glb")
    {
      this->WarnOfUnit(store.Info());
    }
    this->TellWritten(this->Line.output,
      CountOf(mesh->mesh.triangles.size(), "triangle") +
        (mesh->pictures.empty() ? "" : " and " + CountOf(mesh->pictures.size(), "picture")),
      begin);
    return exitDone;
  }

  // The mesh with one white material.
  Result<TexturedMesh> MakePlain(const Store& store) const
  {
    Result<Mesh> mesh = ExtractMesh(store, this->Line.wanted);
    KDSTREAM_TRY(mesh);
    if (mesh->triangles.empty())
    {
      return Error{ ErrorCode::InvalidArgument,
        "there are no triangles: write points to .ply, .vtp, .obj or .wrl" };
    }
    TexturedMesh plain;
    const std::size_t triangles = mesh->triangles.size();
    plain.mesh = std::move(*mesh);
    plain.corners.assign(
      triangles, { noPictureCoordinate, noPictureCoordinate, noPictureCoordinate });
    plain.materialOf.assign(triangles, 0);
    plain.materials.emplace_back().name = "surface";
    return plain;
  }

  int Export(const Store& store) const
  {
    const auto begin = std::chrono::steady_clock::now();
    ExportOptions options = this->Line.exported;
    if (options.model.empty())
    {
      options.model = std::filesystem::path(this->Line.store).stem().string();
    }
    if (!IsModelId(options.model))
    {
      return PrintError(this->Program, this->Line.store,
        { ErrorCode::InvalidArgument,
          "'" + options.model + "' cannot be a model's name, which must have " +
            std::string(modelIdRule) + "; use --model to give another one" });
    }
    if (!options.page.empty() && !std::filesystem::is_regular_file(options.page / "index.html"))
    {
      return PrintError(this->Program, options.page.string(),
        { ErrorCode::NotFound, "is not a web page: it has no index.html" });
    }
    options.notes = NotesFileOf(this->Line.store);
    Result<ExportReport> report = Error{};
    {
      ProgressReporter progress(this->Program, this->Line.quiet);
      Execution execution;
      execution.progress = std::ref(progress);
      report = ExportStore(store, this->Line.output, options, execution);
    }
    if (!report)
    {
      const Error& error = report.GetError();
      return PrintError(this->Program, error.file.empty() ? this->Line.store : error.file, error);
    }
    if (!this->Line.quiet)
    {
      const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
      std::cerr << this->Program << ": wrote " << CountOf(report->files, "file") << " of "
                << options.model << " to " << this->Line.output << ", " << report->bytes / 1000
                << " kB in " << std::round(seconds.count() * 10) / 10 << " s\n";
    }
    return exitDone;
  }

  TilesOptions WantedTiles() const
  {
    TilesOptions options = this->Line.tiles;
    options.compression = this->Line.compression == "none"    ? TileCompression::None
                          : this->Line.compression == "draco" ? TileCompression::Draco
                                                              : TileCompression::Meshopt;
    options.normals = this->Line.normals == "on";
    return options;
  }

  int ExportTiles(const Store& store) const
  {
    const auto begin = std::chrono::steady_clock::now();
    Result<TilesReport> report = Error{};
    {
      ProgressReporter progress(this->Program, this->Line.quiet);
      Execution execution = MakeTbbExecution(0);
      execution.progress = std::ref(progress);
      report = kdstream::ExportTiles(store, this->Line.output, this->WantedTiles(), execution);
    }
    if (!report)
    {
      return PrintError(this->Program, this->Line.store, report.GetError(), this->Line.output);
    }
    this->WarnOfTileLosses(store.Info());
    this->WarnOfPlace(store.Info());
    if (!this->Line.quiet)
    {
      const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
      std::cerr << this->Program << ": wrote " << CountOf(report->tiles, "tile") << " to "
                << this->Line.output << ", " << report->bytes / 1000 << " kB in "
                << std::round(seconds.count() * 10) / 10 << " s\n";
    }
    return exitDone;
  }

  // Warns about parts of the model that neither a tileset nor a small .glb can hold.
  void WarnOfTileLosses(const ModelDescription& model) const
  {
    std::vector<AttributeInfo> left, rounded;
    for (const AttributeInfo& array : model.attributes)
    {
      const AttributeRole role = RoleOf(array);
      const bool hasPlace = role == AttributeRole::Normals || role == AttributeRole::Colors;
      if (!hasPlace && !IsTileArray(array))
      {
        left.push_back(array);
      }
      else if (!hasPlace && !IsExactInTiles(array))
      {
        rounded.push_back(array);
      }
    }
    if (!left.empty())
    {
      this->WarnOfLoss("this format cannot hold these attributes: " + AttributesWithoutPlace(left));
    }
    if (!rounded.empty())
    {
      this->WarnOfLoss(
        "these attributes are written as floats of 32 bits: " + AttributesWithoutPlace(rounded));
    }
    if (this->Line.compression == "draco" && model.primitive == PrimitiveType::Points)
    {
      this->WarnOfLoss("Draco compresses triangles: the points are not compressed");
    }
    if (model.unused && !this->Line.wanted.level)
    {
      this->WarnOfLoss(
        "this format cannot hold " + UnusedText(model) + "; .ply, .vtp, .obj and .wrl can");
    }
    this->WarnOfUnit(model);
  }

  // Warns about an unknown unit: glTF and 3D Tiles are in metres.
  void WarnOfUnit(const ModelDescription& model) const
  {
    if (!model.unit.empty() && !MetresOfUnit(model.unit))
    {
      this->WarnOfLoss(
        "the unit '" + model.unit + "' is not known: coordinates are written as metres");
    }
  }

  // Makes the mesh; if the level is one piece with a texture, the mesh has the texture too.
  Result<TileMesh> MakeSmallMesh(const Store& store, bool normals) const
  {
    const ModelDescription& model = store.Info();
    const std::vector<PieceId> textured = this->TexturedPieces(model, {});
    if (textured.size() != 1)
    {
      const Result<Mesh> mesh = ExtractMesh(store, this->Line.wanted);
      KDSTREAM_TRY(mesh);
      return WholeTileMesh(*mesh, normals);
    }
    const Result<Piece> piece = store.ReadPiece(textured.front());
    KDSTREAM_TRY(piece);
    const protocol::BlobId name = TextureOfPiece(textured.front(), model.depths);
    const auto blob = store.Read(name);
    KDSTREAM_TRY(blob);
    const Result<TextureTile> tile = DecodeTextureTile(*blob, piece->triangles, piece->positions);
    if (!tile)
    {
      return Error{ ErrorCode::Damaged, BlobName(name) + ": " + tile.GetError().message };
    }
    TileMeshOptions options;
    options.normals = normals;
    return CutTileMesh(*piece, &*tile, options);
  }

  // Warns if the model is far from (0, 0, 0), as with map coordinates. --origin is the place of (0,
  // 0, 0).
  void WarnOfPlace(const ModelDescription& model) const
  {
    constexpr double far = 1e5, mostKilometres = 1e15;
    Vec3 middle{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      middle[k] = model.box.lo[k] / 2 + model.box.hi[k] / 2;
    }
    const double metres = Length(middle) * MetresOfUnit(model.unit).value_or(1);
    if (this->Line.tiles.origin && metres > far)
    {
      const auto kilometres = std::llround(std::min(metres / 1000, mostKilometres));
      this->WarnOfLoss("the model lies " + std::to_string(kilometres) +
                       " km from its point (0, 0, 0), perhaps in map coordinates (UTM). It will "
                       "stand that far from --origin: subtract the map coordinates of --origin "
                       "from the input's");
    }
  }

  // Writes a level, or the original, as one small file.
  int ExportGlb(const Store& store) const
  {
    const auto begin = std::chrono::steady_clock::now();
    const auto output = CheckOutputAndFolders(this->Line.output, this->Line.store);
    if (!output)
    {
      return PrintError(this->Program, this->Line.output, output.GetError(), this->Line.output);
    }
    EndAtInterrupts(this->Program, this->Line.output);
    const TilesOptions options = this->WantedTiles();
    const Result<TileMesh> mesh = this->MakeSmallMesh(store, options.normals);
    if (!mesh)
    {
      return PrintError(this->Program, this->Line.store, mesh.GetError());
    }
    const ModelDescription& model = store.Info();
    const Vec3 up = model.homeView.value_or(HomeView{}).up, front = FrontOf(up);
    TileFrame frame;
    frame.axes = { Cross(up, front), up, front };
    frame.scale = MetresOfUnit(model.unit).value_or(1);
    frame.copyright = model.credit;
    const std::optional<unsigned> level = this->Line.wanted.level;
    if (!model.grid.Lossless())
    {
      frame.latticeStep = model.grid.step * (level ? model.levels[*level].spacing : 1);
      frame.latticeOrigin = model.grid.origin;
    }
    const auto bytes = EncodeTileGlb(*mesh, frame, options.compression);
    if (!bytes)
    {
      return PrintError(this->Program, this->Line.output, bytes.GetError());
    }
    const int exitCode = this->WriteOutput(
      [&]()
      {
        NewFile::RemoveLeftovers(*output);
        return WriteWhole(*output, *bytes);
      });
    if (exitCode != exitDone)
    {
      return exitCode;
    }
    this->WarnOfTileLosses(model);
    if (model.textures && model.textures->levels && level && mesh->picture.empty())
    {
      this->WarnOfLoss("the level's textures are left out: kdstream-store extract --level " +
                       std::to_string(*level) + " -o OUT.glb has them");
    }
    if (model.textures && !level)
    {
      this->WarnOfLoss("the original's textures are left out: kdstream-store extract --all -o "
                       "OUT.glb has them");
    }
    this->TellWritten(this->Line.output,
      mesh->triangles.empty() ? CountOf(mesh->points.size(), "point")
                              : CountOf(mesh->triangles.size(), "triangle"),
      begin);
    return exitDone;
  }

  int PrintDistance(const Store& store) const
  {
    const Result<Mesh> level = ExtractMesh(store, this->Line.wanted);
    if (!level)
    {
      return PrintError(this->Program, this->Line.store, level.GetError());
    }
    Result<MeshDistance> distance = Error{};
    bool isCloud = false;
    {
      ProgressReporter progress(this->Program, this->Line.quiet);
      Execution execution = MakeTbbExecution(0);
      execution.progress = std::ref(progress);
      const Result<Mesh> mesh = ReadAnyMesh(this->Line.against, execution);
      distance = mesh ? MeasureDistance(*mesh, *level, {}, execution)
                      : Result<MeshDistance>(mesh.GetError());
      isCloud = mesh && mesh->triangles.empty();
    }
    if (!distance)
    {
      return PrintError(this->Program, this->Line.against, distance.GetError());
    }
    if (isCloud)
    {
      this->WarnOfPoints(this->Line.against + ":");
    }
    if (level->triangles.empty())
    {
      this->WarnOfPoints(this->Line.store + ": level " + std::to_string(*this->Line.wanted.level));
    }
    this->PrintDistance(*distance);
    return exitDone;
  }

  // Warns if a mesh has no triangles: users expect distances between surfaces.
  void WarnOfPoints(const std::string& what) const
  {
    std::cerr
      << this->Program << ": warning: " << what
      << " has no triangles: distances are measured from its points and to its nearest point\n";
  }

  void PrintDistance(const MeshDistance& distance) const
  {
    if (this->Line.json)
    {
      JsonWriter json({ 2 });
      json.BeginObject()
        .Member("rms_forward", distance.rmsForward)
        .Member("rms_backward", distance.rmsBackward)
        .Member("hausdorff", distance.hausdorff)
        .Member("diagonal", distance.diagonal)
        .EndObject();
      std::cout << json.Text() << "\n";
      return;
    }
    const auto line = [&](const char* name, double value)
    {
      const double percent = distance.diagonal > 0 ? 100 * value / distance.diagonal : 0;
      std::printf("%-21s%.6g (%.4f %% of the diagonal)\n", name, value, percent);
    };
    line("RMS to the level", distance.rmsForward);
    line("RMS from the level", distance.rmsBackward);
    line("Hausdorff distance", distance.hausdorff);
    std::printf("%-21s%.6g\n", "diagonal", distance.diagonal);
  }

  template <class Work>
  int WithStore(const Work& work)
  {
    const Result<std::shared_ptr<Store>> store = Store::Open(this->Line.store);
    return store ? work(**store) : PrintError(this->Program, this->Line.store, store.GetError());
  }

  std::string Program;
  CommandLine& Line;
};

void AddExtract(CLI::App& extract, CommandLine& line)
{
  extract.add_option("STORE", line.store, "the store")->required();
  auto* what = extract.add_option_group("WHAT", "exactly one of");
  what->add_option("--level", line.wanted.level, "all of level D")->type_name("D");
  what->add_option("--partition", line.wanted.partition, "partition I of the original")
    ->type_name("I");
  auto* region =
    what->add_option("--region", line.wanted.region, "the partitions around node CELL of the tree")
      ->type_name("CELL");
  what->add_flag("--all", line.all, "all partitions: the original, if the store is lossless");
  what
    ->add_option("--resolutions", line.wanted.resolutions,
      "one surface of mixed resolutions: a JSON list with one entry per partition, either a depth "
      "from the stitch depth on or \"original\"; or an object with a base level and finer pieces")
    ->type_name("FILE");
  what->require_option(1);
  const char* const regions = "Region";
  auto* rings =
    extract
      .add_option("--rings", line.wanted.rings, "radius of the region, in side lengths of a cell")
      ->check(CLI::Range(0U, 1000U))
      ->capture_default_str()
      ->group(regions);
  auto* context = extract
                    .add_option("--in-context", line.wanted.inContext,
                      "join it with level D around it to one surface")
                    ->type_name("D")
                    ->group(regions);
  rings->needs(region);
  context->needs(region);
  extract
    .add_option("-o,--output", line.output,
      "mesh to write: .ply, .vtp, .stl, .obj, .wrl or .glb; .obj and .glb include the textures of "
      "partitions or a level")
    ->type_name("OUT")
    ->required()
    ->group("Output");
  extract.add_flag("--quiet", line.quiet, "print no summary")->group("Output");
  extract.footer(std::string("Examples:\n") + extractExamples);
}

void AddExport(CLI::App& exported, CommandLine& line)
{
  exported.add_option("STORE", line.store, "the store")->required();
  exported
    .add_option("DIR", line.output,
      "files: the folder to write to, other models in it are kept; 3dtiles: a new folder; glb: the "
      "file to write")
    ->required();
  exported
    .add_option("--format", line.format,
      "files of KdStream's own viewers, a tileset of 3D Tiles 1.1 (Cesium, three.js and others), "
      "or one small glTF")
    ->check(CLI::IsMember({ formatFiles, formatTiles, formatGlb }))
    ->capture_default_str();
  const char* const files = "Files";
  const auto only = [&line](CLI::Option* option, const char* formats)
  { line.ofFormats.emplace_back(option, formats); };
  only(exported
         .add_option("--model", line.exported.model,
           "name of the model for viewers [default: the store's name]")
         ->type_name("ID")
         ->group(files),
    formatFiles);
  auto* const page =
    exported
      .add_option("--page", line.exported.page,
        "also copy the viewer's web page from this folder, and make a page for the model, m/ID")
      ->type_name("WEB")
      ->group(files);
  only(page, formatFiles);
  only(
    exported
      .add_option("--address", line.exported.address,
        "where DIR will be on the web, for messengers and search engines, which need whole "
        "addresses, such as https://example.org/scans")
      ->check(
        [](const std::string& text) -> std::string
        {
          return IsPageRoot(text) ? ""
                                  : "\"" + text +
                                      "\" is not an address such as "
                                      "https://example.org/scans";
        })
      ->transform([](const std::string& text) { return text.ends_with('/') ? text : text + "/"; })
      ->needs(page)
      ->type_name("URL")
      ->group(files),
    formatFiles);
  const char* const tiles = "3dtiles and glb";
  only(exported
         .add_option("--compression", line.compression,
           "compression of the .glb files: meshopt (EXT_meshopt_compression, 16 bits a "
           "coordinate), draco "
           "(KHR_draco_mesh_compression; not of points), or none")
         ->check(CLI::IsMember({ "meshopt", "draco", "none" }))
         ->capture_default_str()
         ->group(tiles),
    "3dtiles and glb");
  only(exported
         .add_option("--normals", line.normals, "write normals; without them viewers show facets")
         ->check(CLI::IsMember({ "on", "off" }))
         ->capture_default_str()
         ->group(tiles),
    "3dtiles and glb");
  only(
    exported
      .add_option_function<std::string>(
        "--origin", [&line](const std::string& text) { line.tiles.origin = ParseGlobePlace(text); },
        "3dtiles: where the point (0, 0, 0) of the model stands on the globe, in degrees and "
        "metres "
        "above the ellipsoid; the heading turns it clockwise")
      ->check(
        [](const std::string& text) -> std::string
        {
          return MayHaveDecimalCommas(text)
                   ? "\"" + text +
                       "\" may be two numbers with decimal commas: write decimal points, such "
                       "as 13.05,47.8,430"
                 : ParseGlobePlace(text)
                   ? ""
                   : "\"" + text +
                       "\" is not a place: give longitude (-180 to 180), "
                       "latitude (-90 to 90), height and, where needed, heading, "
                       "such as 13.05,47.8,430";
        })
      ->type_name("LON,LAT,HEIGHT[,HEADING]")
      ->group(tiles),
    formatTiles);
  only(exported.add_option("--level", line.wanted.level, "glb: level D [default: the original]")
         ->type_name("D")
         ->group(tiles),
    formatGlb);
  exported.add_flag("--quiet", line.quiet, "print no progress and no summary")->group("Output");
  exported.footer(std::string("Examples:\n") + exportExamples);
}

void AddEdit(CLI::App& edit, CommandLine& line)
{
  edit.add_option("STORE", line.store, "the store")->required();
  auto* texts = edit.add_option_group("TEXTS", "at least one of; an empty text removes it");
  CheckText(texts->add_option("--title", line.texts.title, "title of the model"));
  CheckText(
    texts->add_option("--description", line.texts.description, "a few lines about the model"));
  CheckText(texts->add_option("--credit", line.texts.credit, "who made or scanned it"));
  const std::string license = "terms of use";
  CheckText(texts->add_option("--license", line.texts.license, license));
  // An alternative spelling is also accepted.
  CheckText(texts->add_option("--licence", line.texts.license, license))->group("");
  CheckText(texts->add_option("--unit", line.texts.unit, "unit of the coordinates, such as mm"));
  AddDirectionOption(*texts, "--up", line.texts.up, "upward direction");
  AddDirectionOption(*texts, "--view", line.texts.view,
    "initial view: direction from the model's centre to the eye");
  texts->require_option(1, 0);
  edit.add_flag("--quiet", line.quiet, "print no progress and no summary")->group("Output");
  edit.footer(std::string("Example:\n") + editExample);
}

void AddDistance(CLI::App& distance, CommandLine& line)
{
  distance.add_option("STORE", line.store, "the store")->required();
  const char* const compared = "Meshes to compare";
  distance.add_option("--level", line.wanted.level, "level D of the store")
    ->type_name("D")
    ->required()
    ->group(compared);
  distance
    .add_option(
      "--against", line.against, "mesh to compare it with, in any format that kdstream-build reads")
    ->type_name("MESH")
    ->required()
    ->group(compared);
  const char* const output = "Output";
  distance
    .add_flag("--json", line.json,
      "print JSON: rms_forward (from the mesh to the level), rms_backward, hausdorff, diagonal")
    ->group(output);
  distance.add_flag("--quiet", line.quiet, "print no progress")->group(output);
  distance.footer(std::string("Example:\n") + distanceExample);
}

}

int main(int argc, char** argv)
try
{
  CommandLine line;
  CLI::App app(description, "kdstream-store");
  app.require_subcommand(1);
  app.footer(std::string("Examples:\n") + infoExample + verifyExample + extractExamples +
             distanceExample + editExample + exportExamples);
  CLI::App* info = app.add_subcommand("info", "prints what the store contains");
  info->add_option("STORE", line.store, "the store")->required();
  info->add_flag("--json", line.json, "print JSON")->group("Output");
  info->footer(std::string("Example:\n") + infoExample);
  CLI::App* verify =
    app.add_subcommand("verify", "reads and checks the whole store, and reports what is damaged");
  verify->add_option("STORE", line.store, "the store")->required();
  verify->footer(std::string("Example:\n") + verifyExample);
  CLI::App* extract = app.add_subcommand("extract", "extracts a mesh from the store");
  AddExtract(*extract, line);
  CLI::App* distance = app.add_subcommand("distance",
    "measures the distance between a level and a mesh, with 100,000 samples in each direction");
  AddDistance(*distance, line);
  CLI::App* edit = app.add_subcommand("edit",
    "changes the title and other texts that viewers show, but not the content and its "
    "digest. A running server shows the new texts after about 2 seconds");
  AddEdit(*edit, line);
  CLI::App* exported =
    app.add_subcommand("export", "writes the files that a plain web server (nginx, Apache, object "
                                 "storage) needs to serve the model, or a tileset for other "
                                 "viewers");
  AddExport(*exported, line);
  return RunProgram(app, argc, argv,
    [&]()
    {
      Commands commands(app.get_name(), line);
      return info->parsed()       ? commands.Info()
             : verify->parsed()   ? commands.Verify()
             : distance->parsed() ? commands.Distance()
             : edit->parsed()     ? commands.Edit()
             : exported->parsed() ? commands.Export()
                                  : commands.Extract();
    });
}
catch (...) // memory ran out before the work began
{
  return kdstream::PrintError("kdstream-store", "", kdstream::CaughtError());
}
