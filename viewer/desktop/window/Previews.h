// SPDX-License-Identifier: BSD-3-Clause
// Turning 3D previews of the models, each in a tile of the window (paper section 5.1).
#pragma once

#include "viewer/client/ModelSource.h"
#include "viewer/desktop/SessionScene.h"
#include "viewer/session/ViewerSession.h"

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

class vtkRenderWindow;

namespace kdstream
{

// A part of the window, in pixels from the window's upper left corner.
struct Tile
{
  std::size_t model = 0; // number in the list
  double left = 0, top = 0, width = 0, height = 0;
};

// Opens one model at a time: the next one that has a tile and no preview yet. Uses a connection of
// its own.
class Previews
{
public:
  // layer: of the window. source: if it is null, there are no previews.
  Previews(vtkRenderWindow& window, int layer, std::unique_ptr<ModelSource> source);
  ~Previews();

  // Shows these tiles from now on, and no others.
  void Place(const std::vector<Tile>& tiles, int windowWidth, int windowHeight);
  // Turns the previews by an angle about their models' up axes, radians.
  void Turn(double angle);
  // Takes what has arrived, and requests what is missing. Returns whether there is something new to
  // draw.
  bool Load();
  // Whether a preview is being loaded.
  bool IsLoading() const { return this->Loading.has_value(); }
  // Why a model has no preview; empty if it has one, or may still get one.
  const std::string& TroubleOf(std::size_t model) const { return this->Entries[model].trouble; }
  bool AnyIsShown() const;

private:
  struct Entry
  {
    std::unique_ptr<SessionScene> scene; // made when the preview is first placed
    bool isThere = false, isPlaced = false;
    std::string trouble;
    ViewerScene view; // its surface is in `scene`
    Vec3 up{ 0, 1, 0 };
  };

  void Ask();
  bool Finish();
  void Aim(Entry& entry) const;

  vtkRenderWindow& Window;
  int Layer;
  std::unique_ptr<ModelSource> Source;
  ViewerSession Session;
  std::deque<Entry> Entries;
  std::optional<std::size_t> Loading;
  double Angle = 0;
};

}
