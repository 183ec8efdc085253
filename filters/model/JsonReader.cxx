// SPDX-License-Identifier: BSD-3-Clause
#include "filters/model/JsonReader.h"

#include "filters/core/Texts.h"
#include "filters/model/JsonWriter.h"

#include <cmath>
#include <limits>

namespace kdstream
{

namespace
{

bool IsIntegerIn(const JsonValue& value, std::uint64_t lowest, std::uint64_t highest)
{
  return value.IsUint64() && value.GetUint64() >= lowest && value.GetUint64() <= highest;
}

}

double NumberOf(const JsonValue& value)
{
  return value.IsNumber() ? value.GetDouble() : std::numeric_limits<double>::quiet_NaN();
}

std::string Show(const JsonValue& value)
{
  if (value.IsNumber())
  {
    return Quoted(value.IsUint64()  ? std::to_string(value.GetUint64())
                  : value.IsInt64() ? std::to_string(value.GetInt64())
                                    : JsonNumber(value.GetDouble()));
  }
  return value.IsObject()   ? "an object"
         : value.IsArray()  ? "an array"
         : value.IsString() ? Quoted(TextOf(value))
         : value.IsBool()   ? value.IsTrue() ? "true" : "false"
                            : "null";
}

void JsonReader::Fail(const std::string& what)
{
  if (this->FirstFault.empty())
  {
    this->FirstFault = this->Place + ": " + what;
  }
}

const JsonValue* JsonReader::Find(const JsonValue& object, const char* key, bool required)
{
  if (!object.IsObject())
  {
    this->Fail("an object was expected, not " + Show(object));
    return nullptr;
  }
  const JsonValue* member = FindMember(object, key);
  if (!member && required)
  {
    this->Fail(std::string("\"") + key + "\" is missing");
  }
  return member;
}

std::uint64_t JsonReader::Integer(
  const JsonValue& object, const char* key, std::uint64_t lowest, std::uint64_t highest)
{
  const JsonValue* value = this->Find(object, key);
  if (!value)
  {
    return lowest;
  }
  if (!IsIntegerIn(*value, lowest, highest))
  {
    this->Fail(std::string("\"") + key + "\" is " + Show(*value) + ", not an integer from " +
               std::to_string(lowest) + " to " + std::to_string(highest));
    return lowest;
  }
  return value->GetUint64();
}

double JsonReader::Number(const JsonValue& object, const char* key, double lowest)
{
  const JsonValue* value = this->Find(object, key);
  if (!value)
  {
    return lowest;
  }
  const double number = NumberOf(*value);
  if (!std::isfinite(number) || number < lowest)
  {
    this->Fail(std::string("\"") + key + "\" is " + Show(*value) +
               ", not a finite number of at least " + JsonNumber(lowest));
    return lowest;
  }
  return number;
}

std::array<double, 3> JsonReader::Vector(const JsonValue& object, const char* key)
{
  std::array<double, 3> vector{};
  const JsonValue* value = this->Array(object, key, 3);
  if (!value)
  {
    return vector;
  }
  if (value->Size() != 3)
  {
    this->Fail(std::string("\"") + key + "\" must have three numbers");
    return vector;
  }
  for (std::size_t k = 0; k < 3; ++k)
  {
    const JsonValue& number = (*value)[k];
    if (!std::isfinite(NumberOf(number)))
    {
      this->Fail(std::string("\"") + key + "\" holds " + Show(number) + ", not a finite number");
      return {};
    }
    vector[k] = NumberOf(number);
  }
  return vector;
}

bool JsonReader::Boolean(const JsonValue& object, const char* key)
{
  const JsonValue* value = this->Find(object, key);
  if (value && !value->IsBool())
  {
    this->Fail(std::string("\"") + key + "\" is " + Show(*value) + ", not true or false");
    return false;
  }
  return value && value->GetBool();
}

std::string JsonReader::Text(
  const JsonValue& object, const char* key, std::size_t mostBytes, bool required)
{
  const JsonValue* value = this->Find(object, key, required);
  return value ? this->TextIn(*value, key, mostBytes) : std::string();
}

std::string JsonReader::TextIn(const JsonValue& value, const char* key, std::size_t mostBytes)
{
  if (!value.IsString())
  {
    this->Fail(std::string("\"") + key + "\" is " + Show(value) + ", not a string");
    return {};
  }
  const std::string_view text = TextOf(value);
  if (text.size() > mostBytes)
  {
    this->Fail(
      std::string("\"") + key + "\" is longer than " + std::to_string(mostBytes) + " bytes");
    return {};
  }
  if (!IsUtf8(text))
  {
    this->Fail(std::string("\"") + key + "\" contains an unpaired surrogate");
    return {};
  }
  return std::string(text);
}

std::vector<std::uint32_t> JsonReader::Integers(const JsonValue& object, const char* key,
  std::uint32_t lowest, std::uint32_t highest, std::size_t most, bool required)
{
  std::vector<std::uint32_t> integers;
  if (!required && !this->Find(object, key, false))
  {
    return integers;
  }
  const JsonValue* values = this->Array(object, key, most);
  if (!values)
  {
    return integers;
  }
  integers.reserve(values->Size());
  for (const JsonValue& value : values->GetArray())
  {
    if (!IsIntegerIn(value, lowest, highest))
    {
      this->Fail(std::string("\"") + key + "\" holds " + Show(value) + ", not an integer from " +
                 std::to_string(lowest) + " to " + std::to_string(highest));
      return {};
    }
    integers.push_back(value.GetUint());
  }
  return integers;
}

const JsonValue* JsonReader::Array(const JsonValue& object, const char* key, std::size_t most)
{
  const JsonValue* value = this->Find(object, key);
  if (!value)
  {
    return nullptr;
  }
  if (!value->IsArray() || value->Size() > most)
  {
    this->Fail(std::string("\"") + key + "\" must be an array of at most " + std::to_string(most) +
               " values");
    return nullptr;
  }
  return value;
}

}
