// SPDX-License-Identifier: BSD-3-Clause
#include "filters/app/ExportStore.h"

#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/TreePage.h"
#include "filters/core/SystemReason.h"
#include "filters/files/Folders.h"
#include "filters/files/RandomLetters.h"
#include "filters/files/WriteWhole.h"
#include "filters/model/ModelJson.h"
#include "filters/store/StoreNotes.h"
#include "server/protocol/ResourcePath.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace kdstream
{
namespace
{

namespace fs = std::filesystem;

// Where a text has @, what pages may load.
std::string WithPolicy(std::string text)
{
  for (auto at = text.find('@'); at != text.npos; at = text.find('@'))
  {
    text.replace(at, 1, protocol::pagePolicy);
  }
  return text;
}

// nginx takes the headers of an outer block where an inner one has none of its own.
constexpr const char* nginxRules =
  R"(# Include this in a server { } whose root is this folder.
gzip_static on;
gzip_vary on;
add_header Cache-Control no-cache;
add_header X-Content-Type-Options nosniff;
add_header Content-Security-Policy "@";
add_header Referrer-Policy same-origin;
location ~ ^/kdstream(-more)?\.wasm$ {
  types { application/wasm wasm; }
}
location = /kdstream.nginx.conf { return 404; }
location = /.htaccess { return 404; }
location = /api { return 404; }
location = /api/models { rewrite ^ /api/models.json last; }
location /api/ {
  # Folders are nothing that can be asked for.
  try_files $uri =404;
  add_header Cache-Control no-cache;
  add_header X-Content-Type-Options nosniff;
  # Pages of other sites may read the models. Drop these lines if they may not.
  add_header Access-Control-Allow-Origin *;
  types { application/json json; }
  default_type application/octet-stream;
  # A path with a digest never changes its content.
  location ~ "^/api/models/[^/]+/[0-9a-f]{32}/" {
    try_files $uri =404;
    add_header Cache-Control "public, max-age=31536000, immutable";
    add_header X-Content-Type-Options nosniff;
    add_header Access-Control-Allow-Origin *;
    types { }
    default_type application/octet-stream;
  }
}
)";

// Nothing but what AllowOverride FileInfo allows: for anything else Apache would answer nothing.
constexpr const char* apacheRules =
  R"(AddType application/wasm .wasm
AddType application/json .json
# What is compressed already: FILE.gz is sent for FILE to whom takes it.
RemoveType .gz
AddEncoding gzip .gz
<IfModule mod_rewrite.c>
  RewriteEngine On
  # Folders, and what this host is told by, are nothing that can be asked for.
  RewriteRule ^(kdstream\.nginx\.conf|\.htaccess)$ - [R=404,L]
  RewriteRule ^api/models$ %{REQUEST_URI}.json [R=302,L]
  RewriteCond %{REQUEST_FILENAME} -d
  RewriteRule ^api(/|$) - [R=404,L]
  RewriteCond %{HTTP:Accept-Encoding} gzip
  RewriteCond %{REQUEST_FILENAME}.gz -f
  RewriteRule ^(.+)$ $1.gz [L]
</IfModule>
<IfModule mod_headers.c>
  Header set Cache-Control "no-cache"
  Header set X-Content-Type-Options nosniff
  Header merge Vary Accept-Encoding
  <If "%{REQUEST_URI} =~ m#/api/#">
    # Pages of other sites may read the models. Drop this line if they may not.
    Header set Access-Control-Allow-Origin "*"
  </If>
  <Else>
    Header set Content-Security-Policy "@"
    Header set Referrer-Policy same-origin
  </Else>
  # A path with a digest never changes its content.
  <If "%{REQUEST_URI} =~ m#/api/models/[^/]+/[0-9a-f]{32}/#">
    Header set Cache-Control "public, max-age=31536000, immutable"
    Header unset Vary
    ForceType application/octet-stream
  </If>
</IfModule>
)";

