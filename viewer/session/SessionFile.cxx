// SPDX-License-Identifier: BSD-3-Clause
// Recorded sessions: what the user did, as JSON lines that can be played. Step "replay" of the
// pipeline picture.
#include "viewer/session/SessionFile.h"

#include "filters/model/Json.h"
#include "filters/model/JsonWriter.h"
#include "viewer/session/ViewerSession.h"
#include "viewer/session/appearance/Coloring.h"

#include <algorithm>
#include <initializer_list>
#include <optional>

namespace kdstream
{
namespace
{

Error Wrong(std::size_t line, const std::string& what)
{
  return { ErrorCode::InvalidInput, "line " + std::to_string(line) + ": " + what };
}

// Checks that `object` has exactly `keys`; returns what is wrong.
std::optional<std::string> CheckKeys(
  const JsonValue& object, std::initializer_list<const char*> keys)
{
  if (!object.IsObject())
  {
    return "not an object";
  }
  for (const char* key : keys)
  {
    if (!FindMember(object, key))
    {
      return std::string("'") + key + "' is missing";
    }
  }
  for (const JsonMember& member : object.GetObject())
  {
    const std::string_view name = TextOf(member.name);
    if (std::find(keys.begin(), keys.end(), name) == keys.end())
    {
      return "unknown key '" + std::string(name.substr(0, 64)) + "'";
    }
  }
  return std::nullopt;
}

Result<Touch> ParseTouch(const JsonValue& object, std::size_t line)
{
  if (const auto wrong = CheckKeys(object, { "id", "x", "y" }))
  {
    return Wrong(line, "a touch: " + *wrong);
  }
  const JsonValue &id = *FindMember(object, "id"), &x = *FindMember(object, "x"),
                  &y = *FindMember(object, "y");
  if (!id.IsInt64() || !x.IsNumber() || !y.IsNumber())
  {
    return Wrong(line, "a touch: id must be an integer, x and y must be numbers");
  }
  return Touch{ id.GetInt64(), x.GetDouble(), y.GetDouble() };
}

Result<SessionStep> ParseTouches(const JsonValue& object, std::size_t line)
{
  if (const auto wrong = CheckKeys(object, { "t", "touches" }))
  {
    return Wrong(line, *wrong);
  }
  const JsonValue &time = *FindMember(object, "t"), &touches = *FindMember(object, "touches");
  if (!time.IsNumber() || !touches.IsArray())
  {
    return Wrong(line, "'t' must be a number of seconds, 'touches' a list");
  }
  SessionStep step{ SessionStep::Kind::Touches, { time.GetDouble(), {} }, {} };
  for (const JsonValue& entry : touches.GetArray())
  {
    const auto touch = ParseTouch(entry, line);
    KDSTREAM_TRY(touch);
    step.frame.touches.push_back(*touch);
  }
  return step;
}

Result<SessionStep> ParseNamed(
  const JsonValue& object, std::size_t line, const char* key, SessionStep::Kind kind)
{
  if (const auto wrong = CheckKeys(object, { key }))
  {
    return Wrong(line, *wrong);
  }
  const JsonValue& text = *FindMember(object, key);
  if (!text.IsString() || text.GetString().empty())
  {
    return Wrong(line, std::string("'") + key + "' must be a text that is not empty");
  }
  return SessionStep{ kind, {}, std::string(TextOf(text)) };
}

// Parses a step whose text is one of `words`.
Result<SessionStep> ParseWord(const JsonValue& object, std::size_t line, const char* key,
  SessionStep::Kind kind, std::initializer_list<std::string_view> words)
{
  auto step = ParseNamed(object, line, key, kind);
  if (step && std::find(words.begin(), words.end(), step->name) == words.end())
  {
    std::string known;
    for (const std::string_view word : words)
    {
      known += (known.empty() ? "'" : ", '") + std::string(word) + "'";
    }
    return Wrong(line, "'" + std::string(key) + "' must be one of " + known);
  }
  return step;
}

Result<SessionStep> ParseZoom(const JsonValue& object, std::size_t line)
{
  if (const auto wrong = CheckKeys(object, { "zoom", "x", "y" }))
  {
    return Wrong(line, *wrong);
  }
  const JsonValue &factor = *FindMember(object, "zoom"), &x = *FindMember(object, "x"),
                  &y = *FindMember(object, "y");
  if (!factor.IsNumber() || !(factor.GetDouble() > 0) || !x.IsNumber() || !y.IsNumber())
  {
    return Wrong(line, "'zoom' must be a number above 0, 'x' and 'y' must be numbers");
  }
  SessionStep step{ SessionStep::Kind::Zoom, {} };
  step.factor = factor.GetDouble();
  step.x = x.GetDouble();
  step.y = y.GetDouble();
  return step;
}

Result<SessionStep> ParseRings(const JsonValue& object, std::size_t line)
{
  if (const auto wrong = CheckKeys(object, { "rings" }))
  {
    return Wrong(line, *wrong);
  }
  const JsonValue& rings = *FindMember(object, "rings");
  if (!rings.IsUint() || rings.GetUint() < 1 || rings.GetUint() > 3)
  {
    return Wrong(line, "'rings' must be 1, 2 or 3");
  }
  SessionStep step{ SessionStep::Kind::Rings, {} };
  step.rings = rings.GetUint();
  return step;
}

Result<SessionStep> ParseBudgets(const JsonValue& object, std::size_t line)
{
  if (const auto wrong = CheckKeys(object, { "triangles", "memory" }))
  {
    return Wrong(line, *wrong);
  }
  const JsonValue &triangles = *FindMember(object, "triangles"),
                  &memory = *FindMember(object, "memory");
  const auto isCount = [](const JsonValue& value)
  { return value.IsUint64() && value.GetUint64() > 0; };
  if (!isCount(triangles) || !isCount(memory))
  {
    return Wrong(line, "'triangles' and 'memory' (bytes) must be integers above 0");
  }
  SessionStep step{ SessionStep::Kind::Budgets, {} };
  step.triangles = triangles.GetUint64();
  step.memory = memory.GetUint64();
  return step;
}

Result<SessionStep> ParseWindow(const JsonValue& object, std::size_t line)
{
  if (const auto wrong = CheckKeys(object, { "window", "ratio" }))
  {
    return Wrong(line, *wrong);
  }
  const JsonValue &sides = *FindMember(object, "window"), &ratio = *FindMember(object, "ratio");
  const auto isSide = [](const JsonValue& side)
  { return side.IsInt() && side.GetInt() >= 1 && side.GetInt() <= SessionStep::largestSide; };
  if (!sides.IsArray() || sides.Size() != 2 || !isSide(sides[0]) || !isSide(sides[1]))
  {
    return Wrong(line, "'window' must be a list of width and height, each 1 to " +
                         std::to_string(SessionStep::largestSide) + " pixels");
  }
  if (!ratio.IsNumber() || !(ratio.GetDouble() >= 0.125 && ratio.GetDouble() <= 8))
  {
    return Wrong(line, "'ratio' must be the number of pixels per point, 0.125 to 8");
  }
  SessionStep step{ SessionStep::Kind::Window, {} };
  step.window = { sides[0].GetInt(), sides[1].GetInt(), ratio.GetDouble() };
  return step;
}

Result<SessionStep> ParseWait(const JsonValue& object, std::size_t line)
{
  auto step = ParseWord(object, line, "wait", SessionStep::Kind::WaitForIdle, { "idle" });
  if (step)
  {
    step->name.clear();
  }
  return step;
}

Result<SessionStep> ParseColorsStep(const JsonValue& object, std::size_t line)
{
  auto step = ParseNamed(object, line, "colours", SessionStep::Kind::Colors);
  if (step && !ParseColors(step->name))
  {
    return Wrong(line, "'colours' must be 'own', 'none', 'partition', 'resolution' or "
                       "'by:NAME:MAP:LOW:HIGH', where LOW:HIGH or MAP:LOW:HIGH may be left out");
  }
  return step;
}

Result<SessionStep> ParseLink(const JsonValue& object, std::size_t line)
{
  auto step = ParseNamed(object, line, "link", SessionStep::Kind::Link);
  KDSTREAM_TRY(step);
  if (const auto link = ParseViewLink(step->name); !link)
  {
    return Wrong(line, link.GetError().message);
  }
  return step;
}

Result<SessionStep> ParseDepth(const JsonValue& object, std::size_t line)
{
  if (const auto wrong = CheckKeys(object, { "depth" }))
  {
    return Wrong(line, *wrong);
  }
  const JsonValue& depth = *FindMember(object, "depth");
  if (!depth.IsNumber() || !(depth.GetDouble() >= 0 && depth.GetDouble() <= 1))
  {
    return Wrong(line, "'depth' must be a number from 0 to 1");
  }
  SessionStep step{ SessionStep::Kind::Depth, {} };
  step.factor = depth.GetDouble();
  return step;
}

Result<SessionStep> ParseLightsStep(const JsonValue& object, std::size_t line)
{
  auto step = ParseNamed(object, line, "lamps", SessionStep::Kind::Lights);
  KDSTREAM_TRY(step);
  if (const auto lights = ParseLights(step->name); !lights)
  {
    return Wrong(line, "'lamps': " + lights.GetError().message);
  }
  return step;
}

Result<SessionStep> ParseStep(std::string_view text, std::size_t line)
{
  const auto parsed = ParseJson(text);
  if (!parsed || !parsed->IsObject())
  {
    return Wrong(line, "not a JSON object");
  }
  using Kind = SessionStep::Kind;
  const JsonValue& object = *parsed;
  const auto has = [&object](const char* key) { return FindMember(object, key) != nullptr; };
  return has("touches")      ? ParseTouches(object, line)
         : has("zoom")       ? ParseZoom(object, line)
         : has("wait")       ? ParseWait(object, line)
         : has("rings")      ? ParseRings(object, line)
         : has("window")     ? ParseWindow(object, line)
         : has("triangles")  ? ParseBudgets(object, line)
         : has("select")     ? ParseNamed(object, line, "select", Kind::Select)
         : has("screenshot") ? ParseNamed(object, line, "screenshot", Kind::Screenshot)
         : has("go")         ? ParseWord(object, line, "go", Kind::Go, { "home", "undo", "back" })
         : has("side")       ? ParseWord(object, line, "side", Kind::Side,
                                 { "front", "back", "left", "right", "top", "bottom" })
         : has("tool")       ? ParseWord(object, line, "tool", Kind::Tool,
                                 { "none", "measure", "section", "light", "second light" })
         : has("section")    ? ParseWord(object, line, "section", Kind::Section,
                                 { "front", "side", "above", "x", "y", "z", "view", "flip", "off" })
         : has("depth")      ? ParseDepth(object, line)
         : has("lamps")      ? ParseLightsStep(object, line)
         : has("link")       ? ParseLink(object, line)
         : has("turning") ? ParseWord(object, line, "turning", Kind::Turning, { "upright", "free" })
         : has("detail")
           ? ParseWord(object, line, "detail", Kind::Detail, { "view", "level", "full" })
         : has("colours") ? ParseColorsStep(object, line)
         : has("light")   ? ParseWord(object, line, "light", Kind::Light, { "relief", "plain" })
         : has("boxes")   ? ParseWord(object, line, "boxes", Kind::Boxes, { "on", "off" })
                          : Wrong(line, "unknown step: it must have one of 'touches', 'zoom', "
                                          "'wait', 'screenshot', 'select', "
                                          "'go', 'side', 'link', 'tool', 'section', 'depth', 'lamps', "
                                          "'turning', 'detail', 'rings', 'triangles', "
                                          "'colours', 'light', 'boxes', 'window'");
}

}

Result<std::vector<SessionStep>> ParseSession(
  std::string_view text, const std::function<Status(const SessionStep&)>& check)
{
  std::vector<SessionStep> steps;
  std::size_t line = 0;
  while (!text.empty())
  {
    ++line;
    const std::size_t end = text.find('\n');
    const std::string_view content = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (content.find_first_not_of(" \t\r") == std::string_view::npos)
    {
      continue;
    }
    auto step = ParseStep(content, line);
    KDSTREAM_TRY(step);
    if (const Status checked = check ? check(*step) : Status{}; !checked)
    {
      return Wrong(line, checked.GetError().message);
    }
    steps.push_back(std::move(*step));
  }
  return steps;
}

bool NeedsModel(const SessionStep& step)
{
  using Kind = SessionStep::Kind;
  return step.kind == Kind::Touches || step.kind == Kind::Zoom || step.kind == Kind::Go ||
         step.kind == Kind::Side || step.kind == Kind::Section || step.kind == Kind::Depth;
}

Status Perform(const SessionStep& step, ViewerSession& session)
{
  switch (step.kind)
  {
    case SessionStep::Kind::Select:
      return session.SelectModel(step.name);
    case SessionStep::Kind::Touches:
      session.HandleTouches(step.frame);
      break;
    case SessionStep::Kind::Zoom:
      session.Zoom(step.factor, step.x, step.y);
      break;
    case SessionStep::Kind::Go:
      step.name == "home"   ? session.GoHome()
      : step.name == "undo" ? session.UndoView()
                            : session.LeaveFullScreen();
      break;
    case SessionStep::Kind::Side:
      session.LookFromSide(step.name);
      break;
    case SessionStep::Kind::Tool:
      session.SetTool(step.name == "measure"        ? Tool::Measure
                      : step.name == "section"      ? Tool::Section
                      : step.name == "light"        ? Tool::Light
                      : step.name == "second light" ? Tool::SecondLight
                                                    : Tool::None);
      break;
    case SessionStep::Kind::Section:
      session.SetSectionAlong(step.name);
      break;
    case SessionStep::Kind::Depth:
      session.SetSectionDepth(step.factor);
      break;
    case SessionStep::Kind::Lights:
    {
      const auto lights = ParseLights(step.name);
      KDSTREAM_TRY(lights);
      session.SetLight(*lights);
      break;
    }
    case SessionStep::Kind::Link:
    {
      const auto link = ParseViewLink(step.name);
      KDSTREAM_TRY(link);
      return session.Follow(*link);
    }
    case SessionStep::Kind::Turning:
      session.SetTurning(step.name == "free" ? Turning::Free : Turning::Upright);
      break;
    case SessionStep::Kind::Detail:
      session.SetDetail(step.name == "level"  ? DetailMode::Level
                        : step.name == "full" ? DetailMode::Full
                                              : DetailMode::View);
      break;
    case SessionStep::Kind::Rings:
      session.SetRings(step.rings);
      break;
    case SessionStep::Kind::Budgets:
      session.SetBudgets(step.triangles, static_cast<std::size_t>(step.memory));
      break;
    case SessionStep::Kind::Window:
      session.Resize(step.window);
      break;
    case SessionStep::Kind::WaitForIdle:
    case SessionStep::Kind::Screenshot:
    case SessionStep::Kind::Colors:
    case SessionStep::Kind::Light:
    case SessionStep::Kind::Boxes:
      break;
  }
  return {};
}

std::string FormatSessionStep(const SessionStep& step)
{
  JsonWriter json;
  json.BeginObject();
  switch (step.kind)
  {
    case SessionStep::Kind::Touches:
      json.Member("t", step.frame.time).Key("touches").BeginArray();
      for (const Touch& touch : step.frame.touches)
      {
        json.BeginObject()
          .Member("id", touch.id)
          .Member("x", touch.x)
          .Member("y", touch.y)
          .EndObject();
      }
      json.EndArray();
      break;
    case SessionStep::Kind::Screenshot:
      json.Member("screenshot", step.name);
      break;
    case SessionStep::Kind::Select:
      json.Member("select", step.name);
      break;
    case SessionStep::Kind::Zoom:
      json.Member("zoom", step.factor).Member("x", step.x).Member("y", step.y);
      break;
    case SessionStep::Kind::Go:
      json.Member("go", step.name);
      break;
    case SessionStep::Kind::Side:
      json.Member("side", step.name);
      break;
    case SessionStep::Kind::Tool:
      json.Member("tool", step.name);
      break;
    case SessionStep::Kind::Section:
      json.Member("section", step.name);
      break;
    case SessionStep::Kind::Depth:
      json.Member("depth", step.factor);
      break;
    case SessionStep::Kind::Lights:
      json.Member("lamps", step.name);
      break;
    case SessionStep::Kind::Link:
      json.Member("link", step.name);
      break;
    case SessionStep::Kind::Turning:
      json.Member("turning", step.name);
      break;
    case SessionStep::Kind::Detail:
      json.Member("detail", step.name);
      break;
    case SessionStep::Kind::Rings:
      json.Member("rings", step.rings);
      break;
    case SessionStep::Kind::Budgets:
      json.Member("triangles", step.triangles).Member("memory", step.memory);
      break;
    case SessionStep::Kind::Colors:
      json.Member("colours", step.name);
      break;
    case SessionStep::Kind::Light:
      json.Member("light", step.name);
      break;
    case SessionStep::Kind::Boxes:
      json.Member("boxes", step.name);
      break;
    case SessionStep::Kind::Window:
      json.Key("window").BeginArray().Put(step.window.width).Put(step.window.height).EndArray();
      json.Member("ratio", step.window.pixelRatio);
      break;
    case SessionStep::Kind::WaitForIdle:
      json.Member("wait", "idle");
      break;
  }
  json.EndObject();
  return json.Text();
}

}
