// SPDX-License-Identifier: BSD-3-Clause
// Writes JSON: the only writer of the project, used for everything from the metadata of a store to
// the status of a page. It writes the same bytes on every platform.
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

// The shortest decimal text that reads back as the same double; "null" if the number is not finite.
std::string JsonNumber(double value);

struct JsonStyle
{
  unsigned indent = 0; // spaces for each depth, with one value a line; 0: all on one line
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

  // Bytes that are not UTF-8 are replaced by U+FFFD.
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
  // Writes null if there is no value.
  template <class T>
  JsonWriter& Put(const std::optional<T>& value)
  {
    return value ? this->Put(*value) : this->PutJson("null");
  }
  // Calls the function, which must write exactly one value.
  template <std::invocable<JsonWriter&> Function>
  JsonWriter& Put(const Function& write)
  {
    write(*this);
    return *this;
  }
  // Writes an array with the values of a range.
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
  // Writes a value that is already JSON.
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
  bool First = true;     // nothing has been written into this object or array yet
  bool AfterKey = false; // the next call writes the value of a member
};

}
