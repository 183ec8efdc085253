// SPDX-License-Identifier: BSD-3-Clause
#include "filters/app/ExportStore.h"

#include "filters/app/HiddenFolder.h"
#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/TreePage.h"
#include "filters/core/SystemReason.h"
#include "filters/files/Folders.h"
#include "filters/files/HeldFolder.h"
#include "filters/files/WriteWhole.h"
#include "filters/model/ListedPages.h"
#include "filters/model/ModelJson.h"
#include "filters/outofcore/files/LockedFolder.h"
#include "filters/page/EmbedAnswer.h"
#include "filters/page/GzipText.h"
#include "filters/page/IiifManifest.h"
#include "filters/page/ModelPage.h"
#include "filters/page/ModelPicture.h"
#include "filters/page/PreviewGlb.h"
#include "filters/protocol/ResourcePath.h"
#include "filters/store/StoreNotes.h"

#include <sys/stat.h>
#include <unistd.h>

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

// Replaces each @ in a text by the policy that restricts what pages may load.
std::string WithPolicy(std::string text)
{
  for (auto at = text.find('@'); at != text.npos; at = text.find('@'))
  {
    text.replace(at, 1, protocol::pagePolicy);
  }
  return text;
}

// nginx uses the headers of an outer block only if an inner block has none of its own.
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
# Pages of other sites may load the script as a module, and viewers there a manifest.
location ~ ^/(embed\.js|m/[^/]+/manifest\.json)$ {
  add_header Cache-Control no-cache;
  add_header X-Content-Type-Options nosniff;
  add_header Access-Control-Allow-Origin *;
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
    types { model/gltf-binary glb; }
    default_type application/octet-stream;
  }
}
)";

// These are only rules that AllowOverride FileInfo allows. With any other rule Apache would answer
// no request at all.
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
  <If "%{REQUEST_URI} =~ m#/api/|/embed\.js|/m/[^/]+/manifest\.json#">
    # Pages of other sites may read the models, and load the script as a module. Drop this line if
    # they may not.
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
  <If "%{REQUEST_URI} =~ m#/preview\.glb$#">
    ForceType model/gltf-binary
  </If>
</IfModule>
)";

// Makes the error one of `file`, the name that the user knows.
Status About(const fs::path& file, const Status& status)
{
  return status
           ? Status{}
           : Status{ Error{ status.GetError().code, status.GetError().message, file.string() } };
}

// The folder that the user names. Folders below it are opened one after the other without following
// links: others may be able to write to them, and must not redirect this program.
class TargetFolder
{
public:
  explicit TargetFolder(fs::path folder)
    : Folder(std::move(folder))
  {
  }
  Status Make()
  {
    std::error_code failure;
    for (auto above = this->Folder; !above.empty() && !fs::exists(above, failure);
         above = above.parent_path())
    {
      this->Made.insert(this->Made.begin(), above);
    }
    fs::create_directories(this->Folder, failure);
    if (failure)
    {
      return SystemError("cannot be written", failure.value(), this->Folder.string());
    }
    auto held = HeldFolder::Open(this->Folder);
    KDSTREAM_TRY(held);
    this->Held.emplace(std::move(*held));
    return {};
  }
  ~TargetFolder()
  {
    for (auto made = this->Made.rbegin(); made != this->Made.rend(); ++made)
    {
      ::rmdir(made->c_str()); // does nothing if the folder is not empty
    }
  }
  TargetFolder(const TargetFolder&) = delete;
  TargetFolder& operator=(const TargetFolder&) = delete;

  // Opens the folder `below`, a relative path; makes it if it does not exist. Errors: InputOutput,
  // also for a link.
  Result<HeldFolder> Enter(const fs::path& below)
  {
    auto here = HeldFolder::Open(this->Held->Path());
    if (!here)
    {
      return Error{ here.GetError().code, here.GetError().message, this->Folder.string() };
    }
    for (fs::path walked; walked != below;)
    {
      const fs::path name = *std::next(below.begin(), std::distance(walked.begin(), walked.end()));
      bool isNew = false;
      here = here->Below(name.string(), 0777, &isNew);
      walked /= name;
      if (isNew)
      {
        this->Made.push_back(this->Folder / walked);
      }
      if (!here)
      {
        return Error{ here.GetError().code, here.GetError().message, this->NameOf(walked) };
      }
    }
    return here;
  }
  std::string NameOf(const fs::path& below) const { return (this->Folder / below).string(); }

