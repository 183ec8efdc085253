#include "filters/store/StoreWriter.h"

#include "filters/store/Sqlite.h"
#include "filters/store/StoreSchema.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace kdstream
{
namespace
{

Error SystemError(const std::string& what)
{
  return { ErrorCode::InputOutput, what + ": " + std::strerror(errno) };
}

Status Sync(const std::filesystem::path& path, int flags)
{
  const int descriptor = ::open(path.c_str(), flags);
  if (descriptor < 0)
  {
    return SystemError("cannot open to make durable");
  }
  const bool synced = ::fsync(descriptor) == 0;
  const Error error = SystemError("cannot make durable");
  ::close(descriptor);
  return synced ? Status{} : Status{ error };
}

}

struct StoreWriter::State
{
  std::filesystem::path target, temporary;
  StoreInfo info;
  Database database;
  Statement page, piece;
  std::unique_ptr<ContentDigest> digest;
  std::vector<float> deviations; // of the resolution that is being written

  ~State()
  {
    this->page = {};
    this->piece = {};
    this->database.reset();
    if (!this->temporary.empty())
    {
      ::unlink(this->temporary.c_str());
    }
  }

  // A new file beside the store, open for SQLite.
  Status MakeTemporary()
  {
    const std::filesystem::path folder =
      this->target.has_parent_path() ? this->target.parent_path() : ".";
    std::string name = (folder / ("." + this->target.filename().string() + ".XXXXXX")).string();
    const int descriptor = ::mkstemp(name.data());
    if (descriptor < 0)
    {
      return SystemError("cannot create a file in " + folder.string());
    }
    ::fchmod(descriptor, 0644);
    ::close(descriptor);
    this->temporary = name;
    return {};
  }
};

StoreWriter::StoreWriter(std::unique_ptr<State> state)
  : S(std::move(state))
{
}

StoreWriter::~StoreWriter() = default;

Result<std::unique_ptr<StoreWriter>> StoreWriter::Create(
  const std::filesystem::path& store, StoreInfo info)
{
  auto state = std::make_unique<State>();
  state->target = store;
  state->digest = std::make_unique<ContentDigest>(info);
  state->info = std::move(info);
  if (Status status = state->MakeTemporary(); !status)
  {
    return status.GetError();
  }
  Result<Database> database = OpenForWriting(state->temporary);
  if (!database)
  {
    return database.GetError();
  }
  state->database = std::move(*database);
  // The file is thrown away unless it is finished: no journal, and one fsync at the end.
  const std::string setUp =
    "PRAGMA page_size = 4096; PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF;"
    "PRAGMA application_id = " +
    std::to_string(storeApplicationId) + "; PRAGMA user_version = " + std::to_string(storeVersion) +
    ";" + storeSchema + "BEGIN;";
  if (Status status = Execute(state->database.get(), setUp); !status)
  {
    return status.GetError();
  }
  Result<Statement> page =
    Statement::Prepare(state->database.get(), "INSERT INTO tree VALUES (?, ?, ?)");
  Result<Statement> piece =
    Statement::Prepare(state->database.get(), "INSERT INTO pieces VALUES (?, ?, ?, ?, ?, ?, ?)");
  if (!page || !piece)
  {
    return (page ? piece : page).GetError();
  }
  state->page = std::move(*page);
  state->piece = std::move(*piece);
  return std::unique_ptr<StoreWriter>(new StoreWriter(std::move(state)));
}

Status StoreWriter::AddTreePage(NodeId page, std::span<const std::uint8_t> data)
{
  this->S->digest->AddTreePage(page, data);
  Statement& insert = this->S->page;
  insert.Bind(1, std::int64_t{ page });
  insert.Bind(2, data);
  insert.Bind(3, TreePageChecksum(page, data));
  const Result<bool> done = insert.Step();
  insert.Reset();
  return done ? Status{} : Status{ done.GetError() };
}

Status StoreWriter::AddPiece(const Piece& piece, std::span<const std::uint8_t> data)
{
  StoreInfo& info = this->S->info;
  ResolutionInfo& resolution =
    piece.id.resolution.IsOriginal() ? info.original : info.levels[piece.id.resolution.Depth()];
  resolution.vertices += piece.ownVertices;
  resolution.bytes += data.size();
  ++resolution.pieces;
  this->S->deviations.insert(
    this->S->deviations.end(), piece.deviations.begin(), piece.deviations.end());
  this->S->digest->AddPiece(piece.id, data);
  const std::int64_t row = PieceRow(piece.id);
  Statement& insert = this->S->piece;
  insert.Bind(1, row);
  insert.Bind(2, row >> 32);
  insert.Bind(3, std::int64_t{ piece.id.node });
  insert.Bind(4, std::int64_t{ piece.ownVertices });
  insert.Bind(5, static_cast<std::int64_t>(piece.triangles.size()));
  insert.Bind(6, data);
  insert.Bind(7, PieceChecksum(piece.id, piece.ownVertices, piece.triangles.size(), data));
  const Result<bool> done = insert.Step();
  insert.Reset();
  return done ? Status{} : Status{ done.GetError() };
}

void StoreWriter::FinishResolution(Resolution resolution, std::uint64_t triangles)
{
  StoreInfo& info = this->S->info;
  ResolutionInfo& finished =
    resolution.IsOriginal() ? info.original : info.levels[resolution.Depth()];
  finished.triangles = triangles;
  std::vector<float>& deviations = this->S->deviations;
  if (!deviations.empty())
  {
    const auto at99 =
      deviations.begin() + static_cast<std::ptrdiff_t>((deviations.size() - 1) * 99 / 100);
    std::nth_element(deviations.begin(), at99, deviations.end());
    finished.deviation99 = *at99;
    finished.deviation = *std::max_element(at99, deviations.end());
    deviations.clear();
  }
}

Result<StoreInfo> StoreWriter::Finish()
{
  State& state = *this->S;
  state.info.digest = state.digest->Hexadecimal();
  const std::string json = StoreInfoToJson(state.info);
  {
    Result<Statement> insert =
      Statement::Prepare(state.database.get(), "INSERT INTO metadata VALUES ('model', ?, ?)");
    if (!insert)
    {
      return insert.GetError();
    }
    insert->Bind(1, json);
    insert->Bind(2, MetadataChecksum("model", json));
    if (const Result<bool> done = insert->Step(); !done)
    {
      return done.GetError();
    }
  }
  if (Status status = Execute(state.database.get(), "COMMIT"); !status)
  {
    return status.GetError();
  }
  state.page = {};
  state.piece = {};
  state.database.reset();
  if (Status status = Sync(state.temporary, O_RDWR); !status)
  {
    return status.GetError();
  }
  if (::rename(state.temporary.c_str(), state.target.c_str()) != 0)
  {
    return SystemError("cannot be put in place");
  }
  state.temporary.clear();
  const std::filesystem::path folder =
    state.target.has_parent_path() ? state.target.parent_path() : ".";
  if (Status status = Sync(folder, O_RDONLY | O_DIRECTORY); !status)
  {
    return status.GetError();
  }
  return state.info;
}

}
