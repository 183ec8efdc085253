// SPDX-License-Identifier: BSD-3-Clause
#include "filters/model/JsonWriter.h"

#include "filters/core/Texts.h"
#include "filters/model/DecimalNumber.h"

#include <cmath>

namespace kdstream
{

std::string JsonNumber(double value)
{
  return std::isfinite(value) ? ShortestDecimal(value) : "null";
}

JsonWriter& JsonWriter::Key(std::string_view key)
{
  this->BeginEntry();
  this->AppendQuoted(key);
  this->Written += this->Style.indent == 0 ? ":" : ": ";
  this->AfterKey = true;
  return *this;
}

JsonWriter& JsonWriter::Put(std::string_view text)
{
  this->BeginEntry();
  this->AppendQuoted(text);
  return *this;
}

JsonWriter& JsonWriter::PutJson(std::string_view json)
{
  this->BeginEntry();
  this->Written += json;
  return *this;
}

JsonWriter& JsonWriter::Begin(char bracket)
{
  this->BeginEntry();
  this->Written += bracket;
  ++this->Depth;
  this->First = true;
  return *this;
}

JsonWriter& JsonWriter::End(char bracket)
{
  --this->Depth;
  if (!this->First)
  {
    this->BreakLine();
  }
  this->Written += bracket;
  this->First = false;
  return *this;
}

void JsonWriter::BreakLine()
{
  if (this->Style.indent > 0)
  {
    this->Written += '\n';
    this->Written.append(this->Style.indent * this->Depth, ' ');
  }
}

// Writes the separator before a value or a key.
void JsonWriter::BeginEntry()
{
  if (this->AfterKey)
  {
    this->AfterKey = false;
    return;
  }
  if (this->Depth > 0)
  {
    this->Written += this->First ? "" : ",";
    this->BreakLine();
  }
  this->First = false;
}

void JsonWriter::AppendQuoted(std::string_view text)
{
  if (!IsUtf8(text))
  {
    this->AppendQuoted(RepairUtf8(text));
    return;
  }
  static constexpr std::string_view escaped = "\"\\\b\f\n\r\t", letters = "\"\\bfnrt";
  static constexpr char digits[] = "0123456789ABCDEF";
  this->Written += '"';
  for (const char c : text)
  {
    const auto code = static_cast<unsigned char>(c);
    if (const std::size_t i = escaped.find(c); i != std::string_view::npos)
    {
      this->Written += '\\';
      this->Written += letters[i];
    }
    else if (code < 0x20)
    {
      this->Written += "\\u00";
      this->Written += digits[code >> 4];
      this->Written += digits[code & 15];
    }
    else
    {
      this->Written += c;
    }
  }
  this->Written += '"';
}

}
