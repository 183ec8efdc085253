// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/StaticFiles.h"

#include "Testing/Fixtures/TemporaryFolder.h"

#include <gtest/gtest.h>

#include <fstream>

using namespace kdstream;
namespace fs = std::filesystem;

namespace
{

class Web : public testing::Test
{
protected:
  const fixtures::TemporaryFolder temporary;
  const fs::path outer = this->temporary.Path;
  fs::path root = outer / "web";

  void SetUp() override
  {
    fs::create_directories(this->root / "sub");
    this->Put(this->outer / "secret.txt", "secret");
    this->Put(this->root / "index.html", "<p>home</p>");
    this->Put(this->root / "sub/index.html", "<p>sub</p>");
    this->Put(this->root / "a b.js", "1");
    this->Put(this->root / "empty.wasm", "");
    this->Put(this->root / ".hidden", "hidden");
    fs::create_directories(this->root / ".git");
    this->Put(this->root / ".git/config", "hidden");
    fs::create_symlink(this->outer / "secret.txt", this->root / "link.txt");
    fs::create_directory_symlink(this->outer, this->root / "out");
    fs::create_symlink(this->root / "index.html", this->root / "inside.html");
    fs::create_directories(this->outer / "web-other");
    this->Put(this->outer / "web-other/x.txt", "secret");
    this->Put(this->root / "page.js", "plain");
    this->Put(this->root / "page.js.gz", "gzip of page");
    this->Put(this->root / "index.html.gz", "gzip of home");
    this->Put(this->root / "lure.js", "lure");
    fs::create_symlink(this->outer / "secret.txt", this->root / "lure.js.gz");
    this->Put(this->root / "folder.js", "no folder");
    fs::create_directories(this->root / "folder.js.gz");
    fs::create_symlink(this->outer / "web-other/x.txt", this->root / "sibling.txt");
  }
  static void Put(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

  std::string Read(std::string_view path)
  {
    const auto files = StaticFiles::Open(this->root);
    EXPECT_TRUE(files);
    const auto file = files->Read(path);
    return file ? std::string((*file)->bytes->begin(), (*file)->bytes->end()) : "no file";
  }
};

}

TEST_F(Web, ServesFilesAndIndexes)
{
  EXPECT_EQ(this->Read("/"), "<p>home</p>");
  EXPECT_EQ(this->Read("/index.html"), "<p>home</p>");
  EXPECT_EQ(this->Read("/inside.html"), "<p>home</p>");
  EXPECT_EQ(this->Read("/sub"), "<p>sub</p>");
  EXPECT_EQ(this->Read("/sub/"), "<p>sub</p>");
  EXPECT_EQ(this->Read("/a%20b.js"), "1");
  EXPECT_EQ(this->Read("/empty.wasm"), "");
  const auto files = StaticFiles::Open(this->root);
  EXPECT_EQ((*files->Read("/a b.js"))->contentType, "text/javascript; charset=utf-8");
  EXPECT_EQ((*files->Read("/empty.wasm"))->contentType, "application/wasm");
}

TEST_F(Web, NothingOutsideTheFolderIsServed)
{
  for (const char* path : { "/../secret.txt", "/%2e%2e/secret.txt", "/..%2fsecret.txt",
         "/%2E%2E%2Fsecret.txt", "/sub/../../secret.txt", "/sub/%2e%2e/%2e%2e/secret.txt",
         "/..\\secret.txt", "/..%5csecret.txt", "//secret.txt", "/%2fetc/passwd", "//etc/passwd",
         "/link.txt", "/out/secret.txt", "/out/", "/sibling.txt", "/.hidden", "/.git/config",
         "/%2egit/config", "/./index.html", "/%252e%252e/secret.txt", "/index.html%00.js",
         "/index.html/", "/index.html/x", "/missing", "/%2e" })
  {
    const auto content = this->Read(path);
    EXPECT_TRUE(
      content == "no file" || (content == "<p>home</p>" && path == std::string("/index.html/")))
      << path << ": " << content;
  }
}

TEST_F(Web, WrongEscapesAreInvalid)
{
  const auto files = StaticFiles::Open(this->root);
  for (const char* path : { "/%", "/%2", "/%zz", "/%-1", "/a%2" })
  {
    const auto file = files->Read(path);
    ASSERT_FALSE(file) << path;
    EXPECT_EQ(file.GetError().code, ErrorCode::InvalidArgument) << path;
  }
}

TEST_F(Web, FilesStayInMemoryUntilTheyAreForgotten)
{
  const auto files = StaticFiles::Open(this->root);
  EXPECT_FALSE(files->Find("/index.html"));
  const auto first = *files->Read("/index.html");
  EXPECT_EQ(files->Find("/index.html"), first);
  EXPECT_EQ(files->Find("//%69ndex.html"), first);
  EXPECT_FALSE(files->Find("/index.html", true)) << "gzip has bytes of its own";
  this->Put(this->root / "index.html", "new");
  EXPECT_EQ(files->Find("/index.html"), first);
  const StaticFiles copy = *files;
  copy.Forget();
  EXPECT_FALSE(files->Find("/index.html"));
  EXPECT_EQ((*files->Read("/index.html"))->bytes->size(), 3u);
  EXPECT_FALSE(files->Find("/missing"));
  EXPECT_FALSE(files->Find("/../secret.txt"));
}

TEST_F(Web, WhatCannotBeServedIsReportedOnceUntilItCanBe)
{
  std::vector<std::string> reported;
  const auto files =
    StaticFiles::Open(this->root, [&reported](const std::string& file, const std::string& what)
      { reported.push_back(fs::path(file).filename().string() + ": " + what); });
  const auto large = this->root / "large.bin";
  const auto read = [&]
  {
    const auto file = files->Read("/large.bin");
    return file ? ErrorCode::Cancelled : file.GetError().code;
  };
  const std::string line = "large.bin: the file is larger than 64 MiB, too large to serve";
  this->Put(large, "");
  fs::resize_file(large, StaticFiles::maximumBytes + 1);
  EXPECT_EQ(read(), ErrorCode::LimitExceeded);
  EXPECT_EQ(read(), ErrorCode::LimitExceeded);
  EXPECT_EQ(reported, (std::vector<std::string>{ line }));
  fs::resize_file(large, StaticFiles::maximumBytes);
  EXPECT_EQ(read(), ErrorCode::Cancelled) << "it is read";
  files->Forget();
  fs::resize_file(large, StaticFiles::maximumBytes + 1);
  EXPECT_EQ(read(), ErrorCode::LimitExceeded);
  EXPECT_EQ(reported, (std::vector<std::string>{ line, line })) << "anew";
  EXPECT_FALSE(files->Read("/missing"));
  EXPECT_EQ(reported.size(), 2u) << "nor what there is not";
}

TEST_F(Web, NoMoreStaysInMemoryThanMay)
{
  const auto files = StaticFiles::Open(this->root);
  for (const char* name : { "a.bin", "b.bin", "c.bin" })
  {
    this->Put(this->root / name, "");
    fs::resize_file(this->root / name, StaticFiles::keptBytes / 2);
    EXPECT_TRUE(files->Read("/" + std::string(name)));
  }
  EXPECT_TRUE(files->Find("/a.bin"));
  EXPECT_TRUE(files->Find("/b.bin"));
  EXPECT_FALSE(files->Find("/c.bin"));
}

TEST_F(Web, TheFolderMustBeOne)
{
  EXPECT_FALSE(StaticFiles::Open(this->root / "missing"));
  EXPECT_FALSE(StaticFiles::Open(this->root / "index.html"));
}

TEST_F(Web, MediaTypes)
{
  const std::pair<const char*, const char*> types[] = { { "a.html", "text/html; charset=utf-8" },
    { "a.css", "text/css; charset=utf-8" }, { "a.js", "text/javascript; charset=utf-8" },
    { "a.wasm", "application/wasm" }, { "a.webmanifest", "application/manifest+json" },
    { "a.svg", "image/svg+xml" }, { "a.js.gz", "application/gzip" },
    { "a", "application/octet-stream" } };
  const auto files = StaticFiles::Open(this->root);
  for (const auto& [name, type] : types)
  {
    this->Put(this->root / name, "x");
    EXPECT_EQ((*files->Read("/" + std::string(name)))->contentType, type) << name;
  }
}

TEST_F(Web, GzipLiesBesideTheFile)
{
  const auto files = StaticFiles::Open(this->root);
  const auto read = [&files](std::string_view path, bool acceptGzip)
  {
    const auto file = files->Read(path, acceptGzip);
    return file ? std::string((*file)->bytes->begin(), (*file)->bytes->end()) + ", " +
                    (*file)->encoding + ((*file)->varies ? ", varies" : "")
                : "no file";
  };
  EXPECT_EQ(read("/page.js", false), "plain, , varies");
  EXPECT_EQ(read("/page.js", true), "gzip of page, gzip, varies");
  EXPECT_EQ(read("/", true), "gzip of home, gzip, varies");
  EXPECT_EQ(read("/page.js.gz", true), "gzip of page, ");
  EXPECT_EQ(read("/a%20b.js", true), "1, ");
  EXPECT_EQ(read("/lure.js", true), "lure, ") << "a link that leads outside";
  EXPECT_EQ(read("/folder.js", true), "no folder, ");
  EXPECT_EQ(read("/missing.js", true), "no file");
  EXPECT_EQ((*files->Read("/page.js", true))->contentType, "text/javascript; charset=utf-8");
  this->Put(this->root / "only.js.gz", "no plain file");
  EXPECT_EQ(read("/only.js", true), "no file");
}
