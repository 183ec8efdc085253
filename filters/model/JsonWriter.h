// SPDX-License-Identifier: BSD-3-Clause
// Writes JSON: the only writer of the project, used from the metadata of a store to the status of a
// page. The same bytes on every platform.
#pragma once

#include <charconv>
#include <concepts>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

namespace kdstream
{

// The shortest decimal text that reads back as the same double; null where it is not finite.
std::string JsonNumber(double value);

struct JsonStyle
{
  unsigned indent = 0; // blanks for each depth, a line a value; 0: all in one line
};

// Writes one JSON text, in the order of the calls:
//
//   JsonWriter json;
//   json.BeginObject().Member("id", 7).Member("box", [&](JsonWriter& box) { … }).EndObject();
//
// A value in an object needs a key: call Key first, or Member. Values in arrays, and outermost
// ones, have no keys.
class JsonWriter
{
public:
  explicit JsonWriter(JsonStyle style = {})
    : Style(style)
  {
  }

  JsonWriter& BeginObject() { return this->Begin('{'); }
  JsonWriter& EndObject() { return this->End('}'); }
  JsonWriter& BeginArray() { return this->Begin('['); }
  JsonWriter& EndArray() { return this->End(']'); }
  JsonWriter& Key(std::string_view key);

  // What is not UTF-8 is replaced by U+FFFD.
  JsonWriter& Put(std::string_view text);
  JsonWriter& Put(const std::string& text) { return this->Put(std::string_view(text)); }
  JsonWriter& Put(const char* text) { return this->Put(std::string_view(text)); }
  JsonWriter& Put(bool value) { return this->PutJson(value ? "true" : "false"); }
  JsonWriter& Put(double value) { return this->PutJson(JsonNumber(value)); }
  template <std::integral T>
  JsonWriter& Put(T value)
  {
    char text[24];
    const char* const end = std::to_chars(text, text + sizeof(text), value).ptr;
    return this->PutJson({ text, static_cast<std::size_t>(end - text) });
  }
  // null where there is none.
  template <class T>
  JsonWriter& Put(const std::optional<T>& value)
  {
    return value ? this->Put(*value) : this->PutJson("null");
  }
  // Whatever the function writes, which must be one value.
  template <std::invocable<JsonWriter&> Function>
  JsonWriter& Put(const Function& write)
  {
    write(*this);
    return *this;
  }
  // An array of the values of a range.
  template <class Range>
  requires(!std::same_as<typename Range::value_type, char>) JsonWriter& Put(const Range& values)
  {
    this->BeginArray();
    for (const auto& value : values)
    {
      this->Put(value);
    }
    return this->EndArray();
  }
  // A value that is JSON already.
  JsonWriter& PutJson(std::string_view json);

  template <class T>
  JsonWriter& Member(std::string_view key, const T& value)
  {
    return this->Key(key).Put(value);
  }

  const std::string& Text() const { return this->Written; }

private:
  JsonWriter& Begin(char bracket);
  JsonWriter& End(char bracket);
  void BreakLine();
  void BeginEntry();
  void AppendQuoted(std::string_view text);

  JsonStyle Style;
  std::string Written;
  std::size_t Depth = 0;
  bool First = true;     // nothing stands in this object or array yet
  bool AfterKey = false; // a member's value is next
};

}
