// SPDX-License-Identifier: BSD-3-Clause
// Reads members of a JSON object, and checks their types and ranges; remembers the first error.
// Internal: not installed.
#pragma once

#include "filters/model/Json.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// The value as text for a message. Only scalars are written, because an array or object may be
// nested to any depth.
std::string Show(const JsonValue& value);

// The number; NaN if the value is not a number.
double NumberOf(const JsonValue& value);

// After an error every function returns a harmless default. Check Fault() at the end.
class JsonReader
{
public:
  explicit JsonReader(std::string place)
    : Place(std::move(place))
  {
  }

  const std::string& Fault() const { return this->FirstFault; }
  bool Good() const { return this->FirstFault.empty(); }
  void Fail(const std::string& what);

  // The member, or null; null is an error if the member is required.
  const JsonValue* Find(const JsonValue& object, const char* key, bool required = true);
  std::uint64_t Integer(
    const JsonValue& object, const char* key, std::uint64_t lowest, std::uint64_t highest);
  // Like Integer, for a type that can hold `highest`.
  template <class T>
  T Small(const JsonValue& object, const char* key, std::uint64_t lowest, std::uint64_t highest)
  {
    return static_cast<T>(this->Integer(object, key, lowest, highest));
  }
  double Number(const JsonValue& object, const char* key, double lowest);
  std::array<double, 3> Vector(const JsonValue& object, const char* key);
  bool Boolean(const JsonValue& object, const char* key);
  std::string Text(
    const JsonValue& object, const char* key, std::size_t mostBytes, bool required = true);
  // The text of a member that has been found.
  std::string TextIn(const JsonValue& value, const char* key, std::size_t mostBytes);
  // An array of at most `most` integers in the range; empty if it is optional and absent.
  std::vector<std::uint32_t> Integers(const JsonValue& object, const char* key,
    std::uint32_t lowest, std::uint32_t highest, std::size_t most, bool required);
  // An array of at most `most` values, or null.
  const JsonValue* Array(const JsonValue& object, const char* key, std::size_t most);

private:
  std::string Place;
  std::string FirstFault;
};

}