  // Waits until the folders made here are on the disk.
  Status Sync() const
  {
    for (const fs::path& made : this->Made)
    {
      KDSTREAM_TRY(SyncFolder(made.has_parent_path() ? made.parent_path() : "."));
    }
    return {};
  }

private:
  fs::path Folder;
  std::optional<HeldFolder> Held;
  std::vector<fs::path> Made; // folders made here, the outermost first
};

// The new folder of an export: that of the model; or, if that exists, the folder of the new digest
// in it. It appears as a whole or not at all (HiddenFolder). An existing folder stays where it is.
class NewFolder
{
public:
  // model: the path of the model's folder in `target`.
  NewFolder(TargetFolder& target, fs::path model, const std::string& digest)
    : Target(target)
    , Folder(std::move(model))
    , Digest(digest)
  {
  }
  Status Make()
  {
    KDSTREAM_TRY(this->EnterParent());
    if (this->IsThere())
    {
      this->Folder /= this->Digest;
      KDSTREAM_TRY(this->EnterParent());
    }
    if (this->IsThere())
    {
      this->Up = true;
      return {};
    }
    return About(this->Target.NameOf(this->Folder),
      this->Hidden.Make(this->Parent->Path(), this->Folder.filename()));
  }

  bool IsUp() const { return this->Up; }
  // Whether this folder contains the file. file: its path in the target.
  bool Holds(const fs::path& file) const
  {
    return std::mismatch(this->Folder.begin(), this->Folder.end(), file.begin(), file.end())
             .first == this->Folder.end();
  }
  const fs::path& Name() const { return this->Folder; }
  // REQUIRES: !IsUp() and Holds(file).
  fs::path PlaceOf(const fs::path& file) const
  {
    return this->Hidden.Place() / file.lexically_relative(this->Folder);
  }
  Status GoUp()
  {
    if (this->IsUp())
    {
      return {};
    }
    const fs::path name = this->Target.NameOf(this->Folder);
    KDSTREAM_TRY(About(name, this->Hidden.Appear(this->InParent())));
    this->Up = true;
    KDSTREAM_TRY(About(name, SyncFolder(this->Parent->Path())));
    return this->Target.Sync();
  }

private:
  fs::path InParent() const { return this->Parent->Path() / this->Folder.filename(); }
  bool IsThere() const
  {
    struct stat found = {};
    return ::lstat(this->InParent().c_str(), &found) == 0;
  }
  Status EnterParent()
  {
    auto parent = this->Target.Enter(this->Folder.parent_path());
    KDSTREAM_TRY(parent);
    this->Parent.emplace(std::move(*parent));
    RemoveDeadFolders(this->Parent->Path());
    return {};
  }

  TargetFolder& Target;
  fs::path Folder;
  std::string Digest;
  std::optional<HeldFolder> Parent;
  HiddenFolder Hidden; // within Parent, until the export is complete
  bool Up = false;
};

// Writes files below a folder, and counts them.
class Writer
{
public:
  // part: the part of `folder` that appears only when it is complete.
  Writer(TargetFolder& folder, const NewFolder& part, const Execution& execution)
    : Folder(folder)
    , Part(part)
    , Runs(execution)
  {
  }

  ExportReport Report;

  // path: of the protocol, "/api/…". If another file is in its place, it is replaced as a whole or
  // not at all.
  Status Put(const std::string& path, std::string_view bytes)
  {
    const auto file = this->PlaceOf(path);
    KDSTREAM_TRY(file);
    // Files of the new folder are not synchronized one by one, but all at once when the folder
    // appears.
    KDSTREAM_TRY(About(
      this->NameOf(path), this->GoesUp(path) ? WriteAnew(*file, bytes) : WriteWhole(*file, bytes)));
    ++this->Report.files;
    this->Report.bytes += bytes.size();
    return {};
  }

