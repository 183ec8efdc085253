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
  int direction = 0; // of 12
  double zoom = 1;
};

// A picture on the way.
struct Sample
{
  double bytes = 0, seconds = 0;
  double wrong = 1; // share of the object's pixels
};

struct MeasuredView
{
  std::vector<Sample> samples;
  double firstBytes = never, firstSeconds = never;
  double oracleBytes = 0; // of the last cut's pieces, and of the tiles that paint it
  double bytes = 0;       // all
  std::uint64_t triangles = 0, wasted = 0;
};

// What a view is compared with: the original, and the background without the model.
struct Reference
{
  WindowPicture original, background;

  double ShareOfWrong(const WindowPicture& picture) const
  {
    return bench::ShareOfWrong(picture, this->original, this->background);
  }
};

// Selects the model and waits for its preview. line: used only by that session.
void OpenPreview(
  ViewerSession& session, SimulatedLine& line, const std::string& model, MeasuredView& measured);

// Views until nothing more arrives, at `rate` bytes a second. Without a reference: draws only the
// last picture, into `last`.
MeasuredView MeasureView(const ServedModel& model, const View& view, SessionOptions options,
  double rate, const Reference* reference, Painter& painter, WindowPicture* last = nullptr);

// Bytes after a jump of the eye, and those of them that nothing was shown of.
struct JumpCost
{
  double bytes = 0, wasted = 0;
};

// Views from direction 0 at a zoom for `after` seconds, jumps to another direction, and waits there
// until nothing more arrives, at `rate` bytes a second.
JumpCost CostOfJump(const ServedModel& model, const View& view, double after, double rate);

// Draws the references of views of a model: its original (`--detail full`). The surface of an
// original with more than 10 million triangles is kept, some 200 bytes a triangle. For more than 50
// million triangles the reference is the same view with four times the budget and a quarter of the
// error.
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
  std::optional<Painter> PainterOfWhole; // whose scene it stays in
};

}
