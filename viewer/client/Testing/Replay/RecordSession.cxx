// SPDX-License-Identifier: BSD-3-Clause
// Records one walk on a phone (Recorder.h): list of models, preview, full screen, pinches through
// the levels, regions, damage, outages, turning the phone, going home and undoing it, turning
// freely, and back.
//
//   RecordSession view|level torus FILE            a bumpy torus, over the stream
//   RecordSession view|level plate FILE            a plate, over GET
//   RecordSession view|level FOLDER/MODEL.kds FILE a store
//   RecordSession view slow|slow-get FILE          the torus on a slow line, with budgets
//   (SlowWalk.h)
//
// view: in view mode; level: with one level for the whole model.
//
// Writes FILE.recording and FILE.trace. Exit code 1 if the walk did not get into all the situations
// that it is for: a recording in which nothing happens proves nothing.
#include "server/session/StoreCatalog.h"
#include "viewer/client/Testing/Replay/MemoryCatalog.h"
#include "viewer/client/Testing/Replay/Recorder.h"
#include "viewer/client/Testing/Replay/SlowWalk.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <set>
#include <string>

using namespace kdstream;
using namespace kdstream::testing;

namespace
{

using Kind = RecordedInput::Kind;

// A square plate with a relief of roofs, each half as wide as the one below it. All coordinates are
// small multiples of 1/16, and much is symmetric, so distances are often equal. This shows if
// anything depends on the order of equal things.
Mesh MakePlate()
{
  constexpr std::uint32_t side = 256;
  Mesh mesh;
  const auto roofs = [](std::uint32_t i)
  {
    std::uint32_t height = 0;
    for (std::uint32_t period = 4; period <= 64; period *= 2)
    {
      height += std::min(i % period, period - i % period);
    }
    return height;
  };
  const auto at = [](std::uint32_t i, std::uint32_t j) { return i * side + j; };
  for (std::uint32_t i = 0; i < side; ++i)
  {
    for (std::uint32_t j = 0; j < side; ++j)
    {
      mesh.points.push_back({ static_cast<double>(i), static_cast<double>(j),
        static_cast<double>(roofs(i) + roofs(j)) / 16 });
      if (i > 0 && j > 0)
      {
        mesh.triangles.push_back({ at(i - 1, j - 1), at(i, j - 1), at(i, j) });
        mesh.triangles.push_back({ at(i - 1, j - 1), at(i, j), at(i - 1, j) });
      }
    }
  }
  return mesh;
}

class Walk
{
public:
  Walk(const Catalog& models, bool stream, bool byView, std::string model, const std::string& file)
    : Phone(models, stream, file)
    , ByView(byView)
    , Model(std::move(model))
    , Stream(stream)
  {
  }

  bool Run();

private:
  void Browse();
  void PinchThroughLevels();
  void PickRegions();
  void LoseTheServer();
  void TurnThePhone();
  void GoHome();
  void TurnFreely();
  void GoBack();

  void Expect(bool condition, const std::string& what);
  // Double taps at several places until the surface is hit: then there is a region, or it waits for
  // the server.
  void PickSomething(double x, double y);
  bool RegionIsShown() const;

