// SPDX-License-Identifier: BSD-3-Clause
// Turning 3D previews of the models: see Previews.h.
#include "viewer/desktop/window/Previews.h"

#include "viewer/session/Geometry.h"

#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace kdstream
{
namespace
{

constexpr int previewSide = 160; // this size does not change what is fetched

SessionOptions PreviewOptions()
{
  SessionOptions options;
  options.cacheBytes = 0;
  return options;
}

// Turns v by an angle about an axis of length 1 through the origin.
Vec3 Turned(const Vec3& v, const Vec3& axis, double angle)
{
  const double cosine = std::cos(angle);
  return v * cosine + Cross(axis, v) * std::sin(angle) + axis * (Dot(axis, v) * (1 - cosine));
}

}

Previews::Previews(vtkRenderWindow& window, int layer, std::unique_ptr<ModelSource> source)
  : Window(window)
  , Layer(layer)
  , Source(std::move(source))
  , Session(PreviewOptions())
{
  this->Session.Resize({ previewSide, previewSide, 1 });
  if (this->Source)
  {
    this->Session.SetModels(this->Source->Models());
    this->Entries.resize(this->Source->Models().size());
  }
}

Previews::~Previews()
{
  for (Entry& entry : this->Entries)
  {
    if (entry.scene)
    {
      this->Window.RemoveRenderer(&entry.scene->Renderer());
    }
  }
}

void Previews::Place(const std::vector<Tile>& tiles, int windowWidth, int windowHeight)
{
  for (Entry& entry : this->Entries)
  {
    entry.isPlaced = false;
  }
  for (const Tile& tile : tiles)
  {
    if (tile.model >= this->Entries.size())
    {
      continue;
    }
    Entry& entry = this->Entries[tile.model];
    entry.isPlaced = true;
    if (!entry.scene)
    {
      entry.scene = std::make_unique<SessionScene>();
      vtkRenderer& renderer = entry.scene->Renderer();
      renderer.SetLayer(this->Layer);
      renderer.InteractiveOff();
      renderer.PreserveColorBufferOff();
      this->Window.AddRenderer(&renderer);
    }
    entry.scene->Renderer().SetViewport(tile.left / windowWidth,
      1 - (tile.top + tile.height) / windowHeight, (tile.left + tile.width) / windowWidth,
      1 - tile.top / windowHeight);
  }
  for (Entry& entry : this->Entries)
  {
    if (entry.scene)
    {
      entry.scene->Renderer().SetDraw(entry.isPlaced);
    }
  }
  this->Ask();
}

void Previews::Turn(double angle)
{
  this->Angle += angle;
  for (Entry& entry : this->Entries)
  {
    if (entry.isPlaced && entry.isThere)
    {
      this->Aim(entry);
    }
  }
}

bool Previews::AnyIsShown() const
{
  return std::any_of(this->Entries.begin(), this->Entries.end(),
    [](const Entry& entry) { return entry.isPlaced && entry.isThere; });
}

bool Previews::Load()
{
  if (!this->Source || !this->Loading)
  {
    return false;
  }
  for (const ClientEvent& event : this->Source->Take())
  {
    if (event.kind == ClientEvent::Kind::Opened && event.model.homeView)
    {
      this->Entries[*this->Loading].up = event.model.homeView->up;
    }
    Deliver(event, this->Session);
  }
  this->Session.BeginFrame();
  for (const SessionRequest& request : this->Session.TakeRequests())
  {
    this->Source->Send(request);
  }
  return this->Finish();
}

// Starts to load the next preview that has a tile and is missing, unless one is being loaded.
void Previews::Ask()
{
  if (this->Loading)
  {
    return;
  }
  const auto next = std::find_if(this->Entries.begin(), this->Entries.end(),
    [](const Entry& entry) { return entry.isPlaced && !entry.isThere && entry.trouble.empty(); });
  if (next != this->Entries.end())
  {
    const auto model = static_cast<std::size_t>(next - this->Entries.begin());
    this->Loading = model;
    (void)this->Session.SelectModel(this->Source->Models()[model].id);
    (void)this->Load();
  }
}

bool Previews::Finish()
{
  Entry& entry = this->Entries[*this->Loading];
  const ViewerStatus status = this->Session.GetStatus();
  const bool isThere = status.vertices > 0 && this->Session.IsIdle();
  if (!isThere && status.error.empty())
  {
    return false;
  }
  entry.isThere = isThere;
  entry.trouble = isThere ? "" : status.error;
  if (isThere)
  {
    entry.view = this->Session.Scene();
    if (const Status followed = entry.scene->Follow(entry.view); !followed)
    {
      entry.isThere = false;
      entry.trouble = followed.GetError().message;
    }
    entry.view.surface = nullptr;
  }
  this->Loading.reset();
  this->Ask();
  return true;
}

void Previews::Aim(Entry& entry) const
{
  const Vec3 focal = entry.view.focal;
  ViewerScene turned = entry.view;
  turned.eye = focal + Turned(entry.view.eye - focal, entry.up, this->Angle);
  turned.up = Turned(entry.view.up, entry.up, this->Angle);
  // This cannot fail: the earlier camera was valid, and this one has the same distance.
  (void)entry.scene->Follow(turned);
}

}
