// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/VtkWords.h"

#include "filters/meshio/ByteSource.h"
#include "filters/meshio/QuotedText.h"

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <iterator>
#include <regex>
#include <string_view>
#include <utility>

namespace kdstream
{
namespace
{

// Messages of the XML parser, and what they mean.
constexpr std::pair<std::string_view, const char*> parserWords[] = {
  { "no element found", "the text ends inside an element" },
  { "unclosed token", "the text ends inside a tag" },
  { "unclosed CDATA section", "the text ends inside a CDATA section" },
  { "partial character", "the text ends inside a character" },
  { "not well-formed (invalid token)", "a character that is not allowed there" },
  { "mismatched tag", "an end tag does not match the open element" },
  { "duplicate attribute", "an attribute appears twice" },
  { "undefined entity", "a name after '&' that is not defined" },
  { "junk after document element", "there is text after the last element" },
  { "XML or text declaration not at start of entity", "the file does not begin with '<?xml'" },
  { "xml declaration not at start of external entity", "the file does not begin with '<?xml'" },
  { "unbound prefix", "a prefix of a name that is not declared" },
  { "unknown encoding", "the encoding that it names is unknown" },
  { "encoding specified in XML declaration is incorrect", "it has another encoding than it names" },
  { "reference to invalid character number", "a number after '&#' that is not a character" },
  { "syntax error", "no tag begins there" },
};

constexpr std::size_t mostSearched = std::size_t{ 64 } << 20;

// " (line 12)", the line of a piece's element, or of this element's array of that name; empty if it
// is not found.
std::string LineOfElement(const std::filesystem::path& file, const std::string& piece,
  const std::string& element, const std::string& array = {})
{
  Result<ByteSource> source = ByteSource::Open(file);
  if (!source)
  {
    return {};
  }
  std::string text;
  while (text.size() < mostSearched)
  {
    const Result<std::string_view> block = source->Peek(ByteSource::blockSize);
    if (!block || block->empty())
    {
      break;
    }
    text += *block;
    source->Consume(block->size());
  }
  std::size_t at = 0;
  const auto go = [&](const std::string& to)
  { at = at == std::string::npos ? at : text.find(to, at); };
  for (long count = std::strtol(piece.c_str(), nullptr, 10); count >= 0; --count)
  {
    go("<Piece");
    at += at == std::string::npos ? 0 : 1;
  }
  if (!element.empty())
  {
    go("<" + element);
  }
  if (!array.empty())
  {
    go("Name=\"" + array + "\"");
  }
  return at == std::string::npos
           ? std::string()
           : " (line " +
               std::to_string(1 + std::count(text.begin(),
                                    text.begin() + static_cast<std::ptrdiff_t>(at), '\n')) +
               ")";
}

// "Polys of piece 0 (line 12): ", to begin a message.
std::string PlaceOfElement(const std::filesystem::path& file, const std::string& piece,
  const std::string& element, const std::string& array = {})
{
  return "<" + element + "> of piece " + piece + LineOfElement(file, piece, element, array) + ": ";
}

// What is wrong with an array of cells, from the end of VTK's sentence.
std::string WrongWithArray(std::string_view end)
{
  const auto has = [&](std::string_view words) { return end.find(words) != end.npos; };
  return has("not long enough")   ? "has fewer numbers than the piece counts, or is damaged"
         : has("monotonically")   ? "has a number that is smaller than the one before it"
         : has("could not be fo") ? "is not there"
                                  : "has a type or a number of components that is not allowed";
}

using OurWords = std::function<std::string(const std::smatch&, const std::filesystem::path&)>;

struct Phrase
{
  std::regex theirs;
  bool hasPlace; // the message names the place itself
  OurWords ours;
};

// form: a format for std::match_results::format.
OurWords Words(const char* form)
{
  return [form](const std::smatch& match, const std::filesystem::path&)
  { return match.format(form); };
}

const std::vector<Phrase>& Phrases()
{
  static const std::vector<Phrase> all = {
    { std::regex("parsing XML in stream at line (\\d+), column (\\d+)[^:]*: (.*)"), true,
      [](const std::smatch& m, const std::filesystem::path&)
      {
        const std::string reason = m[3];
        const auto* const found = std::find_if(std::begin(parserWords), std::end(parserWords),
          [&](const auto& words) { return reason.starts_with(words.first); });
        return "line " + m[1].str() + ", column " + m[2].str() + ": " +
               (found == std::end(parserWords) ? "it is not XML there" : found->second);
      } },
    { std::regex("Cannot read points array from (\\w+) in piece (\\d+)"), true,
      [](const std::smatch& m, const std::filesystem::path& file)
      {
        return PlaceOfElement(file, m[2], m[1]) +
               "its array has fewer numbers than NumberOfPoints counts, or is damaged";
      } },
    { std::regex("from (\\w+) in piece (\\d+) because the \"(\\w+)\" array(.*)"), true,
      [](const std::smatch& m, const std::filesystem::path& file)
      {
        return PlaceOfElement(file, m[2], m[1], m[3]) + "its array '" + m[3].str() + "' " +
               WrongWithArray(m[4].str());
      } },
    { std::regex("Cannot read \\w+ data array \"(.*)\" from (\\w+) in piece (\\d+)"), true,
      [](const std::smatch& m, const std::filesystem::path& file)
      {
        return PlaceOfElement(file, m[3], m[2], m[1]) + "its array " + QuotedText(m[1].str()) +
               " has fewer numbers than the piece counts, or is damaged";
      } },
    { std::regex("Cannot find (\\w+) element in file"), true, Words("it has no element <$1>") },
    { std::regex("Piece (\\d+) is missing its (\\w+) attribute"), true,
      [](const std::smatch& m, const std::filesystem::path& file)
      {
        const std::string line = LineOfElement(file, m[1], "");
        return line.empty() ? std::string("it has no <Piece>")
                            : "<Piece> " + m[1].str() + line + " has no " + m[2].str();
      } },
    { std::regex("missing its Points element"), true,
      Words("a <Piece> has no <Points>, or not one array in it") },
    { std::regex("No Points element available"), true, Words("its first <Piece> has no <Points>") },
    { std::regex("(connectivity|offsets) array missing from (\\w+)", std::regex::icase), true,
      Words("<$2> has no array '$1'") },
    { std::regex("Unsupported (\\w+)=\"(.*)\""), true,
      [](const std::smatch& m, const std::filesystem::path&)
      { return m[1].str() + " is " + QuotedText(m[2].str()) + ", which is not known"; } },
    { std::regex("Error creating (\\w+)"), true,
      [](const std::smatch& m, const std::filesystem::path&)
      { return "it is compressed by " + QuotedText(m[1].str()) + ", which is not known"; } },
    { std::regex("Compressor has no type"), true, Words("its compressor is not named") },
    { std::regex("Unknown data type \"(.*)\""), true,
      [](const std::smatch& m, const std::filesystem::path&)
      { return "an array has the type " + QuotedText(m[1].str()) + ", which is not known"; } },
    { std::regex("Unsupported data type"), true, Words("an array has an unknown type") },
    { std::regex("(ompression header|binary data header)"), false,
      Words("a block of its bytes ends inside its header, or its header is damaged") },
  };
  return all;
}

}

std::string XmlDamage(std::span<const std::string> errors, const std::filesystem::path& file)
{
  std::string ours = "one of its arrays or elements cannot be read";
  for (const std::string& error : errors)
  {
    for (const Phrase& phrase : Phrases())
    {
      std::smatch match;
      if (std::regex_search(error, match, phrase.theirs))
      {
        ours = phrase.ours(match, file);
        if (phrase.hasPlace)
        {
          return ours;
        }
      }
    }
  }
  return ours;
}

Error DamagedVtk(const std::string& part)
{
  return { ErrorCode::InvalidInput, "is damaged, or is not as its header says: " + part };
}

std::string VtkWarning(const std::string& warning)
{
  static const std::pair<std::regex, const char*> words[] = {
    { std::regex("file version|File version"),
      "has a newer version of the format than this program knows: what that version adds is not "
      "read" },
    { std::regex("data array named (\\S+) already exists"), "a second array $1 is dropped" },
    { std::regex("named (\\S+) was tagged as an IdType array"),
      "array $1 is read as numbers, not as ids" },
    { std::regex("Failed creating array named (\\S+)"),
      "dropped: array $1, whose type is not known" },
    { std::regex("First character in AppendedData"),
      "its appended data do not begin with '_': what follows the first one is read" },
    { std::regex("No geometry defined|No points read|No topology read"), "" },
    { std::regex("InformationKey|information|INFORMATION|key "), "" },
  };
  for (const auto& [theirs, ours] : words)
  {
    std::smatch match;
    if (std::regex_search(warning, match, theirs))
    {
      return match.format(ours);
    }
  }
  return "its reader does not know all of it: compare the result with what you expect";
}

}
