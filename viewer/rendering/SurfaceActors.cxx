// SPDX-License-Identifier: BSD-3-Clause
// The actors that draw one surface: see SurfaceActors.h.
#include "viewer/rendering/SurfaceActors.h"

#include "viewer/session/appearance/SceneAppearance.h"

#include <vtkActor.h>
#include <vtkProperty.h>

#include <algorithm>
#include <map>
#include <utility>

namespace kdstream
{
namespace
{

// Each part is an actor, which costs time in every picture. If there are more parts than this, all
// are drawn as one; a viewer's budgets do not allow that many.
constexpr std::size_t mostParts = 1024;

}

SurfaceActors::SurfaceActors(Callback add, Callback remove)
  : Add(std::move(add))
  , Remove(std::move(remove))
{
}

SurfaceActors::~SurfaceActors() = default;

std::unique_ptr<ScenePart> SurfaceActors::NewPart() const
{
  auto part = std::make_unique<ScenePart>();
  if (this->Material)
  {
    part->SetMaterial(*this->Material);
  }
  return part;
}

Status SurfaceActors::Update(const Surface& surface, const TreeDepths& depths, const Vec3& center)
{
  KDSTREAM_TRY(CheckSurface(surface, center));
  this->Tree = depths;
  this->Middle = center;
  std::vector<Entry> whole(1);
  const bool hasOne = this->Entries.size() == 1;
  whole.front().scene = hasOne ? std::move(this->Entries.front().scene) : this->NewPart();
  whole.front().scene->Show(surface, NormalsOf(surface), depths, center, this->Style);
  this->Take(std::move(whole));
  this->FacetSize = FacetLength(surface);
  return {};
}

Status SurfaceActors::Update(const DrawnSurface& surface, const TreeDepths& depths,
  const Vec3& center, const std::shared_ptr<const TileList>& tiles)
{
  const bool isTextured = this->Decoder && tiles && !tiles->empty();
  if (surface.TriangleCount() == 0 || (surface.Parts().size() > mostParts && !isTextured))
  {
    KDSTREAM_TRY(this->Update(surface.Whole(), depths, center));
    this->FacetSize = FacetLength(surface);
    return {};
  }
  std::map<const SurfacePart*, Entry*> before;
  for (Entry& entry : this->Entries)
  {
    if (entry.drawn.part && depths == this->Tree && center == this->Middle)
    {
      before[entry.drawn.part.get()] = &entry;
    }
  }
  std::vector<DrawnSurface::Part> parts = surface.Parts();
  std::erase_if(
    parts, [](const DrawnSurface::Part& part) { return part.part->surface.triangles.empty(); });
  for (const DrawnSurface::Part& part : parts)
  {
    if (before.count(part.part.get()) == 0)
    {
      KDSTREAM_TRY(CheckSurface(part.part->surface, center));
    }
  }
  this->Tree = depths;
  this->Middle = center;
  std::vector<Entry> entries(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i)
  {
    entries[i].drawn = parts[i];
    entries[i].tile = isTextured ? FindTile(*tiles, parts[i].part->piece) : nullptr;
    const auto known = before.find(parts[i].part.get());
    if (known != before.end())
    {
      entries[i].scene = std::move(known->second->scene);
      entries[i].isShown =
        known->second->drawn.LooksLike(parts[i]) && known->second->tile == entries[i].tile;
    }
  }
  // New parts reuse actors of parts that are no longer needed.
  auto spare = this->Entries.begin();
  for (Entry& entry : entries)
  {
    if (!entry.scene)
    {
      spare = std::find_if(
        spare, this->Entries.end(), [](const Entry& each) { return each.scene != nullptr; });
      entry.scene = spare == this->Entries.end() ? this->NewPart() : std::move(spare->scene);
    }
    if (!std::exchange(entry.isShown, true))
    {
      const SurfacePart& part = *entry.drawn.part;
      const UnitNormals normals = UnitNormalsOf(*entry.drawn.normals);
      if (!entry.tile || !entry.scene->ShowTextured(part, normals, depths, center, this->Style,
                           { entry.tile, this->Decoder }))
      {
        entry.scene->Show(part.surface, normals, depths, center, this->Style);
      }
    }
  }
  this->Take(std::move(entries));
  this->FacetSize = FacetLength(surface);
  return {};
}

// Draws these entries from now on. Earlier entries that were not moved into them are released.
void SurfaceActors::Take(std::vector<Entry> entries)
{
  for (const Entry& entry : this->Entries)
  {
    if (entry.scene)
    {
      this->Remove(entry.scene->Actor());
    }
  }
  this->Entries = std::move(entries);
  this->Extent = {};
  for (const Entry& entry : this->Entries)
  {
    this->Add(entry.scene->Actor());
    this->Extent.Add(entry.scene->Bounds());
  }
}

void SurfaceActors::SetStyle(const SceneStyle& style)
{
  const SceneStyle before = std::exchange(this->Style, style);
  if (style.coloring == before.coloring && style.flat == before.flat)
  {
    return;
  }
  for (const Entry& entry : this->Entries)
  {
    entry.scene->SetStyle(style);
  }
}

void SurfaceActors::SetMaterial(vtkProperty& material)
{
  if (this->Material == &material && this->MaterialTime == material.GetMTime())
  {
    return;
  }
  this->Material = &material;
  this->MaterialTime = material.GetMTime();
  for (const Entry& entry : this->Entries)
  {
    entry.scene->SetMaterial(material);
    entry.scene->SetStyle(this->Style);
  }
}

void SurfaceActors::Aim(const Sight& sight)
{
  for (const Entry& entry : this->Entries)
  {
    entry.scene->Aim(sight);
    entry.scene->CutBy(sight.section, this->Middle);
    entry.scene->RaiseRelief(sight.relief, reliefShare * sight.height);
  }
}

}
