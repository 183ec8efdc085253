// Reads members of a JSON object with their types and ranges checked; remembers the first fault.
// Internal to the protocol.
#pragma once

#include "server/protocol/Json.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream::protocol
{

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
  const Json* Find(const Json& object, const char* key, bool required = true);
  std::uint64_t Integer(
    const Json& object, const char* key, std::uint64_t lowest, std::uint64_t highest);
  // As Integer, for a type that holds `highest`.
  template <class T>
  T Small(const Json& object, const char* key, std::uint64_t lowest, std::uint64_t highest)
  {
    return static_cast<T>(this->Integer(object, key, lowest, highest));
  }
  double Number(const Json& object, const char* key, double lowest);
  std::array<double, 3> Vector(const Json& object, const char* key);
  bool Boolean(const Json& object, const char* key);
  std::string Text(
    const Json& object, const char* key, std::size_t mostBytes, bool required = true);
  // An array of integers in the range, at most `most` of them; empty where an optional one is
  // absent.
  std::vector<std::uint32_t> Integers(const Json& object, const char* key, std::uint32_t lowest,
    std::uint32_t highest, std::size_t most, bool required);
  // An array of at most `most` values, or null.
  const Json* Array(const Json& object, const char* key, std::size_t most);

private:
  std::string Place;
  std::string FirstFault;
};

}
