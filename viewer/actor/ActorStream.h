// SPDX-License-Identifier: BSD-3-Clause
// The stream of a vtkKdStreamActor: its session, the source of its model, and the actors that draw
// it. Runs the steps "receive" to "render" of the pipeline picture for a host with a camera of its
// own.
#pragma once

#include "filters/core/Result.h"
#include "viewer/client/ModelSource.h"
#include "viewer/rendering/SurfaceActors.h"
#include "viewer/session/ViewerSession.h"
#include "viewer/session/appearance/Coloring.h"
#include "viewer/session/appearance/SceneRules.h"

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>

namespace kdstream
{

// Threads: that of the window.
class ActorStream
{
public:
  // tolerance, and triangles for the smallest models: RefinementOptions.
  ActorStream(std::unique_ptr<ModelSource> source, double tolerance, std::uint64_t triangles,
    SurfaceActors::Callback add, SurfaceActors::Callback remove);

  // Waits until the model is open and its preview has arrived. model: its name, empty for the only
  // one. Errors: NotFound; InputOutput if nothing arrives for this time.
  Status Open(const std::string& model, std::chrono::seconds timeout);

  void SetBudgets(std::uint64_t triangles, std::size_t bytes);
  void SetColors(const ColorChoice& colors);
  // Asks for what is needed there. Errors: those of CheckCamera.
  Status FollowCamera(const SceneCamera& camera, int width, int height);
  // Takes and draws what has arrived, for at most this number of seconds, but at least one piece.
  // Errors: those of SurfaceActors.
  Status TakeIn(double seconds);
  // Waits until something more has arrived.
  bool Wait(std::chrono::milliseconds atMost) { return this->Source->Wait(atMost); }
  // Whether there is something to take in.
  bool HasNews();
  // Whether all that is needed where one looks is drawn.
  bool IsComplete() const;

  const Box& ModelBox() const { return this->Extent; }
  const ViewerSession& Viewer() const { return this->Session; }
  SurfaceActors& Actors() { return this->Drawn; }

private:
  void TakeEvents();
  void Send();
  Status Draw();

  std::unique_ptr<ModelSource> Source;
  ViewerSession Session;
  SurfaceActors Drawn;
  std::deque<ClientEvent> Events; // that have come, and wait for their turn
  bool IsOpened = false;
  Box Extent; // of the whole model
  Viewport Window;
  ColorChoice Colors;
  ScalarDescriptions Scalars;
  std::uint64_t Triangles = 0;
  std::size_t Bytes = 0;
  std::optional<std::uint64_t> ShownVersion;
  std::shared_ptr<const TileList> ShownTiles;
};

}
