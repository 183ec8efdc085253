// SPDX-License-Identifier: BSD-3-Clause
// Finds the files that a mesh names: see FilesBeside.h.
#include "filters/texture/FilesBeside.h"

#include "filters/core/Texts.h"
#include "filters/files/Folders.h"
#include "filters/meshio/QuotedText.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <clocale>
#include <cwctype>
#include <locale.h>
#include <span>
#include <system_error>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::size_t mostNames = 1 << 16, mostFolders = 64;

bool IsFile(const std::filesystem::path& file)
{
  std::error_code failed;
  return std::filesystem::is_regular_file(file, failed);
}

// Decodes "a%20b" to "a b".
std::string WithoutEscapes(std::string_view name)
{
  std::string plain;
  for (std::size_t i = 0; i < name.size(); ++i)
  {
    unsigned value = 0;
    const char* const digits = name.data() + i + 1;
    if (name[i] == '%' && i + 2 < name.size() &&
        std::from_chars(digits, digits + 2, value, 16).ptr == digits + 2 && value >= ' ')
    {
      plain += static_cast<char>(value);
      i += 2;
    }
    else
    {
      plain += name[i];
    }
  }
  return plain;
}

// Reads the name as Latin-1, whose letters are those of Windows' code page 1252, and returns UTF-8.
std::string FromLatin(std::string_view name)
{
  std::string utf8;
  for (const char c : name)
  {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80)
    {
      utf8 += c;
    }
    else
    {
      utf8 += static_cast<char>(0xC0U | byte >> 6U);
      utf8 += static_cast<char>(0x80U | (byte & 0x3FU));
    }
  }
  return utf8;
}

std::filesystem::path PlainPath(std::string_view written)
{
  std::string name(written);
  std::replace(name.begin(), name.end(), '\\', '/');
  return std::filesystem::path(name).lexically_normal();
}

bool IsBlankOfName(char c)
{
  return blanksOfNames.find(c) != std::string_view::npos;
}

}

bool LeadsOutside(std::string_view written)
{
  const bool drive = written.size() > 1 && written[1] == ':';
  const std::filesystem::path relative = PlainPath(written);
  return drive || relative.is_absolute() || (!relative.empty() && *relative.begin() == "..");
}

std::filesystem::path FileBeside(const std::filesystem::path& base, std::string_view written)
{
  std::filesystem::path relative = PlainPath(written);
  if (LeadsOutside(written))
  {
    relative = relative.filename() == ".." ? "" : relative.filename();
  }
  return base.parent_path() / relative;
}

std::string WhyMissing(std::string_view written, bool isPlural)
{
  constexpr std::string_view scheme = "file:";
  std::string_view name = WithoutQuotes(written);
  name.remove_prefix(name.starts_with(scheme) ? scheme.size() : 0);
  const bool isAddress = name.find("://") != std::string_view::npos;
  if (!isAddress && !LeadsOutside(WithoutEscapes(name)))
  {
    return isPlural ? "are not there" : "is not there";
  }
  return std::string(isPlural ? "lie" : "lies") +
         (isAddress ? " on the web, and nothing is downloaded"
                    : " outside the mesh's folder, and nothing is read there");
}

PictureSource PictureBeside(const std::filesystem::path& file, std::string_view written,
  const std::string& before, const std::string& after)
{
  PictureSource picture;
  picture.file = file;
  const bool isElsewhere = LeadsOutside(WithoutEscapes(WithoutQuotes(written))) && !IsFile(file);
  picture.wrong = isElsewhere ? "it " + WhyMissing(written) : "";
  picture.name =
    before + QuotedText(isElsewhere ? std::string(written) : file.filename().string()) + after;
  return picture;
}

std::string_view WithoutQuotes(std::string_view name)
{
  name = Trimmed(name, blanksOfNames);
  if (name.size() >= 2 && (name.front() == '"' || name.front() == '\'') &&
      name.back() == name.front())
  {
    name = Trimmed(name.substr(1, name.size() - 2), blanksOfNames);
  }
  return name;
}

std::string_view WithoutComment(std::string_view name)
{
  for (std::size_t at = name.find('#'); at != std::string_view::npos; at = name.find('#', at + 1))
  {
    if (at > 0 && IsBlankOfName(name[at - 1]))
    {
      return name.substr(0, at);
    }
  }
  return name;
}

