// SPDX-License-Identifier: BSD-3-Clause
// The one brain of all viewers: what a person does and what a server sends go in, requests and a
// scene come out. Conducts "look", "choose", "pick", "request" and "draw" of the pipeline picture
// (paper section 5).
#pragma once

#include "filters/core/Result.h"
#include "filters/model/ModelDescription.h"
#include "viewer/session/Camera.h"
#include "viewer/session/GestureRecognizer.h"
#include "viewer/session/SessionOptions.h"
#include "viewer/session/SessionTypes.h"
#include "viewer/session/ViewLink.h"
#include "viewer/session/section/ShownSection.h"
#include "viewer/session/tools/Measurement.h"

#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

struct SessionParts;

// One person's session with one server. The states:
//
//   no model --SelectModel--> browsing --tap, pinch, wheel, SelectModel again--> full screen
//                                      <--LeaveFullScreen--
//
// *Browsing* shows the selected model's preview, which can be turned, and double-tapped. In *full
// screen* pinching zooms about the surface under the fingers, and the visible part becomes as fine
// as the screen shows it (ViewRefinement). A double tap on the surface picks the partition nearest
// to the hit and streams the region around it as the original, whatever the zoom. A double tap
// beside the model drops the region and goes home. Selecting another model browses that one.
//
// The first view of a model is that of its description (HomeView). Nobody gets lost: some of the
// shown surface stays on the screen (KeepInSight). The eye never goes through the surface, nor,
// while nothing is shown, into the box: a motion ends before them, but zooming out always leads
// away. Where a changed surface is around the eye, the eye steps back.
//
// A region stays while one turns, pans and pinches, until it is too small to be seen. The next
// region adds to it, as far as the budget allows; then the parts out of view are dropped.
//
// What has come is shown in the next frame, if it is wanted, and the surface is whole all the time
// (ShownSurface). A blob that fails is named in Status().error, and not requested again before the
// next double tap, pinch or selection; a coarser surface stays shown there.
//
// With DetailMode::Level the zoom picks one level for the whole model instead (LevelPolicy, paper
// section 5.2). The level appears when all of it has come, and the next region replaces the last
// one. If a piece of a level failed, the next coarser level is shown. DetailMode::Full shows all of
// the model as the original, when all of it has come.
//
// Not thread-safe; no input blocks, throws, or calls back (but for clock and trace).
class ViewerSession
{
public:
  explicit ViewerSession(SessionOptions options = {});
  // Of `other` nothing is left but to destroy it, or to assign another one.
  ViewerSession(ViewerSession&& other) noexcept;
  ViewerSession& operator=(ViewerSession&& other) noexcept;
  ~ViewerSession();

  // ---- what the person does
  // Shows the same view in another window. An untouched first view or side fits again. Of a turned
  // model, what was visible stays visible, from the same direction. After a zoom the eye stays.
  // Back in a window of the former size, the view is exactly the former one.
  void Resize(const Viewport& viewport);
  // Errors: NotFound where the server's list is known and `model` is not in it; nothing changes
  // then.
  Status SelectModel(const std::string& model);
  void EnterFullScreen();
  // What fingers do from here on, in full screen; a gesture that the tool does not use works as
  // ever. Half a measurement is dropped.
  void SetTool(Tool tool);
  Tool GetTool() const;
  // Of the model that is selected, oldest first; at most 64. Ends move to the original when that
  // has come.
  const std::vector<Measurement>& Measurements() const;
  void NameMeasurement(std::size_t index, const std::string& name);
  void RemoveMeasurement(std::size_t index);
  // Cuts away what is above a plane. By the view what is cut away is not fetched. Errors are as
  // ShownSection has them; nothing before a model is open.
  void SetSection(const std::optional<SectionPlane>& plane);
  bool SetSectionAlong(std::string_view word);
  void SetSectionDepth(double depth);
  const ShownSection& GetSection() const;
  // The outline as SVG (SectionDrawing); empty without a section.
  std::string SectionOutline() const;
  // Nothing: the standard light. What is out of its range is brought into that.
  void SetLight(const std::optional<RakingLight>& light);
  const std::optional<RakingLight>& GetLight() const;
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
  // Shows the view of a link: the model full screen, as soon as it is open, and the camera where it
  // stood. A region is picked again. If the model is another version, a sentence says so. Errors:
  // those of SelectModel.
  Status Follow(const ViewLink& link);
  // For a host with a camera of its own: shows the model full screen from there (Camera::LookFrom),
  // also from within the surface; the eye does not step out of it then. Does nothing before the
  // model is open.
  void LookFrom(const Vec3& eye, const Vec3& focal, const Vec3& up, double tangent);
  // Goes back to the view before the last jump (a side, a link, home, back to browsing), whatever
  // has moved since; one jump with each call. Does nothing without a jump.
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
  // The same for all that is held, each share by itself. What is shown becomes coarser, and a
  // region smaller, where they exceed their share. The share of the tree counts for models that are
  // opened from now on. No session file tells of it.
  void SetMemory(const MemoryShares& shares);
  // As SessionOptions::prefetchBytes.
  void SetPrefetch(std::size_t bytes);
  // Whether the parts of the next surfaces tell where they morph from (DrawnSurface::Part); at
  // first they do not. No trace tells of it.
  void SetGeomorphs(bool geomorphs);

