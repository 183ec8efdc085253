// SPDX-License-Identifier: BSD-3-Clause
// A store exported as files: the same bytes as a server would send, and a viewer for which they are
// enough.
#include "Testing/EndToEnd/ProgramsTest.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/model/ModelJson.h"
#include "filters/model/Notes.h"
#include "filters/protocol/ResourcePath.h"
#include "filters/store/Store.h"

#include <sys/stat.h>
#include <zlib.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <map>
#include <set>
#include <thread>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

namespace fs = std::filesystem;

std::string Uncompressed(const fs::path& file)
{
  gzFile input = gzopen(file.c_str(), "rb");
  std::string text(1 << 20, '\0');
  text.resize(static_cast<std::size_t>(
    std::max(gzread(input, text.data(), static_cast<unsigned>(text.size())), 0)));
  gzclose(input);
  return text;
}

class TestExport : public ProgramsTest
{
protected:
  void SetUp() override
  {
    this->ProgramsTest::Write("ring.ply", Torus(200, 100));
    ASSERT_EQ(this->Build({ "ring.ply", "-o", "ring.kds", "--title", "A ring" }).exitCode, 0);
  }
  Outcome Export(std::vector<std::string> arguments)
  {
    arguments.insert(arguments.begin(), "export");
    return this->Store(arguments);
  }
  std::vector<ModelSummary> List() const
  {
    const auto list = ParseModelList(ReadWhole(this->Folder / "www/api/models.json"));
    EXPECT_TRUE(list);
    return list ? *list : std::vector<ModelSummary>();
  }
};

TEST_F(TestExport, EveryPathHasWhatAServerSends)
{
  const Outcome outcome = this->Export({ "ring.kds", "www" });
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_NE(outcome.err.find(" files of ring to www, "), std::string::npos) << outcome.err;
  const auto store = *kdstream::Store::Open(this->Folder / "ring.kds");
  std::size_t blobs = 0;
  for (const auto& entry : fs::recursive_directory_iterator(this->Folder / "www/api"))
  {
    if (!entry.is_regular_file() || entry.path().extension() == ".gz")
    {
      continue;
    }
    EXPECT_EQ(entry.path().string().find("/.kdstream"), std::string::npos) << entry.path();
    if (entry.path().filename() == "preview.glb")
    {
      EXPECT_EQ(ReadWhole(entry.path()).substr(0, 4), "glTF");
      continue;
    }
    const std::string path = "/" + entry.path().lexically_relative(this->Folder / "www").string();
    const auto resource = protocol::ParseResourcePath(path);
    ASSERT_TRUE(resource) << path;
    if (resource->kind != protocol::ResourcePath::Kind::Blob)
    {
      EXPECT_EQ(Uncompressed(entry.path().string() + ".gz"), ReadWhole(entry.path())) << path;
      continue;
    }
    ++blobs;
    EXPECT_EQ(resource->digest, store->Info().digest);
    const auto bytes = store->Read(resource->blob);
    ASSERT_TRUE(bytes) << path;
    EXPECT_EQ(ReadWhole(entry.path()), std::string(bytes->begin(), bytes->end())) << path;
  }
  EXPECT_GT(blobs, store->PieceIds().size() + 1);
  const auto model = ParseModel(ReadWhole(this->Folder / "www/api/models/ring/model.json"));
  ASSERT_TRUE(model);
  EXPECT_EQ(model->title, "A ring");
  EXPECT_EQ(model->digest, store->Info().digest);
  EXPECT_TRUE(fs::exists(this->Folder / "www/kdstream.nginx.conf"));
  EXPECT_TRUE(fs::exists(this->Folder / "www/.htaccess"));
}

