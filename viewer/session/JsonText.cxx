// JSON lines with the same bytes on every platform: numbers as RapidJSON writes them (emscripten's
// C++ library has no std::to_chars for doubles), keys in the order they are added.
#include "viewer/session/JsonText.h"

#include "server/protocol/Json.h"

namespace kdstream
{

std::string JsonNumber(double value)
{
  protocol::JsonWriter writer;
  writer.Put(value);
  return writer.Text();
}

std::string JsonString(std::string_view text)
{
  static constexpr char digits[] = "0123456789abcdef";
  std::string quoted = "\"";
  for (const char c : text)
  {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
    {
      quoted += '\\';
      quoted += c;
    }
    else if (code < 0x20)
    {
      quoted += "\\u00";
      quoted += digits[code >> 4];
      quoted += digits[code & 15];
    }
    else
    {
      quoted += c;
    }
  }
  return quoted + "\"";
}

JsonObject& JsonObject::AddRaw(std::string_view key, std::string_view json)
{
  this->Members += this->Members.size() > 1 ? "," : "";
  this->Members += JsonString(key);
  this->Members += ':';
  this->Members += json;
  return *this;
}

}
