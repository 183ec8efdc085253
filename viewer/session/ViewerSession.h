// SPDX-License-Identifier: BSD-3-Clause
// The one brain of all viewers: what a person does and what a server sends go in, requests and a
// scene come out. Conducts "look", "choose", "pick", "request" and "draw" of the pipeline picture
// (paper section 5).
#pragma once

#include "filters/codec/PieceCodec.h"
#include "filters/core/Result.h"
#include "filters/model/ModelDescription.h"
#include "viewer/session/GestureRecognizer.h"
#include "viewer/session/KnownTree.h"
#include "viewer/session/LevelPolicy.h"
#include "viewer/session/Measurement.h"
#include "viewer/session/MemoryBudget.h"
#include "viewer/session/Momentum.h"
#include "viewer/session/Picker.h"
#include "viewer/session/PieceCache.h"
#include "viewer/session/SessionTypes.h"
#include "viewer/session/ShownSurface.h"
#include "viewer/session/ViewLink.h"
#include "viewer/session/ViewRefinement.h"
#include "viewer/session/line/BlobHistory.h"
#include "viewer/session/line/WishList.h"
#include "viewer/session/look/RakingLight.h"
#include "viewer/session/paint/ShownTiles.h"
#include "viewer/session/section/ShownSection.h"

#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

class ViewerSession;

struct SessionOptions
{
  unsigned rings = 1; // around a picked cell, 1-3
  Turning turning = Turning::Upright;
  bool coasts = false; // the model turns on for a moment when it is let go (Advance)
  DetailMode detail = DetailMode::View;
  RefinementOptions refinement; // by the view
  LevelPolicyOptions policy;    // by one level for all
  GestureThresholds gestures;
  // Decoded pieces that are kept beyond what is shown, bytes.
  std::size_t cacheBytes = std::size_t{ 256 } << 20;
  // What is kept of the model's tree, bytes.
  std::size_t treeBytes = standardTreeBytes;
  // Decoded pictures of textures that are kept, bytes.
  std::size_t pictureBytes = std::size_t{ 512 } << 20;
  // By the view, when all that is wanted is there: what one would want next, nearer by half in the
  // middle of the screen, is fetched until about so many bytes were asked for, once for each view.
  // 0: nothing is fetched ahead.
  std::size_t aheadBytes = 0;
  // A pick may ask for so many pages and boxes of the tree.
  std::size_t mostBlobsOfPick = 1000;
  // A point of a cloud is picked by a finger that is so many points of the screen away, or less.
  double fingerPoints = 24;
  // A region takes at most so many partitions, nearest first.
  std::size_t mostRegionPartitions = 512;
  // And about as many as have so many triangles, but at least the one that was picked.
  std::uint64_t mostRegionTriangles = std::numeric_limits<std::uint64_t>::max();
  // A region that has shrunk to fewer points than this on the screen is let go.
  double smallestRegionPoints = 32;
  // Seconds of a steady clock, for parsing times only; without one these are 0.
  std::function<double()> clock;
  // Blobs of which Statistics tells: the newest.
  std::size_t mostStatistics = 10'000;
  // All of the above that is held, at most.
  void TakeShares(const MemoryShares& shares);
  // From then on, `sink` is called with one line of JSON after every input: the input, the state,
  // the requests that it led to. The same inputs give the same lines. What writes them is linked
  // only where this is called: a page does without.
  void TraceTo(std::function<void(std::string_view)> sink);

private:
  friend class ViewerSession;
  std::function<void(std::string_view)> Sink;
  std::string (ViewerSession::*FormatTrace)(
    std::string_view input, std::string_view detail) const = nullptr; // with Sink
};

enum class Tool
{
  None,
  Measure, // taps place the ends of distances
  Section, // one finger moves the section along its normal, two turn it
  Light,   // a finger is where the light comes from
  SecondLight
};

