// SPDX-License-Identifier: BSD-3-Clause
// The logic of all viewers. Inputs are what the user does and what the server sends; outputs are
// requests and a scene. Runs the steps "navigate", "choose", "pick", "request" and "draw" of the
// pipeline picture (paper section 5).
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

// One user's session with one server. The states:
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
// The first view of a model is that of its description (HomeView). The user cannot get lost: some
// of the shown surface stays on the screen (KeepInSight). The eye never goes through the surface,
// or, while nothing is shown, into the box: motions stop before them, except that zooming out is
// always possible. If a changed surface surrounds the eye, the eye steps back.
//
// A region stays while one turns, pans and pinches, until it is too small to be seen. The next
// region adds to it, as far as the budget allows; then the parts out of view are dropped.
//
// Wanted data are shown in the next frame after they arrive, and the surface is whole at all times
// (ShownSurface). A blob that fails is named in Status().error, and not requested again before the
// next double tap, pinch or selection; a coarser surface is shown there.
//
// With DetailMode::Level the zoom picks one level for the whole model instead (LevelPolicy, paper
// section 5.2). The level appears when all of it has arrived, and the next region replaces the last
// one. If a piece of a level failed, the next coarser level is shown. DetailMode::Full shows all of
// the model as the original, when all of it has arrived.
//
// Not thread-safe; no input blocks, throws, or calls back (except clock and trace).
class ViewerSession
{
public:
  explicit ViewerSession(SessionOptions options = {});
  // Afterwards `other` can only be destroyed, or assigned to.
  ViewerSession(ViewerSession&& other) noexcept;
  ViewerSession& operator=(ViewerSession&& other) noexcept;
  ~ViewerSession();

  // ---- what the user does. Shows the same view in another window. An untouched first view or side
  // fits again. In a turned view, what was visible stays visible, from the same direction. After a
  // zoom the eye stays. If the window gets its former size back, so does the view, exactly.
  void Resize(const Viewport& viewport);
  // Errors: NotFound if the server's list is known and does not have `model`; nothing changes then.
  Status SelectModel(const std::string& model);
  void EnterFullScreen();
  // Chooses the tool for fingers from here on, in full screen; a gesture that the tool does not use
  // works as before. An unfinished measurement is dropped.
  void SetTool(Tool tool);
  Tool GetTool() const;
  // Distances measured on the selected model, oldest first; at most 64. Their ends move to the
  // original when it has arrived.
  const std::vector<Measurement>& Measurements() const;
  void NameMeasurement(std::size_t index, const std::string& name);
  void RemoveMeasurement(std::size_t index);
  // Cuts away what is above a plane; in view mode, that is not fetched. Nothing is cut before a
  // model is open. Values that are not finite change nothing (ShownSection). SetSectionAlong takes
  // the words of ShownSection::SetAlong, and "front", "side" and "above" for a plane across the
  // direction from which one sees that side of the model. False for other words.
  void SetSection(const std::optional<SectionPlane>& plane);
  bool SetSectionAlong(std::string_view word);
  void SetSectionDepth(double depth);
  const ShownSection& GetSection() const;
  // The outline as SVG (SectionDrawing); empty without a section.
  std::string SectionOutline() const;
  // Nothing: the standard light. Values out of range are clamped.
  void SetLight(const std::optional<RakingLight>& light);
  const std::optional<RakingLight>& GetLight() const;
  // Back to browsing the same model: its preview again, whole, without a region.
  void LeaveFullScreen();
  void HandleTouches(const TouchFrame& frame);
  // Call when the system has taken the fingers for a gesture of its own: their gesture never ended,
  // so it is not a tap.
  void CancelTouches();
  // A wheel or trackpad enlarges by `factor` > 0 about pixel (x, y), like a pinch there. Other
  // factors change nothing.
  void Zoom(double factor, double x, double y);
  // Goes back to the first view, fitted to this window.
  void GoHome();
  // Shows the model from a side; horizontal, except for top and bottom: "front" (as the first view,
  // but level), "back", "left", "right" (of somebody who looks at the front), "top", "bottom". This
  // is a jump (UndoView). For other words: false, and nothing changes.
  bool LookFromSide(std::string_view side);
  // The current view, without colours and light, which belong to the scene.
  ViewLink Link() const;
  // Shows the view of a link: the model in full screen, as soon as it is open, with the link's
  // camera. A region is picked again. If the model is another version, a message says so. Errors:
  // those of SelectModel.
  Status Follow(const ViewLink& link);
  // For a host with a camera of its own: shows the model in full screen from that camera
  // (Camera::LookFrom). The eye may be inside the surface, and then does not step out of it. Does
  // nothing before the model is open.
  void LookFrom(const Vec3& eye, const Vec3& focal, const Vec3& up, double tangent);
  // Goes back to the view before the last jump (a side, a link, home, back to browsing), whatever
  // has moved since. Each call takes back one jump. Does nothing without a jump.
  void UndoView();
  void SetTurning(Turning turning);
  void SetCoasting(bool coasts);
  // The model turns by itself, once in 24 seconds, until it is touched or zoomed. Session files do
  // not record it.
  void SetSpinning(bool spins);
  // Lets the model turn, after a release or by itself, up to `time`, by the clock of HandleTouches.
  // Call this before each frame.
  void Advance(double time);
  // Sets the rings of this region and of later ones. Clamped to 1-3.
  void SetRings(unsigned rings);
  void SetDetail(DetailMode detail);
  // From now on shows at most about this number of triangles, and uses about this number of bytes
  // for their pieces (SharesOfBudgets).
  void SetBudgets(std::uint64_t triangles, std::size_t bytes);
  // The same with separate shares for everything in memory. If the shown surface or a region
  // exceeds its share, the surface becomes coarser, and the region smaller. The share of the tree
  // applies to models opened from now on. Session files do not record it.
  void SetMemory(const MemoryShares& shares);
  // As SessionOptions::prefetchBytes.
  void SetPrefetch(std::size_t bytes);
  // Whether the parts of later surfaces have the positions from which they morph
  // (DrawnSurface::Part); default: no. Traces do not record it.
  void SetGeomorphs(bool geomorphs);

