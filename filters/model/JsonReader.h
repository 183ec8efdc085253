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

// A value as text for a message. Only scalars are written out, because a nested value may have any
// depth.
std::string Show(const JsonValue& value);

// NaN for what is not a number.
double NumberOf(const JsonValue& value);

// Every function gives a harmless default once something is wrong; look at Fault() at the end.
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

  // The member, or null (a fault, if it is required).
  const JsonValue* Find(const JsonValue& object, const char* key, bool required = true);
  std::uint64_t Integer(
    const JsonValue& object, const char* key, std::uint64_t lowest, std::uint64_t highest);
  // As Integer, for a type that holds `highest`.
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
  // The value of a member that was found.
  std::string TextIn(const JsonValue& value, const char* key, std::size_t mostBytes);
  // An array of integers in the range, at most `most` of them; empty if an optional one is absent.
  std::vector<std::uint32_t> Integers(const JsonValue& object, const char* key,
    std::uint32_t lowest, std::uint32_t highest, std::size_t most, bool required);
  // An array of at most `most` values, or null.
  const JsonValue* Array(const JsonValue& object, const char* key, std::size_t most);

private:
  std::string Place;
  std::string FirstFault;
};

}
