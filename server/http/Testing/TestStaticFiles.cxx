#include "server/http/StaticFiles.h"

#include <gtest/gtest.h>

#include <fstream>
#include <unistd.h>

using namespace kdstream;
namespace fs = std::filesystem;

namespace
{

class Web : public testing::Test
{
protected:
  fs::path outer = fs::temp_directory_path() / ("kdstream-static-" + std::to_string(::getpid()));
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
    fs::create_symlink(this->outer / "web-other/x.txt", this->root / "sibling.txt");
  }
  void TearDown() override { fs::remove_all(this->outer); }

  static void Put(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

  std::string Read(std::string_view path)
  {
    const auto files = StaticFiles::Open(this->root);
    EXPECT_TRUE(files);
    const auto file = files->Read(path);
    return file ? std::string(file->bytes->begin(), file->bytes->end()) : "no file";
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
  EXPECT_EQ(files->Read("/a b.js")->contentType, "text/javascript; charset=utf-8");
  EXPECT_EQ(files->Read("/empty.wasm")->contentType, "application/wasm");
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

TEST_F(Web, TheFolderMustBeOne)
{
  EXPECT_FALSE(StaticFiles::Open(this->root / "missing"));
  EXPECT_FALSE(StaticFiles::Open(this->root / "index.html"));
}
