// SPDX-License-Identifier: BSD-3-Clause
// A walk on a slow connection: see SlowWalk.h.
#include "viewer/client/Testing/Replay/SlowWalk.h"

#include "viewer/client/Testing/Replay/MemoryCatalog.h"
#include "viewer/client/Testing/Replay/Recorder.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>

namespace kdstream::testing
{
namespace
{

using Kind = RecordedInput::Kind;

class SlowWalk
{
public:
  SlowWalk(const Catalog& models, bool stream, const std::string& file)
    : Phone(models, stream, file)
  {
    this->Phone.bytesPerSecond = 50e3;
    this->Phone.drawsEach = true;
  }

  bool Run()
  {
    this->Look();
    this->TapOnTheWay();
    this->MeetBudgets();
    this->Expect(this->Phone.Surfaces() > 40, "each arrival is drawn");
    this->Expect(this->Phone.Holes() == 0, "no surface has a hole");
    this->Expect(this->Phone.Finish(), "the files are written");
    return this->Good;
  }

private:
  void Look();
  void TapOnTheWay();
  void MeetBudgets();
  void TapSomewhere();
  std::ptrdiff_t OthersSent() const;
  void Expect(bool condition, const char* what);
  bool IsIdle() const { return this->Phone.Traced().Session().IsIdle(); }

  Recorder Phone;
  bool Good = true;
};

void SlowWalk::Expect(bool condition, const char* what)
{
  if (!condition)
  {
    const ViewerStatus status = this->Phone.Status();
    std::fprintf(stderr, "not as it should be: %s; %llu triangles, error: '%s'\n", what,
      static_cast<unsigned long long>(status.triangles), status.error.c_str());
    this->Good = false;
  }
}

// Zooms while much is outstanding.
void SlowWalk::Look()
{
  this->Phone.Do(Kind::Resize, { 1170, 2532, 3 });
  this->Phone.Do(Kind::Select, {}, "torus");
  this->Phone.Settle();
  this->Phone.Tap(600, 1300);
  this->Phone.Wait(1);
  for (int i = 0; i < 4; ++i)
  {
    this->Phone.Pinch(585 + 20 * i, 1266, 240, 400);
    this->Phone.Settle(5);
    this->Expect(!this->IsIdle(), "much is owed still");
  }
  this->Phone.Pinch(585, 1266, 600, 300);
  this->Phone.Settle(5);
}

// Taps until it hits the surface.
void SlowWalk::TapSomewhere()
{
  for (int i = 0; i < 40; ++i)
  {
    this->Phone.DoubleTap(585, 1266 + (i % 2 == 0 ? 30 : -30) * i);
    const ViewerStatus status = this->Phone.Status();
    if (status.picking || status.region)
    {
      return;
    }
    this->Phone.Do(Kind::Undo); // the tap missed the model, and went home
  }
  this->Expect(false, "no double tap hit the surface");
}

// How many of the sent blobs are not of the tree, and neither the picked partition nor a piece
// above it. TestTapByGet counts in the same way.
std::ptrdiff_t SlowWalk::OthersSent() const
{
  const auto region = this->Phone.Status().region;
  const TreeDepths depths = this->Phone.catalog.Find("torus")->Description().depths;
  return std::count_if(this->Phone.sent.begin(), this->Phone.sent.end(),
    [&](const protocol::BlobId& blob)
    {
      const NodeId node = IsOfPiece(blob) ? PieceOfBlob(blob, depths).node : 0;
      const bool isIntermediate =
        node != 0 && region && node == region->cell >> (depths.partition - DepthOfNode(node));
      return !IsOfTree(blob) && !isIntermediate;
    });
}

// Taps. The first partition must arrive after at most one blob that was requested before, not
// counting the tree and the pieces that the tap needs.
void SlowWalk::TapOnTheWay()
{
  this->TapSomewhere();
  this->Phone.sent.clear();
  const auto isShown = [this]
  {
    const auto region = this->Phone.Status().region;
    return region && region->shown > 0;
  };
  while (!isShown() && this->Phone.Settle(1) > 0)
  {
  }
  this->Expect(isShown(), "a partition is there");
  this->Expect(!this->IsIdle(), "before all else");
  this->Expect(this->OthersSent() <= 1, "soon");
  this->Phone.Settle();
  const auto region = this->Phone.Status().region;
  this->Expect(region && region->shown == region->partitions, "the region comes");
  this->Expect(
    this->Phone.Traced().Session().GetStatus().remainingError == 0, "all is fine enough");
}

void SlowWalk::MeetBudgets()
{
  const auto whole = this->Phone.Status().triangles;
  this->Phone.Do(Kind::Budgets, { 12'000, double(std::size_t{ 1 } << 28) });
  this->Phone.Settle();
  const auto met = this->Phone.Status();
  this->Expect(met.triangles < whole && met.triangles < 18'000, "fewer triangles");
  this->Expect(met.remainingError > 0, "what is left is told");
  this->Phone.Pinch(585, 1266, 300, 600);
  this->Phone.Settle();
  this->TapSomewhere();
  this->Phone.Settle();
  this->Expect(this->Phone.Status().triangles < 18'000, "near, too");
  this->Phone.Do(Kind::Budgets, { 2e6, double(std::size_t{ 1 } << 21) });
  this->Phone.Settle();
  this->Expect(this->Phone.Status().remainingError > 0, "memory is one, too");
  this->Phone.Do(Kind::Budgets, { 2e6, double(std::size_t{ 1 } << 28) });
  this->Phone.Settle();
  this->Expect(this->Phone.Status().remainingError == 0, "and finer again");
  this->Expect(this->IsIdle(), "all has come");
}

}

bool WalkSlowly(bool stream, const std::string& file)
{
  const MemoryCatalog models(ColoredTorus(), "torus");
  return SlowWalk(models, stream, file).Run();
}

}