  Status PutText(const std::string& path, const std::string& text)
  {
    KDSTREAM_TRY(this->Put(path, text));
    constexpr int smallest = 9;
    const auto small = GzipText(text, smallest);
    KDSTREAM_TRY(small);
    return this->Put(path + ".gz", *small);
  }

  // Copies all files below the folder `page`; they are not counted.
  Status CopyPage(const fs::path& page, const std::string& path = "/")
  {
    const auto names = NamesIn(page);
    KDSTREAM_TRY(names);
    for (const std::string& name : *names)
    {
      const fs::path from = page / name;
      const std::string to = path + name;
      std::error_code failure;
      if (fs::is_directory(from, failure))
      {
        KDSTREAM_TRY(this->CopyPage(from, to + "/"));
        continue;
      }
      const auto bytes = ReadWholeFile(from);
      KDSTREAM_TRY(bytes);
      const auto file = this->PlaceOf(to);
      KDSTREAM_TRY(file);
      KDSTREAM_TRY(
        HasBytes(*file, *bytes) ? Status{} : About(this->NameOf(to), WriteWhole(*file, *bytes)));
    }
    return {};
  }

  // The path for messages: it begins with the folder's name as the user gave it.
  std::string NameOf(const std::string& path) const { return this->Folder.NameOf(path.substr(1)); }

  // Errors: NotFound; InputOutput, also for a link; LimitExceeded.
  Result<std::string> Read(const std::string& path)
  {
    const auto file = this->PlaceOf(path);
    KDSTREAM_TRY(file);
    constexpr std::size_t mostBytes = std::size_t{ 16 } << 20; // viewers do not take a longer list
    auto text = ReadWholeFile(*file, Links::Refuse, mostBytes);
    if (!text)
    {
      return Error{ text.GetError().code, text.GetError().message, this->NameOf(path) };
    }
    return text;
  }

  // If the file exists already, it should have the same bytes, because its path contains the
  // digest: they are compared.
  template <class Read>
  Status PutBlob(const std::string& path, const Read& read)
  {
    const auto blob = read();
    KDSTREAM_TRY(blob);
    const std::string_view bytes(reinterpret_cast<const char*>(blob->data()), blob->size());
    const auto file = this->PlaceOf(path);
    KDSTREAM_TRY(file);
    return HasBytes(*file, bytes) ? Status{} : this->Put(path, bytes);
  }

  Status RemoveText(const std::string& path)
  {
    for (const std::string& each : { path, path + ".gz" })
    {
      const auto file = this->PlaceOf(each);
      KDSTREAM_TRY(file);
      std::error_code failure;
      fs::remove(*file, failure);
      if (failure)
      {
        return SystemError("cannot be removed", failure.value(), this->NameOf(each));
      }
    }
    return {};
  }

  Status Tell(std::size_t done, std::size_t all) const
  {
    return this->Runs.Report("export", static_cast<double>(done) / static_cast<double>(all));
  }

private:
  bool GoesUp(const std::string& path) const
  {
    return !this->Part.IsUp() && this->Part.Holds(path.substr(1));
  }

  // Where to write a file, in a folder that exists from now on. Valid until the next call for
  // another folder.
  Result<fs::path> PlaceOf(const std::string& path)
  {
    const fs::path file = path.substr(1);
    if (this->GoesUp(path))
    {
      const fs::path place = this->Part.PlaceOf(file);
      std::error_code failure;
      fs::create_directories(place.parent_path(), failure); // an error shows when the file is made
      return place;
    }
    if (!this->Entered || this->EnteredName != file.parent_path())
    {
      auto entered = this->Folder.Enter(file.parent_path());
      KDSTREAM_TRY(entered);
      this->Entered.emplace(std::move(*entered));
      this->EnteredName = file.parent_path();
    }
    return this->Entered->Path() / file.filename();
  }

  TargetFolder& Folder;
  const NewFolder& Part;
  const Execution& Runs;
  std::optional<HeldFolder> Entered; // the folder of the previous file
  fs::path EnteredName;
};