// A folder for files on their way up: hidden, of a random name, and its owner's alone, so that
// nobody has put anything into it. Locked, as long as this process fills it.
class HiddenFolder
{
public:
  // Removes what calls that were killed have left of `target`. Also of versions that did not use
  // random letters.
  static void RemoveLeftovers(const fs::path& target)
  {
    const auto parent = target.parent_path();
    const auto begin = BeginOf(target);
    std::vector<fs::path> left;
    const auto names = NamesIn(parent);
    for (const std::string& name : names ? *names : std::vector<std::string>())
    {
      const bool isPlain = name.size() + 1 == begin.size() + ending.size();
      if ((isPlain || name.size() == begin.size() + randomLetters + ending.size()) &&
          name.starts_with(begin) && name.ends_with(ending))
      {
        left.push_back(parent / name);
      }
    }
    for (const fs::path& path : left)
    {
      const int lock = Open(path);
      struct stat state = {};
      if (lock >= 0 && ::fstat(lock, &state) == 0 && state.st_uid == ::geteuid() &&
          ::flock(lock, LOCK_EX | LOCK_NB) == 0)
      {
        RemoveTree(path);
      }
      Close(lock);
    }
  }

  // For what is to become `target`.
  Status Make(const fs::path& target)
  {
    const auto begin = BeginOf(target);
    for (;;)
    {
      fs::path place = target.parent_path() / (begin + RandomLetters() + std::string(ending));
      if (::mkdir(place.c_str(), S_IRWXU) != 0)
      {
        if (errno == EEXIST)
        {
          continue;
        }
        return SystemError("cannot be written", errno, target.string());
      }
      const int lock = Open(place);
      struct stat state = {};
      const bool isKnown = lock >= 0 && ::fstat(lock, &state) == 0;
      const int reason = errno;
      // Before it was locked another call may have taken it for a leftover.
      const bool isTaken =
        lock >= 0 && ::flock(lock, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
      if (isKnown && !isTaken && state.st_nlink > 0)
      {
        this->Place = std::move(place); // not copied: memory may have run out
        this->Lock = lock;
        return {};
      }
      Close(lock);
      if (!isKnown && reason != ENOENT)
      {
        ::rmdir(place.c_str());
        return SystemError("cannot be written", reason, target.string());
      }
    }
  }
  HiddenFolder() = default;
  ~HiddenFolder()
  {
    if (!this->Place.empty())
    {
      RemoveTree(this->Place);
    }
    Close(this->Lock);
  }
  HiddenFolder(const HiddenFolder&) = delete;
  HiddenFolder& operator=(const HiddenFolder&) = delete;

  const fs::path& Path() const { return this->Place; }

private:
  static constexpr std::string_view ending = ".new";

  static std::string BeginOf(const fs::path& target)
  {
    return "." + target.filename().string() + ".";
  }
  static int Open(const fs::path& folder)
  {
    return ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  }
  static void Close(int descriptor)
  {
    if (descriptor >= 0)
    {
      ::close(descriptor);
    }
  }
  fs::path Place;
  int Lock = -1;
};

// A folder that goes up whole or not at all: what belongs into it is written into a hidden one
// beside it, waited for, and takes its name at the end, or is removed. A folder that is up already
// stays where it is.
class NewFolder
{
public:
  explicit NewFolder(fs::path folder)
    : Folder(std::move(folder))
    , Place(this->Folder)
  {
  }
  Status Make()
  {
    std::error_code failure;
    if (fs::exists(this->Folder, failure))
    {
      return {};
    }
    const auto parent = this->Folder.parent_path();
    for (auto above = parent; !above.empty() && !fs::exists(above, failure);
         above = above.parent_path())
    {
      this->Made.push_back(above);
    }
    fs::create_directories(parent, failure);
    KDSTREAM_TRY(this->Hidden.Make(this->Folder));
    this->Place = this->Hidden.Path() / this->Folder.filename();
    return ::mkdir(this->Place.c_str(), 0777) == 0 // less the umask, as it stays
             ? Status{}
             : Status{ SystemError("cannot be written", errno, this->Folder.string()) };
  }
  ~NewFolder()
  {
    std::error_code failure;
    if (!this->Hidden.Path().empty())
    {
      RemoveTree(this->Hidden.Path());
    }
    for (const auto& parent : this->Made)
    {
      fs::remove(parent, failure); // where nothing else has come into it
    }
  }
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  bool IsUp() const { return this->Place == this->Folder; }
  bool Holds(const fs::path& file) const
  {
    return std::mismatch(this->Folder.begin(), this->Folder.end(), file.begin(), file.end())
             .first == this->Folder.end();
  }
  const fs::path& Name() const { return this->Folder; }
  fs::path PlaceOf(const fs::path& file) const
  {
    return this->Place / file.lexically_relative(this->Folder);
  }
  Status GoUp()
  {
    if (this->IsUp())
    {
      return {};
    }
    KDSTREAM_TRY(SyncTree(this->Place));
    std::error_code failure;
    fs::rename(this->Place, this->Folder, failure);
    if (failure)
    {
      return SystemError("cannot be written", failure.value(), this->Folder.string());
    }
    this->Place = this->Folder;
    KDSTREAM_TRY(SyncFolder(this->Folder.parent_path()));
    for (const auto& parent : this->Made)
    {
      KDSTREAM_TRY(SyncFolder(parent.has_parent_path() ? parent.parent_path() : "."));
    }
    return {};
  }

private:
  fs::path Folder, Place;
  std::vector<fs::path> Made; // by this, the innermost first
  HiddenFolder Hidden;
};

// Of a model's files: of all, or of those with another digest than what is up.
fs::path NewPartOf(const fs::path& all, const std::string& digest)
{
  std::error_code failure;
  return fs::exists(all, failure) ? all / digest : all;
}

// Writes files below a folder, and counts them.
class Writer
{
public:
  // part: of the folder, and not up before the rest.
  Writer(fs::path folder, const NewFolder& part, const Execution& execution)
    : Folder(std::move(folder))
    , Part(part)
    , Runs(execution)
  {
  }