TEST_F(TestExport, ModelsAreAddedAndReplaced)
{
  ASSERT_EQ(this->Export({ "ring.kds", "www", "--quiet" }).exitCode, 0);
  ASSERT_EQ(this->Export({ "ring.kds", "www", "--model", "another" }).exitCode, 0);
  ASSERT_EQ(this->List().size(), 2u);
  EXPECT_EQ(this->List()[0].id, "another");
  EXPECT_EQ(this->List()[1].id, "ring");
  const std::string before = this->List()[1].digest;
  this->ProgramsTest::Write("ring.ply", Torus(100, 50));
  ASSERT_EQ(this->Build({ "ring.ply", "-o", "ring.kds" }).exitCode, 0);
  ASSERT_EQ(this->Export({ "ring.kds", "www" }).exitCode, 0);
  ASSERT_EQ(this->List().size(), 2u);
  EXPECT_NE(this->List()[1].digest, before);
  // A client that reads the earlier build can continue.
  EXPECT_TRUE(fs::exists(this->Folder / "www/api/models/ring" / before));
}

// Other users may write to the folder, so only the link that the user names is followed.
TEST_F(TestExport, PlantedLinksAreNotFollowed)
{
  ASSERT_EQ(this->Export({ "ring.kds", "www" }).exitCode, 0);
  const std::string digest = this->List().at(0).digest;
  const fs::path www = this->Folder / "www", away = this->Folder / "away";
  for (const std::string& planted : { std::string("api"), std::string("api/models"),
         std::string("api/models/ring"), "api/models/ring/" + digest,
         "api/models/ring/" + digest + "/levels", std::string("api/models.json") })
  {
    fs::remove_all(www);
    fs::remove_all(away);
    ASSERT_EQ(this->Export({ "ring.kds", "www" }).exitCode, 0);
    ASSERT_TRUE(fs::exists(www / planted)) << planted;
    if (fs::is_directory(www / planted))
    {
      fs::create_directory(away);
    }
    else
    {
      fs::copy_file(www / planted, away);
    }
    fs::remove_all(www / planted);
    fs::create_symlink(away, www / planted);
    const Outcome outcome = this->Export({ "ring.kds", "www" });
    EXPECT_EQ(outcome.exitCode, 1) << planted;
    EXPECT_NE(outcome.err.find("www/" + planted + ": is a symbolic link, which is not followed"),
      std::string::npos)
      << planted << ": " << outcome.err;
    EXPECT_TRUE(fs::is_symlink(www / planted)) << planted;
    EXPECT_TRUE(!fs::is_directory(away) || fs::is_empty(away)) << planted;
    EXPECT_EQ(outcome.err.find("/proc/"), std::string::npos) << outcome.err;
  }
  // A link in place of a file is replaced, even if it leads to the same bytes.
  fs::remove_all(www);
  ASSERT_EQ(this->Export({ "ring.kds", "www" }).exitCode, 0);
  fs::path blob;
  for (const auto& entry : fs::recursive_directory_iterator(www / "api/models/ring" / digest))
  {
    blob = entry.is_regular_file() ? entry.path() : blob;
  }
  fs::rename(blob, this->Folder / "blob");
  fs::create_symlink(this->Folder / "blob", blob);
  ASSERT_EQ(this->Export({ "ring.kds", "www" }).exitCode, 0);
  EXPECT_FALSE(fs::is_symlink(blob));
  EXPECT_EQ(ReadWhole(blob), ReadWhole(this->Folder / "blob"));
  // A link of the user's own is followed.
  fs::rename(www, this->Folder / "real");
  fs::create_directory_symlink("real", www);
  EXPECT_EQ(this->Export({ "ring.kds", "www", "--model", "another" }).exitCode, 0);
  EXPECT_TRUE(fs::exists(this->Folder / "real/api/models/another/model.json"));
}

// The notes are the same as a server sends.
TEST_F(TestExport, NotesGoUpAndComeDownWithTheirModel)
{
  const auto notes = FormatNotes({ { "One", "<b>", "model=ring" }, { "Two", "", "model=ring" } });
  this->WriteText("ring.notes.json", notes);
  ASSERT_EQ(this->Export({ "ring.kds", "www", "--model", "torus" }).exitCode, 0);
  const fs::path file = this->Folder / "www/api/models/torus/notes.json";
  EXPECT_EQ(ReadWhole(file), notes);
  EXPECT_EQ(Uncompressed(file.string() + ".gz"), notes);
  EXPECT_EQ(this->List().at(0).notes, 2u);

  this->WriteText("ring.notes.json", "{}");
  const Outcome wrong = this->Export({ "ring.kds", "www", "--model", "torus" });
  EXPECT_EQ(wrong.exitCode, 1);
  EXPECT_NE(wrong.err.find("ring.notes.json: notes: \"type\" is missing"), std::string::npos)
    << wrong.err;
  EXPECT_EQ(ReadWhole(file), notes);

  fs::remove(this->Folder / "ring.notes.json");
  ASSERT_EQ(this->Export({ "ring.kds", "www", "--model", "torus" }).exitCode, 0);
  EXPECT_FALSE(fs::exists(file));
  EXPECT_FALSE(fs::exists(file.string() + ".gz"));
  EXPECT_EQ(this->List().at(0).notes, 0u);
}

