// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/StaticFiles.h"

#include "filters/core/SystemReason.h"
#include "filters/core/Texts.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>

namespace kdstream
{

namespace
{

namespace fs = std::filesystem;

// The path below the root. Nothing if one of its parts is hidden, empty, "." or "..".
std::optional<fs::path> RelativePath(std::string_view path)
{
  fs::path relative;
  while (!path.empty())
  {
    const auto slash = path.find('/');
    const auto part = path.substr(0, slash);
    path.remove_prefix(slash == std::string_view::npos ? path.size() : slash + 1);
    if (part.empty())
    {
      continue;
    }
    const bool plain = part.front() != '.' &&
                       std::none_of(part.begin(), part.end(),
                         [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '\\'; });
    if (!plain)
    {
      return std::nullopt;
    }
    relative /= part;
  }
  return relative;
}

std::string ContentType(const fs::path& file)
{
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 15> types{ {
    { ".html", "text/html; charset=utf-8" },
    { ".js", "text/javascript; charset=utf-8" },
    { ".mjs", "text/javascript; charset=utf-8" },
    { ".css", "text/css; charset=utf-8" },
    { ".txt", "text/plain; charset=utf-8" },
    { ".json", "application/json" },
    { ".map", "application/json" },
    { ".webmanifest", "application/manifest+json" },
    { ".wasm", "application/wasm" },
    { ".gz", "application/gzip" },
    { ".png", "image/png" },
    { ".jpg", "image/jpeg" },
    { ".svg", "image/svg+xml" },
    { ".ico", "image/x-icon" },
    { ".woff2", "font/woff2" },
  } };
  const auto extension = file.extension().string();
  const auto found = std::find_if(
    types.begin(), types.end(), [&](const auto& type) { return type.first == extension; });
  return std::string(found == types.end() ? "application/octet-stream" : found->second);
}

bool IsBelow(const fs::path& file, const fs::path& root)
{
  return std::mismatch(root.begin(), root.end(), file.begin(), file.end()).first == root.end();
}

Result<BlobBytes> ReadWhole(const fs::path& file)
{
  std::error_code error;
  const auto size = fs::file_size(file, error);
  if (error)
  {
    return SystemError("the file cannot be read", error.value(), file.string());
  }
  if (size > StaticFiles::maximumBytes)
  {
    return Error{ ErrorCode::LimitExceeded, "the file is larger than 64 MiB, too large to serve",
      file.string() };
  }
  errno = 0;
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
  std::ifstream stream(file, std::ios::binary);
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!stream || static_cast<std::size_t>(stream.gcount()) != bytes.size())
  {
    return SystemError("the file cannot be read", errno == 0 ? EIO : errno, file.string());
  }
  return std::make_shared<const std::vector<std::uint8_t>>(std::move(bytes));
}

// Whether the error means that the path leads to nothing that may be served.
bool SaysAbsent(const std::error_code& error)
{
  return error == std::errc::no_such_file_or_directory || error == std::errc::not_a_directory ||
         error == std::errc::permission_denied || error == std::errc::filename_too_long ||
         error == std::errc::too_many_symbolic_link_levels || error == std::errc::invalid_argument;
}

}

// Files in memory, by their path in the folder and by whether gzip is accepted.
struct StaticFiles::Kept
{
  using Key = std::pair<std::string, bool>;
  Report report;
  std::mutex mutex;                            // for the members below
  std::map<std::string, std::string> reported; // the last report, by path in the folder
  std::map<Key, std::shared_ptr<const StaticFile>> files;
  std::uintmax_t bytes = 0;
  std::uint64_t forgotten = 0; // how often Forget was called
};

StaticFiles::StaticFiles(std::filesystem::path root, Report report)
  : Root(std::move(root))
  , Memory(std::make_shared<Kept>())
{
  this->Memory->report = std::move(report);
}

