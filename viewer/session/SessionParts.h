// SPDX-License-Identifier: BSD-3-Clause
// The parts of a session, and how they are connected; ViewerSession is its interface. Part of step
// "request" of the pipeline picture.
#pragma once

#include "viewer/session/Fetcher.h"
#include "viewer/session/SessionOptions.h"
#include "viewer/session/ViewLink.h"
#include "viewer/session/camera/CameraControl.h"
#include "viewer/session/model/LodSelection.h"
#include "viewer/session/model/PickedRegion.h"
#include "viewer/session/model/ShownModel.h"
#include "viewer/session/tools/Tools.h"

#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

// Each part has a state of its own, and refers only to parts before it. None refers to the session.
struct SessionParts
{
  SessionOptions options;
  ShownModel model; // the model that all other parts use
  LodSelection lod;
  PickedRegion region;
  CameraControl camera;
  Tools tools;
  Fetcher fetcher;

  ViewerMode mode = ViewerMode::NoModel;
  std::vector<ModelSummary> models;
  bool hasModels = false;
  bool previewsOnly = false;
  std::optional<ViewLink> followed; // waits until its model is open

  explicit SessionParts(SessionOptions chosen);
  SessionParts(const SessionParts&) = delete; // the parts refer to each other

  // The view for which pieces are selected now.
  LodSelection::View View() const;
  // Every input ends here: compares what the view wants with what is loaded and with what is in
  // flight.
  void Update();
  // Updates the level that the zoom asks for, and drops a region that has become too small to see.
  void FollowZoom();

  void Select(const std::string& id);
  // REQUIRES, for the next two: an open model.
  void Handle(const Gesture& gesture, double time);
  void TakeLink(bool isJump); // applies `followed`

  // As ViewerSession's functions of these names.
  bool IsIdle() const
  {
    return this->fetcher.Wishes().IsIdle() && !this->lod.IsDue() &&
           !this->model.surface.NeedsDrawing() && !this->camera.Coasts();
  }
  ViewerScene Scene() const;
  ViewerStatus GetStatus() const;

private:
  void DoubleTap(const Gesture& gesture);
};

}
