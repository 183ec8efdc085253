// SPDX-License-Identifier: BSD-3-Clause
// Recorded sessions: what a person did, as JSON lines, to be played again. Step "replay" of the
// README's picture.
#include "viewer/session/SessionFile.h"

#include "filters/model/Json.h"
#include "filters/model/JsonWriter.h"

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

// What is wrong with the keys of `object`: it must have exactly `keys`.
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
  for (const auto& member : object.GetObject())
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
    return Wrong(line, "a touch: id is an integer, x and y are numbers");
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
    return Wrong(line, "'t' is a number of seconds, 'touches' a list");
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
  if (!text.IsString() || text.GetStringLength() == 0)
  {
    return Wrong(line, std::string("'") + key + "' is a text that is not empty");
  }
  return SessionStep{ kind, {}, std::string(TextOf(text)) };
}

Result<SessionStep> ParseStep(std::string_view text, std::size_t line)
{
  const auto parsed = ParseJson(text);
  if (!parsed || !parsed->IsObject())
  {
    return Wrong(line, "not a JSON object");
  }
  const JsonValue& object = *parsed;
  if (FindMember(object, "touches"))
  {
    return ParseTouches(object, line);
  }
  if (FindMember(object, "screenshot"))
  {
    return ParseNamed(object, line, "screenshot", SessionStep::Kind::Screenshot);
  }
  if (FindMember(object, "select"))
  {
    return ParseNamed(object, line, "select", SessionStep::Kind::Select);
  }
  if (FindMember(object, "turning"))
  {
    auto step = ParseNamed(object, line, "turning", SessionStep::Kind::Turning);
    if (step && step->name != "upright" && step->name != "free")
    {
      return Wrong(line, "one can turn 'upright' or 'free' only");
    }
    return step;
  }
  if (FindMember(object, "wait"))
  {
    auto step = ParseNamed(object, line, "wait", SessionStep::Kind::WaitForIdle);
    if (step && step->name != "idle")
    {
      return Wrong(line, "one can wait for 'idle' only");
    }
    if (step)
    {
      step->name.clear();
    }
    return step;
  }
  return Wrong(line, "none of 'touches', 'wait', 'screenshot', 'select', 'turning'");
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
    case SessionStep::Kind::Turning:
      json.Member("turning", step.name);
      break;
    case SessionStep::Kind::WaitForIdle:
      json.Member("wait", "idle");
      break;
  }
  json.EndObject();
  return json.Text();
}

}
