// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry to the viewer session. The bytes say what the user, the connection and the
// server do, correct or wrong. Checks two things. When the server finally answers correctly, except
// for blobs that it has lost, the session comes to rest, whatever happened before. And the drawn
// surface never has a hole, unless a piece was sent in place of another one: a session cannot
// detect that in a single piece.
#include "viewer/session/MemoryBudget.h"
#include "viewer/session/Testing/MemoryServer.h"
#include "viewer/session/ViewerSession.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <utility>

using namespace kdstream;
using kdstream::testing::CountBoundaryEdges;
using kdstream::testing::MakeTorus;
using kdstream::testing::MemoryServer;
using protocol::BlobId;

namespace
{

constexpr int width = 400, height = 300;
constexpr unsigned mostAnswers = 20'000;

// P = 6; 2,048 vertices.
const MemoryServer& Torus()
{
  static const MemoryServer server(MakeTorus(64, 32), 32, 2);
  return server;
}

class Input
{
public:
  explicit Input(std::span<const std::uint8_t> bytes)
    : Bytes(bytes)
  {
  }
  bool IsOver() const { return this->Bytes.empty(); }
  std::uint8_t Next()
  {
    if (this->Bytes.empty())
    {
      return 0;
    }
    const std::uint8_t first = this->Bytes.front();
    this->Bytes = this->Bytes.subspan(1);
    return first;
  }
  double Across(double from, double to) { return from + (to - from) * this->Next() / 255; }

private:
  std::span<const std::uint8_t> Bytes;
};

class Visit
{
public:
  explicit Visit(Input input)
    : Given(input)
    , Server(Torus())
    , All(this->Server.AllBlobs())
    , Random(this->Given.Next())
    , Session(OptionsOf(this->Given))
  {
    this->LieOfPieces();
    this->Server.lie = [this](const BlobId& blob, std::vector<std::uint8_t>& bytes)
    { return this->Lie(blob, bytes); };
    this->Session.Resize({ width, height, 1 });
    (void)this->Session.SelectModel("torus").HasValue();
  }

  void Run()
  {
    while (!this->Given.IsOver())
    {
      this->Step();
    }
    this->Server.lie = nullptr;
    unsigned answers = 0;
    do
    {
      this->Frame();
      if (++answers > mostAnswers)
      {
        std::fputs("FuzzSession: it asks for ever\n", stderr);
        std::abort();
      }
    } while (this->Server.Answer(this->Session));
    if (!this->Session.IsIdle())
    {
      std::fputs("FuzzSession: it waits for what nobody owes it\n", stderr);
      std::abort();
    }
  }

private:
  static SessionOptions OptionsOf(Input& input)
  {
    SessionOptions options;
    const std::uint8_t how = input.Next();
    options.detail = how % 4 == 0   ? DetailMode::Level
                     : how % 4 == 1 ? DetailMode::Full
                                    : DetailMode::View;
    options.cacheBytes = how & 4 ? std::size_t{ 64 } << 10 : options.cacheBytes;
    options.refinement.triangles = how & 8 ? 2000 : options.refinement.triangles;
    return options;
  }

  // Lets pages report wrong errors and sizes of pieces.
  void LieOfPieces()
  {
    constexpr float errors[] = { 0, 1e-30F, 0.01F, 1, 1e30F };
    constexpr std::uint32_t sizes[] = { 0, 1, 1000, 60'000'000 };
    PieceTable lies = this->Server.Table();
    for (unsigned lie = this->Given.Next() % 16; lie > 0; --lie)
    {
      const unsigned finest = this->Server.Codec().depths.finest;
      const unsigned depth = this->Given.Next() % (finest + 1);
      const unsigned nodes = PieceDepth(Resolution::Level(depth), this->Server.Codec().depths);
      const NodeId first = NodeId{ 1 } << nodes;
      auto& facts = lies.At({ Resolution::Level(depth), first + this->Given.Next() % first });
      facts.most99 = errors[this->Given.Next() % std::size(errors)];
      facts.most = std::max(facts.most99, errors[this->Given.Next() % std::size(errors)]);
      facts.bytes = sizes[this->Given.Next() % std::size(sizes)];
    }
    this->Server.TellOfPieces(lies);
  }

  bool Lie(const BlobId& blob, std::vector<std::uint8_t>& bytes)
  {
    switch (this->Way)
    {
      case 1:
        bytes[this->Given.Next() * (bytes.size() - 1) / 255] ^= this->Given.Next();
        break;
      case 2:
        bytes.resize(this->Given.Next() * bytes.size() / 255);
        break;
      case 3:
        bytes = this->Server.Blob(this->AnyBlob());
        this->Swapped = this->Swapped || IsOfPiece(blob);
        break;
      case 4: // sent twice, the first time for an arbitrary request
        this->Session.BlobArrived(this->Given.Next(), blob, bytes, 0.01, false);
        break;
      default:
        break;
    }
    return this->Way != 5;
  }

