// SPDX-License-Identifier: BSD-3-Clause
// The page's picture: decides when a frame makes a surface, when it draws, and how fast the device
// is. Step "render" of the pipeline picture.
//
// Lengths and positions are pixels of the canvas, times seconds of performance.now().
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

  // Makes all that draws: when there is a context, and when one that was lost is given back.
  void MakeRenderer();
  // The context is lost, and all that was made of it.
  void ForgetRenderer();
  void Resize(const Viewport& viewport);
  // The next frame draws, whatever has changed: if nothing has, the same picture again.
  void Redraw() { this->Again = true; }
  // Whether new vertices morph to their places; not at first.
  void SetGeomorphs(bool geomorphs) { this->MayMorph = geomorphs; }
  void SetColors(const ColorChoice& colors);
  const ColorChoice& Colors() const { return this->Chosen; }

  // The background from the next picture on: colours, 0-1. At first the usual ones.
  void SetBackground(const Vec3& bottom, const Vec3& top) { this->Background = { bottom, top }; }

  // Draws if anything has changed. True if it did, or if the next frame has more to do. Without a
  // renderer it does nothing.
  bool Draw();

  // Whether what is drawn is not yet what it comes to.
  bool IsInFlight() const;
  // "gliding", "plain", "frames" and "drawingError" of the status, into an object.
  void Describe(JsonWriter& json) const;
  // The bytes of buffers and textures.
  std::size_t GraphicsBytes() const;

private:
  // All that decides about a picture.
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
  std::unique_ptr<GlesRenderer> Renderer; // null before there is a context and after it was lost
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
  double LastPicture = -1; // begin of the last frame, if the view moved in it; otherwise below 0
  std::uint64_t Frames = 0;
  std::string DrawingError;
};

// The bytes of WebAssembly's memory, which never shrinks.
std::size_t HeapBytes();

}
