// SPDX-License-Identifier: BSD-3-Clause
// Parses JSON: the only reader for the project's own files and messages, small enough for a phone's
// page (doc/decisions/0032-libraries.md). Internal: not installed.
//
// Texts may be hostile. Neither parsing nor its result uses recursion, however deeply a text is
// nested. Numbers are rounded correctly. A number that is too large for a double is an error, and
// so is text that is not UTF-8. If a key is repeated, the last one counts, as in JavaScript.
#pragma once

#include "filters/core/Result.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string_view>
#include <vector>

namespace kdstream
{

struct JsonMember;

// A value. It is valid as long as its document exists.
class JsonValue
{
public:
  // The values of an array, or the members of an object.
  template <class Iterator>
  struct Range
  {
    Iterator first, last;
    Iterator begin() const { return this->first; }
    Iterator end() const { return this->last; }
  };
  class ValueIterator;
  class MemberIterator;

  bool IsBool() const { return this->Kind == Kinds::True || this->Kind == Kinds::False; }
  bool IsTrue() const { return this->Kind == Kinds::True; }
  bool IsString() const { return this->Kind == Kinds::String; }
  bool IsArray() const { return this->Kind == Kinds::Array; }
  bool IsObject() const { return this->Kind == Kinds::Object; }
  bool IsNumber() const { return this->IsUint64() || this->IsInt64() || this->IsDouble(); }
  // Whether it is a number that is spelled as an integer and fits.
  bool IsUint64() const { return this->Kind == Kinds::Unsigned; }
  bool IsInt64() const
  {
    return this->Kind == Kinds::Negative ||
           (this->IsUint64() && this->Content.integer <= std::uint64_t(INT64_MAX));
  }
  bool IsUint() const { return this->IsUint64() && this->Content.integer <= UINT32_MAX; }
  bool IsInt() const
  {
    return this->IsInt64() && this->GetInt64() >= INT32_MIN && this->GetInt64() <= INT32_MAX;
  }

  // REQUIRES: the value is of this type.
  bool GetBool() const { return this->IsTrue(); }
  std::uint64_t GetUint64() const { return this->Content.integer; }
  std::int64_t GetInt64() const { return static_cast<std::int64_t>(this->Content.integer); }
  std::uint32_t GetUint() const { return static_cast<std::uint32_t>(this->Content.integer); }
  int GetInt() const { return static_cast<int>(this->GetInt64()); }
  double GetDouble() const; // any number
  // It may be invalid UTF-8, because an escape can give half of a surrogate pair.
  std::string_view GetString() const { return { this->Content.text, this->Count }; }

  // The number of values or members. REQUIRES: an array or an object.
  std::size_t Size() const { return this->Count; }
  // REQUIRES: an array, and index < Size(). O(index).
  const JsonValue& operator[](std::size_t index) const;
  // The member; null if there is none. REQUIRES: an object. O(members).
  const JsonValue& operator[](std::string_view key) const;
  Range<ValueIterator> GetArray() const;
  Range<MemberIterator> GetObject() const;

protected:
  friend class JsonParser;
  enum class Kinds : std::uint8_t
  {
    Null,
    False,
    True,
    Unsigned,
    Negative,
    Double,
    String,
    Array,
    Object
  };
  bool IsDouble() const { return this->Kind == Kinds::Double; }
  const JsonValue* Next() const { return this + this->Span; }

  union
  {
    std::uint64_t integer; // the bits, if it is negative
    double number;
    const char* text;
    const JsonValue* first; // of the values; or of names and values alternately
  } Content{ 0 };
  std::uint32_t Count = 0; // bytes of a text, or number of values or members
  std::uint32_t Span = 1;  // distance to the next value on the same level
  Kinds Kind = Kinds::Null;
};

struct JsonMember
{
  const JsonValue& name; // a string
  const JsonValue& value;
};

class JsonValue::ValueIterator
{
public:
  explicit ValueIterator(const JsonValue* at)
    : At(at)
  {
  }
  const JsonValue& operator*() const { return *this->At; }
  ValueIterator& operator++()
  {
    this->At = this->At->Next();
    return *this;
  }
  bool operator==(const ValueIterator&) const = default;

private:
  const JsonValue* At;
};

class JsonValue::MemberIterator
{
public:
  explicit MemberIterator(const JsonValue* at)
    : At(at)
  {
  }
  JsonMember operator*() const { return { this->At[0], this->At[1] }; }
  MemberIterator& operator++()
  {
    this->At = this->At[1].Next();
    return *this;
  }
  bool operator==(const MemberIterator&) const = default;

private:
  const JsonValue* At;
};

// The outermost value, and all values inside it.
class JsonDocument : public JsonValue
{
  friend class JsonParser;
  std::vector<JsonValue> Values;
  std::unique_ptr<char[]> Texts;

public:
  JsonDocument() = default;
  JsonDocument(JsonDocument&&) = default;
  JsonDocument& operator=(JsonDocument&&) = default;
};

// Memory: at most 25 bytes for each byte of text, so limit the size of the text first. Errors:
// InvalidInput, with the byte at which the JSON is malformed.
Result<JsonDocument> ParseJson(std::string_view text);

// The member, or null if there is none. REQUIRES: an object. O(members).
const JsonValue* FindMember(const JsonValue& object, std::string_view key);

// REQUIRES: a string.
inline std::string_view TextOf(const JsonValue& value)
{
  return value.GetString();
}

}