  // Asks for what has failed once more, as where a server is back.
  void AskAgain();
  // Shows and requests only previews, by the view, until this is called with false: taps and zooms
  // wait. For a page that has only begun to load (parts.js). No trace tells of it.
  void SetPreviewsOnly(bool only);

  // ---- what the server sends. Pieces that were on their way when their request was cancelled are
  // kept, other answers to it are ignored.
  void SetModels(std::vector<ModelSummary> models);
  void Opened(std::uint32_t request, const ModelDescription& model);
  // Bytes of any content may be given; what is wrong with them is reported in the status, too.
  // transmissionSeconds: from the request, or from the blob before it.
  BlobArrival BlobArrived(std::uint32_t request, const protocol::BlobId& blob,
    std::span<const std::uint8_t> bytes, double transmissionSeconds, bool fromCache);
  void BlobFailed(std::uint32_t request, const protocol::BlobId& blob, const std::string& message);
  // All that is outstanding of the request has failed.
  void RequestFailed(std::uint32_t request, const std::string& message);
  // The server says that it has sent everything.
  void RequestEnded(std::uint32_t request);

  // ---- frames
  // Requests what the view needs now, and cancels what it does not need any more; part of
  // BeginFrame. Call it by itself where a frame is rendered of the old surface.
  void FollowView();
  // Draws what has changed; call before rendering Scene().
  void BeginFrame();
  // Call after rendering, with the seconds that it and BeginFrame took.
  void EndFrame(double seconds);

  // ---- what comes out
  // What to send since the last call, in order.
  std::vector<SessionRequest> TakeRequests();
  ViewerScene Scene() const;
  const Camera& GetCamera() const;
  DetailMode GetDetail() const;
  ViewerStatus GetStatus() const;
  const std::vector<ModelSummary>& Models() const;
  // Of the newest blobs (SessionOptions::mostStatistics), oldest first.
  const std::deque<BlobStatistics>& Statistics() const;
  // Whether nothing is outstanding that is wanted now, and all that came has been drawn.
  bool IsIdle() const;
  // The boxes of the region's partitions, that of the picked one first; none without a region.
  std::vector<Box> RegionBoxes() const;
  // Of all models so far.
  const SessionTraffic& GetTraffic() const;

  // What it is made of, for this project's own viewers and tests (SessionParts.h).
  const SessionParts& Parts() const { return *this->Own; }

private:
  void Done(std::string_view input, std::string_view detail = {});
  // The camera has come nearer or farther, or what the zoom asks for may be another level.
  void Zoomed(std::string_view input, std::string_view detail = {});
  void Answered(std::string_view input, std::string_view detail = {});
  void Trace(std::string_view input, std::string_view detail = {}) const;
  friend struct SessionOptions;
  std::string FormatTrace(std::string_view input, std::string_view detail) const;

  std::unique_ptr<SessionParts> Own;
};

}