Status PutBlobs(const Store& store, const std::string& model, Writer& writer)
{
  const ModelDescription& info = store.Info();
  std::vector<protocol::BlobId> blobs;
  for (const PieceId piece : store.PieceIds())
  {
    blobs.push_back(BlobOfPiece(piece, info.depths));
    if (info.textures && info.textures->levels && !piece.resolution.IsOriginal())
    {
      blobs.push_back(TextureOfPiece(piece, info.depths));
    }
  }
  for (std::uint32_t p = 0; info.textures && p < info.partitions; ++p)
  {
    blobs.push_back(protocol::BlobId::Texture(p));
  }
  for (const NodeId page : TreePages(info.depths))
  {
    blobs.push_back(protocol::BlobId::TreePage(page));
  }
  for (const NodeId node : AllPartitionBoxes(info.depths))
  {
    blobs.push_back(protocol::BlobId::PartitionBoxes(node));
  }
  std::size_t done = 0;
  for (const protocol::BlobId& blob : blobs)
  {
    KDSTREAM_TRY(writer.Tell(done++, blobs.size()));
    KDSTREAM_TRY(writer.PutBlob(
      protocol::BlobPath(model, info.digest, blob), [&] { return store.Read(blob); }));
  }
  return {};
}

// Writes the same preview as a server makes: for viewers of glTF, and for augmented reality.
Status PutPreview(const Store& store, const ModelDescription& model, Writer& writer)
{
  if (!HasPreviewGlb(model))
  {
    return {};
  }
  const auto blob = store.Read(BlobOfPiece(PreviewPiece(model), model.depths));
  KDSTREAM_TRY(blob);
  const auto bytes = EncodePreviewGlb(model, *blob);
  if (!bytes)
  {
    return bytes.GetError().code == ErrorCode::NotFound ? Status{} : Status{ bytes.GetError() };
  }
  const PagePlace place{ "/" };
  return writer.Put(place.Preview(model.id, model.digest),
    { reinterpret_cast<const char*>(bytes->data()), bytes->size() });
}

// Reads the notes; nothing if there are none.
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

// Writes the files about the model that do not depend only on its content.
Status PutTexts(
  const ModelDescription& model, const std::optional<NotesText>& notes, Writer& writer)
{
  const std::string path = protocol::NotesPath(model.id);
  KDSTREAM_TRY(notes ? writer.PutText(path, { notes->bytes.begin(), notes->bytes.end() })
                     : writer.RemoveText(path));
  return writer.PutText(protocol::ModelPath(model.id), WriteModel(model));
}

std::string PageFile(const std::string& model, const char* name)
{
  return "/" + std::string(pagesFolder) + model + "/" + name;
}

// Writes the model's page and the files that belong to it. Removes an earlier oembed.json if there
// is no address now.
Status PutPage(const Store& store, const ModelDescription& model,
  const std::optional<NotesText>& notes, const ExportOptions& options, Writer& writer)
{
  const auto viewer = ReadWholeFile(options.page / "index.html");
  KDSTREAM_TRY(viewer);
  const PagePlace place{ options.address, "../../", true };
  if (HasPicture(model))
  {
    const auto blob = store.Read(BlobOfPiece(PreviewPiece(model), model.depths));
    KDSTREAM_TRY(blob);
    const auto picture = DrawModelPicture(model, *blob);
    KDSTREAM_TRY(picture);
    KDSTREAM_TRY(writer.Put(PageFile(model.id, "picture.jpg"),
      { reinterpret_cast<const char*>(picture->data()), picture->size() }));
  }
  const auto all = notes ? notes->notes : std::vector<Note>();
  KDSTREAM_TRY(
    writer.PutText(PageFile(model.id, "manifest.json"), WriteIiifManifest(model, place, all)));
  const std::string embed = PageFile(model.id, "oembed.json");
  KDSTREAM_TRY(options.address.empty() ? writer.RemoveText(embed)
                                       : writer.PutText(embed, WriteEmbedAnswer(model, place, {})));
  return writer.PutText(PageFile(model.id, "index.html"), MakeModelPage(*viewer, model, place, {}));
}