// One person's session with one server. The states:
//
//   no model --SelectModel--> browsing --tap, pinch, wheel, SelectModel again--> full screen
//                                      <--LeaveFullScreen--
//
// *Browsing* shows the selected model's preview, which can be turned, and double-tapped. In *full
// screen* pinching zooms about the surface under the fingers, and what is seen becomes as fine as
// the screen shows it (ViewRefinement); a double tap on the surface picks the partition nearest to
// the hit and streams the region around it as the original, whatever the zoom; a double tap beside
// the model lets the region go, and goes home. Selecting another model browses that one.
//
// The first view of a model is that of its description (ModelPose). Nobody gets lost: some of the
// shown surface stays on the screen (KeepInSight), and the eye never goes through it, nor, while
// nothing is shown, into the box. A motion ends before them; but zooming out always leads away.
// Where a surface that has changed is around the eye, that steps back.
//
// A region stays while one turns, pans and pinches, until it has become too small to be seen. The
// next one adds to it, as far as the budget goes; what leaves the view then is let go.
//
// Whatever has come of what is wanted is shown in the next frame, and the surface is whole all the
// time (ShownSurface). A blob that fails is named in Status().error, and not asked for again before
// the next double tap, pinch or selection; what is coarser stays shown there.
//
// With DetailMode::Level the zoom picks one level for the whole model instead (LevelPolicy, paper
// section 5.2), which appears when all of it has come, and the next region replaces the last one.
// If a piece of a level failed, the next coarser level is shown. DetailMode::Full shows all of the
// model as the original, when all of it has come.
//
// Not thread-safe; no input blocks, throws, or calls back (but for clock and trace).
class ViewerSession
{
public:
  explicit ViewerSession(SessionOptions options = {});

  // ---- what the person does
  // Shows the same in another window. A first view or a side that nobody has touched fits again; of
  // a model that was turned all is seen that was, from where it was; where one has zoomed the eye
  // stays. Back in the window of before, and in the same one, it is exactly what was seen.
  void Resize(const Viewport& viewport);
  // Errors: NotFound where the server's list is known and `model` is not in it; nothing changes
  // then.
  Status SelectModel(const std::string& model);
  void EnterFullScreen();
  // What fingers do from here on, in full screen; what is not said there they do as ever. Half a
  // measurement is dropped.
  void SetTool(Tool tool);
  Tool GetTool() const { return this->InHand; }
  // Of the model that is selected, oldest first; at most 64. Ends move to the original when that
  // has come.
  const std::vector<Measurement>& Measurements() const { return this->Measured; }
  void NameMeasurement(std::size_t index, const std::string& name);
  void RemoveMeasurement(std::size_t index);
  // Cuts away what is above a plane. By the view what is cut away is not fetched. Errors are as
  // ShownSection has them; nothing before a model is open.
  void SetSection(const std::optional<SectionPlane>& plane);
  bool SetSectionAlong(std::string_view word);
  void SetSectionDepth(double depth);
  const ShownSection& GetSection() const { return this->Section; }
  // The outline as SVG (SectionDrawing); empty without a section.
  std::string SectionOutline() const;
  // Nothing: the standard light. What is out of its range is brought into that.
  void SetLight(const std::optional<RakingLight>& light);
  const std::optional<RakingLight>& GetLight() const { return this->Lamps; }
  // Back to browsing the same model: its preview again, whole, without a region.
  void LeaveFullScreen();
  void HandleTouches(const TouchFrame& frame);
  // The fingers have gone without ending their gesture, because the system took them for one of its
  // own: this is not a tap.
  void CancelTouches();
  // A wheel or trackpad enlarges by `factor` > 0 about pixel (x, y), as a pinch there would. Other
  // factors change nothing.
  void Zoom(double factor, double x, double y);
  // The first view again, of this window.
  void GoHome();
  // From a side, level but for top and bottom: "front" (as the first view, but level), "back",
  // "left", "right" (of somebody who looks at the front), "top", "bottom". A jump. False, and
  // nothing changes, for other words.
  bool LookFromSide(std::string_view side);
  // The view as it is now; without colours and light, which are the scene's.
  ViewLink Link() const;
  // Shows what somebody else saw: the model full screen, as soon as it is open, and the camera
  // where it stood. A region is picked again. Where the model is another version a sentence says
  // so. Errors: those of SelectModel.
  Status Follow(const ViewLink& link);
  // A host of its own camera looks so, full screen: as Camera::LookFrom, wherever that is; also
  // within the surface, out of which the eye does not step from then on. Nothing before the model
  // is open.
  void LookFrom(const Vec3& eye, const Vec3& focal, const Vec3& up, double tangent);
  // The view before the last jump (a side, a link, home, back to browsing) again, however one has
  // moved since; one jump after the other. Nothing where there is none.
  void UndoView();
  void SetTurning(Turning turning);
  void SetCoasting(bool coasts);
  // The model turns by itself, once in 24 seconds, until it is touched or zoomed. No session file
  // tells of it.
  void SetSpinning(bool spins);
  // It is `time` by the clock of HandleTouches: what was let go turns on, and what turns by itself.
  // Call before each frame.
  void Advance(double time);
  // For this region and the next ones. Clamped to 1-3.
  void SetRings(unsigned rings);
  void SetDetail(DetailMode detail);
  // From now on at most about so many triangles are shown, and so many bytes taken
  // (SharesOfBudgets).
  void SetBudgets(std::uint64_t triangles, std::size_t bytes);
  // The same for all that is held, each by itself: what is shown becomes coarser, and a region
  // smaller, where they exceed it. Of the tree it counts for models that are opened from now on. No
  // session file tells of it.
  void SetMemory(const MemoryShares& shares);
  // As SessionOptions::aheadBytes.
  void SetAhead(std::size_t bytes);
  // Whether the parts of the next surfaces tell where they glide from (DrawnSurface::Part); at
  // first they do not. No trace tells of it.
  void SetGlides(bool glides) { this->Shown.SetGlides(glides); }

