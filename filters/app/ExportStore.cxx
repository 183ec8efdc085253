// SPDX-License-Identifier: BSD-3-Clause
#include "filters/app/ExportStore.h"

#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/TreePage.h"
#include "filters/core/SystemReason.h"
#include "filters/model/ModelJson.h"
#include "filters/store/StoreNotes.h"
#include "filters/store/WriteWhole.h"
#include "server/protocol/ResourcePath.h"

#include <zlib.h>

#include <algorithm>
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

// A folder that goes up whole or not at all: what belongs into it is written into a hidden one
// beside it, which takes its name at the end, or is removed. (What a call has left there that was
// killed stays for the next one.) A folder that is up already stays where it is.
class NewFolder
{
public:
  explicit NewFolder(fs::path folder)
    : Folder(std::move(folder))
    , Place(this->Folder)
  {
    std::error_code failure;
    if (fs::exists(this->Folder, failure))
    {
      return;
    }
    this->Place = this->Folder.parent_path() / ("." + this->Folder.filename().string() + ".new");
    auto parent = this->Place.parent_path();
    for (; !parent.empty() && !fs::exists(parent, failure); parent = parent.parent_path())
    {
      this->Made.push_back(parent);
    }
  }
  ~NewFolder()
  {
    std::error_code failure;
    if (!this->IsUp())
    {
      fs::remove_all(this->Place, failure);
    }
    for (const auto& parent : this->Made)
    {
      fs::remove(parent, failure); // where nothing else has come into it
    }
  }
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  bool IsUp() const { return this->Place == this->Folder; }
  const fs::path& Name() const { return this->Folder; }
  fs::path PlaceOf(const fs::path& file) const
  {
    return this->Place / file.lexically_relative(this->Folder);
  }
  Status GoUp()
  {
    std::error_code failure;
    if (!this->IsUp())
    {
      fs::rename(this->Place, this->Folder, failure);
    }
    if (failure)
    {
      return SystemError("cannot be written", failure.value(), this->Folder.string());
    }
    this->Place = this->Folder;
    return {};
  }

private:
  fs::path Folder, Place;
  std::vector<fs::path> Made; // by this, the innermost first
};

// Of a model's files: of all, or of those with another digest than what is up.
fs::path NewPartOf(const fs::path& folder, const std::string& model, const std::string& digest)
{
  const auto all = folder / fs::path(protocol::ModelPath(model).substr(1)).parent_path();
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
    KDSTREAM_TRY(WriteWhole(file, bytes));
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

  // What is there already is the same: its path has the digest. (From a call that was interrupted.)
  template <class Read>
  Status PutBlob(const std::string& path, const Read& read)
  {
    std::error_code failure;
    const auto there = fs::file_size(this->PlaceOf(path), failure);
    const auto bytes = read();
    KDSTREAM_TRY(bytes);
    if (!failure && there == bytes->size())
    {
      return {};
    }
    return this->Put(path, { reinterpret_cast<const char*>(bytes->data()), bytes->size() });
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
    const auto& part = this->Part.Name();
    const bool isOfPart =
      std::mismatch(part.begin(), part.end(), file.begin(), file.end()).first == part.end();
    return isOfPart ? this->Part.PlaceOf(file) : file;
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
  std::error_code failure;
  if (fs::exists(file, failure))
  {
    std::ifstream input(file, std::ios::binary);
    auto list = ParseModelList(std::string(std::istreambuf_iterator<char>(input), {}));
    if (!list)
    {
      return Error{ ErrorCode::InvalidInput, list.GetError().message, file.string() };
    }
    models = std::move(*list);
  }
  std::erase_if(models, [&](const ModelSummary& other) { return other.id == model.id; });
  models.push_back(model);
  std::sort(models.begin(), models.end(),
    [](const ModelSummary& a, const ModelSummary& b) { return a.id < b.id; });
  return models;
}

Status CopyPage(const fs::path& page, const fs::path& folder)
{
  std::error_code failure;
  fs::copy(
    page, folder, fs::copy_options::recursive | fs::copy_options::overwrite_existing, failure);
  return failure ? Status(SystemError("the page cannot be copied", failure.value(), page.string()))
                 : Status();
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
  NewFolder part(NewPartOf(folder, options.model, told.digest));
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
