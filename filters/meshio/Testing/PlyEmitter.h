// SPDX-License-Identifier: BSD-3-Clause
// Writes PLY files of every shape, for the tests of the reader. Shares no code with the reader
// under test.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace kdstream::test
{

enum class EmitEncoding
{
  Ascii,
  LittleEndian,
  BigEndian
};

struct EmitProperty
{
  std::string name;
  std::string type;
  std::string countType; // empty if it is not a list
};

// Every value is a double: all PLY types fit into it exactly.
struct EmitElement
{
  std::string name;
  std::vector<EmitProperty> properties;
  std::vector<std::vector<std::vector<double>>> records; // [record][property][value]
};

struct EmitStyle
{
  EmitEncoding encoding = EmitEncoding::Ascii;
  std::string newline = "\n";
  std::string blank = " ";
  bool comments = false;
};

// Returns the one-letter code of a type; "int16" and "short" are the same type.
inline char EmitTypeCode(const std::string& type)
{
  const std::vector<std::pair<std::string, char>> codes{ { "char", 'b' }, { "int8", 'b' },
    { "uchar", 'B' }, { "uint8", 'B' }, { "short", 'h' }, { "int16", 'h' }, { "ushort", 'H' },
    { "uint16", 'H' }, { "int", 'i' }, { "int32", 'i' }, { "uint", 'I' }, { "uint32", 'I' },
    { "int64", 'q' }, { "uint64", 'Q' }, { "float", 'f' }, { "float32", 'f' }, { "double", 'd' },
    { "float64", 'd' } };
  return std::find_if(
    codes.begin(), codes.end(), [&type](const auto& code) { return code.first == type; })
    ->second;
}

class PlyEmitter
{
public:
  explicit PlyEmitter(EmitStyle style)
    : Style(std::move(style))
  {
  }

  std::string Emit(const std::vector<EmitElement>& elements)
  {
    this->Bytes.clear();
    this->EmitHeader(elements);
    for (const EmitElement& element : elements)
    {
      for (const auto& record : element.records)
      {
        this->AtLineBegin = true;
        for (std::size_t p = 0; p < element.properties.size(); ++p)
        {
          const EmitProperty& property = element.properties[p];
          if (!property.countType.empty())
          {
            this->EmitValue(property.countType, static_cast<double>(record[p].size()));
          }
          for (double value : record[p])
          {
            this->EmitValue(property.type, value);
          }
        }
        if (this->Style.encoding == EmitEncoding::Ascii && !element.properties.empty())
        {
          this->Bytes += this->Style.newline;
        }
      }
    }
    return this->Bytes;
  }

  // Writes one value.
  std::string EmitOne(const std::string& type, double value)
  {
    this->Bytes.clear();
    this->EmitValue(type, value);
    return this->Bytes;
  }

private:
  void EmitHeader(const std::vector<EmitElement>& elements)
  {
    const std::string& end = this->Style.newline;
    const char* format = this->Style.encoding == EmitEncoding::Ascii ? "ascii"
                         : this->Style.encoding == EmitEncoding::LittleEndian
                           ? "binary_little_endian"
                           : "binary_big_endian";
    this->Bytes += "ply" + end;
    const std::string comment =
      this->Style.comments ? "comment element vertex 5 end_header" + end + "obj_info x" + end : "";
    this->Bytes += comment + "format " + format + " 1.0" + end + comment;
    for (const EmitElement& element : elements)
    {
      this->Bytes += "element " + element.name + " " + std::to_string(element.records.size()) + end;
      for (const EmitProperty& property : element.properties)
      {
        this->Bytes += "property ";
        this->Bytes += property.countType.empty() ? "" : "list " + property.countType + " ";
        this->Bytes += property.type + " " + property.name + end + comment;
      }
    }
    this->Bytes += "end_header" + end;
  }

  void EmitValue(const std::string& type, double value)
  {
    switch (EmitTypeCode(type))
    {
      case 'b':
        return this->EmitAs(static_cast<std::int8_t>(value));
      case 'B':
        return this->EmitAs(static_cast<std::uint8_t>(value));
      case 'h':
        return this->EmitAs(static_cast<std::int16_t>(value));
      case 'H':
        return this->EmitAs(static_cast<std::uint16_t>(value));
      case 'i':
        return this->EmitAs(static_cast<std::int32_t>(value));
      case 'I':
        return this->EmitAs(static_cast<std::uint32_t>(value));
      case 'q':
        return this->EmitAs(static_cast<std::int64_t>(value));
      case 'Q':
        return this->EmitAs(static_cast<std::uint64_t>(value));
      case 'f':
        return this->EmitAs(static_cast<float>(value));
      default:
        return this->EmitAs(value);
    }
  }

  template <class T>
  void EmitAs(T value)
  {
    if (this->Style.encoding == EmitEncoding::Ascii)
    {
      char text[64];
      const auto end = std::to_chars(text, text + sizeof(text), value).ptr;
      this->Bytes += this->AtLineBegin ? "" : this->Style.blank;
      this->Bytes.append(text, end);
      this->AtLineBegin = false;
      return;
    }
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    const std::uint16_t probe = 1;
    const bool nativeLittle = *reinterpret_cast<const char*>(&probe) == 1;
    if (nativeLittle != (this->Style.encoding == EmitEncoding::LittleEndian))
    {
      std::reverse(bytes, bytes + sizeof(T));
    }
    this->Bytes.append(bytes, sizeof(T));
  }

  EmitStyle Style;
  std::string Bytes;
  bool AtLineBegin = true;
};

}
