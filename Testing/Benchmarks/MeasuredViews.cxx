// SPDX-License-Identifier: BSD-3-Clause
// Views a model over a simulated line: see MeasuredViews.h.
#include "Testing/Benchmarks/MeasuredViews.h"

#include "viewer/session/SessionParts.h"

#include <array>
#include <memory>
#include <utility>

namespace kdstream::bench
{
namespace
{

// Bytes a second: everything arrives at once.
constexpr double atOnce = 1e12;
// Triangles up to which each view loads the original anew.
constexpr std::uint64_t mostAnew = 10'000'000;
// Triangles up to which the original is the reference.
constexpr std::uint64_t mostWhole = 50'000'000;
constexpr std::size_t manyBytes = std::size_t{ 16 } << 30; // the most memory for a whole model
// How much finer the reference of a larger model is.
constexpr unsigned finer = 4;

double clockOfFingers = 0;

// Turns the preview to a direction.
void Turn(ViewerSession& session, int direction)
{
  const std::array<double, 3> tilts{ 0, 90, -90 };
  for (int i = 0; i < direction % 4; ++i)
  {
    clockOfFingers += 1;
    session.HandleTouches({ clockOfFingers, { { 1, 290, 240 } } });
    session.HandleTouches({ clockOfFingers += 0.1, { { 1, 510, 240 } } });
    session.HandleTouches({ clockOfFingers += 0.1, {} });
  }
  const double tilt = tilts[static_cast<std::size_t>(direction) / 4];
  clockOfFingers += 1;
  session.HandleTouches({ clockOfFingers, { { 1, 400, 240 } } });
  session.HandleTouches({ clockOfFingers += 0.1, { { 1, 401, 240 + tilt } } });
  session.HandleTouches({ clockOfFingers += 0.1, {} });
}

void Open(ViewerSession& session, SimulatedLine& line, const ServedModel& model, const View& view,
  MeasuredView& measured)
{
  OpenPreview(session, line, model.Description().id, measured);
  Turn(session, view.direction);
  session.EnterFullScreen();
  session.Zoom(view.zoom, width / 2.0, height / 2.0);
}

double BytesOfShown(const ViewerSession& session, const ServedModel& model)
{
  const TreeDepths& depths = model.Description().depths;
  std::vector<protocol::BlobId> blobs;
  for (const PieceId piece : session.Parts().model.surface.Pieces())
  {
    blobs.push_back(BlobOfPiece(piece, depths));
  }
  for (const TexturedPiece& textured : *session.Scene().tiles)
  {
    blobs.push_back(TextureOfPiece(textured.piece, depths));
  }
  double bytes = 0;
  for (const protocol::BlobId& blob : blobs)
  {
    const auto size = model.BlobSize(blob);
    bytes += size ? static_cast<double>(*size) : 0;
  }
  return bytes;
}

}

void OpenPreview(
  ViewerSession& session, SimulatedLine& line, const std::string& model, MeasuredView& measured)
{
  session.Resize({ width, height, 1 });
  static_cast<void>(session.SelectModel(model));
  while (line.Next(session))
  {
    session.BeginFrame();
    if (session.GetStatus().vertices > 0 && measured.firstBytes == never)
    {
      measured.firstBytes = static_cast<double>(line.Bytes());
      measured.firstSeconds = line.Now();
    }
  }
}

MeasuredView MeasureView(const ServedModel& model, const View& view, SessionOptions options,
  double rate, const Reference* reference, Painter& painter, WindowPicture* last)
{
  options.mostStatistics = 0;
  ViewerSession session(std::move(options));
  SimulatedLine line(model, rate, roundTrip);
  MeasuredView measured;
  Open(session, line, model, view, measured);
  std::uint64_t version = 0;
  std::shared_ptr<const TileList> tiles;
  double bytes = 0;
  const auto draw = [&](bool anyway)
  {
    const ViewerScene scene = session.Scene();
    const bool fresh = scene.surfaceVersion != version || scene.tiles != tiles;
    if (reference && fresh && (anyway || static_cast<double>(line.Bytes()) > 1.08 * bytes))
    {
      version = scene.surfaceVersion;
      tiles = scene.tiles;
      bytes = static_cast<double>(line.Bytes());
      measured.samples.push_back(
        { bytes, line.Now(), reference->ShareOfWrong(painter.Draw(scene)) });
    }
  };
  do
  {
    session.BeginFrame();
    draw(false);
  } while (line.Next(session));
  session.BeginFrame();
  draw(true);
  measured.bytes = static_cast<double>(line.Bytes());
  measured.triangles = session.GetStatus().triangles;
  measured.wasted = session.GetTraffic().wasted;
  measured.oracleBytes = BytesOfShown(session, model);
  if (last)
  {
    *last = painter.Draw(session.Scene());
  }
  return measured;
}

JumpCost CostOfJump(const ServedModel& model, const View& view, double after, double rate)
{
  SessionOptions options;
  options.mostStatistics = 0;
  ViewerSession session(std::move(options));
  SimulatedLine line(model, rate, roundTrip);
  MeasuredView unused;
  Open(session, line, model, { 0, view.zoom }, unused);
  const double until = line.Now() + after;
  do
  {
    session.BeginFrame();
  } while (line.Next(session) && line.Now() < until);
  const auto before = static_cast<double>(line.Bytes());
  const auto wasted = static_cast<double>(session.GetTraffic().wasted);
  Turn(session, view.direction);
  do
  {
    session.BeginFrame();
  } while (line.Next(session));
  return { static_cast<double>(line.Bytes()) - before,
    static_cast<double>(session.GetTraffic().wasted) - wasted };
}

// The session stays the same from view to view; only the eye moves.
WindowPicture ReferencePictures::OfWhole(const View& view)
{
  SimulatedLine line(this->Model, atOnce, 0);
  MeasuredView unused;
  if (!this->Whole)
  {
    SessionOptions options;
    options.detail = DetailMode::Full;
    options.cacheBytes = manyBytes;
    options.mostStatistics = 0;
    this->Whole.emplace(std::move(options));
    this->PainterOfWhole.emplace();
    Open(*this->Whole, line, this->Model, view, unused);
    do
    {
      while (line.Next(*this->Whole))
      {
      }
      this->Whole->BeginFrame();
    } while (line.Next(*this->Whole));
  }
  ViewerSession viewer;
  SimulatedLine other(this->Model, atOnce, 0);
  Open(viewer, other, this->Model, view, unused);
  const ViewerScene camera = viewer.Scene();
  ViewerScene scene = this->Whole->Scene();
  scene.eye = camera.eye;
  scene.focal = camera.focal;
  scene.up = camera.up;
  scene.viewAngle = camera.viewAngle;
  return this->PainterOfWhole->Draw(scene);
}

Reference ReferencePictures::Of(const View& view, Painter& painter)
{
  Reference reference;
  const std::uint64_t triangles = this->Model.Description().triangles;
  if (triangles > mostAnew && triangles <= mostWhole)
  {
    reference.original = this->OfWhole(view);
  }
  else
  {
    SessionOptions options;
    options.detail = triangles <= mostAnew ? DetailMode::Full : DetailMode::View;
    options.refinement.triangles *= finer;
    options.refinement.bytes *= finer;
    options.cacheBytes *= finer;
    options.refinement.tolerance /= finer;
    MeasureView(
      this->Model, view, std::move(options), atOnce, nullptr, painter, &reference.original);
  }
  reference.background = painter.Draw(ViewerSession(SessionOptions()).Scene());
  return reference;
}

}
