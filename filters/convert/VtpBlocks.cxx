// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. read the tags: how lengths are written, and what each array is
// 2. check base64 inside an array's element
// 3. check appended data: for each array its length, and the bytes up to the next array.
#include "filters/convert/VtpBlocks.h"

#include "filters/convert/VtkWords.h"
#include "filters/core/Texts.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/QuotedText.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

constexpr std::string_view xmlBlanks = " \t\r\n";
constexpr std::size_t longestTag = std::size_t{ 1 } << 16;

// Whether a character is in the base64 alphabet of VTK's XML files (RFC 4648, section 4).
bool IsBase64(char c)
{
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '+' ||
         c == '/';
}

// Decodes checked base64 up to the first '='.
std::string FromBase64(std::string_view text)
{
  const auto bytes = Base64Decoded(text);
  return bytes ? std::string(bytes->begin(), bytes->end()) : std::string();
}

// The number of base64 characters for this number of bytes.
std::uint64_t Base64Size(std::uint64_t bytes)
{
  return (bytes + 2) / 3 * 4;
}

class VtpScan
{
public:
  VtpScan(ByteSource& source, const KeptBytes& keep)
    : Source(source)
    , Keep(keep)
  {
  }

  Result<bool> Run()
  {
    while (this->Now != State::Appended)
    {
      const Result<std::string_view> block = this->Source.Peek(static_cast<std::size_t>(
        std::min<std::uint64_t>(ByteSource::blockSize, this->Source.Remaining())));
      KDSTREAM_TRY(block);
      if (block->empty())
      {
        return this->HasBlanks; // VTK reports what is missing
      }
      const Result<std::size_t> taken = this->Take(*block);
      KDSTREAM_TRY(taken);
      this->Line += static_cast<std::uint64_t>(
        std::count(block->begin(), block->begin() + static_cast<std::ptrdiff_t>(*taken), '\n'));
      this->Source.Consume(*taken);
    }
    const std::uint64_t begin = this->Source.Position();
    KDSTREAM_TRY(this->CheckAppended());
    KDSTREAM_TRY(this->KeepRest(begin));
    return this->HasBlanks;
  }

private:
  enum class State
  {
    Text,
    Tag,
    Base64,
    Other, // not XML, or nothing more to check
    Appended
  };

  struct Array
  {
    std::string name; // "the array 'Points' (line 12)"
    std::int64_t offset = 0;
  };

  // Takes bytes from the beginning of the block, as the state requires.
  Result<std::size_t> Take(std::string_view block)
  {
    switch (this->Now)
    {
      case State::Tag:
        return this->TakeTag(block);
      case State::Base64:
        return this->TakeBase64(block);
      case State::Text:
      {
        const std::size_t end = std::min(block.find('<'), block.size());
        KDSTREAM_TRY(this->Keep(block.substr(0, end)));
        this->Now = end < block.size() ? State::Tag : State::Text;
        this->Tag.clear();
        this->Quote = 0;
        return end;
      }
      case State::Other:
      case State::Appended:
        break;
    }
    KDSTREAM_TRY(this->Keep(block));
    return block.size();
  }

  // Takes a tag up to its end, which may be in a later block. Comments have neither quotes nor the
  // same end.
  Result<std::size_t> TakeTag(std::string_view block)
  {
    std::size_t taken = 0;
    for (bool isWhole = false; taken < block.size() && !isWhole;)
    {
      const char c = block[taken++];
      this->Tag += c;
      const bool isComment = this->Tag.starts_with("<!--");
      if (!isComment && (c == '"' || c == '\'') && (this->Quote == 0 || this->Quote == c))
      {
        this->Quote = this->Quote == 0 ? c : '\0';
      }
      isWhole = c == '>' && this->Quote == 0 && (!isComment || this->Tag.ends_with("-->"));
      if (isWhole)
      {
        KDSTREAM_TRY(this->EndTag());
      }
      else if (this->Tag.size() > longestTag)
      {
        this->Now = State::Other;
        break;
      }
    }
    KDSTREAM_TRY(this->Keep(block.substr(0, taken)));
    return taken;
  }

  std::string Attribute(std::string_view name) const
  {
    for (std::size_t at = this->Tag.find(name); at != std::string::npos;
         at = this->Tag.find(name, at + 1))
    {
      const std::size_t equals = this->Tag.find_first_not_of(xmlBlanks, at + name.size());
      if (xmlBlanks.find(this->Tag[at - 1]) == std::string_view::npos ||
          equals == std::string::npos || this->Tag[equals] != '=')
      {
        continue;
      }
      const std::size_t quote = this->Tag.find_first_of("\"'", equals);
      const std::size_t end =
        quote == std::string::npos ? quote : this->Tag.find(this->Tag[quote], quote + 1);
      if (end != std::string::npos)
      {
        return this->Tag.substr(quote + 1, end - quote - 1);
      }
    }
    return {};
  }

