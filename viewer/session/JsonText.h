// JSON lines with the same bytes on every platform, keys in the order they are added.
#pragma once

#include <charconv>
#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace kdstream
{

// A short decimal text that reads back as the same double; null where it is not finite.
std::string JsonNumber(double value);
template <std::integral T>
std::string JsonNumber(T value)
{
  char text[24];
  return { text, std::to_chars(text, text + sizeof(text), value).ptr };
}
// null where there is none.
template <class T>
std::string JsonNumber(const std::optional<T>& value)
{
  return value ? JsonNumber(*value) : "null";
}
// In quotes, escaped.
std::string JsonString(std::string_view text);

// Builds one object or array.
class JsonObject
{
public:
  JsonObject& AddRaw(std::string_view key, std::string_view json);
  JsonObject& Add(std::string_view key, std::string_view text)
  {
    return this->AddRaw(key, JsonString(text));
  }
  JsonObject& Add(std::string_view key, const char* text)
  {
    return this->AddRaw(key, JsonString(text));
  }
  JsonObject& Add(std::string_view key, bool value)
  {
    return this->AddRaw(key, value ? "true" : "false");
  }
  template <class T>
  requires(std::integral<T> || std::floating_point<T>) JsonObject& Add(
    std::string_view key, T value)
  {
    return this->AddRaw(key, JsonNumber(value));
  }
  std::string Text() const { return this->Members + "}"; }

private:
  std::string Members = "{";
};

// [a,b,…] of a range, each made JSON by `format`.
template <class Range, class Format>
std::string JsonArray(const Range& range, const Format& format)
{
  std::string text = "[";
  for (const auto& value : range)
  {
    text += text.size() > 1 ? "," : "";
    text += format(value);
  }
  return text + "]";
}

}
