// Recorded sessions: what a person did, as JSON lines, to be played again. Step "replay" of the
// README's picture.
#include "viewer/session/SessionFile.h"

#include "viewer/session/JsonText.h"

#include <nlohmann/json.hpp>

#include <initializer_list>
#include <optional>

namespace kdstream
{
namespace
{

using nlohmann::json;

Error Wrong(std::size_t line, const std::string& what)
{
  return { ErrorCode::InvalidInput, "line " + std::to_string(line) + ": " + what };
}

// What is wrong with the keys of `object`: it must have exactly `keys`.
std::optional<std::string> CheckKeys(const json& object, std::initializer_list<const char*> keys)
{
  if (!object.is_object())
  {
    return "not an object";
  }
  for (const char* key : keys)
  {
    if (!object.contains(key))
    {
      return std::string("'") + key + "' is missing";
    }
  }
  for (const auto& member : object.items())
  {
    bool known = false;
    for (const char* key : keys)
    {
      known = known || member.key() == key;
    }
    if (!known)
    {
      return "unknown key '" + member.key().substr(0, 64) + "'";
    }
  }
  return std::nullopt;
}

Result<Touch> ParseTouch(const json& object, std::size_t line)
{
  if (const auto wrong = CheckKeys(object, { "id", "x", "y" }))
  {
    return Wrong(line, "a touch: " + *wrong);
  }
  if (!object["id"].is_number_integer() || !object["x"].is_number() || !object["y"].is_number())
  {
    return Wrong(line, "a touch: id is an integer, x and y are numbers");
  }
  return Touch{ object["id"].get<std::int64_t>(), object["x"].get<double>(),
    object["y"].get<double>() };
}

Result<SessionStep> ParseTouches(const json& object, std::size_t line)
{
  if (const auto wrong = CheckKeys(object, { "t", "touches" }))
  {
    return Wrong(line, *wrong);
  }
  if (!object["t"].is_number() || !object["touches"].is_array())
  {
    return Wrong(line, "'t' is a number of seconds, 'touches' a list");
  }
  SessionStep step{ SessionStep::Kind::Touches, { object["t"].get<double>(), {} }, {} };
  for (const json& entry : object["touches"])
  {
    const auto touch = ParseTouch(entry, line);
    if (!touch)
    {
      return touch.GetError();
    }
    step.frame.touches.push_back(*touch);
  }
  return step;
}

Result<SessionStep> ParseNamed(
  const json& object, std::size_t line, const char* key, SessionStep::Kind kind)
{
  if (const auto wrong = CheckKeys(object, { key }))
  {
    return Wrong(line, *wrong);
  }
  if (!object[key].is_string() || object[key].get<std::string>().empty())
  {
    return Wrong(line, std::string("'") + key + "' is a text that is not empty");
  }
  return SessionStep{ kind, {}, object[key].get<std::string>() };
}

Result<SessionStep> ParseStep(std::string_view text, std::size_t line)
{
  const json object = json::parse(text, nullptr, false);
  if (!object.is_object())
  {
    return Wrong(line, "not a JSON object");
  }
  if (object.contains("touches"))
  {
    return ParseTouches(object, line);
  }
  if (object.contains("screenshot"))
  {
    return ParseNamed(object, line, "screenshot", SessionStep::Kind::Screenshot);
  }
  if (object.contains("select"))
  {
    return ParseNamed(object, line, "select", SessionStep::Kind::Select);
  }
  if (object.contains("wait"))
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
  return Wrong(line, "none of 'touches', 'wait', 'screenshot', 'select'");
}

}

Result<std::vector<SessionStep>> ParseSession(std::string_view text)
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
    if (!step)
    {
      return step.GetError();
    }
    steps.push_back(std::move(*step));
  }
  return steps;
}

std::string FormatSessionStep(const SessionStep& step)
{
  switch (step.kind)
  {
    case SessionStep::Kind::Touches:
    {
      const auto touch = [](const Touch& t)
      { return JsonObject().Add("id", t.id).Add("x", t.x).Add("y", t.y).Text(); };
      return JsonObject()
        .Add("t", step.frame.time)
        .AddRaw("touches", JsonArray(step.frame.touches, touch))
        .Text();
    }
    case SessionStep::Kind::Screenshot:
      return JsonObject().Add("screenshot", step.name).Text();
    case SessionStep::Kind::Select:
      return JsonObject().Add("select", step.name).Text();
    case SessionStep::Kind::WaitForIdle:
      break;
  }
  return JsonObject().Add("wait", "idle").Text();
}

}