  Status EndTag()
  {
    this->Now = State::Text;
    if (this->Tag.starts_with("<VTKFile"))
    {
      this->LengthBytes = this->Attribute("header_type") == "UInt64" ? 8 : 4;
      this->IsBig = this->Attribute("byte_order") == "BigEndian";
      this->IsCompressed = !this->Attribute("compressor").empty();
    }
    if (this->Tag.starts_with("<AppendedData"))
    {
      this->IsRaw = this->Attribute("encoding") == "raw";
      this->Now = State::Appended;
    }
    const std::string format = this->Attribute("format");
    const std::string given = this->Attribute("Name");
    const std::string name = "the array " + (given.empty() ? given : QuotedText(given) + " ") +
                             "(line " + std::to_string(this->Line) + ")";
    if (format == "appended")
    {
      const std::string offset = this->Attribute("offset");
      Array array;
      array.name = name;
      if (ParseNumber(offset, array.offset) != NumberTextError::None || array.offset < 0)
      {
        return DamagedVtk(name + " has an invalid offset: " + QuotedText(offset));
      }
      this->Arrays.push_back(std::move(array));
    }
    if (format == "binary" && !this->Tag.ends_with("/>"))
    {
      this->Now = State::Base64;
      this->Inline = name;
      this->First.clear();
      this->Characters = this->Padding = 0;
      this->IsAfterBlank = false;
    }
    return {};
  }

  Error NotBase64(const std::string& name, char c) const
  {
    return DamagedVtk(name + " has " + QuotedText(std::string(1, c)) + " in its base64");
  }

  Result<std::size_t> TakeBase64(std::string_view block)
  {
    const std::size_t end = std::min(block.find('<'), block.size());
    std::string kept;
    for (const char c : block.substr(0, end))
    {
      if (xmlBlanks.find(c) != std::string_view::npos)
      {
        this->IsAfterBlank = this->Characters > 0;
        continue;
      }
      if (c != '=' && !IsBase64(c))
      {
        return this->NotBase64(this->Inline, c);
      }
      const bool isApart = this->Characters == Base64Size(this->LengthBytes);
      if (c != '=' && this->Padding > 0 && !isApart && !this->IsCompressed)
      {
        return this->NotBase64(this->Inline, '=');
      }
      this->HasBlanks = this->HasBlanks || this->IsAfterBlank;
      this->Padding = c == '=' ? this->Padding + 1 : 0;
      if (this->First.size() < base64OfLength)
      {
        this->First += c;
      }
      ++this->Characters;
      kept += c;
    }
    KDSTREAM_TRY(this->Keep(kept));
    if (end < block.size())
    {
      KDSTREAM_TRY(this->CheckInline());
      this->Now = State::Tag;
      this->Tag.clear();
      this->Quote = 0;
    }
    return end;
  }

