// SPDX-License-Identifier: BSD-3-Clause
// The page's picture: see PagePicture.h.
#include "viewer/mobile/web/PagePicture.h"

#include <emscripten/emscripten.h>

#include <utility>

// Only declared here; gl.js implements it, and lets the browser decode the picture.
// clang-format off
EM_JS(void, kdstream_upload_picture, (unsigned texture, const void* begin, std::size_t bytes,
  unsigned format, unsigned width, unsigned height), {})
// clang-format on

namespace kdstream
{

namespace
{

void UploadTile(unsigned texture, const TextureTile& tile)
{
  kdstream_upload_picture(texture, tile.image.data(), tile.image.size(),
    static_cast<unsigned>(tile.format), tile.width, tile.height);
}

}

std::size_t HeapBytes()
{
  return __builtin_wasm_memory_size(0) * 65536;
}

PagePicture::PagePicture(PageSession& page, double (*clock)())
  : Page(page)
  , Clock(clock)
{
}

std::size_t PagePicture::GraphicsBytes() const
{
  return this->Renderer ? this->Renderer->GraphicsBytes() : 0;
}

void PagePicture::MakeRenderer()
{
  this->Drawn.reset();
  auto made = GlesRenderer::Make();
  if (!made)
  {
    this->DrawingError = made.GetError().message;
    return;
  }
  GlesRenderer::SetTileUpload(UploadTile);
  this->Renderer = std::move(*made);
  this->DrawingError.clear();
}

void PagePicture::ForgetRenderer()
{
  if (this->Renderer)
  {
    this->Renderer->Forget();
    this->Renderer.reset();
  }
}

void PagePicture::Resize(const Viewport& viewport)
{
  this->Window = viewport;
  this->Page.Session().Resize(viewport);
  this->Drawn.reset(); // resizing a canvas clears it
}

void PagePicture::SetColors(const ColorChoice& colors)
{
  this->Chosen = colors;
  ++this->ColorsVersion;
}

bool PagePicture::MayDrawSurface(double now) const
{
  return this->Pace.MayDraw(this->Page.Session().GetStatus().blobsWanted > 0, now);
}

// Makes a surface from what has arrived, for a later frame, unless the old surface is still
// morphing. Returns whether there is a new surface.
bool PagePicture::MakeSurface(double morphed, double now)
{
  if (morphed < 1 || !this->MayDrawSurface(now))
  {
    return false;
  }
  ViewerSession& session = this->Page.Session();
  const std::uint64_t version = session.Scene().surfaceVersion;
  session.SetGeomorphs(this->MayMorph && this->Page.IsWhole() && this->Geomorph.MayBegin(now));
  const double begin = this->Clock();
  session.BeginFrame();
  this->Pace.Made(this->Clock() - begin);
  return session.Scene().surfaceVersion != version;
}

// Decides whether the picture has occlusion. The device's speed is measured by the time until the
// browser's next frame, because drawing continues after Render has returned.
bool PagePicture::ChooseOcclusion(State state, double now)
{
  const std::optional<State>& last = this->Drawn;
  state.occluded = last && last->occluded;
  if (this->LastPicture >= 0)
  {
    this->Occlusion.Drawn(state.occluded, now - this->LastPicture, now);
  }
  const bool moves = last != state;
  const bool fresh = !last || last->surfaceVersion != state.surfaceVersion;
  this->LastPicture = moves && !fresh ? now : -1;
  return this->Occlusion.Has(moves, now);
}

PagePicture::State PagePicture::StateOf(const ViewerScene& scene, double morphed, double now)
{
  State state{ scene.surfaceVersion, scene.eye, scene.focal, scene.up, this->Window,
    this->ColorsVersion, morphed, scene.section, scene.capVersion, scene.lighting };
  state.tiles = scene.tiles;
  state.occluded = this->ChooseOcclusion(state, now);
  if (scene.surface->PointCount() == 0) // only the background is drawn
  {
    state = State{};
    state.viewport = this->Window;
  }
  return state;
}

void PagePicture::Render(const ViewerScene& scene, const State& state)
{
  this->Renderer->SetColoring(ColoringOf(this->Chosen, scene.scalars));
  this->Renderer->SetBackground(this->Background[0], this->Background[1]);
  this->Renderer->SetMorphed(state.morphed);
  this->Renderer->SetOcclusion(state.occluded);
  const Status drawn = this->Renderer->Draw(scene, this->Window);
  this->DrawingError = drawn ? "" : drawn.GetError().message;
  this->Drawn = state;
  this->Again = false;
  ++this->Frames;
}

// A new surface that morphs looks like the earlier surface at first; its time starts after that
// frame.
bool PagePicture::Draw()
{
  if (!this->Renderer)
  {
    return false;
  }
  const double begin = this->Clock();
  ViewerSession& session = this->Page.Session();
  this->Page.FollowMemory(HeapBytes() + this->GraphicsBytes());
  session.Advance(begin);
  session.FollowView();
  double morphed = this->Geomorph.Share(begin);
  if (session.Scene().surface->PointCount() == 0)
  {
    this->MakeSurface(morphed, begin); // the first surface is drawn at once
    this->Pace.Made(0);
  }
  ViewerScene scene = session.Scene();
  if (this->Drawn && !this->MayDrawSurface(begin))
  {
    scene.tiles = this->Drawn->tiles;
  }
  const bool fresh = !this->Drawn || this->Drawn->surfaceVersion != scene.surfaceVersion;
  const bool made = !fresh && (this->Pace.PutsOff(session.GetStatus().blobsLoaded) ||
                                this->MakeSurface(morphed, begin));
  const bool begins = fresh && this->Drawn && scene.surface->HasGeomorphs();
  const State state = this->StateOf(scene, begins ? 0 : morphed, begin);
  if (this->Drawn == state && !this->Again)
  {
    return made; // if a surface was made, the next frame draws it
  }
  const bool retextured = !this->Drawn || this->Drawn->tiles != scene.tiles;
  this->Render(scene, state);
  const double end = this->Clock();
  const double seconds = end - begin + (fresh ? this->Pace.MakingSeconds() : 0);
  if (!made)
  {
    session.EndFrame(seconds); // its time belongs to the shown surface, not to the next one
  }
  if (fresh || retextured)
  {
    this->Pace.Drawn(end, seconds);
  }
  if (begins)
  {
    this->Geomorph.Begin(end);
  }
  return true;
}

bool PagePicture::IsInFlight() const
{
  const bool drawsSoon =
    this->Pace.IsPuttingOff() ||
    (this->Drawn && this->Drawn->surfaceVersion != this->Page.Session().Scene().surfaceVersion);
  return this->IsMorphing() || this->IsPlain() || drawsSoon;
}

void PagePicture::Describe(JsonWriter& json) const
{
  json.Member("gliding", this->IsMorphing())
    .Member("plain", this->IsPlain())
    .Member("frames", this->Frames)
    .Member("drawingError", this->DrawingError);
}

}