  Recorder Phone;
  bool ByView;
  std::string Model;
  bool Stream;
  bool Good = true;
};

void Walk::Expect(bool condition, const std::string& what)
{
  if (!condition)
  {
    std::fprintf(stderr, "not as it should be: %s; error: '%s'\n", what.c_str(),
      this->Phone.Status().error.c_str());
    this->Good = false;
  }
}

bool Walk::RegionIsShown() const
{
  const ViewerStatus status = this->Phone.Status();
  return status.region && status.region->shown == status.region->partitions;
}

void Walk::PickSomething(double x, double y)
{
  const auto before = this->Phone.Status().region;
  for (int i = 0; i < 40; ++i)
  {
    const double way = 45.0 * i;
    const bool across = i % 2 == 0;
    this->Phone.DoubleTap(x + (across ? way : 0), y + (across ? 0 : way));
    while (this->Phone.Status().picking && this->Phone.Answer())
    {
    }
    const ViewerStatus status = this->Phone.Status();
    if (status.picking || (status.region && (!before || status.region->cell != before->cell)))
    {
      return;
    }
    if (status.canUndo)
    {
      this->Phone.Do(Kind::Undo); // the tap missed the model, and went home
    }
  }
  this->Expect(false, "no double tap hit the surface");
}

void Walk::Browse()
{
  this->Phone.Do(Kind::Resize, { 1170, 2532, 3 });
  this->Phone.Do(Kind::Detail, { this->ByView ? 0.0 : 1.0 });
  this->Phone.Do(Kind::Select, {}, "no-such-model");
  this->Phone.Do(Kind::Select, {}, this->Model);
  this->Phone.Settle();
  this->Expect(this->Phone.Status().shownLevel == 11u, "the preview is shown");
  this->Phone.Drag(500, 1200, 180, 75);
  this->Phone.Tap(600, 1300);
  this->Expect(this->Phone.Status().mode == ViewerMode::FullScreen, "a tap fills the screen");
  this->Phone.Wait(1);
  this->Phone.Settle();
}

void Walk::PinchThroughLevels()
{
  std::set<unsigned> inwards, outwards;
  for (int i = 0; i < 7; ++i)
  {
    this->Phone.Pinch(585 + 20 * i, 1266, 240, 350);
    this->Phone.Settle();
    inwards.insert(*this->Phone.Status().shownLevel);
  }
  const bool original = this->ByView && this->Phone.Status().original;
  this->Expect(original || inwards.size() >= (this->ByView ? 2 : 3),
    "pinching in goes through levels, by the view perhaps to the original at once");
  for (int i = 0; i < 6; ++i)
  {
    this->Phone.Pinch(585, 1266, 620, 260, 15, -20);
    this->Phone.Settle(9); // some answers, before the rest is cancelled
    outwards.insert(*this->Phone.Status().shownLevel);
  }
  this->Phone.Settle();
  this->Expect(outwards.size() >= 2, "pinching out goes back");
  this->Phone.Pinch(585, 1266, 240, 700);
  this->Phone.Settle();
}

void Walk::PickRegions()
{
  this->PickSomething(585, 1266);
  this->Phone.Settle(7);
  this->Phone.Break();
  this->Phone.Wait(2);
  this->Phone.Do(Kind::Tick);
  this->Phone.Settle();
  this->Expect(this->RegionIsShown(), "the region comes over a lost connection");

  this->Phone.Pinch(585, 1266, 400, 420, 150, 60);
  this->Phone.Do(Kind::Rings, { 2 });
  this->PickSomething(300, 900);
  this->Phone.Settle(3);
  this->Phone.DamageNext();
  this->Phone.Settle();
  this->Expect(!this->Phone.Status().error.empty(), "a damaged blob is told of");
  this->Phone.Do(Kind::Touches, { 1, 100, 100 });
  this->Phone.Wait(0.01);
  this->Phone.Do(Kind::CancelTouches);
  this->PickSomething(585, 1266);
  this->Phone.Settle();
  this->Expect(this->RegionIsShown(), "the second region is there");
  this->Expect(this->Phone.Status().error.empty(), "the error has gone");
}

void Walk::LoseTheServer()
{
  for (std::uint32_t partition = 0; partition < 64; partition += 3)
  {
    this->Phone.catalog.unreadable.insert(protocol::BlobId::Partition(partition));
  }
  this->Phone.serverIsUp = false;
  this->Phone.Break();
  this->Phone.Do(Kind::Rings, { 3 });
  this->PickSomething(700, 1500);
  this->Phone.Settle();
  this->Phone.Wait(0.1);
  this->Phone.Do(Kind::Tick);
  this->Phone.Settle();
  this->Expect(!this->Phone.Traced().Line().Trouble().empty(), "the line says what is wrong");
  for (int i = 0; i < 4; ++i)
  {
    this->Phone.Wait(3);
    this->Phone.Do(Kind::Tick);
    this->Phone.Settle();
  }
  this->Phone.serverIsUp = true;
  this->Phone.Do(Kind::RetryNow);
  this->Phone.Do(Kind::Tick);
  this->Phone.Settle();
  this->Expect(this->Phone.Traced().Line().Trouble().empty(), "the server is back");
  this->Expect(this->Phone.Traced().Session().IsIdle(), "all that was asked has been answered");
  this->Phone.catalog.unreadable.clear();
}

void Walk::TurnThePhone()
{
  this->Phone.Do(Kind::Resize, { 2532, 1170, 3 });
  this->Phone.Settle();
  this->Phone.Drag(1266, 585, -200, 33);
  for (const double factor : { 0.6, 1.9, 0.8, 1.3, 2.1 })
  {
    this->Phone.Do(Kind::Wheel, { factor, 1300, 570 });
    this->Phone.Settle();
  }
  this->PickSomething(1266, 585);
  this->Phone.Settle();
  this->Expect(this->RegionIsShown(), "a region in landscape");
}

void Walk::GoHome()
{
  const Vec3 eye = this->Phone.Traced().Session().Scene().eye;
  this->Phone.Do(Kind::Home);
  this->Phone.Settle();
  this->Expect(this->Phone.Traced().Session().Scene().eye != eye, "home is elsewhere");
  this->Phone.Do(Kind::Undo);
  this->Phone.Settle();
  this->Expect(this->Phone.Traced().Session().Scene().eye == eye, "and undone");
}

void Walk::TurnFreely()
{
  this->Phone.Do(Kind::Turning, { 1 });
  for (int i = 0; i <= 12; ++i)
  {
    const double x = 300 * std::cos(0.1 * i), y = 300 * std::sin(0.1 * i);
    this->Phone.Do(Kind::Touches, { 1, 1266 - x, 585 - y, 2, 1266 + x, 585 + y });
    this->Phone.Do(Kind::Draw);
    this->Phone.Wait(1.0 / 60);
  }
  this->Phone.Do(Kind::Touches);
  this->Phone.Drag(1266, 585, 90, -140);
  this->Phone.Do(Kind::Turning, { 0 });
  this->Phone.Do(Kind::Coast, { 1 });
  this->Phone.Drag(1266, 585, -160, 60);
  this->Expect(this->Phone.Status().coasting, "what is let go turns on");
  for (int i = 0; i < 90; ++i)
  {
    this->Phone.Wait(1.0 / 60);
    this->Phone.Do(Kind::Draw);
  }
  this->Expect(!this->Phone.Status().coasting, "for a moment");
  this->Phone.Do(Kind::Coast, { 0 });
  this->Phone.Settle();
}

void Walk::GoBack()
{
  this->Phone.Do(Kind::Back);
  this->Phone.Settle();
  const ViewerStatus status = this->Phone.Status();
  this->Expect(status.mode == ViewerMode::Browsing && !status.region, "back to the preview");
  this->Phone.Do(Kind::Rings, { 3 });
  this->PickSomething(1266, 585);
  this->Phone.Settle();
  this->Expect(this->RegionIsShown(), "a region of three rings");
}

bool Walk::Run()
{
  this->Browse();
  this->PinchThroughLevels();
  this->PickRegions();
  this->LoseTheServer();
  this->TurnThePhone();
  this->GoHome();
  this->TurnFreely();
  this->GoBack();
  const bool streams = this->Phone.Traced().Line().GetState() == ServerLine::State::Streaming;
  this->Expect(streams == this->Stream, "the line is the one meant");
  this->Expect(this->Phone.Finish(), "the files are written");
  return this->Good;
}

}