// The lower-case letter of a two-byte letter (Latin, Greek, Cyrillic), as UTF-8; any other
// character is returned unchanged.
std::array<char, 2> SmallLetter(char lead, char next)
{
  static const locale_t unicode = ::newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr);
  const auto letter = static_cast<wint_t>(((lead & 0x1F) << 6) | (next & 0x3F));
  const wint_t small = unicode ? ::towlower_l(letter, unicode) : letter;
  if (small < 0x80 || small >= 0x800)
  {
    return { lead, next };
  }
  return { static_cast<char>(0xC0 | (small >> 6U)), static_cast<char>(0x80 | (small & 0x3FU)) };
}

// A combining mark changes the letter before it into another one. For each mark: the letters that
// it changes, and the results. Only lower-case letters: Latin, Greek and Cyrillic.
struct MarkedLetters
{
  char32_t mark;
  std::u32string_view letters, marked;
};
constexpr std::array markedLetters{
  MarkedLetters{ 0x300, U"aeinou", U"\u00e0\u00e8\u00ec\u01f9\u00f2\u00f9" },
  MarkedLetters{ 0x301, U"aceilnorsuyz\u03b1\u03b5\u03b7\u03b9\u03bf\u03c5\u03c9",
    U"\u00e1\u0107\u00e9\u00ed\u013a\u0144\u00f3\u0155\u015b\u00fa\u00fd\u017a"
    U"\u03ac\u03ad\u03ae\u03af\u03cc\u03cd\u03ce" },
  MarkedLetters{ 0x302, U"aceghijosuwy",
    U"\u00e2\u0109\u00ea\u011d\u0125\u00ee\u0135\u00f4\u015d\u00fb\u0175\u0177" },
  MarkedLetters{ 0x303, U"ainou", U"\u00e3\u0129\u00f1\u00f5\u0169" },
  MarkedLetters{ 0x304, U"aeiou", U"\u0101\u0113\u012b\u014d\u016b" },
  MarkedLetters{
    0x306, U"aegiou\u0438\u0443", U"\u0103\u0115\u011f\u012d\u014f\u016d\u0439\u045e" },
  MarkedLetters{ 0x307, U"cegz", U"\u010b\u0117\u0121\u017c" },
  MarkedLetters{ 0x308, U"aeiouy\u0435\u0456\u03b9\u03c5",
    U"\u00e4\u00eb\u00ef\u00f6\u00fc\u00ff\u0451\u0457\u03ca\u03cb" },
  MarkedLetters{ 0x30a, U"au", U"\u00e5\u016f" },
  MarkedLetters{ 0x30b, U"ou", U"\u0151\u0171" },
  MarkedLetters{ 0x30c, U"cdelnrstz", U"\u010d\u010f\u011b\u013e\u0148\u0159\u0161\u0165\u017e" },
  MarkedLetters{ 0x327, U"cgklnrst", U"\u00e7\u0123\u0137\u013c\u0146\u0157\u015f\u0163" },
  MarkedLetters{ 0x328, U"aeiu", U"\u0105\u0119\u012f\u0173" },
};

// The letter combined with a mark; 0 if there is none. Also handles kana with voiced marks.
char32_t WithMark(char32_t letter, char32_t mark)
{
  const bool isKana = letter > 0x3040 && letter < 0x3100;
  if (isKana && (mark == 0x3099 || mark == 0x309a))
  {
    return letter + (mark - 0x3098);
  }
  for (const MarkedLetters& known : markedLetters)
  {
    const std::size_t at = known.mark == mark ? known.letters.find(letter) : known.letters.npos;
    if (at != known.letters.npos)
    {
      return known.marked[at];
    }
  }
  return 0;
}

// The character at `at`, of at most three bytes, and its length; 0 if there is none.
std::pair<char32_t, std::size_t> CharacterAt(std::string_view text, std::size_t at)
{
  const auto byte = [&](std::size_t i)
  { return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : 0U; };
  const unsigned lead = byte(0);
  const auto isNext = [&](std::size_t i) { return (byte(i) & 0xC0U) == 0x80; };
  if (lead < 0x80)
  {
    return { lead, 1 };
  }
  if (lead >= 0xC2 && lead < 0xE0 && isNext(1))
  {
    return { (lead & 0x1FU) << 6U | (byte(1) & 0x3FU), 2 };
  }
  return lead >= 0xE0 && lead < 0xF0 && isNext(1) && isNext(2)
           ? std::pair<char32_t, std::size_t>(
               (lead & 0xFU) << 12U | (byte(1) & 0x3FU) << 6U | (byte(2) & 0x3FU), 3)
           : std::pair<char32_t, std::size_t>(0, 1);
}

