#include "filters/store/StoreWriter.h"

#include "filters/store/DeviationList.h"
#include "filters/store/Sqlite.h"
#include "filters/store/StoreSchema.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>

namespace kdstream
{
namespace
{

Error SystemError(const std::string& what)
{
  return { ErrorCode::InputOutput, what + ": " + std::strerror(errno) };
}

// What a store is called until it is whole: ".NAME.XXXXXX" and this.
constexpr std::string_view unfinished = ".unfinished";
constexpr std::size_t randomLetters = 6;

// Removes what writers of this store that were killed have left: theirs are locked by nobody.
void RemoveLeftovers(const std::filesystem::path& folder, const std::string& prefix)
{
  std::error_code ignored;
  std::vector<std::filesystem::path> left;
  for (std::filesystem::directory_iterator entry(folder, ignored), end; entry != end;
       entry.increment(ignored))
  {
    const std::string name = entry->path().filename().string();
    if (name.size() == prefix.size() + randomLetters + unfinished.size() &&
        name.starts_with(prefix) && name.ends_with(unfinished))
    {
      left.push_back(entry->path());
    }
  }
  for (const std::filesystem::path& path : left)
  {
    const int descriptor = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (descriptor >= 0 && ::flock(descriptor, LOCK_EX | LOCK_NB) == 0)
    {
      ::unlink(path.c_str());
    }
    if (descriptor >= 0)
    {
      ::close(descriptor);
    }
  }
}

bool IsLinked(int descriptor)
{
  struct stat state = {};
  return ::fstat(descriptor, &state) == 0 && state.st_nlink > 0;
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
  int lock = -1; // of the temporary file, as long as this process writes it
  ModelDescription info;
  Database database;
  Statement page, piece;
  std::unique_ptr<ContentDigest> digest;
  std::unique_ptr<DeviationList> deviations; // of the resolution that is being written

  ~State()
  {
    this->page = {};
    this->piece = {};
    this->database.reset();
    if (!this->temporary.empty())
    {
      ::unlink(this->temporary.c_str());
    }
    if (this->lock >= 0)
    {
      ::close(this->lock);
    }
  }

  // A new file beside the store, open for SQLite.
  Status MakeTemporary()
  {
    const std::filesystem::path folder =
      this->target.has_parent_path() ? this->target.parent_path() : ".";
    const std::string prefix = "." + this->target.filename().string() + ".";
    RemoveLeftovers(folder, prefix);
    while (this->lock < 0)
    {
      std::string name =
        (folder / (prefix + std::string(randomLetters, 'X') + std::string(unfinished))).string();
      this->lock = ::mkostemps(name.data(), static_cast<int>(unfinished.size()), O_CLOEXEC);
      if (this->lock < 0)
      {
        return SystemError("cannot create a file in " + folder.string());
      }
      ::fchmod(this->lock, 0644);
      // Before it was locked another writer may have taken it for a leftover.
      const bool taken = ::flock(this->lock, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
      if (!taken && IsLinked(this->lock))
      {
        this->temporary = name;
        return {};
      }
      ::unlink(name.c_str());
      ::close(std::exchange(this->lock, -1));
    }
    return {};
  }
};

StoreWriter::StoreWriter(std::unique_ptr<State> state)
  : S(std::move(state))
{
}

StoreWriter::~StoreWriter() = default;

Result<std::unique_ptr<StoreWriter>> StoreWriter::Create(
  const std::filesystem::path& store, ModelDescription info)
{
  auto state = std::make_unique<State>();
  state->target = store;
  state->deviations =
    std::make_unique<DeviationList>(store.has_parent_path() ? store.parent_path() : ".");
  state->digest = std::make_unique<ContentDigest>(info);
  state->info = std::move(info);
  KDSTREAM_TRY(state->MakeTemporary());
  Result<Database> database = OpenForWriting(state->temporary);
  KDSTREAM_TRY(database);
  state->database = std::move(*database);
  // The file is thrown away unless it is finished: no journal, and one fsync at the end.
  const std::string setUp =
    "PRAGMA page_size = 4096; PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF;"
    "PRAGMA application_id = " +
    std::to_string(storeApplicationId) + "; PRAGMA user_version = " + std::to_string(storeVersion) +
    ";" + storeSchema + "BEGIN;";
  KDSTREAM_TRY(Execute(state->database.get(), setUp));
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
  ModelDescription& info = this->S->info;
  ResolutionDescription& resolution =
    piece.id.resolution.IsOriginal() ? info.original : info.levels[piece.id.resolution.Depth()];
  resolution.vertices += piece.ownVertices;
  resolution.bytes += data.size();
  ++resolution.pieces;
  KDSTREAM_TRY(this->S->deviations->Add(piece.deviations));
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

Status StoreWriter::FinishResolution(Resolution resolution, std::uint64_t triangles)
{
  ModelDescription& info = this->S->info;
  ResolutionDescription& finished =
    resolution.IsOriginal() ? info.original : info.levels[resolution.Depth()];
  finished.triangles = triangles;
  const Result<DeviationList::Summary> deviations = this->S->deviations->Finish();
  KDSTREAM_TRY(deviations);
  finished.deviation99 = deviations->at99;
  finished.deviation = deviations->largest;
  return {};
}

Result<ModelDescription> StoreWriter::Finish()
{
  State& state = *this->S;
  state.info.digest = state.digest->Hexadecimal();
  const std::string json = MetadataOf(state.info);
  {
    Result<Statement> insert =
      Statement::Prepare(state.database.get(), "INSERT INTO metadata VALUES ('model', ?, ?)");
    KDSTREAM_TRY(insert);
    insert->Bind(1, json);
    insert->Bind(2, MetadataChecksum("model", json));
    if (const Result<bool> done = insert->Step(); !done)
    {
      return done.GetError();
    }
  }
  KDSTREAM_TRY(Execute(state.database.get(), "COMMIT"));
  state.page = {};
  state.piece = {};
  state.database.reset();
  KDSTREAM_TRY(Sync(state.temporary, O_RDWR));
  if (::rename(state.temporary.c_str(), state.target.c_str()) != 0)
  {
    return SystemError("cannot be put in place");
  }
  state.temporary.clear();
  const std::filesystem::path folder =
    state.target.has_parent_path() ? state.target.parent_path() : ".";
  KDSTREAM_TRY(Sync(folder, O_RDONLY | O_DIRECTORY));
  return state.info;
}

}