int main(int count, char** arguments)
{
  const std::string detail = count == 4 ? arguments[1] : "";
  const bool byView = detail == "view";
  const std::string what = count == 4 ? arguments[2] : "";
  const bool isSlow = what == "slow" || what == "slow-get";
  if ((!byView && detail != "level") || (isSlow && !byView))
  {
    std::fprintf(stderr, "usage: RecordSession view|level torus|plate|FOLDER/MODEL.kds FILE\n"
                         "       RecordSession view slow|slow-get FILE\n");
    return 2;
  }
  if (what == "torus" || what == "plate")
  {
    const bool torus = what == "torus";
    const MemoryCatalog models(torus ? ColoredTorus() : MakePlate(), what);
    return Walk(models, torus, byView, what, arguments[3]).Run() ? 0 : 1;
  }
  if (isSlow)
  {
    return WalkSlowly(what == "slow", arguments[3]) ? 0 : 1;
  }
  const std::filesystem::path store = what;
  StoreCatalog stores(store.parent_path(),
    [](const std::filesystem::path& file, const std::string& wrong)
    { std::fprintf(stderr, "%s: %s\n", file.c_str(), wrong.c_str()); });
  if (const Status status = stores.Reload(); !status)
  {
    std::fprintf(stderr, "%s\n", status.GetError().message.c_str());
    return 2;
  }
  return Walk(stores, true, byView, store.stem().string(), arguments[3]).Run() ? 0 : 1;
}
