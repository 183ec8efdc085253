// SPDX-License-Identifier: BSD-3-Clause
// The viewer of the page: a session, its connection to the server and its picture, as plain
// functions for page.js. Step "render" of the pipeline picture.
//
// Texts and bytes go in through one buffer: page.js asks for room (ViewerInbox), copies them there,
// and calls a function that takes the buffer's content. Texts come out through another buffer: a
// function fills it, and ViewerText and ViewerTextBytes say where it is. Lengths and positions are
// pixels of the canvas; times are seconds of performance.now().
//
// No input can make the program trap, except by lack of memory, which page.js reports to the user.
#include "viewer/mobile/web/PagePicture.h"
#include "viewer/mobile/web/PageSession.h"
#include "viewer/session/InputTouches.h"
#include "viewer/session/SessionParts.h"
#include "viewer/session/appearance/ColorLegend.h"
#include "viewer/session/appearance/Palette.h"

#include <emscripten/emmalloc.h>
#include <emscripten/emscripten.h>
#include <emscripten/html5.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <set>
#include <span>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

namespace kdstream
{

namespace
{

double Now()
{
  return emscripten_performance_now() * 1e-3;
}

}

struct WebViewer
{
  PageSession page{ Now };
  PagePicture picture{ page, Now };
  std::vector<ServerLine::Action> actions; // actions to do; the last element is done first
  std::size_t mostBytes = 0;               // the maximum size of the answer to the last Fetch

  std::string inbox, outbox;
  std::vector<std::uint8_t> arrived; // the bytes of the last arrival
};

namespace
{

// More than the size of any answer that a phone could show.
constexpr std::size_t mostInbox = std::size_t{ 32 } << 20;

int HexOf(const Color& color)
{
  return color[0] << 16 | color[1] << 8 | color[2];
}

// A legend of the shown resolutions, the finest first.
std::string LegendOfDetail(const ViewerScene& scene)
{
  std::set<Resolution> shown;
  for (const auto& part : scene.surface->Parts())
  {
    shown.insert(part.part->piece.resolution);
  }
  JsonWriter json;
  json.BeginArray();
  for (auto resolution = shown.rbegin(); resolution != shown.rend(); ++resolution)
  {
    json.BeginObject()
      .Member("level", resolution->IsOriginal() ? -1 : static_cast<int>(resolution->Depth()))
      .Member("color", HexOf(ResolutionColor(*resolution)))
      .EndObject();
  }
  json.EndArray();
  return json.Text();
}

// Reads the id, x, y and isPair of each pointer, as doubles.
std::vector<Touch> ParseTouches(const std::string& bytes, double pixelRatio)
{
  double values[4];
  std::vector<Touch> touches;
  for (std::size_t at = 0; at + sizeof(values) <= bytes.size(); at += sizeof(values))
  {
    std::memcpy(values, bytes.data() + at, sizeof(values));
    AddTouches({ static_cast<std::int64_t>(values[0]), values[1], values[2], values[3] != 0 },
      pixelRatio, touches);
  }
  return touches;
}

const Viewport& WindowOf(const WebViewer& viewer)
{
  return viewer.page.Session().GetCamera().GetViewport();
}

}

}

using kdstream::WebViewer;