  // Requests again what has failed, for example when a server is back.
  void AskAgain();
  // While true, view mode shows and requests only previews; taps and zooms take effect afterwards.
  // For a page that has only begun to load (parts.js). Traces do not record it.
  void SetPreviewsOnly(bool only);

  // ---- what the server sends. Pieces that were in flight when their request was cancelled are
  // kept; other answers to such a request are ignored.
  void SetModels(std::vector<ModelSummary> models);
  void Opened(std::uint32_t request, const ModelDescription& model);
  // The bytes may be hostile; errors in them are reported in the status, too. transmissionSeconds:
  // since the request, or since the blob before it, whichever is later.
  BlobArrival BlobArrived(std::uint32_t request, const protocol::BlobId& blob,
    std::span<const std::uint8_t> bytes, double transmissionSeconds, bool fromCache);
  void BlobFailed(std::uint32_t request, const protocol::BlobId& blob, const std::string& message);
  // Everything that is still outstanding of the request has failed.
  void RequestFailed(std::uint32_t request, const std::string& message);
  // The server says that it has sent everything: what is still outstanding of the request has
  // failed.
  void RequestEnded(std::uint32_t request);

  // ---- frames. Requests what the view needs now, and cancels what it does not need any more; part
  // of BeginFrame. Call it by itself in a frame that renders the old surface again.
  void FollowView();
  // Draws what has changed; call before rendering Scene().
  void BeginFrame();
  // Call after rendering, with the seconds that it and BeginFrame took.
  void EndFrame(double seconds);

  // ---- outputs. The requests since the last call, to be sent in this order.
  std::vector<SessionRequest> TakeRequests();
  ViewerScene Scene() const;
  const Camera& GetCamera() const;
  DetailMode GetDetail() const;
  ViewerStatus GetStatus() const;
  const std::vector<ModelSummary>& Models() const;
  // Statistics of the newest blobs (SessionOptions::mostStatistics), oldest first.
  const std::deque<BlobStatistics>& Statistics() const;
  // Whether nothing that is wanted now is outstanding, and everything that has arrived has been
  // drawn.
  bool IsIdle() const;
  // The boxes of the region's partitions, that of the picked one first; none without a region.
  std::vector<Box> RegionBoxes() const;
  // The traffic of all models so far.
  const SessionTraffic& GetTraffic() const;

  // The session's parts, for this project's own viewers and tests (SessionParts.h).
  const SessionParts& Parts() const { return *this->Own; }

private:
  void Done(std::string_view input, std::string_view detail = {});
  // For inputs that may change the distance of the camera, or the level that the zoom asks for.
  void Zoomed(std::string_view input, std::string_view detail = {});
  void Answered(std::string_view input, std::string_view detail = {});
  void Trace(std::string_view input, std::string_view detail = {}) const;
  friend struct SessionOptions;
  std::string FormatTrace(std::string_view input, std::string_view detail) const;

  std::unique_ptr<SessionParts> Own;
};

}
