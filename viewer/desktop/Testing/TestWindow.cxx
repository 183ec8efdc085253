// SPDX-License-Identifier: BSD-3-Clause
// kdstream-view's window as a user operates it: on an X server, by xdotool. CMake runs this under
// xvfb-run.
#include "filters/store/StoreNotes.h"
#include "server/http/HttpServer.h"
#include "viewer/client/Testing/TorusCatalog.h"
#include "viewer/desktop/Testing/PicturesCompared.h"
#include "viewer/desktop/Testing/ReadClipboard.h"
#include "viewer/desktop/Testing/ScreenPicture.h"
#include "viewer/session/SessionFile.h"

#include "Testing/Fixtures/TemporaryFolder.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <thread>

using namespace kdstream;
using namespace std::chrono_literals;
using fixtures::ReadWhole;
using fixtures::TemporaryFolder;
using kdstream::testing::LookAtScreen;
using kdstream::testing::ReadClipboard;
using kdstream::testing::ScreenPicture;
using kdstream::testing::ShareThatDiffers;
using kdstream::testing::TorusModel;

namespace
{

const std::string program = KDSTREAM_PROGRAMS "/kdstream-view";
constexpr int windowWidth = 800, windowHeight = 600;
constexpr auto patience = 60s; // per step, even on a busy machine

// A catalog with the same ring under several names.
class Rings : public Catalog
{
public:
  Rings()
  {
    for (const std::string id : { "first", "second", "third" })
    {
      auto model = std::make_shared<TorusModel>();
      model->described = kdstream::testing::ServedTorus().Description();
      model->described->id = id;
      model->described->title = "The " + id + " ring";
      this->All.push_back(model);
    }
  }
  std::vector<std::shared_ptr<const ServedModel>> Models() const override { return this->All; }
  std::shared_ptr<const ServedModel> Find(std::string_view id) const override
  {
    const auto found = std::find_if(this->All.begin(), this->All.end(),
      [&](const auto& model) { return model->Description().id == id; });
    return found == this->All.end() ? nullptr : *found;
  }

private:
  std::vector<std::shared_ptr<const ServedModel>> All;
};

class TestWindow : public ::testing::Test
{
protected:
  TestWindow() { this->Server = std::move(*HttpServer::Start(this->Models, {})); }
  ~TestWindow() override
  {
    if (this->Process > 0)
    {
      ::kill(this->Process, SIGKILL);
      ::waitpid(this->Process, nullptr, 0);
    }
  }

  static void Do(const std::string& command)
  {
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
  }
  static void Hands(const std::string& what) { Do("xdotool " + what + " >/dev/null"); }

  // Starts the program, and waits until its window is there.
  void Open(const std::string& arguments)
  {
    this->Process = ::fork();
    if (this->Process == 0)
    {
      const std::string command = "cd '" + this->Folder.Path.string() +
                                  "' && XDG_CACHE_HOME=\"$PWD/kept\" exec '" + program + "' " +
                                  arguments + " >out 2>err";
      ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
      ::_exit(127);
    }
    Hands("search --sync --onlyvisible --class kdstream-view");
  }

  // Presses keys, or Ctrl-C in the terminal, until the program has ended; returns its exit code.
  int End(bool inTerminal = false)
  {
    if (inTerminal)
    {
      ::kill(this->Process, SIGINT);
    }
    int status = 0;
    const auto last = std::chrono::steady_clock::now() + patience;
    while (::waitpid(this->Process, &status, WNOHANG) == 0)
    {
      if (std::chrono::steady_clock::now() > last)
      {
        ADD_FAILURE() << "it does not end";
        return -1;
      }
      if (!inTerminal)
      {
        std::system("xdotool key q >/dev/null 2>&1");
      }
      std::this_thread::sleep_for(200ms);
    }
    this->Process = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

  std::string Err() { return ReadWhole(this->Folder / "err"); }

  std::size_t Pictures(const std::string& model)
  {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(this->Folder.Path))
    {
      const std::string name = entry.path().filename().string();
      count += name.rfind(model, 0) == 0 && name.ends_with(".png") ? 1 : 0;
    }
    return count;
  }