// A model is exported completely or not at all.
TEST_F(TestExport, WhatFailsLeavesNothing)
{
  const auto files = [this]
  {
    std::set<std::string> all;
    if (fs::exists(this->Folder / "www"))
    {
      for (const auto& entry : fs::recursive_directory_iterator(this->Folder / "www"))
      {
        all.insert(entry.path().string());
      }
    }
    return all;
  };
  const auto damage = [this](const std::string& name)
  {
    fs::copy_file(this->Folder / "ring.kds", this->Folder / name);
    std::fstream store(this->Folder / name, std::ios::in | std::ios::out | std::ios::binary);
    constexpr std::streamoff inside = 100; // inside a page, not where pages are linked
    store.seekp(static_cast<std::streamoff>(fs::file_size(this->Folder / name) / 2) + inside);
    store.write("spoilt", 6);
  };
  damage("spoilt.kds");
  const Outcome first = this->Export({ "spoilt.kds", "www", "--model", "ring" });
  EXPECT_EQ(first.exitCode, 1);
  EXPECT_NE(first.err.find("wrong checksum"), std::string::npos) << first.err;
  EXPECT_FALSE(fs::exists(this->Folder / "www")) << "nor the folders";

  ASSERT_EQ(this->Export({ "ring.kds", "www" }).exitCode, 0);
  const auto before = files();
  EXPECT_EQ(std::count_if(before.begin(), before.end(),
              [](const std::string& file) { return file.find("/.kdstream") != std::string::npos; }),
    0);
  this->ProgramsTest::Write("ring.ply", Torus(100, 50));
  ASSERT_EQ(this->Build({ "ring.ply", "-o", "ring.kds" }).exitCode, 0);
  damage("again.kds");
  EXPECT_EQ(this->Export({ "again.kds", "www", "--model", "ring" }).exitCode, 1);
  EXPECT_EQ(files(), before) << "another digest";

  // Files that a killed run has left are removed.
  const auto store = *kdstream::Store::Open(this->Folder / "ring.kds");
  const auto digest = store->Info().digest;
  const auto left = this->Folder / "www/api/models/ring/.kdstream-files-0123456789abcdef-7-abcdef";
  fs::create_directories(left / digest / "tree");
  this->WriteText(
    (left / digest / "tree/1").lexically_relative(this->Folder.Path).string(), "half");
  ASSERT_EQ(this->Export({ "ring.kds", "www" }).exitCode, 0);
  EXPECT_FALSE(fs::exists(left));
  EXPECT_TRUE(fs::exists(this->Folder / "www/api/models/ring" / digest / "tree/1"));
}

// A file of which only the size is right is written again.
TEST_F(TestExport, ARerunComparesContents)
{
  ASSERT_EQ(this->Export({ "ring.kds", "www" }).exitCode, 0);
  const auto contents = [this]
  {
    std::map<std::string, std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(this->Folder / "www"))
    {
      if (entry.is_regular_file())
      {
        all[entry.path().string()] = ReadWhole(entry.path());
      }
    }
    return all;
  };
  const auto before = contents();
  for (const auto& [file, bytes] : before)
  {
    std::ofstream(file, std::ios::binary) << std::string(bytes.size(), '\0');
    if (file.find("models.json") != std::string::npos)
    {
      std::ofstream(file, std::ios::binary) << bytes;
    }
  }
  ASSERT_EQ(this->Export({ "ring.kds", "www" }).exitCode, 0);
  EXPECT_TRUE(contents() == before);
}