  std::uint64_t NumberAt(std::string_view bytes, std::size_t at) const
  {
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < this->LengthBytes; ++i)
    {
      const auto byte = static_cast<unsigned char>(bytes[at + i]);
      number |= std::uint64_t{ byte } << (8 * (this->IsBig ? this->LengthBytes - 1 - i : i));
    }
    return number;
  }

  // Whether the length is encoded separately, before the bytes.
  bool IsApart(std::string_view first) const
  {
    return first.substr(0, Base64Size(this->LengthBytes)).find('=') != std::string_view::npos;
  }

  static Status CheckClaim(const std::string& name, std::uint64_t claimed, std::uint64_t held)
  {
    return claimed <= held ? Status{}
                           : Status(DamagedVtk(name + " claims " + std::to_string(claimed) +
                                               " bytes; it has " + std::to_string(held)));
  }

  // Checks the length of the base64 in an element. Compressed data is not checked here, except that
  // its base64 is complete.
  Status CheckInline() const
  {
    const std::string bytes = FromBase64(this->First);
    if (this->Characters == 0 || (this->IsCompressed && this->Characters % 4 == 0))
    {
      return {};
    }
    if (this->Characters % 4 != 0 || this->Padding > 2 || bytes.size() < this->LengthBytes)
    {
      return DamagedVtk(this->Inline + " ends inside of its base64");
    }
    const bool isApart = this->IsApart(this->First);
    const std::uint64_t characters =
      this->Characters - (isApart ? Base64Size(this->LengthBytes) : 0);
    const std::uint64_t all = characters / 4 * 3 - (characters > 0 ? this->Padding : 0);
    const std::uint64_t length = isApart ? 0 : this->LengthBytes;
    return CheckClaim(this->Inline, this->NumberAt(bytes, 0), all - std::min(all, length));
  }

  // ---- appended data, after '_'

  Result<std::string_view> BytesAt(std::uint64_t at, std::uint64_t count)
  {
    this->Source.Seek(at);
    const Result<std::string_view> bytes = this->Source.Peek(
      static_cast<std::size_t>(std::min<std::uint64_t>(count, this->Source.Remaining())));
    return bytes ? bytes->substr(0, static_cast<std::size_t>(count)) : bytes;
  }

  // Finds the end tag of the appended data.
  Result<std::uint64_t> FindAppendedEnd(std::uint64_t begin)
  {
    constexpr std::uint64_t most = std::uint64_t{ 1 } << 16; // bytes that may follow
    const std::uint64_t from =
      std::max(begin, this->Source.Size() - std::min(this->Source.Size(), most));
    const Result<std::string_view> last = this->BytesAt(from, most);
    KDSTREAM_TRY(last);
    const std::size_t end = last->rfind("</AppendedData");
    return end == std::string_view::npos
             ? Result<std::uint64_t>(DamagedVtk("<AppendedData> has no end: the file was cut"))
             : from + end;
  }

  Status CheckAppended()
  {
    const std::uint64_t tag = this->Source.Position();
    const Result<std::string_view> begin = this->BytesAt(tag, ByteSource::blockSize);
    KDSTREAM_TRY(begin);
    const std::size_t mark = begin->find('_');
    if (mark == std::string_view::npos)
    {
      return DamagedVtk("<AppendedData> has no '_', after which its bytes begin");
    }
    this->AppendedBegin = tag + mark + 1;
    const Result<std::uint64_t> found = this->FindAppendedEnd(this->AppendedBegin);
    KDSTREAM_TRY(found);
    std::uint64_t end = *found;
    if (!this->IsRaw)
    {
      const Result<std::uint64_t> characters = this->CheckCharacters(end);
      KDSTREAM_TRY(characters);
      end = this->AppendedBegin + *characters;
    }
    std::stable_sort(this->Arrays.begin(), this->Arrays.end(),
      [](const Array& a, const Array& b) { return a.offset < b.offset; });
    const std::uint64_t all = end - this->AppendedBegin;
    for (std::size_t i = this->Arrays.size(), next = i; i-- > 0;)
    {
      next = i + 1 < this->Arrays.size() && this->Arrays[i + 1].offset > this->Arrays[i].offset
               ? i + 1
               : next;
      const std::uint64_t room =
        next < this->Arrays.size() ? static_cast<std::uint64_t>(this->Arrays[next].offset) : all;
      KDSTREAM_TRY(this->CheckArray(this->Arrays[i], room));
    }
    return {};
  }

  // Counts the base64 characters. The offsets of arrays count these, so there must be no blanks
  // between them.
  Result<std::uint64_t> CheckCharacters(std::uint64_t end)
  {
    std::uint64_t count = 0;
    bool isAfterBlank = false;
    for (std::uint64_t at = this->AppendedBegin; at < end;)
    {
      const Result<std::string_view> bytes =
        this->BytesAt(at, std::min<std::uint64_t>(ByteSource::blockSize, end - at));
      KDSTREAM_TRY(bytes);
      if (bytes->empty())
      {
        break;
      }
      for (const char c : *bytes)
      {
        const bool isBlank = xmlBlanks.find(c) != std::string_view::npos;
        isAfterBlank = isAfterBlank || isBlank;
        if (!isBlank && (isAfterBlank || (c != '=' && !IsBase64(c))))
        {
          return isAfterBlank ? DamagedVtk("<AppendedData> has blanks or line ends in its base64, "
                                           "which the offsets of arrays cannot count")
                              : this->NotBase64("<AppendedData>", c);
        }
        count += isBlank ? 0 : 1;
      }
      at += bytes->size();
    }
    return count;
  }

  // Checks an appended array. room: the offset of the next array.
  Status CheckArray(const Array& array, std::uint64_t room)
  {
    const auto offset = static_cast<std::uint64_t>(array.offset);
    const std::uint64_t left = room > offset ? room - offset : 0;
    const std::uint64_t at = this->AppendedBegin + offset;
    const auto encoded = [this](std::uint64_t bytes)
    { return this->IsRaw ? bytes : Base64Size(bytes); };
    const std::uint64_t first = encoded(this->LengthBytes);
    if (first > left)
    {
      return DamagedVtk(array.name + " begins at " + std::to_string(offset) + ", after the end");
    }
    const Result<std::string_view> read = this->BytesAt(at, first);
    KDSTREAM_TRY(read);
    const bool isApart = !this->IsRaw && this->IsApart(*read);
    const std::string bytes = this->IsRaw ? std::string(*read) : FromBase64(*read);
    if (bytes.size() < this->LengthBytes)
    {
      return DamagedVtk(
        array.name + " begins at " + std::to_string(offset) + ", where no length is");
    }
    const std::uint64_t number = this->NumberAt(bytes, 0); // of bytes, or of compressed blocks
    if (!this->IsCompressed)
    {
      const std::uint64_t together = isApart ? 0 : this->LengthBytes;
      const std::uint64_t rest =
        this->IsRaw ? left - first : (left - (isApart ? first : 0)) / 4 * 3;
      return CheckClaim(array.name, number, rest - std::min(rest, this->IsRaw ? 0 : together));
    }
    if (number == 0)
    {
      return {};
    }
    const std::uint64_t head =
      number <= left ? encoded(this->LengthBytes * (3 + number)) : std::uint64_t{ 0 };
    if (head == 0 || head > left)
    {
      return CheckClaim(array.name, std::max(number, left + 1), left);
    }
    const Result<std::uint64_t> sum = this->SumOfBlocks(at, number, head);
    KDSTREAM_TRY(sum);
    return CheckClaim(array.name, encoded(*sum), left - head);
  }

  // The sum of the lengths of all compressed blocks. These lengths follow three numbers.
  Result<std::uint64_t> SumOfBlocks(std::uint64_t at, std::uint64_t blocks, std::uint64_t head)
  {
    std::uint64_t sum = 0;
    const std::uint64_t most = ~std::uint64_t{ 0 } / 4;
    constexpr std::uint64_t atOnce = 3 * std::uint64_t{ 4096 }; // whole groups of base64
    for (std::uint64_t done = 0; done < blocks + 3; done += atOnce)
    {
      const std::uint64_t numbers = std::min(atOnce, blocks + 3 - done);
      const std::uint64_t bytes = numbers * this->LengthBytes, skipped = done * this->LengthBytes;
      const std::uint64_t begin = this->IsRaw ? skipped : skipped / 3 * 4;
      const Result<std::string_view> read = this->BytesAt(at + begin,
        std::min(head - std::min(head, begin), this->IsRaw ? bytes : Base64Size(bytes)));
      KDSTREAM_TRY(read);
      const std::string lengths = this->IsRaw ? std::string(*read) : FromBase64(*read);
      for (std::uint64_t i = done == 0 ? 3 : 0; i < numbers; ++i)
      {
        const std::uint64_t end = (i + 1) * this->LengthBytes;
        sum += end <= lengths.size()
                 ? std::min(most, this->NumberAt(lengths, end - this->LengthBytes))
                 : most;
        sum = std::min(sum, most);
      }
    }
    return sum;
  }

  Status KeepRest(std::uint64_t begin)
  {
    for (std::uint64_t at = begin; at < this->Source.Size();)
    {
      const Result<std::string_view> bytes = this->BytesAt(at, ByteSource::blockSize);
      KDSTREAM_TRY(bytes);
      if (bytes->empty())
      {
        break;
      }
      KDSTREAM_TRY(this->Keep(*bytes));
      at += bytes->size();
    }
    return {};
  }

  static constexpr std::size_t base64OfLength = 12; // for a length of 8 bytes

  ByteSource& Source;
  const KeptBytes& Keep;
  State Now = State::Text;
  std::uint64_t Line = 1;
  std::string Tag; // the part read so far
  char Quote = 0;  // the quote that is open in Tag
  std::uint64_t LengthBytes = 4;
  bool IsBig = false, IsCompressed = false, IsRaw = false;
  std::string Inline, First; // the current array, and how its base64 begins
  std::uint64_t Characters = 0, Padding = 0;
  bool IsAfterBlank = false, HasBlanks = false;
  std::vector<Array> Arrays; // the appended arrays
  std::uint64_t AppendedBegin = 0;
};

}

Result<bool> CheckVtpBlocks(ByteSource& source, const KeptBytes& keep)
{
  source.Seek(source.Start());
  return VtpScan(source, keep).Run();
}

}
