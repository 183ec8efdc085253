// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. Count the characters that a value can follow. This is an upper bound for the number of values;
//    allocate memory for them once.
// 2. Parse values one after the other. An open array or object stores which one contains it, so no
//    stack is needed. The grammar is that of RFC 8259.
#include "filters/model/Json.h"

#include "filters/core/Texts.h"
#include "filters/model/DecimalNumber.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string>

namespace kdstream
{

class JsonParser
{
public:
  explicit JsonParser(std::string_view text)
    : Text(text)
  {
    const auto isBefore = [](char c) { return c == '[' || c == '{' || c == ',' || c == ':'; };
    this->Document.Values.reserve(
      1 + static_cast<std::size_t>(std::count_if(text.begin(), text.end(), isBefore)));
    this->Document.Texts = std::make_unique<char[]>(text.size());
    this->TextEnd = this->Document.Texts.get();
  }

  // Returns false if the JSON is malformed, at the position At.
  bool Parse()
  {
    bool isWhole = false; // of the value that was begun last
    while (!isWhole || this->Open != none)
    {
      if (isWhole ? !this->GoOn(isWhole) : !this->BeginValue(isWhole))
      {
        return false;
      }
    }
    this->SkipSpace();
    static_cast<JsonValue&>(this->Document) = this->Document.Values.front();
    return this->At == this->Text.size();
  }

  std::size_t At = 0;
  JsonDocument Document;

private:
  using Kinds = JsonValue::Kinds;
  static constexpr std::uint32_t none = UINT32_MAX;

  char Peek() const { return this->At < this->Text.size() ? this->Text[this->At] : '\0'; }
  bool Take(char c)
  {
    const bool is = this->At < this->Text.size() && this->Text[this->At] == c;
    this->At += is ? 1 : 0;
    return is;
  }
  bool TakeWord(std::string_view word)
  {
    const bool is = this->Text.substr(this->At, word.size()) == word;
    this->At += is ? word.size() : 0;
    return is;
  }
  void SkipSpace()
  {
    this->At = std::min(this->Text.find_first_not_of(" \t\n\r", this->At), this->Text.size());
  }
  bool TakeDigits()
  {
    const std::size_t begin = this->At;
    this->At = std::min(this->Text.find_first_not_of("0123456789", this->At), this->Text.size());
    return this->At > begin;
  }

  JsonValue& Add(Kinds kind)
  {
    JsonValue& value = this->Document.Values.emplace_back();
    value.Kind = kind;
    return value;
  }
  JsonValue& Outer() { return this->Document.Values[this->Open]; }

  // isWhole: set to whether the value is complete: not an array or object, or an empty one.
  bool BeginValue(bool& isWhole)
  {
    this->SkipSpace();
    if (this->Open != none)
    {
      ++this->Outer().Count;
    }
    isWhole = true;
    switch (this->Peek())
    {
      case '{':
        return this->BeginOuter(Kinds::Object, isWhole) && (isWhole || this->TakeName());
      case '[':
        return this->BeginOuter(Kinds::Array, isWhole);
      case '"':
        return this->TakeString();
      case 't':
        this->Add(Kinds::True);
        return this->TakeWord("true");
      case 'f':
        this->Add(Kinds::False);
        return this->TakeWord("false");
      case 'n':
        this->Add(Kinds::Null);
        return this->TakeWord("null");
      default:
        return this->TakeNumber();
    }
  }

  bool BeginOuter(Kinds kind, bool& isWhole)
  {
    ++this->At;
    JsonValue& value = this->Add(kind);
    value.Span = this->Open; // until the value is complete
    this->Open = static_cast<std::uint32_t>(this->Document.Values.size() - 1);
    this->SkipSpace();
    isWhole = this->EndOuter();
    return true;
  }

  // Ends the open array or object if its end comes here; returns whether it does.
  bool EndOuter()
  {
    JsonValue& value = this->Outer();
    if (!this->Take(value.IsObject() ? '}' : ']'))
    {
      return false;
    }
    const std::uint32_t around = value.Span;
    value.Span = static_cast<std::uint32_t>(this->Document.Values.size() - this->Open);
    value.Content.first = &value + 1;
    this->Open = around;
    return true;
  }

  // Called after a complete value in an open array or object: either this ends, or another value
  // follows.
  bool GoOn(bool& isWhole)
  {
    this->SkipSpace();
    isWhole = this->EndOuter();
    return isWhole ||
           (this->Take(',') && (this->Outer().IsArray() || (this->SkipSpace(), this->TakeName())));
  }

  bool TakeName()
  {
    const bool isName = this->Peek() == '"' && this->TakeString();
    this->SkipSpace();
    return isName && this->Take(':');
  }

  bool TakeNumber()
  {
    const std::size_t begin = this->At;
    const bool isNegative = this->Take('-');
    if (!this->Take('0') && !this->TakeDigits())
    {
      return false;
    }
    const std::string_view digits =
      this->Text.substr(begin + (isNegative ? 1 : 0), this->At - begin - (isNegative ? 1 : 0));
    if (const bool isInteger = this->Peek() != '.' && this->Peek() != 'e' && this->Peek() != 'E';
        isInteger && this->AddInteger(digits, isNegative))
    {
      return true;
    }
    if (this->Take('.') && !this->TakeDigits())
    {
      return false;
    }
    if (this->Take('e') || this->Take('E'))
    {
      if (!this->Take('-'))
      {
        this->Take('+');
      }
      if (!this->TakeDigits())
      {
        return false;
      }
    }
    const double number = NearestDouble(this->Text.substr(begin, this->At - begin));
    this->Add(Kinds::Double).Content.number = number;
    if (!std::isfinite(number))
    {
      this->At = begin;
    }
    return std::isfinite(number);
  }