// If other users may write to the folder, links with predictable names may be traps.
TEST_F(TestExport, NoPlantedLinkIsFollowed)
{
  fs::create_directories(this->Folder / "elsewhere");
  fs::create_directories(this->Folder / "www/api/models/torus");
  this->WriteText("victim", "precious");
  const fs::path victim = this->Folder / "victim";
  this->WriteText("elsewhere/kept", "precious");
  const std::string hidden = ".kdstream-files-0123456789abcdef-7-abcdef";
  fs::create_symlink(this->Folder / "elsewhere", this->Folder / ("www/api/models/" + hidden));
  fs::create_symlink(this->Folder / "elsewhere", this->Folder / ("www/api/models/torus/" + hidden));
  for (const std::string name : { "www/.htaccess.new", "www/kdstream.nginx.conf.new",
         "www/api/models.json.new", "www/api/models/torus/model.json.new" })
  {
    fs::create_symlink(victim, this->Folder / name);
  }
  ASSERT_EQ(this->Export({ "ring.kds", "www" }).exitCode, 0);
  ASSERT_EQ(this->Export({ "ring.kds", "www", "--model", "torus" }).exitCode, 0);
  EXPECT_EQ(ReadWhole(this->Folder / "elsewhere/kept"), "precious");
  EXPECT_EQ(ReadWhole(victim), "precious");
  EXPECT_EQ(this->List().size(), 2u);
  EXPECT_FALSE(fs::is_symlink(this->Folder / "www/api/models/ring"));
}

// The umask decides who may read the exported files; usually the web server's user may.
TEST_F(TestExport, WhatGoesUpHasWhatTheUmaskGives)
{
  const mode_t before = ::umask(022);
  ASSERT_EQ(this->Export({ "ring.kds", "www" }).exitCode, 0);
  ::umask(before);
  for (const auto& entry : fs::recursive_directory_iterator(this->Folder / "www"))
  {
    const auto mode = static_cast<unsigned>(entry.status().permissions()) & 0777U;
    EXPECT_EQ(mode, entry.is_directory() ? 0755U : 0644U) << entry.path();
    EXPECT_FALSE(entry.path().filename().string().starts_with(".kdstream")) << entry.path();
  }
}

// The page that links lead to, with a head for messengers; the list says where each model's page
// is.
TEST_F(TestExport, WithTheViewersPageEachModelHasOneOfItsOwn)
{
  fs::create_directories(this->Folder / "web");
  this->WriteText("web/index.html",
    "<html><head><title>KdStream</title><link href=\"style.css\"></head><body></body></html>");
  this->WriteText("ring.notes.json", FormatNotes({ { "One", "<b>", "model=ring" } }));
  const auto hasPages = [this]
  {
    return ReadWhole(this->Folder / "www/api/models.json").find(R"("pages":"m/")") !=
           std::string::npos;
  };
  const auto has = [this](const std::string& file, const std::string& part)
  {
    const auto text = ReadWhole(this->Folder / file);
    EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;
  };
  ASSERT_EQ(
    this->Export({ "ring.kds", "www", "--page", "web", "--address", "https://example.org/scans" })
      .exitCode,
    0);
  const std::string page = "www/m/ring/index.html";
  has(page, "<title>A ring – KdStream</title>");
  has(page, "<link rel=\"canonical\" href=\"https://example.org/scans/m/ring/\">");
  has(page, "href=\"https://example.org/scans/m/ring/oembed.json\"");
  has(page, "href=\"../../style.css\"");
  EXPECT_EQ(Uncompressed((this->Folder / page).string() + ".gz"), ReadWhole(this->Folder / page));
  has("www/m/ring/oembed.json", "https://example.org/scans/m/ring/?embed");
  has("www/m/ring/manifest.json", "https://example.org/scans/m/ring/manifest.json");
  has("www/m/ring/manifest.json", "\"value\":\"<b>\"");
  EXPECT_EQ(ReadWhole(this->Folder / "www/m/ring/picture.jpg").substr(0, 3), "\xff\xd8\xff");
  has("www/m/index.html", "<a href=\"../m/ring/\">A ring</a>");
  has("www/sitemap.xml", "<url><loc>https://example.org/scans/m/ring/</loc></url>");
  EXPECT_TRUE(hasPages());

  ASSERT_EQ(this->Export({ "ring.kds", "www", "--page", "web" }).exitCode, 0);
  has(page, "<link rel=\"canonical\" href=\"../../m/ring/\">");
  EXPECT_FALSE(fs::exists(this->Folder / "www/m/ring/oembed.json")) << "it needs whole addresses";
  EXPECT_FALSE(fs::exists(this->Folder / "www/sitemap.xml")) << "and so does this";
  ASSERT_EQ(this->Export({ "ring.kds", "www", "--model", "bare" }).exitCode, 0);
  EXPECT_FALSE(hasPages()) << "not each has one";
  EXPECT_EQ(this->Export({ "ring.kds", "www", "--address", "https://example.org" }).exitCode, 2)
    << "without a page";
  EXPECT_EQ(
    this->Export({ "ring.kds", "www", "--page", "web", "--address", "/scans" }).exitCode, 2);
}