extern "C"
{
  // Lack of memory must trap. Otherwise operator new, which cannot throw here, would return null,
  // and the program would continue. The linker puts this function before the C library's own
  // (--wrap).
  int __real_emscripten_resize_heap(std::size_t bytes);
  int __wrap_emscripten_resize_heap(std::size_t bytes);
  EMSCRIPTEN_KEEPALIVE int __wrap_emscripten_resize_heap(std::size_t bytes)
  {
    if (__real_emscripten_resize_heap(bytes) == 0)
    {
      __builtin_trap();
    }
    return 1;
  }

  // Makes a viewer, which exists until it is dropped.
  EMSCRIPTEN_KEEPALIVE WebViewer* ViewerMake()
  {
    return new WebViewer;
  }

  EMSCRIPTEN_KEEPALIVE void ViewerDrop(WebViewer* viewer)
  {
    delete viewer;
  }

  // Call this when the rest of the WebAssembly has been loaded (parts.js).
  EMSCRIPTEN_KEEPALIVE void ViewerBecomeWhole(WebViewer* viewer)
  {
    viewer->page.BecomeWhole();
  }

  // ---- texts and bytes

  // Returns room for this number of bytes; null if there are too many.
  EMSCRIPTEN_KEEPALIVE char* ViewerInbox(WebViewer* viewer, std::size_t bytes)
  {
    if (bytes > kdstream::mostInbox)
    {
      return nullptr;
    }
    viewer->inbox.assign(bytes, '\0');
    return viewer->inbox.data();
  }
  EMSCRIPTEN_KEEPALIVE const char* ViewerText(const WebViewer* viewer)
  {
    return viewer->outbox.data();
  }
  EMSCRIPTEN_KEEPALIVE std::size_t ViewerTextBytes(const WebViewer* viewer)
  {
    return viewer->outbox.size();
  }

  // ---- what the user does

  // The inbox holds the model's id.
  EMSCRIPTEN_KEEPALIVE void ViewerSelect(WebViewer* viewer)
  {
    viewer->page.SelectModel(viewer->inbox);
  }
  EMSCRIPTEN_KEEPALIVE void ViewerEnterFullScreen(WebViewer* viewer)
  {
    viewer->page.Session().EnterFullScreen();
  }
  EMSCRIPTEN_KEEPALIVE void ViewerLeaveFullScreen(WebViewer* viewer)
  {
    viewer->page.Session().LeaveFullScreen();
  }
  // The inbox holds id, x, y and isPair (0 or 1) of every pointer that is down, as doubles.
  EMSCRIPTEN_KEEPALIVE void ViewerTouches(WebViewer* viewer, double time)
  {
    const double ratio = kdstream::WindowOf(*viewer).pixelRatio;
    viewer->page.Session().HandleTouches({ time, kdstream::ParseTouches(viewer->inbox, ratio) });
  }
  // The same as DragByKey and TapByKey.
  EMSCRIPTEN_KEEPALIVE void ViewerDragByKey(
    WebViewer* viewer, int right, int down, bool pans, double time)
  {
    for (unsigned frame = 0; frame < kdstream::dragFrames; ++frame)
    {
      viewer->page.Session().HandleTouches(
        kdstream::DragByKey(kdstream::WindowOf(*viewer), right, down, pans, time, frame));
    }
  }
  EMSCRIPTEN_KEEPALIVE void ViewerTapByKey(WebViewer* viewer, unsigned times, double time)
  {
    for (unsigned frame = 0; frame < times * kdstream::tapFrames; ++frame)
    {
      viewer->page.Session().HandleTouches(
        kdstream::TapByKey(kdstream::WindowOf(*viewer), time, frame));
    }
  }
  EMSCRIPTEN_KEEPALIVE void ViewerCancelTouches(WebViewer* viewer)
  {
    viewer->page.Session().CancelTouches();
  }
  EMSCRIPTEN_KEEPALIVE void ViewerZoom(WebViewer* viewer, double factor, double x, double y)
  {
    viewer->page.Session().Zoom(factor, x, y);
  }
  // Zooms in or out about the middle.
  EMSCRIPTEN_KEEPALIVE void ViewerZoomByKey(WebViewer* viewer, bool isIn)
  {
    const auto& window = kdstream::WindowOf(*viewer);
    const double factor = isIn ? kdstream::keyZoom : 1 / kdstream::keyZoom;
    viewer->page.Session().Zoom(factor, 0.5 * window.width, 0.5 * window.height);
  }
  // Makes the next frame draw again.
  EMSCRIPTEN_KEEPALIVE void ViewerRedraw(WebViewer* viewer)
  {
    viewer->picture.Redraw();
  }

  // Each colour is 0xrrggbb.
  EMSCRIPTEN_KEEPALIVE void ViewerSetBackground(WebViewer* viewer, unsigned bottom, unsigned top)
  {
    const auto color = [](unsigned hex)
    {
      return kdstream::Vec3{ (hex >> 16 & 0xff) / 255.0, (hex >> 8 & 0xff) / 255.0,
        (hex & 0xff) / 255.0 };
    };
    viewer->picture.SetBackground(color(bottom), color(top));
    viewer->picture.Redraw();
  }

  EMSCRIPTEN_KEEPALIVE void ViewerGoHome(WebViewer* viewer)
  {
    viewer->page.Session().GoHome();
  }
  EMSCRIPTEN_KEEPALIVE void ViewerUndoView(WebViewer* viewer)
  {
    viewer->page.Session().UndoView();
  }
  // The inbox holds the side: "front" and so on.
  EMSCRIPTEN_KEEPALIVE void ViewerLookFromSide(WebViewer* viewer)
  {
    viewer->page.Session().LookFromSide(viewer->inbox);
  }
  EMSCRIPTEN_KEEPALIVE void ViewerSetSpinning(WebViewer* viewer, bool spins)
  {
    viewer->page.Session().SetSpinning(spins);
  }
  // The inbox holds a link to a view.
  EMSCRIPTEN_KEEPALIVE void ViewerFollow(WebViewer* viewer)
  {
    viewer->page.Follow(viewer->inbox);
  }
  // The text is a link to the current view, without colours.
  EMSCRIPTEN_KEEPALIVE void ViewerLink(WebViewer* viewer)
  {
    viewer->outbox = FormatViewLink(viewer->page.Session().Link());
  }
  // tool: 0 none, 1 measure, 2 section, 3 light, 4 second light.
  EMSCRIPTEN_KEEPALIVE void ViewerSetTool(WebViewer* viewer, unsigned tool)
  {
    viewer->page.Session().SetTool(
      tool <= 4 ? static_cast<kdstream::Tool>(tool) : kdstream::Tool::None);
  }
  // The inbox holds the direction: "x" and so on.
  EMSCRIPTEN_KEEPALIVE void ViewerSetSectionAlong(WebViewer* viewer)
  {
    viewer->page.Session().SetSectionAlong(viewer->inbox);
  }
  EMSCRIPTEN_KEEPALIVE void ViewerSetSectionDepth(WebViewer* viewer, double depth)
  {
    viewer->page.Session().SetSectionDepth(depth);
  }
  // The text is the section's outline as SVG.
  EMSCRIPTEN_KEEPALIVE void ViewerSectionOutline(WebViewer* viewer)
  {
    viewer->outbox = viewer->page.Session().SectionOutline();
  }
  // Sets the intensities of both lights and the relief, if there is raking light.
  EMSCRIPTEN_KEEPALIVE void ViewerDim(
    WebViewer* viewer, double lightSource, double secondLight, double relief)
  {
    auto light = viewer->page.Session().GetLight();
    if (light)
    {
      light->lightSource.intensity = lightSource;
      light->relief = relief;
      if (light->second)
      {
        light->second->intensity = secondLight;
      }
      viewer->page.Session().SetLight(light);
    }
  }
  EMSCRIPTEN_KEEPALIVE void ViewerStandardLight(WebViewer* viewer)
  {
    viewer->page.Session().SetLight({});
  }
  // The text is the measured distances (PageSession::MeasurementsJson).
  EMSCRIPTEN_KEEPALIVE void ViewerMeasurements(WebViewer* viewer)
  {
    viewer->outbox = viewer->page.MeasurementsJson();
  }
  // The inbox holds links, one per line.
  EMSCRIPTEN_KEEPALIVE void ViewerSetMarks(WebViewer* viewer)
  {
    viewer->page.SetMarks(viewer->inbox);
  }
  // The text is the marks (PageSession::MarksJson).
  EMSCRIPTEN_KEEPALIVE void ViewerMarks(WebViewer* viewer)
  {
    viewer->outbox = viewer->page.MarksJson();
  }
  // The inbox holds the name.
  EMSCRIPTEN_KEEPALIVE void ViewerNameMeasurement(WebViewer* viewer, std::size_t index)
  {
    viewer->page.Session().NameMeasurement(index, viewer->inbox);
  }
  EMSCRIPTEN_KEEPALIVE void ViewerRemoveMeasurement(WebViewer* viewer, std::size_t index)
  {
    viewer->page.Session().RemoveMeasurement(index);
  }
  EMSCRIPTEN_KEEPALIVE void ViewerSetMemory(WebViewer* viewer, double bytes)
  {
    viewer->page.SetMemory(bytes > 4e9 ? 0xffffffff : static_cast<std::size_t>(bytes));
  }
  // The text is the bytes of memory in use, as JSON.
  EMSCRIPTEN_KEEPALIVE void ViewerMemory(WebViewer* viewer)
  {
    const auto top = reinterpret_cast<std::size_t>(sbrk(0));
    kdstream::JsonWriter json;
    json.BeginObject()
      .Member("budget", viewer->page.MemoryBytes())
      .Member("heap", kdstream::HeapBytes())
      .Member("used", top - emmalloc_free_dynamic_memory())
      .Member("pieces", viewer->page.Session().Parts().model.Bytes())
      .Member("graphics", viewer->picture.GraphicsBytes())
      .EndObject();
    viewer->outbox = json.Text();
  }
  // turning: 0 upright, 1 free.
  EMSCRIPTEN_KEEPALIVE void ViewerSetTurning(WebViewer* viewer, unsigned turning)
  {
    viewer->page.Session().SetTurning(
      turning == 1 ? kdstream::Turning::Free : kdstream::Turning::Upright);
  }
  // detail: 0 as the view needs, 1 one level for the whole model.
  EMSCRIPTEN_KEEPALIVE void ViewerSetDetail(WebViewer* viewer, unsigned detail)
  {
    viewer->page.Session().SetDetail(
      detail == 1 ? kdstream::DetailMode::Level : kdstream::DetailMode::View);
  }

  // Whether anything moves by itself: new vertices morph, and a released model continues to turn.
  EMSCRIPTEN_KEEPALIVE void ViewerSetMotion(WebViewer* viewer, bool motion)
  {
    viewer->picture.SetGeomorphs(motion);
    viewer->page.Session().SetCoasting(motion);
  }
  EMSCRIPTEN_KEEPALIVE void ViewerSetPrefetch(WebViewer* viewer, unsigned bytes)
  {
    viewer->page.Session().SetPrefetch(bytes);
  }
  EMSCRIPTEN_KEEPALIVE void ViewerSetRings(WebViewer* viewer, unsigned rings)
  {
    viewer->page.Session().SetRings(rings);
  }
  // coloring: a SurfaceColoring; a larger number means the array whose name is in the inbox. map: a
  // ColorMap; a larger number means the first one. low and high: the ends of the map's range, or
  // NaN.
  EMSCRIPTEN_KEEPALIVE void ViewerSetColors(
    WebViewer* viewer, unsigned coloring, unsigned map, double low, double high)
  {
    using kdstream::SurfaceColoring;
    const auto last = static_cast<unsigned>(SurfaceColoring::Attribute);
    kdstream::ColorChoice colors;
    colors.coloring = static_cast<SurfaceColoring>(std::min(coloring, last));
    colors.attribute = viewer->inbox;
    colors.map = kdstream::allColorMaps[map < kdstream::allColorMaps.size() ? map : 0];
    if (low < high)
    {
      colors.range = { low, high };
    }
    viewer->picture.SetColors(colors);
  }

  // ---- the canvas

  // Creates what is needed to draw. Call this when gl.js has a context, and when a lost context was
  // restored.
  EMSCRIPTEN_KEEPALIVE void ViewerMakeRenderer(WebViewer* viewer)
  {
    viewer->picture.MakeRenderer();
  }
  EMSCRIPTEN_KEEPALIVE void ViewerContextLost(WebViewer* viewer)
  {
    viewer->picture.ForgetRenderer();
  }
  EMSCRIPTEN_KEEPALIVE void ViewerResize(
    WebViewer* viewer, int width, int height, double pixelRatio)
  {
    viewer->picture.Resize({ std::max(width, 1), std::max(height, 1), pixelRatio });
  }
  // Draws if something has changed; returns whether it had.
  EMSCRIPTEN_KEEPALIVE bool ViewerFrame(WebViewer* viewer)
  {
    return viewer->picture.Draw();
  }

  // ---- the connection to the server

  // The inbox holds the list of models. Returns false if it is not a list; the text says why.
  EMSCRIPTEN_KEEPALIVE bool ViewerSetModels(WebViewer* viewer)
  {
    const kdstream::Status status = viewer->page.SetModels(viewer->inbox);
    viewer->outbox = status ? "" : status.GetError().message;
    viewer->inbox = {};
    return status.HasValue();
  }
  EMSCRIPTEN_KEEPALIVE void ViewerSocketOpened(WebViewer* viewer, double now)
  {
    viewer->page.Line().SocketOpened(now);
  }
  // The inbox holds a message of the stream.
  EMSCRIPTEN_KEEPALIVE void ViewerSocketText(WebViewer* viewer, double now)
  {
    viewer->page.Line().SocketText(viewer->inbox, now);
  }
  EMSCRIPTEN_KEEPALIVE void ViewerSocketFrame(WebViewer* viewer, double now)
  {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(viewer->inbox.data());
    viewer->page.Line().SocketFrame(std::span(bytes, viewer->inbox.size()), now);
  }
  // The inbox holds the reason. retryAfter: the seconds that a busy server asks to wait, or 0.
  EMSCRIPTEN_KEEPALIVE void ViewerSocketEnded(
    WebViewer* viewer, bool refused, double now, double retryAfter)
  {
    viewer->page.Line().SocketEnded(refused, viewer->inbox, now, retryAfter);
  }
  // The inbox holds the body of the answer; if there is no answer (status 0), the reason.
  EMSCRIPTEN_KEEPALIVE void ViewerFetched(
    WebViewer* viewer, unsigned status, double now, double retryAfter)
  {
    std::string body = std::exchange(viewer->inbox, {});
    if (status == 0)
    {
      viewer->page.Line().Fetched(
        kdstream::Error{ kdstream::ErrorCode::InputOutput, std::move(body) }, now);
    }
    else
    {
      viewer->page.Line().Fetched(kdstream::HttpReply{ status, std::move(body), retryAfter }, now);
    }
  }
  EMSCRIPTEN_KEEPALIVE void ViewerTick(WebViewer* viewer, double now)
  {
    viewer->page.Line().Tick(now);
  }
  EMSCRIPTEN_KEEPALIVE void ViewerRetryNow(WebViewer* viewer)
  {
    viewer->page.Line().RetryNow();
  }

  // ---- what the page reads

  // Call this after every input.
  EMSCRIPTEN_KEEPALIVE void ViewerExchange(WebViewer* viewer, double now)
  {
    viewer->page.Exchange(now);
    auto actions = viewer->page.Line().TakeActions();
    std::reverse(actions.begin(), actions.end());
    actions.insert(actions.end(), viewer->actions.begin(), viewer->actions.end());
    viewer->actions.swap(actions);
  }
  // Returns the next action for the connection: 0 nothing, 1 connect, 2 send the text, 3 close, 4
  // fetch the path in the text, 5 search the stored answers for the paths in the text. For a
  // search, the first line is its number ("7 again": PageSession::TakeSearch), and each further
  // line is a path.
  EMSCRIPTEN_KEEPALIVE int ViewerNextAction(WebViewer* viewer)
  {
    if (std::string search = viewer->page.TakeSearch(); !search.empty())
    {
      viewer->outbox = std::move(search);
      return 5;
    }
    if (viewer->actions.empty())
    {
      return 0;
    }
    kdstream::ServerLine::Action action = std::move(viewer->actions.back());
    viewer->actions.pop_back();
    using Kind = kdstream::ServerLine::Action::Kind;
    switch (action.kind)
    {
      case Kind::Connect:
        return 1;
      case Kind::Send:
        viewer->outbox = std::move(action.text);
        return 2;
      case Kind::Close:
        return 3;
      case Kind::Fetch:
        viewer->outbox = std::move(action.fetch.target);
        viewer->mostBytes = std::min(action.fetch.mostBytes, kdstream::mostInbox);
        return 4;
    }
    return 0;
  }
  // The maximum size of the answer to the last fetch.
  EMSCRIPTEN_KEEPALIVE std::size_t ViewerMostBytes(const WebViewer* viewer)
  {
    return viewer->mostBytes;
  }
  // Takes a stored blob of a search from the inbox.
  EMSCRIPTEN_KEEPALIVE void ViewerFound(WebViewer* viewer, std::uint32_t search, std::size_t index)
  {
    viewer->page.Found(search, index, { viewer->inbox.begin(), viewer->inbox.end() });
  }
  EMSCRIPTEN_KEEPALIVE void ViewerEndSearch(
    WebViewer* viewer, std::uint32_t search, bool isKept, double now)
  {
    viewer->page.EndSearch(search, isKept, now);
  }
  EMSCRIPTEN_KEEPALIVE void ViewerSetKeeps(WebViewer* viewer, bool keeps)
  {
    viewer->page.SetKeeps(keeps);
  }
  // Returns the bytes of the next blob that has arrived and is to be stored; the text is its path.
  // Returns null if there is none.
  EMSCRIPTEN_KEEPALIVE const std::uint8_t* ViewerArrival(WebViewer* viewer)
  {
    auto arrival = viewer->page.TakeArrival();
    viewer->outbox = arrival ? std::move(arrival->path) : "";
    viewer->arrived = arrival ? std::move(arrival->bytes) : std::vector<std::uint8_t>();
    return arrival ? viewer->arrived.data() : nullptr;
  }
  EMSCRIPTEN_KEEPALIVE std::size_t ViewerArrivalBytes(const WebViewer* viewer)
  {
    return viewer->arrived.size();
  }
  // The text is the arrays that the model can be coloured by. For the current array it also has the
  // range of the map, and the classes of a legend: {"arrays","low","high","classes"}.
  EMSCRIPTEN_KEEPALIVE void ViewerArrays(WebViewer* viewer)
  {
    const auto scalars = viewer->page.Session().Scene().scalars;
    const kdstream::Coloring coloring = ColoringOf(viewer->picture.Colors(), scalars);
    kdstream::JsonWriter json;
    json.BeginObject().Member("low", coloring.low).Member("high", coloring.high);
    json.Key("arrays").BeginArray();
    for (const kdstream::ScalarDescription& scalar : scalars)
    {
      json.Put(scalar.name);
    }
    json.EndArray().Key("classes").BeginArray();
    if (coloring.hasClasses)
    {
      const auto& classes = scalars.Find(coloring.attribute)->classes;
      for (const kdstream::ScalarDescription::Class& each : classes)
      {
        if (kdstream::IsInLegend(each, classes))
        {
          json.Put(each.value);
        }
      }
    }
    json.EndArray().EndObject();
    viewer->outbox = json.Text();
  }
  // Returns the colour, 0xrrggbb, of a value of the array that the model is coloured by.
  EMSCRIPTEN_KEEPALIVE int ViewerShade(WebViewer* viewer, double value)
  {
    const auto scalars = viewer->page.Session().Scene().scalars;
    return kdstream::HexOf(ColoringOf(viewer->picture.Colors(), scalars).Of(value));
  }
  // The text is the legend for the colours of the resolutions that are shown: [{"level","color"}],
  // the finest first. level: -1 for the original; color: 0xrrggbb.
  EMSCRIPTEN_KEEPALIVE void ViewerLegend(WebViewer* viewer)
  {
    viewer->outbox = kdstream::LegendOfDetail(viewer->page.Session().Scene());
  }
  EMSCRIPTEN_KEEPALIVE void ViewerStatus(WebViewer* viewer)
  {
    kdstream::JsonWriter json;
    json.BeginObject();
    viewer->page.Describe(json, viewer->picture.IsInFlight());
    viewer->picture.Describe(json);
    json.EndObject();
    viewer->outbox = json.Text();
  }
}