  ExportReport Report;

  // path: of the protocol, "/api/…". Another file in its place is replaced at once, or not at all.
  Status Put(const std::string& path, std::string_view bytes)
  {
    const fs::path file = this->PlaceOf(path);
    std::error_code failure;
    fs::create_directories(file.parent_path(), failure);
    // What is not up is waited for all at once.
    const bool goesUp = !this->Part.IsUp() && this->Part.Holds(this->Folder / path.substr(1));
    KDSTREAM_TRY(goesUp ? WriteAnew(file, bytes) : WriteWhole(file, bytes));
    ++this->Report.files;
    this->Report.bytes += bytes.size();
    return {};
  }

  Status PutText(const std::string& path, const std::string& text)
  {
    KDSTREAM_TRY(this->Put(path, text));
    const auto small = Compressed(text);
    KDSTREAM_TRY(small);
    return this->Put(path + ".gz", *small);
  }

  // What is there already should be the same, since its path has the digest: it is compared.
  template <class Read>
  Status PutBlob(const std::string& path, const Read& read)
  {
    const auto blob = read();
    KDSTREAM_TRY(blob);
    const std::string_view bytes(reinterpret_cast<const char*>(blob->data()), blob->size());
    return HasBytes(this->PlaceOf(path), bytes) ? Status{} : this->Put(path, bytes);
  }

  Status RemoveText(const std::string& path)
  {
    const std::string file = this->PlaceOf(path).string();
    for (const std::string& each : { file, file + ".gz" })
    {
      std::error_code failure;
      fs::remove(each, failure);
      if (failure)
      {
        return SystemError("cannot be removed", failure.value(), each);
      }
    }
    return {};
  }