// A host of plain files, which supports neither streams nor regions.
TEST_F(TestExport, AViewerIsContentWithAHostOfFiles)
{
  ASSERT_EQ(this->Export({ "ring.kds", "www" }).exitCode, 0);
  const std::string said = (this->Folder / "said").string();
  const pid_t host = ::fork();
  if (host == 0)
  {
    if (std::freopen(said.c_str(), "w", stdout) && std::freopen("/dev/null", "w", stderr))
    {
      ::execlp("python3", "python3", "-u", "-m", "http.server", "--bind", "127.0.0.1",
        "--directory", (this->Folder / "www").c_str(), "0", nullptr);
    }
    ::_exit(127);
  }
  std::string port;
  for (int i = 0; i < 200 && port.empty(); ++i)
  {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const std::string text = ReadWhole(said); // "Serving HTTP on 127.0.0.1 port N (…"
    const auto at = text.find(" port ");
    port = at == std::string::npos ? "" : text.substr(at + 6, text.find(' ', at + 6) - at - 6);
  }
  const std::string url = "http://127.0.0.1:" + port;
  const auto view = [this](const std::string& source, const std::string& picture)
  {
    return RunTool(this->Folder, "view",
      { source, "--offscreen", "auto", "--size", "400x300", "--screenshot", picture });
  };
  const Outcome outcome = view(url, "files.png");
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_EQ(view("ring.kds", "store.png").exitCode, 0);
  EXPECT_EQ(ReadWhole(this->Folder / "files.png"), ReadWhole(this->Folder / "store.png"));
  EXPECT_GT(ReadWhole(this->Folder / "files.png").size(), 5000u);
  ::kill(host, SIGTERM);
  ::waitpid(host, nullptr, 0);
}

TEST_F(TestExport, WhatCannotBeWrittenIsSaid)
{
  this->WriteText("file", "");
  const Outcome noFolder = this->Export({ "ring.kds", "file" });
  EXPECT_EQ(noFolder.exitCode, 1);
  EXPECT_NE(noFolder.err.find("cannot be written"), std::string::npos) << noFolder.err;
  const Outcome name = this->Export({ "ring.kds", "www", "--model", "a b" });
  EXPECT_EQ(name.exitCode, 2);
  EXPECT_NE(name.err.find("'a b' cannot be a model's name"), std::string::npos) << name.err;
  const Outcome page = this->Export({ "ring.kds", "www", "--page", "." });
  EXPECT_EQ(page.exitCode, 1);
  EXPECT_NE(page.err.find("is not a web page: it has no index.html"), std::string::npos)
    << page.err;
  fs::create_directories(this->Folder / "www/api");
  this->WriteText("www/api/models.json", "something else");
  const Outcome list = this->Export({ "ring.kds", "www" });
  EXPECT_EQ(list.exitCode, 1);
  EXPECT_NE(list.err.find("www/api/models.json"), std::string::npos) << list.err;
  EXPECT_FALSE(fs::exists(this->Folder / "www/api/models"));
  EXPECT_EQ(this->Export({ "none.kds", "www" }).exitCode, 1);
}

}
