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

// A part of the window, pixels from its upper left corner.
struct Tile
{
  std::size_t model = 0; // in the list
  double left = 0, top = 0, width = 0, height = 0;
};

// Models are opened one after the other, as they are first placed, on a connection of their own.
class Previews
{
public:
  // layer: of the window. source: may be null, then there are none.
  Previews(vtkRenderWindow& window, int layer, std::unique_ptr<ModelSource> source);
  ~Previews();

  // These tiles are shown from now on, and no others.
  void Place(const std::vector<Tile>& tiles, int windowWidth, int windowHeight);
  // They turn by an angle about their models' up axes, radians.
  void Turn(double angle);
  // Takes what has come, asks for what is missing. Returns whether there is something new to draw.
  bool Load();
  // Whether something is on its way.
  bool IsLoading() const { return this->Loading.has_value(); }
  // Why a model has none; empty if it has, or may have one.
  const std::string& TroubleOf(std::size_t model) const { return this->Entries[model].trouble; }
  bool AnyIsShown() const;

private:
  struct Entry
  {
    std::unique_ptr<SessionScene> scene; // made once the preview has a place
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