  Status Tell(std::size_t done, std::size_t all) const
  {
    return this->Runs.Report("export", static_cast<double>(done) / static_cast<double>(all));
  }

private:
  static Result<std::string> Compressed(const std::string& text)
  {
    z_stream stream{};
    constexpr int gzip = 16; // beside the bits of the window
    if (deflateInit2(
          &stream, Z_BEST_COMPRESSION, Z_DEFLATED, MAX_WBITS + gzip, 9, Z_DEFAULT_STRATEGY) != Z_OK)
    {
      return Error{ ErrorCode::LimitExceeded, "there is no memory for compressing" };
    }
    std::string small(deflateBound(&stream, text.size()), '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
    stream.avail_in = static_cast<uInt>(text.size());
    stream.next_out = reinterpret_cast<Bytef*>(small.data());
    stream.avail_out = static_cast<uInt>(small.size());
    deflate(&stream, Z_FINISH); // cannot fail: all of it has room
    small.resize(stream.total_out);
    deflateEnd(&stream);
    return small;
  }

  fs::path PlaceOf(const std::string& path) const
  {
    const fs::path file = this->Folder / path.substr(1);
    return this->Part.Holds(file) ? this->Part.PlaceOf(file) : file;
  }

  fs::path Folder;
  const NewFolder& Part;
  const Execution& Runs;
};

protocol::BlobId BlobOf(PieceId piece, const TreeDepths& depths)
{
  return piece.resolution.IsOriginal()
           ? protocol::BlobId::Partition(piece.node - (NodeId{ 1 } << depths.partition))
           : protocol::BlobId::LevelPiece(
               static_cast<std::uint8_t>(piece.resolution.Depth()), piece.node);
}

Status PutBlobs(const Store& store, const std::string& model, Writer& writer)
{
  const ModelDescription& info = store.Info();
  const auto pathOf = [&](const protocol::BlobId& blob)
  { return protocol::BlobPath(model, info.digest, blob); };
  const std::vector<PieceId> pieces = store.PieceIds();
  const std::vector<NodeId> pages = TreePages(info.depths);
  const std::vector<NodeId> boxes = AllPartitionBoxes(info.depths);
  const std::uint64_t textures = info.textures ? info.partitions : 0;
  const std::size_t all = pieces.size() + pages.size() + boxes.size() + textures;
  std::size_t done = 0;
  for (const PieceId piece : pieces)
  {
    KDSTREAM_TRY(writer.Tell(done++, all));
    KDSTREAM_TRY(writer.PutBlob(
      pathOf(BlobOf(piece, info.depths)), [&] { return store.ReadPieceBlob(piece); }));
  }
  for (std::uint32_t p = 0; info.textures && p < info.partitions; ++p)
  {
    KDSTREAM_TRY(writer.Tell(done++, all));
    KDSTREAM_TRY(writer.PutBlob(
      pathOf(protocol::BlobId::Texture(p)), [&] { return store.ReadTextureBlob(p); }));
  }
  for (const NodeId page : pages)
  {
    KDSTREAM_TRY(writer.Tell(done++, all));
    KDSTREAM_TRY(writer.PutBlob(
      pathOf(protocol::BlobId::TreePage(page)), [&] { return store.ReadTreePageBlob(page); }));
  }
  for (const NodeId node : boxes)
  {
    KDSTREAM_TRY(writer.Tell(done++, all));
    KDSTREAM_TRY(writer.PutBlob(
      pathOf(protocol::BlobId::PartitionBoxes(node)), [&] { return store.ReadBoxesBlob(node); }));
  }
  return {};
}

// Nothing where there are none.
Result<std::optional<NotesText>> NotesIn(const fs::path& file)
{
  auto notes = file.empty() ? Result<NotesText>(Error{ ErrorCode::NotFound, "" }) : ReadNotes(file);
  if (notes)
  {
    return std::optional(std::move(*notes));
  }
  const Error& error = notes.GetError();
  if (error.code == ErrorCode::NotFound)
  {
    return std::optional<NotesText>();
  }
  return Error{ error.code, error.message, file.string() };
}

// What says of the model what is not its content.
Status PutTexts(
  const ModelDescription& model, const std::optional<NotesText>& notes, Writer& writer)
{
  const std::string path = protocol::NotesPath(model.id);
  KDSTREAM_TRY(notes ? writer.PutText(path, { notes->bytes.begin(), notes->bytes.end() })
                     : writer.RemoveText(path));
  return writer.PutText(protocol::ModelPath(model.id), WriteModel(model));
}

// The models that the folder's list names, with this one.
Result<std::vector<ModelSummary>> ListWith(const fs::path& file, const ModelSummary& model)
{
  std::vector<ModelSummary> models;
  const auto text = ReadWholeFile(file);
  if (text)
  {
    auto list = ParseModelList(*text);
    if (!list)
    {
      return Error{ ErrorCode::InvalidInput, list.GetError().message, file.string() };
    }
    models = std::move(*list);
  }
  else if (text.GetError().code != ErrorCode::NotFound) // or it would lose the others
  {
    return text.GetError();
  }
  std::erase_if(models, [&](const ModelSummary& other) { return other.id == model.id; });
  models.push_back(model);
  std::sort(models.begin(), models.end(),
    [](const ModelSummary& a, const ModelSummary& b) { return a.id < b.id; });
  return models;
}

Status CopyPage(const fs::path& page, const fs::path& folder)
{
  const auto names = NamesIn(page);
  KDSTREAM_TRY(names);
  std::error_code failure;
  fs::create_directories(folder, failure); // where that fails, so does a file in it
  for (const std::string& name : *names)
  {
    const fs::path from = page / name, to = folder / name;
    if (fs::is_directory(from, failure))
    {
      KDSTREAM_TRY(CopyPage(from, to));
      continue;
    }
    const auto bytes = ReadWholeFile(from);
    KDSTREAM_TRY(bytes);
    KDSTREAM_TRY(HasBytes(to, *bytes) ? Status{} : WriteWhole(to, *bytes));
  }
  return {};
}

}

Result<ExportReport> ExportStore(const Store& store, const fs::path& folder,
  const ExportOptions& options, const Execution& execution)
{
  ModelDescription told = store.Info();
  told.id = options.model;
  const auto notes = NotesIn(options.notes);
  KDSTREAM_TRY(notes);
  ModelSummary summary = Summarize(told);
  summary.notes = *notes ? (*notes)->notes.size() : 0;
  const auto models = ListWith(folder / protocol::modelListPath.substr(1), summary);
  KDSTREAM_TRY(models);
  const auto all = folder / fs::path(protocol::ModelPath(options.model).substr(1)).parent_path();
  HiddenFolder::RemoveLeftovers(all);
  HiddenFolder::RemoveLeftovers(all / told.digest);
  NewFolder part(NewPartOf(all, told.digest));
  KDSTREAM_TRY(part.Make());
  Writer writer(folder, part, execution);
  KDSTREAM_TRY(PutBlobs(store, options.model, writer));
  const bool isNewModel = part.Name().filename() == options.model;
  if (isNewModel) // else it is told of once the digest is up
  {
    KDSTREAM_TRY(PutTexts(told, *notes, writer));
  }
  KDSTREAM_TRY(part.GoUp());
  if (!isNewModel)
  {
    KDSTREAM_TRY(PutTexts(told, *notes, writer));
  }
  KDSTREAM_TRY(writer.Put("/kdstream.nginx.conf", WithPolicy(nginxRules)));
  KDSTREAM_TRY(writer.Put("/.htaccess", WithPolicy(apacheRules)));
  if (!options.page.empty())
  {
    KDSTREAM_TRY(CopyPage(options.page, folder));
  }
  KDSTREAM_TRY(writer.PutText(std::string(protocol::modelListPath), WriteModelList(*models)));
  return writer.Report;
}

}