  // Presses S until two consecutive pictures of the model are equal; returns the last one's name.
  std::string SettledPicture(const std::string& model)
  {
    std::filesystem::path before;
    const auto last = std::chrono::steady_clock::now() + patience;
    while (std::chrono::steady_clock::now() < last)
    {
      const std::size_t count = this->Pictures(model) + 1;
      const std::filesystem::path now =
        this->Folder / (model + (count > 1 ? "-" + std::to_string(count) : "") + ".png");
      while (!std::filesystem::exists(now) && std::chrono::steady_clock::now() < last)
      {
        // Press again only if nothing was shown yet. Otherwise the picture is just late, and a
        // second key press would write a picture after the next step.
        Hands("key s");
        const int waits = count > 1 ? 200 : 20;
        for (int i = 0; i < waits && !std::filesystem::exists(now); ++i)
        {
          std::this_thread::sleep_for(50ms);
        }
      }
      if (!before.empty() && ReadWhole(now) == ReadWhole(before))
      {
        return now.filename().string();
      }
      before = now;
      std::this_thread::sleep_for(300ms);
    }
    throw std::runtime_error("the picture of " + model + " does not settle; " + this->Err());
  }

  Rings Models;
  std::unique_ptr<HttpServer> Server;
  TemporaryFolder Folder;
  pid_t Process = -1;
};

// The position of the middle of preview `i` in the strip of three.
std::string Preview(int i)
{
  constexpr int step = 138;
  constexpr int left = (windowWidth - 3 * step + 10) / 2;
  return std::to_string(left + i * step + 64) + " " + std::to_string(windowHeight - 90);
}

std::string Size()
{
  return std::to_string(windowWidth) + "x" + std::to_string(windowHeight);
}

TEST_F(TestWindow, WhatAPersonDoesIsShownAndPlaysAgain)
{
  this->Open(this->Server->Url() + " --size " + Size() +
             " --record r.jsonl --report report.json --stats stats.json");
  // The preview of the first model, above the strip.
  const std::string preview = this->SettledPicture("first");
  // A click on another preview opens that model in the whole window.
  Hands("mousemove " + Preview(1) + " click 1");
  const std::string opened = this->SettledPicture("second");
  ASSERT_FALSE(opened.empty());
  EXPECT_EQ(ShareThatDiffers(this->Folder / preview, this->Folder / opened), 1)
    << "the strip has gone: the model has the whole window";
  // The wheel zooms in on the ring.
  Hands("mousemove 400 420");
  for (int i = 0; i < 4; ++i)
  {
    Hands("click 4");
  }
  const std::string near = this->SettledPicture("second");
  EXPECT_GT(ShareThatDiffers(this->Folder / opened, this->Folder / near), 0.05);
  // A drag turns the model; a double click streams the original there.
  Hands("mousedown 1 mousemove_relative -- 30 0 mousemove_relative -- 60 10 mouseup 1");
  const std::string turned = this->SettledPicture("second");
  EXPECT_GT(ShareThatDiffers(this->Folder / near, this->Folder / turned), 0.02);
  Hands("mousemove 400 330 click --repeat 2 --delay 60 1");
  const std::string last = this->SettledPicture("second");
  ASSERT_EQ(this->End(), 0) << this->Err();
  EXPECT_EQ(this->Err(), "");

  const auto report = nlohmann::json::parse(ReadWhole(this->Folder / "report.json"));
  EXPECT_GT(report.at("blobs"), 5);
  EXPECT_GT(nlohmann::json::parse(ReadWhole(this->Folder / "stats.json")).size(), 5u);

  // The recording is replayed without a window, in another folder.
  const TemporaryFolder again;
  Do("cd '" + again.Path.string() + "' && '" + program + "' " + this->Server->Url() + " --size " +
     Size() + " --offscreen x11 --replay '" + (this->Folder / "r.jsonl").string() + "'");
  for (const std::string& picture : { preview, opened, near, turned, last })
  {
    EXPECT_LE(ShareThatDiffers(this->Folder / picture, again / picture), 0.002)
      << picture << "\n"
      << ReadWhole(this->Folder / "r.jsonl");
  }
}

// A recording has the settings at its beginning and those made later, so its replay needs no
// options.
TEST_F(TestWindow, SettingsAreRecorded)
{
  this->Open(this->Server->Url() + " --model second --size " + Size() +
             " --colour-by partition --light plain --triangles 5000 --rings 2 --record r.jsonl");
  const std::string colored = this->SettledPicture("second");
  Hands("mousemove 400 490 click --repeat 2 --delay 60 1");
  const std::string tapped = this->SettledPicture("second");
  Hands("key b");
  const std::string boxed = this->SettledPicture("second");
  EXPECT_GT(ShareThatDiffers(this->Folder / tapped, this->Folder / boxed), 0.001)
    << ReadWhole(this->Folder / "r.jsonl");
  ASSERT_EQ(this->End(), 0) << this->Err();

  const TemporaryFolder again;
  Do("cd '" + again.Path.string() + "' && '" + program + "' " + this->Server->Url() + " --size " +
     Size() + " --offscreen x11 --replay '" + (this->Folder / "r.jsonl").string() + "'");
  for (const std::string& picture : { colored, tapped, boxed })
  {
    EXPECT_LE(ShareThatDiffers(this->Folder / picture, again / picture), 0.002)
      << picture << "\n"
      << ReadWhole(this->Folder / "r.jsonl");
  }
}

// K cycles through the arrays, and back to the model's own colours; a recording has these steps.
TEST_F(TestWindow, ColoursByTheNextArray)
{
  std::ofstream cloud(this->Folder / "cloud.ply");
  cloud << "ply\nformat ascii 1.0\nelement vertex 3600\nproperty float x\nproperty float y\n"
           "property float z\nproperty float reflectance\nproperty uchar kind\nend_header\n";
  for (int i = 0; i < 3600; ++i)
  {
    const int x = i % 60, y = i / 60;
    cloud << x << " " << y << " 0 " << x * 0.25 << " " << (y < 30 ? 1 : 2) << "\n";
  }
  cloud.close();
  this->Open("cloud.ply --size " + Size() + " --record r.jsonl");
  const std::string own = this->SettledPicture("cloud");
  Hands("key k");
  const std::string measure = this->SettledPicture("cloud");
  Hands("key k");
  const std::string kinds = this->SettledPicture("cloud");
  Hands("key k");
  const std::string again = this->SettledPicture("cloud");
  EXPECT_GT(ShareThatDiffers(this->Folder / own, this->Folder / measure), 0.1);
  EXPECT_GT(ShareThatDiffers(this->Folder / measure, this->Folder / kinds), 0.1);
  EXPECT_EQ(ShareThatDiffers(this->Folder / own, this->Folder / again), 0);
  ASSERT_EQ(this->End(), 0) << this->Err();
  const std::string record = ReadWhole(this->Folder / "r.jsonl");
  for (const char* line :
    { R"({"colours":"by:reflectance"})", R"({"colours":"by:kind"})", R"({"colours":"own"})" })
  {
    EXPECT_NE(record.find(line), std::string::npos) << record;
  }
  const TemporaryFolder elsewhere;
  Do("cd '" + elsewhere.Path.string() + "' && '" + program + "' '" +
     (this->Folder / "cloud.ply").string() + "' --size " + Size() + " --offscreen x11 --replay '" +
     (this->Folder / "r.jsonl").string() + "'");
  EXPECT_LE(ShareThatDiffers(this->Folder / measure, elsewhere / measure), 0.002);
}

TEST_F(TestWindow, KeysOpenPanelsAndGoFromModelToModel)
{
  this->Open(this->Server->Url() + " --model third --size " + Size());
  const std::string third = this->SettledPicture("third");
  for (const char* key : { "F1", "o", "d", "b", "m", "Escape", "Escape", "Escape", "Tab", "Tab" })
  {
    Hands("key " + std::string(key));
  }
  // Pictures do not show panels.
  Hands("key F1");
  const std::string withHelp = this->SettledPicture("third");
  EXPECT_EQ(ShareThatDiffers(this->Folder / third, this->Folder / withHelp), 0);
  Hands("key Next");
  EXPECT_FALSE(this->SettledPicture("first").empty());
  Hands("key Prior");
  this->SettledPicture("third");
  Hands("key plus");
  const std::string nearer = this->SettledPicture("third");
  EXPECT_GT(ShareThatDiffers(this->Folder / third, this->Folder / nearer), 0.05);
  Hands("key h");
  const std::string home = this->SettledPicture("third");
  EXPECT_LE(ShareThatDiffers(this->Folder / third, this->Folder / home), 0.002);
  EXPECT_EQ(this->End(), 0) << this->Err();
}

// A panel appears in the same picture in which its button is shown as pressed, although a new panel
// must be measured first.
TEST_F(TestWindow, PanelsAreThereWithTheirButton)
{
  this->Open(this->Server->Url() + " --model third --size " + Size());
  this->SettledPicture("third");
  std::this_thread::sleep_for(5s); // until the note of the picture has gone
  const auto buttons = [] { return LookAtScreen(100, 4, windowWidth - 104, 50); };
  const auto below = []
  { return LookAtScreen(windowWidth / 2 - 30, windowHeight / 2 - 30, 60, 60); };
  const ScreenPicture free = buttons();
  const ScreenPicture without = below();
  for (const char* key : { "F1", "o", "d" })
  {
    SCOPED_TRACE(key);
    for (const bool opens : { true, false })
    {
      Hands("key " + std::string(key));
      const auto last = std::chrono::steady_clock::now() + patience / 4;
      bool changed = false;
      while (!changed && std::chrono::steady_clock::now() < last)
      {
        changed = (buttons() == free) != opens;
      }
      EXPECT_NE(below() == without, opens) << opens;
      EXPECT_TRUE(changed) << opens;
    }
  }
  EXPECT_EQ(this->End(), 0) << this->Err();
}

// The list of keys stays on the screen while a picture is written, though the picture does not have
// it.
TEST_F(TestWindow, PanelsStayWhileAPictureIsWritten)
{
  this->Open(this->Server->Url() + " --model third --size " + Size());
  const std::string before = this->SettledPicture("third");
  Hands("key F1");
  std::this_thread::sleep_for(2s);
  const auto list = []
  { return LookAtScreen(windowWidth / 2 - 60, windowHeight / 2 - 60, 120, 120); };
  const ScreenPicture shown = list();
  const std::size_t pictures = this->Pictures("third");
  std::size_t looks = 0, without = 0;
  for (int i = 0; i < 5; ++i)
  {
    Hands("key s");
    const auto last = std::chrono::steady_clock::now() + 600ms;
    while (std::chrono::steady_clock::now() < last)
    {
      ++looks;
      without += list() != shown ? 1 : 0;
    }
  }
  EXPECT_EQ(without, 0u) << "of " << looks << " looks";
  EXPECT_GT(looks, 50u);
  const std::string after = this->SettledPicture("third");
  EXPECT_GT(this->Pictures("third"), pictures);
  EXPECT_EQ(ShareThatDiffers(this->Folder / before, this->Folder / after), 0);
  EXPECT_EQ(this->End(), 0) << this->Err();
}

TEST_F(TestWindow, AServerThatGoesIsReportedAndTheWindowGoesOn)
{
  this->Open(this->Server->Url() + " --model first --size " + Size());
  this->SettledPicture("first");
  this->Server.reset();
  Hands("key Next");
  const auto last = std::chrono::steady_clock::now() + patience;
  while (this->Err().empty() && std::chrono::steady_clock::now() < last)
  {
    std::this_thread::sleep_for(100ms);
  }
  EXPECT_EQ(this->Err().rfind("kdstream-view: error: http://127.0.0.1:", 0), 0u) << this->Err();
  Hands("key F1");
  EXPECT_EQ(this->End(), 0) << "it can still be closed";
}

TEST_F(TestWindow, ToolsMeasureAndCopy)
{
  this->Open(this->Server->Url() + " --model first --record r.jsonl --size " + Size());
  this->SettledPicture("first");
  Hands("key t");
  Hands("key r");
  Hands("mousemove 640 280 click 1 sleep 0.6 mousemove 660 320 click 1 sleep 0.6 key 5 key l");
  std::string copied;
  const auto last = std::chrono::steady_clock::now() + patience;
  while ((copied = ReadClipboard()).empty() && std::chrono::steady_clock::now() < last)
  {
    std::this_thread::sleep_for(100ms); // the window is not there yet
  }
  EXPECT_EQ(copied.rfind(this->Server->Url() + "/#model=first&digest=", 0), 0u) << copied;
  EXPECT_EQ(this->End(), 0) << this->Err();
  const std::string recorded = ReadWhole(this->Folder / "r.jsonl");
  EXPECT_NE(recorded.find("{\"tool\":\"measure\"}"), std::string::npos) << recorded;
  EXPECT_NE(recorded.find("{\"side\":\"top\"}"), std::string::npos) << recorded;
}

// The notes are saved beside the store that is shown. Keys that are typed as text are not commands.
TEST_F(TestWindow, NotesAreWrittenAndSteppedThrough)
{
  const std::string tools = program.substr(0, program.rfind("kdstream-view"));
  Do("cd '" + this->Folder.Path.string() + "' && '" + tools +
     "kdstream-generate' vase vase.ply --vertices 5000 --quiet && '" + tools +
     "kdstream-build' vase.ply -o vase.kds --quiet");
  const auto notesAre = [this](const std::vector<Note>& wanted)
  {
    const auto last = std::chrono::steady_clock::now() + patience;
    Result<NotesText> notes = Error{};
    while (std::chrono::steady_clock::now() < last)
    {
      notes = ReadNotes(this->Folder / "vase.notes.json");
      if (notes && notes->notes.size() == wanted.size())
      {
        break;
      }
      std::this_thread::sleep_for(100ms);
    }
    ASSERT_TRUE(notes) << notes.GetError().message;
    ASSERT_EQ(notes->notes.size(), wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i)
    {
      EXPECT_EQ(notes->notes[i].title, wanted[i].title);
      EXPECT_EQ(notes->notes[i].text, wanted[i].text);
      EXPECT_EQ(notes->notes[i].link.rfind("model=vase&digest=", 0), 0u) << notes->notes[i].link;
    }
  };
  this->Open("vase.kds --size " + Size());
  const std::string first = this->SettledPicture("vase");
  // Press "Add a note here", type title and text, press "Keep this note".
  const std::string add = "sleep 1 key n sleep 1 mousemove 570 153 click 1 sleep 1 ";
  Hands(add + "type 'A quakex'");
  Hands("key BackSpace");
  Hands("key Return"); // on to the text
  Hands("type 'of 1687'");
  Hands("key Return");
  Hands("type 'q'");
  Hands("key Escape"); // leave the field, and keep its text
  Hands("key q");      // does not quit yet, but asks
  Hands("sleep 1 mousemove 560 370 click 1 sleep 1 key n");
  Hands("mousemove 300 400 mousedown 1 mousemove_relative -- 90 0 mousemove_relative -- 90 20 "
        "mouseup 1");
  const std::string turned = this->SettledPicture("vase");
  EXPECT_GT(ShareThatDiffers(this->Folder / first, this->Folder / turned), 0.01);
  // Press "Save notes", below the list.
  Hands("key n sleep 1 mousemove 700 159 click 1 sleep 1");
  notesAre({ { "A quake", "of 1687\nq", "" } });
  // A click on the note shows its view again.
  Hands("mousemove 560 104 click 1 sleep 1");
  const std::string again = this->SettledPicture("vase");
  EXPECT_LE(ShareThatDiffers(this->Folder / first, this->Folder / again), 0.01);
  EXPECT_EQ(this->End(), 0) << this->Err();
  EXPECT_EQ(this->Err(), "");
}

TEST_F(TestWindow, ToolsCutAndShine)
{
  this->Open(
    this->Server->Url() + " --model first --record r.jsonl --report r.json --size " + Size());
  const std::string before = this->SettledPicture("first");
  Hands("key c");
  const std::string cut = this->SettledPicture("first");
  EXPECT_GT(ShareThatDiffers(this->Folder / before, this->Folder / cut), 0.02);
  Hands("mousemove 640 280 mousedown 1 mousemove 640 300 mousemove 640 340 mouseup 1");
  const std::string moved = this->SettledPicture("first");
  EXPECT_GT(ShareThatDiffers(this->Folder / cut, this->Folder / moved), 0.005);
  Hands("key i");
  Hands("mousemove 640 280 mousedown 1 mousemove 540 280 mousemove 300 300 mouseup 1");
  const std::string lit = this->SettledPicture("first");
  EXPECT_GT(ShareThatDiffers(this->Folder / moved, this->Folder / lit), 0.02);
  EXPECT_EQ(this->End(), 0) << this->Err();
  const std::string recorded = ReadWhole(this->Folder / "r.jsonl");
  for (const char* step :
    { "{\"section\":\"view\"}", "{\"tool\":\"section\"}", "{\"tool\":\"light\"}" })
  {
    EXPECT_NE(recorded.find(step), std::string::npos) << recorded;
  }
  const std::string report = ReadWhole(this->Folder / "r.json");
  EXPECT_NE(report.find("&section="), std::string::npos) << report;
  EXPECT_NE(report.find("&lamps="), std::string::npos) << report;
}

TEST_F(TestWindow, AnInterruptBeforeAnythingIsSeenIsAFailure)
{
  const int silent = ::socket(AF_INET, SOCK_STREAM, 0); // a server that never answers
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  ASSERT_EQ(::bind(silent, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(::listen(silent, 4), 0);
  ASSERT_EQ(::getsockname(silent, reinterpret_cast<sockaddr*>(&address), &size), 0);
  this->Open("http://127.0.0.1:" + std::to_string(ntohs(address.sin_port)));
  EXPECT_EQ(this->End(true), 1);
  EXPECT_EQ(this->Err(), "kdstream-view: error: interrupted\n");
  ::close(silent);

  this->Open(this->Server->Url() + " --model first --size " + Size());
  this->SettledPicture("first");
  EXPECT_EQ(this->End(true), 0) << "as if it had been closed";
}

// The message is the same as without a window. The window stays, with the model's own colours.
TEST_F(TestWindow, AnArrayThatTheModelHasNotIsReported)
{
  std::ofstream(this->Folder / "cloud.ply")
    << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
       "property float z\nproperty float reflectance\nend_header\n0 0 0 1\n1 0 0 2\n0 1 0 3\n";
  this->Open("cloud.ply --colour-by reflectanse --size " + Size());
  const auto last = std::chrono::steady_clock::now() + patience;
  while (this->Err().find("error") == std::string::npos && std::chrono::steady_clock::now() < last)
  {
    std::this_thread::sleep_for(100ms);
  }
  EXPECT_NE(this->Err().find(
              "kdstream-view: error: cloud.ply: the model has no array of numbers 'reflectanse' to "
              "colour it by; it has 'reflectance'; did you mean reflectance?\n"),
    std::string::npos)
    << this->Err();
  this->SettledPicture("cloud");
  EXPECT_EQ(this->End(), 1);
}

TEST_F(TestWindow, WhatCannotBeOpenedIsReportedAndCanBeTriedAgain)
{
  const std::string url = this->Server->Url();
  this->Server.reset();
  this->Open(url + " --size " + Size());
  const auto last = std::chrono::steady_clock::now() + patience;
  while (this->Err().empty() && std::chrono::steady_clock::now() < last)
  {
    std::this_thread::sleep_for(100ms);
  }
  EXPECT_NE(this->Err().find("cannot be reached"), std::string::npos) << this->Err();
  EXPECT_EQ(this->End(), 0);
}

}