  // Asks for what has failed once more, as where a server is back.
  void AskAgain();
  // Previews are all that is shown and asked for, by the view, until this is called with false:
  // taps and zooms wait. For a page that has only begun to load (parts.js). No trace tells of
  // it.
  void SetPreviewsOnly(bool only);

  // ---- what the server sends. Pieces that were on their way when their request was cancelled are
  // kept, other answers to it are ignored.
  void SetModels(std::vector<ModelSummary> models);
  void Opened(std::uint32_t request, const ModelDescription& model);
  // Bytes of any content may be given; what is wrong with them is told in the status, too.
  // transmissionSeconds: from the request, or from the blob before it.
  BlobArrival BlobArrived(std::uint32_t request, const protocol::BlobId& blob,
    std::span<const std::uint8_t> bytes, double transmissionSeconds, bool fromCache);
  void BlobFailed(std::uint32_t request, const protocol::BlobId& blob, const std::string& message);
  // All that the request still owes has failed.
  void RequestFailed(std::uint32_t request, const std::string& message);
  // The server says that it has sent everything.
  void RequestEnded(std::uint32_t request);

  // ---- frames
  // Asks for what the view needs by now, and calls back what it does not need any more; part of
  // BeginFrame. Call it alone where a frame is rendered of the old surface.
  void FollowView();
  // Draws what has changed; call before rendering Scene().
  void BeginFrame();
  // Call after rendering, with the seconds that it and BeginFrame took.
  void EndFrame(double seconds);

  // ---- what comes out
  // What to send since the last call, in order.
  std::vector<SessionRequest> TakeRequests();
  ViewerScene Scene() const;
  const Camera& GetCamera() const { return this->Eye; }
  DetailMode GetDetail() const { return this->Options.detail; }
  ViewerStatus GetStatus() const;
  const std::vector<ModelSummary>& Models() const { return this->ModelList; }
  // Of the newest blobs (SessionOptions::mostStatistics), oldest first.
  const std::deque<BlobStatistics>& Statistics() const { return this->History.Entries(); }
  // Whether nothing is outstanding that is wanted now, and all that came has been drawn.
  bool IsIdle() const
  {
    return this->Wanted.IsIdle() && !this->ChoiceIsDue && !this->Shown.NeedsDrawing() &&
           !this->Turned.TurnsOn();
  }
  // The cut that is shown, which its surface follows at the next frame; nothing at first.
  const std::optional<Cut>& ShownCut() const { return this->Shown.GetCut(); }
  // The boxes of the region's partitions, that of the picked one first; none without a region.
  std::vector<Box> RegionBoxes() const;
  // Bytes of all pieces, and of textures as they came, that it holds.
  std::size_t PieceBytes() const { return this->Pieces.Bytes() + this->Tiles.Bytes(); }
  // The pieces that the shown surface is drawn from.
  const std::set<PieceId>& ShownPieces() const { return this->Shown.Pieces(); }
  // Of all models so far.
  const SessionTraffic& GetTraffic() const { return this->Traffic; }
  // The blobs that are outstanding, each with the request that it belongs to.
  const std::map<protocol::BlobId, std::uint32_t>& OwedBlobs() const
  {
    return this->Wanted.Book().AllOwed();
  }
  // What is outstanding, for messages.
  std::string DescribeOutstanding() const { return this->Wanted.Book().Describe(); }
  // How often it was worked out what to show and what to ask for: for tests.
  std::uint64_t Choices() const { return this->ChoicesMade; }

private:
  struct Model
  {
    ModelDescription description;
    CodecContext codec;
    LevelPolicy policy;
    Box box;
    KnownTree tree;
    ViewRefinement refinement, next; // for the view, and for one that is nearer
    SeenPartitions seen;
    bool isClosed = false; // nearly: its back is hidden
  };
  struct PickedRegion
  {
    NodeId cell = 1;
    unsigned rings = 1;
    std::vector<std::uint32_t> partitions; // nearest first
    Box box;
    std::vector<Box> boxes; // of these
  };

