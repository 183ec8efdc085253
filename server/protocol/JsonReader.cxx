#include "server/protocol/JsonReader.h"

#include "server/protocol/TextParts.h"

#include <cmath>
#include <limits>

namespace kdstream::protocol
{

namespace
{

// A value for a message. Only scalars are written out: a nested value may be of any depth.
std::string Show(const Json& value)
{
  return value.is_structured() ? std::string("an ") + value.type_name() : Quoted(WriteJson(value));
}

bool IsIntegerIn(const Json& value, std::uint64_t lowest, std::uint64_t highest)
{
  return value.is_number_unsigned() && value.get<std::uint64_t>() >= lowest &&
         value.get<std::uint64_t>() <= highest;
}

}

std::string WriteJson(const Json& value)
{
  return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void JsonReader::Fail(const std::string& what)
{
  if (this->FirstFault.empty())
  {
    this->FirstFault = this->Place + ": " + what;
  }
}

const Json* JsonReader::Find(const Json& object, const char* key, bool required)
{
  if (!object.is_object())
  {
    this->Fail("an object was expected, not " + Show(object));
    return nullptr;
  }
  const auto member = object.find(key);
  if (member == object.end())
  {
    if (required)
    {
      this->Fail(std::string("\"") + key + "\" is missing");
    }
    return nullptr;
  }
  return &*member;
}

std::uint64_t JsonReader::Integer(
  const Json& object, const char* key, std::uint64_t lowest, std::uint64_t highest)
{
  const Json* value = this->Find(object, key);
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
  return value->get<std::uint64_t>();
}

double JsonReader::Number(const Json& object, const char* key, double lowest)
{
  const Json* value = this->Find(object, key);
  if (!value)
  {
    return lowest;
  }
  const double number =
    value->is_number() ? value->get<double>() : std::numeric_limits<double>::quiet_NaN();
  if (!std::isfinite(number) || number < lowest)
  {
    this->Fail(std::string("\"") + key + "\" is " + Show(*value) +
               ", not a finite number of at least " + WriteJson(Json(lowest)));
    return lowest;
  }
  return number;
}

std::array<double, 3> JsonReader::Vector(const Json& object, const char* key)
{
  std::array<double, 3> vector{};
  const Json* value = this->Array(object, key, 3);
  if (!value)
  {
    return vector;
  }
  if (value->size() != 3)
  {
    this->Fail(std::string("\"") + key + "\" has not three numbers");
    return vector;
  }
  for (std::size_t k = 0; k < 3; ++k)
  {
    const Json& number = (*value)[k];
    if (!number.is_number() || !std::isfinite(number.get<double>()))
    {
      this->Fail(std::string("\"") + key + "\" holds " + Show(number) + ", not a finite number");
      return {};
    }
    vector[k] = number.get<double>();
  }
  return vector;
}

bool JsonReader::Boolean(const Json& object, const char* key)
{
  const Json* value = this->Find(object, key);
  if (value && !value->is_boolean())
  {
    this->Fail(std::string("\"") + key + "\" is " + Show(*value) + ", not true or false");
    return false;
  }
  return value && value->get<bool>();
}

std::string JsonReader::Text(
  const Json& object, const char* key, std::size_t mostBytes, bool required)
{
  const Json* value = this->Find(object, key, required);
  if (!value)
  {
    return {};
  }
  if (!value->is_string())
  {
    this->Fail(std::string("\"") + key + "\" is " + Show(*value) + ", not a text");
    return {};
  }
  const auto& text = value->get_ref<const std::string&>();
  if (text.size() > mostBytes)
  {
    this->Fail(
      std::string("\"") + key + "\" is longer than " + std::to_string(mostBytes) + " bytes");
    return {};
  }
  return text;
}

std::vector<std::uint32_t> JsonReader::Integers(const Json& object, const char* key,
  std::uint32_t lowest, std::uint32_t highest, std::size_t most, bool required)
{
  std::vector<std::uint32_t> integers;
  if (!required && !this->Find(object, key, false))
  {
    return integers;
  }
  const Json* values = this->Array(object, key, most);
  if (!values)
  {
    return integers;
  }
  integers.reserve(values->size());
  for (const Json& value : *values)
  {
    if (!IsIntegerIn(value, lowest, highest))
    {
      this->Fail(std::string("\"") + key + "\" holds " + Show(value) + ", not an integer from " +
                 std::to_string(lowest) + " to " + std::to_string(highest));
      return {};
    }
    integers.push_back(value.get<std::uint32_t>());
  }
  return integers;
}

const Json* JsonReader::Array(const Json& object, const char* key, std::size_t most)
{
  const Json* value = this->Find(object, key);
  if (!value)
  {
    return nullptr;
  }
  if (!value->is_array() || value->size() > most)
  {
    this->Fail(std::string("\"") + key + "\" is not an array of at most " + std::to_string(most) +
               " values");
    return nullptr;
  }
  return value;
}

}
