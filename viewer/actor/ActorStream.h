// SPDX-License-Identifier: BSD-3-Clause
// The stream of a vtkKdStreamActor: its session, the source of its model, and the actors that draw
// the model. It does the steps "receive" to "render" of the pipeline picture for a host program
// that has its own camera.
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

// Threads: only the window's thread.
class ActorStream
{
public:
  // tolerance: RefinementOptions. Models with at most triangles / 8 triangles count as small there.
  ActorStream(std::unique_ptr<ModelSource> source, double tolerance, std::uint64_t triangles,
    SurfaceActors::Callback add, SurfaceActors::Callback remove);

  // Waits until the model is open and its preview has arrived. model: its name; empty if the source
  // has only one. Errors: NotFound; InputOutput if nothing arrives for `timeout`.
  Status Open(const std::string& model, std::chrono::seconds timeout);

  void SetBudgets(std::uint64_t triangles, std::size_t bytes);
  void SetColors(const ColorChoice& colors);
  // Requests the pieces that this camera needs. Errors: those of CheckCamera.
  Status FollowCamera(const SceneCamera& camera, int width, int height);
  // Takes and draws what has arrived. Takes at least one piece, and stops after this number of
  // seconds. Errors: those of SurfaceActors.
  Status TakeIn(double seconds);
  // Waits until more has arrived.
  bool Wait(std::chrono::milliseconds atMost) { return this->Source->Wait(atMost); }
  // Whether something has arrived that is not drawn yet.
  bool HasNews();
  // Whether everything that the camera needs is drawn.
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
  std::deque<ClientEvent> Events; // that have arrived, and have not been taken in
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
