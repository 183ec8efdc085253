// JSON texts in and out, by RapidJSON: small enough for a phone's page, which cannot afford
// nlohmann's. Internal: not installed, for sources of the protocol, the session and the client
// only.
//
// Texts are hostile: parsing does not recurse, however deep they nest; numbers are rounded
// correctly, and one that is too large for a double is no JSON, nor is text that is not UTF-8.
// Where a key comes twice the last one counts, as in JavaScript.
#pragma once

#include "filters/core/Result.h"

#include <rapidjson/document.h>
#include <rapidjson/stringbuffer.h>
#include <rapidjson/writer.h>

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>

namespace kdstream::protocol
{

using Json = rapidjson::Value;
using JsonDocument = rapidjson::Document;

// The memory is at most about 24 bytes a byte of text: bound the text first.
// Errors: InvalidInput naming the byte from which on it is no JSON.
Result<JsonDocument> ParseJson(std::string_view text);

// The member, or null where there is none. REQUIRES: an object. O(members).
const Json* FindMember(const Json& object, std::string_view key);

// REQUIRES: a string.
inline std::string_view TextOf(const Json& value)
{
  return { value.GetString(), value.GetStringLength() };
}

// Whether the text is UTF-8. A parsed text may not be: an escape can name half a surrogate pair.
bool IsUtf8(std::string_view text);

// Writes one JSON text, in the order of the calls. Every value is that of a member: Key first. In
// arrays, values follow each other without keys.
class JsonWriter
{
public:
  JsonWriter()
    : Writer(this->Buffer)
  {
  }
  JsonWriter(const JsonWriter&) = delete;
  JsonWriter& operator=(const JsonWriter&) = delete;

  void BeginObject() { this->Writer.StartObject(); }
  void EndObject() { this->Writer.EndObject(); }
  void BeginArray() { this->Writer.StartArray(); }
  void EndArray() { this->Writer.EndArray(); }
  void Key(std::string_view key) { this->Put(key); }

  // What is not UTF-8 is replaced by U+FFFD.
  void Put(std::string_view text);
  void Put(const char* text) { this->Put(std::string_view(text)); }
  void Put(bool value) { this->Writer.Bool(value); }
  // A decimal text that reads back as the same double; null where it is not finite.
  void Put(double value);
  template <std::unsigned_integral T>
  void Put(T value)
  {
    this->Writer.Uint64(value);
  }
  // Vectors and arrays of numbers.
  template <class Range>
  requires(!std::same_as<typename Range::value_type, char>) void Put(const Range& numbers)
  {
    this->BeginArray();
    for (const auto number : numbers)
    {
      this->Put(number);
    }
    this->EndArray();
  }

  template <class T>
  void Member(std::string_view key, const T& value)
  {
    this->Key(key);
    this->Put(value);
  }

  std::string Text() const { return { this->Buffer.GetString(), this->Buffer.GetSize() }; }

private:
  rapidjson::StringBuffer Buffer;
  rapidjson::Writer<rapidjson::StringBuffer> Writer;
};

}
