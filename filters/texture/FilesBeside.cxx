// SPDX-License-Identifier: BSD-3-Clause
// The files that a mesh names: see FilesBeside.h.
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

// "a%20b" is "a b".
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

// Latin-1, whose letters are those of Windows' code page 1252, as UTF-8.
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
         (isAddress ? " on the web, from which nothing is read"
                    : " outside the mesh's folder, where nothing is read");
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

// The small letter of one of two bytes (Latin, Greek, Cyrillic), as UTF-8; else the same.
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
  return folded.starts_with(' ') ? folded.substr(1) : folded;
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

// A file in base's folder, part by part.
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