Result<StaticFiles> StaticFiles::Open(const fs::path& folder, Report report)
{
  std::error_code error;
  auto root = fs::canonical(folder, error);
  if (error || !fs::is_directory(root, error))
  {
    return Error{ ErrorCode::NotFound, "not a folder" };
  }
  return StaticFiles(std::move(root), std::move(report));
}

std::shared_ptr<const StaticFile> StaticFiles::Find(std::string_view urlPath, bool acceptGzip) const
{
  const auto plain = PercentDecoded(urlPath);
  const auto relative = plain ? RelativePath(*plain) : std::nullopt;
  if (!relative)
  {
    return nullptr;
  }
  const std::lock_guard lock(this->Memory->mutex);
  const auto found = this->Memory->files.find({ relative->string(), acceptGzip });
  return found == this->Memory->files.end() ? nullptr : found->second;
}

void StaticFiles::Forget() const
{
  const std::lock_guard lock(this->Memory->mutex);
  this->Memory->files.clear();
  this->Memory->reported.clear();
  this->Memory->bytes = 0;
  ++this->Memory->forgotten;
}

Result<std::shared_ptr<const StaticFile>> StaticFiles::Read(
  std::string_view urlPath, bool acceptGzip) const
{
  const auto plain = PercentDecoded(urlPath);
  if (!plain)
  {
    return Error{ ErrorCode::InvalidArgument,
      "a % in the path is not followed by two hexadecimal digits" };
  }
  const auto relative = RelativePath(*plain);
  if (!relative)
  {
    return Error{ ErrorCode::NotFound, "no such file" };
  }
  const auto forgotten = [this]
  {
    const std::lock_guard lock(this->Memory->mutex);
    return this->Memory->forgotten;
  }();
  auto read = this->ReadFile(*relative, acceptGzip);
  if (!read)
  {
    this->Tell(relative->string(), read.GetError());
    return read.GetError();
  }
  auto file = std::make_shared<const StaticFile>(std::move(*read));
  const std::lock_guard lock(this->Memory->mutex);
  this->Memory->reported.erase(relative->string());
  // A read that began before Forget may have read the earlier file, so its result is not kept.
  if (this->Memory->forgotten == forgotten &&
      this->Memory->bytes + file->bytes->size() <= keptBytes &&
      this->Memory->files.emplace(Kept::Key{ relative->string(), acceptGzip }, file).second)
  {
    this->Memory->bytes += file->bytes->size();
  }
  return file;
}

// Reports an error of a file that exists.
void StaticFiles::Tell(const std::string& relative, const Error& error) const
{
  if (error.file.empty() || !this->Memory->report)
  {
    return;
  }
  {
    const std::lock_guard lock(this->Memory->mutex);
    auto& last = this->Memory->reported[relative];
    if (last == error.message)
    {
      return;
    }
    last = error.message;
  }
  this->Memory->report(error.file, error.message);
}

Result<StaticFile> StaticFiles::ReadFile(const fs::path& relative, bool acceptGzip) const
{
  const Error notFound{ ErrorCode::NotFound, "no such file" };
  std::error_code error;
  auto file = fs::canonical(this->Root / relative, error);
  if (!error && fs::is_directory(file, error))
  {
    file = fs::canonical(file / "index.html", error);
  }
  if (error && !SaysAbsent(error)) // no memory, a failing disk: the file may exist
  {
    return SystemError("the file cannot be read", error.value(), (this->Root / relative).string());
  }
  if (error || !IsBelow(file, this->Root) || !fs::is_regular_file(file, error))
  {
    return notFound;
  }
  auto compressed = fs::canonical(fs::path(file) += ".gz", error);
  const bool varies =
    !error && IsBelow(compressed, this->Root) && fs::is_regular_file(compressed, error);
  const bool encoded = varies && acceptGzip;
  auto bytes = ReadWhole(encoded ? compressed : file);
  KDSTREAM_TRY(bytes);
  return StaticFile{ std::move(*bytes), ContentType(file), encoded ? "gzip" : "", varies };
}

}
