// SPDX-License-Identifier: BSD-3-Clause
// Recordings: see Recording.h.
#include "viewer/client/Testing/Replay/Recording.h"

#include "filters/model/Json.h"
#include "filters/model/JsonWriter.h"

#include <array>
#include <utility>

namespace kdstream::testing
{
namespace
{

using InputKind = RecordedInput::Kind;

struct KindFacts
{
  InputKind kind;
  const char* name;
  std::size_t numbers; // for touches, a multiple of this
};

constexpr std::array<KindFacts, 23> kinds{ { { InputKind::Resize, "resize", 3 },
  { InputKind::Touches, "touches", 3 }, { InputKind::CancelTouches, "cancel", 0 },
  { InputKind::Wheel, "wheel", 3 }, { InputKind::Rings, "rings", 1 },
  { InputKind::Detail, "detail", 1 }, { InputKind::Budgets, "budgets", 2 },
  { InputKind::Turning, "turning", 1 }, { InputKind::Coast, "glide", 1 },
  { InputKind::Home, "home", 0 }, { InputKind::Undo, "undo", 0 },
  { InputKind::Select, "select", 0 }, { InputKind::Back, "back", 0 },
  { InputKind::Models, "models", 0 }, { InputKind::Opened, "opened", 0 },
  { InputKind::Text, "text", 0 }, { InputKind::Frame, "frame", 0 },
  { InputKind::Ended, "ended", 1 }, { InputKind::Fetched, "fetched", 1 },
  { InputKind::NotFetched, "not fetched", 0 }, { InputKind::Tick, "tick", 0 },
  { InputKind::RetryNow, "hurry", 0 }, { InputKind::Draw, "draw", 0 } } };

Error Wrong(const std::string& what)
{
  return { ErrorCode::InvalidInput, "recording: " + what };
}

// Parses the line before a payload. Returns the input, and the size of the payload.
Result<std::pair<RecordedInput, std::size_t>> ParseLine(std::string_view line)
{
  const auto json = ParseJson(line);
  if (!json || !json->IsObject())
  {
    return Wrong("no JSON object: " + std::string(line.substr(0, 100)));
  }
  const JsonValue *time = FindMember(*json, "t"), *name = FindMember(*json, "input"),
                  *numbers = FindMember(*json, "numbers"), *bytes = FindMember(*json, "bytes");
  if (!time || !time->IsNumber() || !name || !name->IsString() || !numbers || !numbers->IsArray() ||
      !bytes || !bytes->IsUint())
  {
    return Wrong("a member is missing or of another type: " + std::string(line.substr(0, 100)));
  }
  RecordedInput input;
  input.time = time->GetDouble();
  for (const JsonValue& number : numbers->GetArray())
  {
    if (!number.IsNumber())
    {
      return Wrong("no number among the numbers");
    }
    input.numbers.push_back(number.GetDouble());
  }
  for (const KindFacts& facts : kinds)
  {
    if (TextOf(*name) == facts.name)
    {
      input.kind = facts.kind;
      const std::size_t count = input.numbers.size();
      if (facts.kind == InputKind::Touches ? count % facts.numbers != 0 : count != facts.numbers)
      {
        return Wrong(std::string(facts.name) + " has " + std::to_string(count) + " numbers");
      }
      return std::pair(std::move(input), std::size_t{ bytes->GetUint() });
    }
  }
  return Wrong("no input is called " + std::string(TextOf(*name)));
}

}

const char* NameOf(InputKind kind)
{
  for (const KindFacts& facts : kinds)
  {
    if (facts.kind == kind)
    {
      return facts.name;
    }
  }
  return "?";
}

std::string FormatInput(const RecordedInput& input)
{
  JsonWriter json;
  json.BeginObject()
    .Member("t", input.time)
    .Member("input", NameOf(input.kind))
    .Member("numbers", input.numbers)
    .Member("bytes", input.payload.size())
    .EndObject();
  return json.Text() + "\n" + (input.payload.empty() ? "" : input.payload + "\n");
}

Result<RecordedInput> TakeInput(std::string_view& text)
{
  const std::size_t end = text.find('\n');
  if (end == std::string_view::npos)
  {
    return Wrong("a line without an end");
  }
  auto line = ParseLine(text.substr(0, end));
  KDSTREAM_TRY(line);
  text.remove_prefix(end + 1);
  auto& [input, bytes] = *line;
  if (bytes > 0)
  {
    if (bytes >= text.size() || text[bytes] != '\n')
    {
      return Wrong("a payload of " + std::to_string(bytes) + " bytes is not whole");
    }
    input.payload = text.substr(0, bytes);
    text.remove_prefix(bytes + 1);
  }
  return std::move(input);
}

}
