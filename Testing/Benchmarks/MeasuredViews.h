// SPDX-License-Identifier: BSD-3-Clause
// Views of a model over a simulated line, and the references with which their pictures are compared
// (doc/benchmarks.md#views).
#pragma once

#include "Testing/Benchmarks/ComparedPictures.h"
#include "Testing/Benchmarks/SimulatedLine.h"
#include "server/session/Catalog.h"

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace kdstream::bench
{

constexpr double never = std::numeric_limits<double>::infinity();
constexpr double roundTrip = 0.03; // s

struct View
{
  int direction = 0; // one of 12
  double zoom = 1;
};

// A picture on the way to the final one.
struct Sample
{
  double bytes = 0, seconds = 0;
  double wrong = 1; // share of the object's pixels that are wrong
};

struct MeasuredView
{
  std::vector<Sample> samples;
  double firstBytes = never, firstSeconds = never;
  double oracleBytes = 0; // of the last cut's pieces, and of their texture tiles
  double bytes = 0;       // all that arrived
  std::uint64_t triangles = 0, wasted = 0;
};

// The pictures that a view is compared with: the original, and the background without the model.
struct Reference
{
  WindowPicture original, background;

  double ShareOfWrong(const WindowPicture& picture) const
  {
    return bench::ShareOfWrong(picture, this->original, this->background);
  }
};

// Selects the model and waits for its preview. line: used only by this session.
void OpenPreview(
  ViewerSession& session, SimulatedLine& line, const std::string& model, MeasuredView& measured);

// Views until nothing more arrives, at `rate` bytes a second. Without a reference only the last
// picture is drawn, into `last`.
MeasuredView MeasureView(const ServedModel& model, const View& view, SessionOptions options,
  double rate, const Reference* reference, Painter& painter, WindowPicture* last = nullptr);

// The bytes that arrive after a jump of the eye, and those of them from which nothing was shown.
struct JumpCost
{
  double bytes = 0, wasted = 0;
};

// Views from direction 0 at the view's zoom for `after` seconds. Then jumps to the view's
// direction, and waits there until nothing more arrives. rate: bytes a second.
JumpCost CostOfJump(const ServedModel& model, const View& view, double after, double rate);

// Draws the references for views of a model: pictures of its original (`--detail full`). If the
// original has more than 10 million triangles, its surface is kept, which takes some 200 bytes for
// each triangle. If it has more than 50 million, the reference is the same view with four times the
// budget and a quarter of the error.
class ReferencePictures
{
public:
  explicit ReferencePictures(const ServedModel& model)
    : Model(model)
  {
  }

  Reference Of(const View& view, Painter& painter);

private:
  WindowPicture OfWhole(const View& view);

  const ServedModel& Model;
  std::optional<ViewerSession> Whole;
  std::optional<Painter> PainterOfWhole; // its scene is kept in this object
};

}