  struct ToldView
  {
    CameraPlace place;
    Camera eye; // there
  };
  struct EarlierView
  {
    Camera eye;
    bool moved = false;
  };
  // As it was when the window began to change its shape.
  struct LeftView
  {
    EarlierView view;
    Camera eye; // in the window as it is now
  };
  // An end of a measurement that is not on the original yet.
  struct End
  {
    std::size_t measurement = 0;
    bool isSecond = false;
    bool isTold = false;                // by a link: the ray begins there, and goes nowhere
    Ray ray;                            // by which it was picked
    std::set<std::uint32_t> partitions; // that are to be the original
    std::vector<Vec3> around;           // places whose partitions are to be, once they are known
  };

  // All that Update goes by.
  struct Situation
  {
    SurfaceWish wish;
    NodeId cell = 0; // of the region, 0 without one
    unsigned rings = 0;
    std::set<protocol::BlobId> tree;     // that is missing
    std::vector<protocol::BlobId> tiles; // that are missing
    std::set<PieceId> failedPieces;
    std::set<protocol::BlobId> failedTree;
    std::uint64_t pieces = 0; // their version
    bool operator==(const Situation&) const = default;
  };

  void CloseModel();
  void Handle(const Gesture& gesture, double time);
  void FitModel();
  double FreePart(const Camera& from, const Camera& to) const;
  void KeepInSight(Camera& camera) const;
  void Move(Camera moved);
  void BackAway(double length);
  void StepOutside();
  void TakeView(const Camera& view, const Viewport& viewport);
  void TakeWindow(const Viewport& viewport);
  void Turn(const Momentum::Drag& drag);
  double DistanceToObstacle(const Ray& ray) const;
  void JumpHome();
  void NoteJump(const EarlierView& before);
  void TakePlace(const CameraPlace& place);
  bool TakeToldPlace(const Viewport& viewport);
  void TakeLink();
  void FocusUnder(double x, double y);
  void PanAndRoll(const Gesture& gesture);
  bool TakeDrag(const Gesture& gesture);
  void ShineFrom(double x, double y);
  void ZoomBy(double factor, double x, double y);
  void DoubleTap(double x, double y);
  std::optional<SurfaceHit> Pick(const Ray& ray, double slack = 0) const;
  std::optional<SurfaceHit> PickUnder(double x, double y) const;
  void FollowSection();
  void SectionMoved();
  void DragSection(double dx, double dy);
  void TurnSection(double dx, double dy);
  double FingerSlack() const;
  bool MeasureAt(double x, double y);
  std::optional<SurfaceHit> EndOn(const Ray& ray) const;
  std::optional<SurfaceHit> EndAt(const Vec3& point, double error) const;
  void AddTold(const std::array<Vec3, 2>& points);
  MeasuredPoint& PointOf(const End& end);
  bool Settle(End& end, const SurfaceHit& hit);
  void FollowEnds();
  void PickEndsAnew();
  bool IsGivenUp(const End& end) const;
  void FollowPick();
  bool SetRegion(NodeId cell);
  std::uint64_t TrianglesOfPartition() const;
  std::size_t MostOfRegion() const;
  void CutRegion();
  void GiveWayToTap();
  bool IsPicking() const { return this->WaitingPick || this->WaitingCell; }
  void DropPick();
  void FollowZoom();
  void Retry();
  Situation GetSituation() const;
  void FollowTiles();
  void Update();
  bool ByView() const { return this->Options.detail == DetailMode::View; }
  void FollowLevel();
  void Choose();
  ViewRefinement::View ViewOf(const Camera& camera, bool inSteps);
  void RefineView();
  void AddToRegion(const PickedRegion& last);
  std::vector<std::uint32_t> LeftOfRegion() const;
  std::vector<PieceId> TappedPieces() const;
  std::vector<protocol::BlobId> InOrder(const std::vector<PieceId>& missing);
  std::size_t BytesOf(const protocol::BlobId& blob);
  void AskMore();
  std::vector<protocol::BlobId> WantedNext();
  unsigned EffectiveLevel() const;
  unsigned LevelFor(Resolution resolution) const;
  SurfaceWish Wish() const;
  protocol::BlobId PreviewBlob() const;
  Status Decode(
    const protocol::BlobId& blob, std::span<const std::uint8_t> bytes, BlobStatistics& entry);
  BlobArrival TakeLate(
    std::uint32_t request, const protocol::BlobId& blob, std::span<const std::uint8_t> bytes);
  void AskForLost(const protocol::BlobId& come);
  void SettleLost();
  std::string SentenceOf(const protocol::BlobId& blob, const std::string& message) const;
  void Fail(const protocol::BlobId& blob, const std::string& message);
  void TellWhatIsMissed();
  void NoteWhatIsShown();
  void Trace(std::string_view input, std::string_view detail = {}) const;
  friend struct SessionOptions;
  std::string FormatTrace(std::string_view input, std::string_view detail) const;