  const BlobId& AnyBlob() { return this->All[this->Given.Next() % this->All.size()]; }

  void Frame()
  {
    this->Session.BeginFrame();
    const ViewerScene scene = this->Session.Scene();
    const bool isOther = std::exchange(this->Drawn, scene.surfaceVersion) != scene.surfaceVersion;
    if (isOther && !this->Swapped && CountBoundaryEdges(scene.surface->Whole().triangles) != 0)
    {
      std::fputs("FuzzSession: there is a hole\n", stderr);
      std::abort();
    }
    this->Session.EndFrame(0.01);
  }

  // Sets budgets, as a user does, or a page that runs out of memory.
  void SetBudgets()
  {
    const std::uint8_t how = this->Given.Next();
    const std::uint64_t triangles = std::uint64_t{ 1 } << how % 16;
    const std::size_t bytes = std::size_t{ 256 } << how / 16;
    if (this->Way % 2 == 0)
    {
      return this->Session.SetBudgets(triangles, bytes);
    }
    MemoryShares shares = SharesOfBudgets(triangles, bytes);
    shares.treeBytes = std::size_t{ 64 } << this->Given.Next() % 16;
    shares.cacheBytes = std::size_t{ 64 } << this->Given.Next() % 16;
    this->Session.SetMemory(shares);
  }

  void Tap(int times)
  {
    const double x = this->Given.Across(-10, width + 10), y = this->Given.Across(-10, height + 10);
    this->Clock += 1;
    for (int i = 0; i < times; ++i)
    {
      this->Session.HandleTouches({ this->Clock += 0.1, { { 1, x, y } } });
      this->Session.HandleTouches({ this->Clock += 0.05, {} });
    }
  }

  void Drag()
  {
    const double x = this->Given.Across(0, width), y = this->Given.Across(0, height);
    this->Session.HandleTouches({ this->Clock += 1, { { 1, x, y } } });
    this->Session.HandleTouches({ this->Clock += 0.1, { { 1, y, x } } });
    this->Session.HandleTouches({ this->Clock += 0.1, {} });
  }

  void UseTools()
  {
    static constexpr const char* words[]{ "x", "side", "above", "view", "flip", "off" };
    const std::uint8_t what = this->Given.Next();
    this->Session.SetTool(static_cast<Tool>(what % 5));
    if (what % 2 == 0)
    {
      this->Session.SetSectionAlong(words[this->Way]);
      this->Session.SetSectionDepth(this->Given.Across(-0.2, 1.2));
    }
    (void)this->Session.SectionOutline();
  }

  void Step()
  {
    const std::uint8_t what = this->Given.Next();
    this->Way = what / 16 % 6;
    switch (what % 16)
    {
      case 0:
        this->Session.EnterFullScreen();
        break;
      case 1:
        this->Session.LeaveFullScreen();
        break;
      case 2:
      case 3:
        this->Session.Zoom(std::exp2(this->Given.Across(-3, 3)), this->Given.Across(0, width),
          this->Given.Across(0, height));
        break;
      case 4:
        this->Tap(2);
        break;
      case 5:
        this->Tap(1);
        break;
      case 6:
        this->Drag();
        break;
      case 7:
        this->Session.SetRings(this->Given.Next());
        break;
      case 8:
        this->Session.SetDetail(this->Way % 2 == 0 ? DetailMode::View : DetailMode::Level);
        break;
      case 9: // the blob is lost for good
        this->Server.refused.insert(this->AnyBlob());
        this->Session.BlobFailed(this->Given.Next(), this->AnyBlob(), "it is gone");
        break;
      case 10:
        this->Session.RequestEnded(this->Given.Next());
        break;
      case 11:
        (void)this->Session.SelectModel(this->Way == 0 ? "sphere" : "torus").HasValue();
        break;
      case 12:
        this->Frame();
        break;
      case 13:
        this->UseTools();
        break;
      case 14:
        this->SetBudgets();
        break;
      default:
        for (int answers = this->Way == 0 ? 8 : 1; answers > 0; --answers)
        {
          (void)this->Server.Answer(this->Session, &this->Random);
        }
        break;
    }
  }

  Input Given;
  MemoryServer Server;
  std::vector<BlobId> All;
  std::mt19937 Random;
  ViewerSession Session;
  unsigned Way = 0;        // how the server lies
  bool Swapped = false;    // a piece was sent in place of another one
  std::uint64_t Drawn = 0; // version of the drawn surface
  double Clock = 0;
};

}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  Visit(Input({ data, size })).Run();
  return 0;
}
