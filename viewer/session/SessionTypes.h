// SPDX-License-Identifier: BSD-3-Clause
// What goes in and out of a viewer's session: requests, the scene, the status, the statistics.
#pragma once

#include "filters/core/drawing/DrawnSurface.h"
#include "filters/core/pieces/Piece.h"
#include "filters/model/ModelDescription.h"
#include "filters/protocol/BlobId.h"
#include "viewer/session/Camera.h"
#include "viewer/session/appearance/SceneAppearance.h"
#include "viewer/session/section/SectionPlane.h"
#include "viewer/session/texture/TileList.h"

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

// A session's request to a server. The host sends it by any means (a stream's message, or a GET for
// each blob) and answers with Opened, BlobArrived, BlobFailed, RequestFailed and RequestEnded of
// ViewerSession.
struct SessionRequest
{
  enum class Kind
  {
    Open,  // requests the description of `model`; later requests are about this model
    Blobs, // `blobs`, of any kind, in the order wanted
    Cancel // cancels the request with this id, which gets no further answers
  };
  Kind kind = Kind::Open;
  std::uint32_t id = 0;                // from 1; of a Cancel: the request that is cancelled
  std::string model;                   // of Open
  std::vector<protocol::BlobId> blobs; // of Blobs: the requested blobs
  bool operator==(const SessionRequest&) const = default;
};
// The request without the blobs in `here`, which are loaded already.
SessionRequest LeftOf(SessionRequest request, const std::vector<protocol::BlobId>& here);
// A request as a line of JSON, for traces. isPreview: the request is only for the preview, and the
// line says so.
std::string FormatRequest(const SessionRequest& request, bool isPreview = false);

// The result of taking a blob.
enum class BlobArrival
{
  Taken,    // undamaged, as far as it was checked
  Unwanted, // not requested, or not any more
  Damaged
};

// The scene to draw.
struct ViewerScene
{
  std::shared_ptr<const DrawnSurface> surface; // never null; empty at first
  std::uint64_t surfaceVersion = 0;            // grows whenever `surface` is replaced
  Box box;                                     // of the model; empty without one
  Vec3 eye{}, focal{}, up{ 0, 1, 0 };
  Quaternion orientation;               // of the camera: x right, y up, view along -z
  double viewAngle = Camera::viewAngle; // radians, vertical
  TreeDepths depths;                    // of the model
  ScalarDescriptions scalars;           // arrays that can colour the model
  std::optional<SectionPlane> section;  // what is above this plane is not drawn
  std::shared_ptr<const Surface> cap;   // in the section's plane, where the model is solid; or null
  std::uint64_t capVersion = 0;         // grows whenever `cap` is replaced
  SceneLighting lighting;
  std::shared_ptr<const TileList> tiles; // texture tiles of parts of the surface; null: none
};

// What decides which pieces are shown in full screen.
enum class DetailMode
{
  View,  // what is visible, as fine as the screen can show it
  Level, // one level for the whole model, by the zoom (paper section 5.2)
  Full   // all of the model as the original
};

// What fingers do besides turning and zooming.
enum class Tool
{
  None,
  Measure, // taps place the ends of distances
  Section, // one finger moves the section along its normal, two turn it
  Light,   // a finger is where the light comes from
  SecondLight
};

enum class ViewerMode
{
  NoModel,   // nothing is selected
  Browsing,  // a model is selected: its preview is shown
  FullScreen // the level follows the zoom, a double tap streams a region
};
const char* NameOf(ViewerMode mode);

// The session's state, for the user.
struct ViewerStatus
{
  ViewerMode mode = ViewerMode::NoModel;
  std::string model; // id, title
  std::string title;
  // The level shown, without the tapped region. In view mode: the finest one; L if that is the
  // original. Nothing before the preview has arrived.
  std::optional<unsigned> shownLevel;
  // The level that the zoom asks for. In view mode: the finest wanted one. Nothing before the model
  // is open.
  std::optional<unsigned> targetLevel;
  bool original = false;     // in view mode: some of the original is shown
  double remainingError = 0; // in view mode: largest SSE left by a budget; else 0
  struct Region
  {
    NodeId cell = 1; // node of the picked partition
    unsigned rings = 1;
    std::uint64_t partitions = 0; // of the region, without those that a section cuts away
    std::uint64_t shown = 0;      // of these, shown as the original
  };
  std::optional<Region> region;
  bool canUndo = false;  // there is a jump of the camera to undo
  bool coasting = false; // the model turns: after a release, or by itself
  bool spinning = false; // the model turns by itself
  bool picking = false;  // a double tap waits for the part of the tree that it needs
  std::uint64_t vertices = 0, triangles = 0; // of the drawn surface
  // Since the last moment without outstanding requests.
  std::uint64_t blobsLoaded = 0, blobsWanted = 0;
  std::uint64_t bytesLoaded = 0; // of these
  std::string error; // a sentence about the last failure; empty again when the user makes the
                     // session request what failed
};

// Statistics of what a session has received.
struct SessionTraffic
{
  std::uint64_t blobs = 0, bytes = 0;
  // The part of these bytes that was not used: pieces that no drawn surface has used, and answers
  // to cancelled requests.
  std::uint64_t wasted = 0;
};

// The region as a JSON object, for traces and pages; null if there is none.
std::string FormatRegion(const std::optional<ViewerStatus::Region>& region);

// How one blob was received and shown, as in the paper's Tables 4-6.
struct BlobStatistics
{
  std::string what;           // "preview", "level" or "partition"
  std::string id;             // "levels/12/3", "partitions/7"
  std::uint64_t vertices = 0; // its own
  std::uint64_t triangles = 0;
  std::uint64_t bytes = 0;
  double transmissionSeconds = 0;
  double parsingSeconds = 0; // decoding and checking
  // Of the first frame that shows the blob: the time to draw the surface and to render it. The
  // blobs that this frame shows for the first time share that time in proportion to their
  // triangles. 0 if the blob has not been shown.
  double renderingSeconds = 0;
  bool fromCache = false; // from the cache on the disk
};

// The statistics as JSON: see doc/cli.md#statistics-of-a-viewer.
std::string StatisticsJson(const std::deque<BlobStatistics>& statistics);

}
