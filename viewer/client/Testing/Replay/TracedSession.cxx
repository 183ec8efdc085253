// SPDX-License-Identifier: BSD-3-Clause
// A session that writes down all it does: see TracedSession.h.
#include "viewer/client/Testing/Replay/TracedSession.h"

#include "filters/core/BitCast.h"
#include "filters/model/ModelJson.h"
#include "viewer/session/appearance/SceneRules.h"
#include "viewer/session/appearance/SplatRadii.h"

#include <initializer_list>
#include <utility>

namespace kdstream::testing
{
namespace
{

// FNV-1a over 64-bit words, with mixing, so that high bits count, too.
class Digest
{
public:
  void Add(std::uint64_t word)
  {
    this->Value = (this->Value ^ word) * 1099511628211u;
    this->Value ^= this->Value >> 29;
  }
  void Add(double value) { this->Add(BitCast<std::uint64_t>(value)); }
  void Add(float value) { this->Add(std::uint64_t{ BitCast<std::uint32_t>(value) }); }
  std::uint64_t Sum() const { return this->Value; }

private:
  std::uint64_t Value = 14695981039346656037u;
};

template <class Range>
std::uint64_t DigestOfNumbers(const Range& range)
{
  Digest digest;
  for (const auto& entry : range)
  {
    for (const auto number : entry)
    {
      digest.Add(number);
    }
  }
  return digest.Sum();
}

std::uint64_t DigestOfSources(const std::vector<Surface::Source>& sources)
{
  Digest digest;
  for (const Surface::Source& source : sources)
  {
    digest.Add(std::uint64_t{ source.resolution.IsOriginal() ? 255u : source.resolution.Depth() });
    digest.Add(std::uint64_t{ source.key });
  }
  return digest.Sum();
}

// The digest of all arrays and their names.
std::uint64_t DigestOfAttributes(const std::vector<Attribute>& attributes)
{
  Digest digest;
  for (const Attribute& array : attributes)
  {
    for (const char letter : array.name)
    {
      digest.Add(std::uint64_t{ static_cast<unsigned char>(letter) });
    }
    for (const std::uint8_t byte : array.values)
    {
      digest.Add(std::uint64_t{ byte });
    }
  }
  return digest.Sum();
}

std::uint64_t DigestOfNumbers(const std::vector<float>& numbers)
{
  Digest digest;
  for (const float number : numbers)
  {
    digest.Add(number);
  }
  return digest.Sum();
}

// The digest of the normals that renderers use for lighting.
std::uint64_t DigestOfNormals(const DrawnSurface& surface)
{
  Digest digest;
  for (const DrawnSurface::Part& part : surface.Parts())
  {
    for (const Vec3& normal : *part.normals)
    {
      for (const double component : normal)
      {
        digest.Add(component);
      }
    }
  }
  return digest.Sum();
}

void PutSurface(JsonWriter& json, const Surface& surface)
{
  Digest triangles;
  for (const Triangle& triangle : surface.triangles)
  {
    for (const auto corner : triangle)
    {
      triangles.Add(std::uint64_t{ corner });
    }
  }
  json.BeginObject()
    .Member("points", surface.points.size())
    .Member("triangles", surface.triangles.size())
    .Member("points_digest", DigestOfNumbers(surface.points))
    .Member("sources_digest", DigestOfSources(surface.sources))
    .Member("triangles_digest", triangles.Sum())
    .Member("normals_digest", DigestOfNumbers(NormalsOf(surface)))
    .Member("attributes", surface.attributes.size())
    .Member("attributes_digest", DigestOfAttributes(surface.attributes))
    .Member("radii_digest",
      DigestOfNumbers(surface.triangles.empty() ? SplatRadii(surface) : std::vector<float>()))
    .EndObject();
}

// {"key":"text","key":"text"…}
std::string TextsJson(std::initializer_list<std::pair<const char*, std::string_view>> members)
{
  JsonWriter json;
  json.BeginObject();
  for (const auto& [key, text] : members)
  {
    json.Member(key, text);
  }
  json.EndObject();
  return json.Text();
}

SessionOptions TracedOptions(const std::function<void(std::string_view)>& trace)
{
  SessionOptions options;
  options.TraceTo(trace);
  return options;
}

ServerLineOptions LineOptions()
{
  ServerLineOptions options;
  options.authority = "recorded:1";
  options.patient = true;
  options.idleTimeout = 20;
  return options;
}

TouchFrame TouchesOf(const RecordedInput& input)
{
  TouchFrame frame{ input.time, {} };
  for (std::size_t i = 0; i < input.numbers.size(); i += 3)
  {
    frame.touches.push_back(
      { static_cast<std::int64_t>(input.numbers[i]), input.numbers[i + 1], input.numbers[i + 2] });
  }
  return frame;
}

}

TracedSession::TracedSession(std::function<void(std::string_view)> trace)
  : Trace(std::move(trace))
  , Viewer(TracedOptions(this->Trace))
  , Server(LineOptions())
{
}

std::vector<ServerLine::Action> TracedSession::Apply(const RecordedInput& input)
{
  JsonWriter line;
  line.BeginObject().Member("t", input.time).Member("recorded", NameOf(input.kind)).EndObject();
  this->Trace(line.Text());
  this->Dispatch(input);
  for (bool busy = true; busy;)
  {
    busy = false;
    for (const ClientEvent& event : this->Server.TakeEvents())
    {
      Deliver(event, this->Viewer);
      busy = true;
    }
    for (const SessionRequest& request : this->Viewer.TakeRequests())
    {
      this->Server.Send(request, input.time);
      busy = true;
    }
  }
  std::vector<ServerLine::Action> actions = this->Server.TakeActions();
  for (const ServerLine::Action& action : actions)
  {
    this->TraceAction(action);
  }
  return actions;
}

void TracedSession::Dispatch(const RecordedInput& input)
{
  using Kind = RecordedInput::Kind;
  const std::vector<double>& numbers = input.numbers;
  switch (input.kind)
  {
    case Kind::Resize:
      return this->Viewer.Resize(
        { static_cast<int>(numbers[0]), static_cast<int>(numbers[1]), numbers[2] });
    case Kind::Touches:
      return this->Viewer.HandleTouches(TouchesOf(input));
    case Kind::CancelTouches:
      return this->Viewer.CancelTouches();
    case Kind::Wheel:
      return this->Viewer.Zoom(numbers[0], numbers[1], numbers[2]);
    case Kind::Rings:
      return this->Viewer.SetRings(static_cast<unsigned>(numbers[0]));
    case Kind::Detail:
      return this->Viewer.SetDetail(numbers[0] == 0   ? DetailMode::View
                                    : numbers[0] == 1 ? DetailMode::Level
                                                      : DetailMode::Full);
    case Kind::Budgets:
      return this->Viewer.SetBudgets(
        static_cast<std::uint64_t>(numbers[0]), static_cast<std::size_t>(numbers[1]));
    case Kind::Turning:
      return this->Viewer.SetTurning(numbers[0] == 0 ? Turning::Upright : Turning::Free);
    case Kind::Coast:
      return this->Viewer.SetCoasting(numbers[0] != 0);
    case Kind::Home:
      return this->Viewer.GoHome();
    case Kind::Undo:
      return this->Viewer.UndoView();
    case Kind::Select:
      if (const Status status = this->Viewer.SelectModel(input.payload); !status)
      {
        this->Trace(TextsJson({ { "not_selected", status.GetError().message } }));
      }
      return;
    case Kind::Back:
      return this->Viewer.LeaveFullScreen();
    case Kind::Models:
      if (auto models = ParseModelList(input.payload))
      {
        this->Viewer.SetModels(std::move(*models));
      }
      return;
    case Kind::Opened:
      return this->Server.SocketOpened(input.time);
    case Kind::Text:
      return this->Server.SocketText(input.payload, input.time);
    case Kind::Frame:
      return this->Server.SocketFrame(
        { reinterpret_cast<const std::uint8_t*>(input.payload.data()), input.payload.size() },
        input.time);
    case Kind::Ended:
      return this->Server.SocketEnded(numbers[0] != 0, input.payload, input.time);
    case Kind::Fetched:
      return this->Server.Fetched(
        HttpReply{ static_cast<unsigned>(numbers[0]), input.payload }, input.time);
    case Kind::NotFetched:
      return this->Server.Fetched(Error{ ErrorCode::InputOutput, input.payload }, input.time);
    case Kind::Tick:
      return this->Server.Tick(input.time);
    case Kind::RetryNow:
      return this->Server.RetryNow();
    case Kind::Draw:
      this->Viewer.Advance(input.time);
      return this->Draw();
  }
}

void TracedSession::Draw()
{
  this->Viewer.BeginFrame();
  const ViewerScene scene = this->Viewer.Scene();
  JsonWriter line;
  line.BeginObject().Member("surface", scene.surfaceVersion);
  Digest view;
  for (const Vec3& vector : { scene.eye, scene.focal, scene.up, scene.box.lo, scene.box.hi })
  {
    for (const double coordinate : vector)
    {
      view.Add(coordinate);
    }
  }
  line.Member("view_digest", view.Sum());
  if (std::exchange(this->DrawnVersion, scene.surfaceVersion) != scene.surfaceVersion)
  {
    line.Key("drawn");
    PutSurface(line, scene.surface->Whole());
    line.Member("normals_of_parts", DigestOfNormals(*scene.surface));
  }
  line.EndObject();
  this->Trace(line.Text());
  this->Viewer.EndFrame(0.01);
}

void TracedSession::TraceAction(const ServerLine::Action& action)
{
  using Kind = ServerLine::Action::Kind;
  switch (action.kind)
  {
    case Kind::Connect:
      return this->Trace(R"({"action":"connect"})");
    case Kind::Send:
      return this->Trace(TextsJson({ { "action", "send" }, { "text", action.text } }));
    case Kind::Close:
      return this->Trace(R"({"action":"close"})");
    case Kind::Fetch:
      return this->Trace(TextsJson({ { "action", "fetch" }, { "target", action.fetch.target } }));
  }
}

void TracedSession::Finish()
{
  this->Trace(StatisticsJson(this->Viewer.Statistics()));
}

}