  SessionOptions Options;
  GestureRecognizer Gestures;
  Camera Eye;
  bool EyeMoved = false;                // by a pinch or a wheel since it was fitted
  std::deque<EarlierView> EarlierViews; // before the last jumps, the last one last
  std::optional<ViewLink> Followed;     // waits until its model is open
  std::optional<ToldView> Told;         // the last link's
  std::optional<LeftView> Left;         // that changes of the window are made from
  bool IsArriving = false;              // at a view of somebody else's, whose surface comes
  bool IsLed = false;                   // by the host's own camera
  Momentum Turned;                      // by itself
  std::vector<ModelSummary> ModelList;
  bool HasModelList = false;
  bool PreviewsOnly = false;

  ViewerMode Mode = ViewerMode::NoModel;
  std::string ModelId;          // selected
  std::optional<Model> Current; // once it is open
  unsigned Target = 0;          // level that the zoom asks for
  std::optional<PickedRegion> Region;
  ShownSection Section;
  std::optional<RakingLight> Lamps;
  Tool InHand = Tool::None;
  std::vector<Measurement> Measured;
  std::size_t MeasurementsMade = 0;
  std::vector<End> Ends; // that wait for the original
  // What a tap waits for until enough of the tree has come: which partition it means, and which are
  // around that.
  std::optional<Vec3> WaitingPick;
  std::optional<NodeId> WaitingCell;
  std::size_t AskedForPick = 0;
  std::set<protocol::BlobId> MissingTree; // what is needed now

  PieceCache Pieces;
  ShownTiles Tiles;
  ShownSurface Shown;
  WishList Wanted;
  bool ChoiceIsDue = false;               // something is wanted, or has come, since the last one
  std::vector<std::uint32_t> EarlierTaps; // partitions of regions before, newest first
  std::set<PieceId> FailedPieces;
  std::set<protocol::BlobId> FailedTree;
  // What failed with all of its request, as where the line is lost, and why; and what of that was
  // asked for again, as long as none of it has come.
  std::map<protocol::BlobId, std::string> Lost;
  std::set<protocol::BlobId> AskedAgain;
  std::map<PieceId, std::string> Doubtful; // that failed, and why: perhaps nobody misses them
  std::string LastError;

  std::optional<Situation> LastSituation; // that Update found something to do in
  std::uint64_t ChoicesMade = 0;
  BlobHistory History;
  SessionTraffic Traffic;
  std::map<PieceId, std::size_t> NeverShown; // bytes of pieces that have come
};

}