  // Returns false if the number does not fit in 64 bits, or is -0, which is a double.
  bool AddInteger(std::string_view digits, bool isNegative)
  {
    std::uint64_t magnitude = 0;
    const bool fits =
      std::from_chars(digits.data(), digits.data() + digits.size(), magnitude).ec == std::errc();
    if (!fits || (isNegative && (magnitude == 0 || magnitude > std::uint64_t{ 1 } << 63)))
    {
      return false;
    }
    this->Add(isNegative ? Kinds::Negative : Kinds::Unsigned).Content.integer =
      isNegative ? 0 - magnitude : magnitude;
    return true;
  }

  bool TakeString()
  {
    JsonValue& value = this->Add(Kinds::String);
    value.Content.text = this->TextEnd;
    for (++this->At; !this->Take('"'); ++this->At)
    {
      if (this->At == this->Text.size() || static_cast<unsigned char>(this->Text[this->At]) < 0x20)
      {
        return false;
      }
      if (this->Text[this->At] != '\\')
      {
        *this->TextEnd++ = this->Text[this->At];
      }
      else if (!this->TakeEscape())
      {
        return false;
      }
    }
    value.Count = static_cast<std::uint32_t>(this->TextEnd - value.Content.text);
    return true;
  }

  // Afterwards At is at the last character of the escape.
  bool TakeEscape()
  {
    constexpr std::string_view letters = "\"\\/bfnrt", meanings = "\"\\/\b\f\n\r\t";
    ++this->At;
    if (this->Peek() == 'u')
    {
      return this->TakeCharacter();
    }
    const std::size_t which = letters.find(this->Peek());
    if (which == letters.npos)
    {
      return false;
    }
    *this->TextEnd++ = meanings[which];
    return true;
  }

  // Parses the four digits after the u at At.
  bool TakeHexadecimal(std::uint32_t& code)
  {
    const std::string_view digits = this->Text.substr(this->At + 1, 4);
    const auto end = digits.data() + digits.size();
    if (digits.size() < 4 || digits[0] == '-' ||
        std::from_chars(digits.data(), end, code, 16).ptr != end)
    {
      return false;
    }
    this->At += 4;
    return true;
  }

  bool TakeCharacter()
  {
    std::uint32_t code = 0, low = 0;
    if (!this->TakeHexadecimal(code))
    {
      return false;
    }
    if (code >= 0xD800 && code < 0xDC00) // the first half of a surrogate pair
    {
      ++this->At;
      if (!this->TakeWord("\\") || this->Peek() != 'u' || !this->TakeHexadecimal(low) ||
          low < 0xDC00 || low >= 0xE000)
      {
        return false;
      }
      code = 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
    }
    const int more = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3; // bytes after
    constexpr unsigned char marks[] = { 0, 0xC0, 0xE0, 0xF0 };
    *this->TextEnd++ = static_cast<char>(marks[more] | (code >> (6 * more)));
    for (int i = more - 1; i >= 0; --i)
    {
      *this->TextEnd++ = static_cast<char>(0x80 | ((code >> (6 * i)) & 0x3F));
    }
    return true;
  }

  const std::string_view Text;
  char* TextEnd = nullptr;
  std::uint32_t Open = none;
};

double JsonValue::GetDouble() const
{
  return this->Kind == Kinds::Unsigned   ? static_cast<double>(this->Content.integer)
         : this->Kind == Kinds::Negative ? static_cast<double>(this->GetInt64())
                                         : this->Content.number;
}

JsonValue::Range<JsonValue::ValueIterator> JsonValue::GetArray() const
{
  return { ValueIterator(this->Content.first),
    ValueIterator(this->Content.first + (this->Span - 1)) };
}

JsonValue::Range<JsonValue::MemberIterator> JsonValue::GetObject() const
{
  return { MemberIterator(this->Content.first),
    MemberIterator(this->Content.first + (this->Span - 1)) };
}

const JsonValue& JsonValue::operator[](std::size_t index) const
{
  const JsonValue* value = this->Content.first;
  for (; index > 0; --index)
  {
    value = value->Next();
  }
  return *value;
}

const JsonValue& JsonValue::operator[](std::string_view key) const
{
  static const JsonValue null;
  const JsonValue* const member = FindMember(*this, key);
  return member ? *member : null;
}

Result<JsonDocument> ParseJson(std::string_view text)
{
  std::size_t end = Utf8Prefix(text);
  if (end == text.size())
  {
    JsonParser parser(text);
    if (parser.Parse())
    {
      return std::move(parser.Document);
    }
    end = parser.At;
  }
  return Error{ ErrorCode::InvalidInput, "invalid JSON at byte " + std::to_string(end) };
}

const JsonValue* FindMember(const JsonValue& object, std::string_view key)
{
  const JsonValue* found = nullptr;
  for (const JsonMember& member : object.GetObject())
  {
    found = TextOf(member.name) == key ? &member.value : found;
  }
  return found;
}

}