// Writes the page of all models, which has a link to each even without scripts, and a list of
// addresses for search engines.
Status PutListPage(
  const std::vector<ModelSummary>& models, const ExportOptions& options, Writer& writer)
{
  const auto viewer = ReadWholeFile(options.page / "index.html");
  KDSTREAM_TRY(viewer);
  const PagePlace place{ options.address, "../", true };
  const std::string sitemap = "/sitemap.xml";
  KDSTREAM_TRY(options.address.empty() ? writer.RemoveText(sitemap)
                                       : writer.PutText(sitemap, WriteSitemap(models, place)));
  return writer.PutText(
    "/" + std::string(pagesFolder) + "index.html", MakeListPage(*viewer, models, place, {}));
}

// "m/" if each of the models has a page; else empty.
std::string PagesOf(const std::vector<ModelSummary>& models, const Writer& writer)
{
  const bool all = std::all_of(models.begin(), models.end(),
    [&writer](const ModelSummary& model)
    {
      std::error_code failure;
      return fs::is_regular_file(writer.NameOf(PageFile(model.id, "index.html")), failure);
    });
  return all ? std::string(pagesFolder) : std::string();
}

// The models in the folder's list, and this one.
Result<std::vector<ModelSummary>> ListWith(const ModelSummary& model, Writer& writer)
{
  std::vector<ModelSummary> models;
  const auto text = writer.Read(std::string(protocol::modelListPath));
  if (text)
  {
    auto list = ParseModelList(*text);
    if (!list)
    {
      return Error{ ErrorCode::InvalidInput, list.GetError().message,
        writer.NameOf(std::string(protocol::modelListPath)) };
    }
    models = std::move(*list);
  }
  // Any other error must be reported; otherwise the new list would lose the other models.
  else if (text.GetError().code != ErrorCode::NotFound)
  {
    return text.GetError();
  }
  std::erase_if(models, [&](const ModelSummary& other) { return other.id == model.id; });
  models.push_back(model);
  std::sort(models.begin(), models.end(),
    [](const ModelSummary& a, const ModelSummary& b) { return a.id < b.id; });
  return models;
}

}

Result<ExportReport> ExportStore(const Store& store, const fs::path& folder,
  const ExportOptions& options, const Execution& execution)
{
  ModelDescription reported = store.Info();
  reported.id = options.model;
  const auto notes = NotesIn(options.notes);
  KDSTREAM_TRY(notes);
  ModelSummary summary = Summarize(reported);
  summary.notes = *notes ? (*notes)->notes.size() : 0;
  TargetFolder target(folder);
  KDSTREAM_TRY(target.Make());
  NewFolder part(
    target, fs::path(protocol::ModelPath(options.model).substr(1)).parent_path(), reported.digest);
  KDSTREAM_TRY(part.Make());
  Writer writer(target, part, execution);
  const auto models = ListWith(summary, writer);
  KDSTREAM_TRY(models);
  KDSTREAM_TRY(PutBlobs(store, options.model, writer));
  KDSTREAM_TRY(PutPreview(store, reported, writer));
  const bool isNewModel = part.Name().filename() == options.model;
  if (isNewModel) // otherwise texts are written after the new digest is complete
  {
    KDSTREAM_TRY(PutTexts(reported, *notes, writer));
  }
  KDSTREAM_TRY(part.GoUp());
  if (!isNewModel)
  {
    KDSTREAM_TRY(PutTexts(reported, *notes, writer));
  }
  KDSTREAM_TRY(writer.Put("/kdstream.nginx.conf", WithPolicy(nginxRules)));
  KDSTREAM_TRY(writer.Put("/.htaccess", WithPolicy(apacheRules)));
  if (!options.page.empty())
  {
    KDSTREAM_TRY(writer.CopyPage(options.page));
    KDSTREAM_TRY(PutPage(store, reported, *notes, options, writer));
    KDSTREAM_TRY(PutListPage(*models, options, writer));
  }
  KDSTREAM_TRY(writer.PutText(std::string(protocol::modelListPath),
    WithPages(WriteModelList(*models), PagesOf(*models, writer))));
  return writer.Report;
}

}
