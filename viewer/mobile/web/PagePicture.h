// SPDX-License-Identifier: BSD-3-Clause
// The page's picture: decides when a frame makes a surface, when it draws, and measures how fast
// the device is. Step "render" of the pipeline picture.
//
// Lengths and positions are pixels of the canvas; times are seconds of performance.now().
#pragma once

#include "filters/model/JsonWriter.h"
#include "viewer/mobile/GeomorphClock.h"
#include "viewer/mobile/GlesRenderer.h"
#include "viewer/mobile/SurfacePace.h"
#include "viewer/mobile/web/PageSession.h"
#include "viewer/session/appearance/Coloring.h"
#include "viewer/session/appearance/OcclusionClock.h"
#include "viewer/session/appearance/SceneAppearance.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace kdstream
{

class PagePicture
{
public:
  // clock: seconds of a steady clock.
  PagePicture(PageSession& page, double (*clock)());

  // Creates what is needed to draw. Call this when there is a context, and when a lost context was
  // restored.
  void MakeRenderer();
  // Call this when the context was lost, with everything that was made in it.
  void ForgetRenderer();
  void Resize(const Viewport& viewport);
  // Makes the next frame draw, even if nothing has changed.
  void Redraw() { this->Again = true; }
  // Whether new vertices morph to their places; the default is false.
  void SetGeomorphs(bool geomorphs) { this->MayMorph = geomorphs; }
  void SetColors(const ColorChoice& colors);
  const ColorChoice& Colors() const { return this->Chosen; }

  // Sets the colours of the background (0-1) from the next picture on.
  void SetBackground(const Vec3& bottom, const Vec3& top) { this->Background = { bottom, top }; }

  // Draws if anything has changed. Returns true if it drew, or if the next frame has more to do.
  // Does nothing without a renderer.
  bool Draw();

  // Whether the picture will still change: new vertices morph, occlusion is missing, or a new
  // surface is about to be drawn.
  bool IsInFlight() const;
  // Writes the status's members "gliding", "plain", "frames" and "drawingError" into an object.
  void Describe(JsonWriter& json) const;
  // The bytes of buffers and textures.
  std::size_t GraphicsBytes() const;

private:
  // Everything that determines a picture.
  struct State
  {
    std::uint64_t surfaceVersion = 0;
    Vec3 eye{}, focal{}, up{};
    Viewport viewport;
    std::uint64_t colorsVersion = 0;
    double morphed = 1;
    std::optional<SectionPlane> section{};
    std::uint64_t capVersion = 0;
    SceneLighting lighting{};
    bool occluded = false;
    std::shared_ptr<const TileList> tiles{};
    bool operator==(const State&) const = default;
  };

  bool IsMorphing() const { return this->Drawn && this->Drawn->morphed < 1; }
  bool IsPlain() const { return this->Drawn && !this->Drawn->occluded; }
  State StateOf(const ViewerScene& scene, double morphed, double now);
  bool MayDrawSurface(double now) const;
  bool MakeSurface(double morphed, double now);
  bool ChooseOcclusion(State state, double now);
  void Render(const ViewerScene& scene, const State& state);

  PageSession& Page;
  double (*Clock)();
  std::unique_ptr<GlesRenderer> Renderer; // null before there is a context, and after it was lost
  Viewport Window;
  ColorChoice Chosen;
  std::uint64_t ColorsVersion = 0;
  std::array<Vec3, 2> Background{ backgroundBottom, backgroundTop };
  std::optional<State> Drawn;
  bool Again = false;
  SurfacePace Pace;
  bool MayMorph = false;
  GeomorphClock Geomorph;
  OcclusionClock Occlusion;
  double LastPicture = -1; // start of the last frame if the view moved in it; otherwise -1
  std::uint64_t Frames = 0;
  std::string DrawingError;
};

// The size of WebAssembly's memory in bytes; it never shrinks.
std::size_t HeapBytes();

}