// Combines a letter and a combining mark, as macOS writes names, into one character, as Linux and
// Windows write them.
std::string Composed(const std::string& name)
{
  std::string composed;
  std::size_t letterBegin = 0;
  for (std::size_t at = 0; at < name.size();)
  {
    const auto [character, length] = CharacterAt(name, at);
    const char32_t letter = composed.empty() ? 0 : CharacterAt(composed, letterBegin).first;
    const char32_t made = character >= 0x300 ? WithMark(letter, character) : 0;
    if (made != 0)
    {
      composed.resize(letterBegin);
      if (made >= 0x800)
      {
        composed += static_cast<char>(0xE0U | made >> 12U);
        composed += static_cast<char>(0x80U | (made >> 6U & 0x3FU));
      }
      else
      {
        composed += static_cast<char>(0xC0U | made >> 6U);
      }
      composed += static_cast<char>(0x80U | (made & 0x3FU));
    }
    else
    {
      letterBegin = composed.size();
      composed.append(name, at, length);
    }
    at += length;
  }
  return composed;
}

std::string FoldedName(std::string_view name)
{
  std::string folded;
  for (std::size_t i = 0; i < name.size(); ++i)
  {
    char c = name[i];
    if (const auto byte = static_cast<unsigned char>(c);
        byte >= 0xC2 && byte < 0xE0 && i + 1 < name.size() && (name[i + 1] & 0xC0) == 0x80)
    {
      const std::array<char, 2> small = SmallLetter(c, name[++i]);
      folded.append(small.data(), small.size());
      continue;
    }
    c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c == '\\' ? '/' : c;
    c = IsBlankOfName(c) ? ' ' : c;
    if (c != ' ' || !folded.ends_with(' '))
    {
      folded += c;
    }
  }
  folded.resize(folded.size() - (folded.ends_with(' ') ? 1 : 0));
  return Composed(folded.starts_with(' ') ? folded.substr(1) : folded);
}

const FilesBeside::Names& FilesBeside::NamesOf(const std::filesystem::path& folder)
{
  static const Names none;
  const auto found = this->Folders.find(folder);
  if (found != this->Folders.end())
  {
    return found->second;
  }
  if (this->Folders.size() == mostFolders)
  {
    return none;
  }
  Names& names = this->Folders[folder];
  Result<std::vector<std::string>> read = NamesIn(folder.empty() ? "." : folder);
  if (!read)
  {
    return names;
  }
  read->resize(std::min<std::size_t>(read->size(), mostNames));
  for (const std::string& name : *read)
  {
    const auto [place, added] = names.emplace(FoldedName(name), name);
    place->second = added ? place->second : std::nullopt;
  }
  return names;
}

// Finds a file below base's folder, comparing one part of the path after the other.
std::optional<std::filesystem::path> FilesBeside::FindFolded(const std::filesystem::path& relative)
{
  std::filesystem::path at = this->Base.parent_path();
  for (const std::filesystem::path& part : relative)
  {
    std::error_code failed;
    if (std::filesystem::exists(at / part, failed))
    {
      at /= part;
      continue;
    }
    const Names& names = this->NamesOf(at);
    const auto found = names.find(FoldedName(part.string()));
    if (found == names.end() || !found->second)
    {
      return std::nullopt;
    }
    at /= *found->second;
  }
  return IsFile(at) ? std::optional(at) : std::nullopt;
}

std::filesystem::path FilesBeside::Find(std::string_view written)
{
  const std::string_view name = WithoutQuotes(written);
  const std::string_view bare = WithoutQuotes(WithoutComment(written));
  const std::string unescaped = WithoutEscapes(bare), latin = FromLatin(bare);
  const std::array<std::string_view, 5> forms{ written, name, bare, unescaped, latin };
  for (const std::string_view form : forms)
  {
    const std::filesystem::path file = FileBeside(this->Base, form);
    if (IsFile(file))
    {
      return file;
    }
  }
  for (const std::string_view form : std::span(forms).subspan(1))
  {
    const std::filesystem::path relative =
      FileBeside(this->Base, form).lexically_relative(this->Base.parent_path());
    for (const std::filesystem::path& looked : { relative, relative.filename() })
    {
      if (const auto found = looked.empty() ? std::nullopt : this->FindFolded(looked))
      {
        return *found;
      }
    }
  }
  return FileBeside(this->Base, name);
}

}
