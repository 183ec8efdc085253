// SPDX-License-Identifier: BSD-3-Clause
// The field's words. A search of the product code for a term of the field finds the code for it. No
// identifier uses a word that was replaced by such a term (doc/design.md#words), in C++ or in
// JavaScript; JavaScript of tests is checked, too. A search of the documents for terms of the field
// finds a page.
#include "Testing/Documents/References.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <regex>

namespace
{

using namespace kdstream;

bool IsJavaScript(const std::string& path)
{
  return (path.ends_with(".js") || path.ends_with(".mjs")) &&
         !path.starts_with("viewer/mobile/web/words/"); // translations
}

bool IsProductCode(const std::string& path)
{
  return (path.starts_with("filters/") || path.starts_with("server/") ||
           path.starts_with("viewer/")) &&
         path.find("/Testing/") == std::string::npos &&
         (path.ends_with(".h") || path.ends_with(".cxx") || IsJavaScript(path));
}

bool IsOfName(char c)
{
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
}

// The end of a string, character or template that begins at `at`, after its closing mark; also of a
// raw string. Only templates may continue over lines.
std::size_t EndOfQuoted(const std::string& text, std::size_t at)
{
  const char mark = text[at];
  if (mark == '"' && at > 0 && text[at - 1] == 'R')
  {
    const std::size_t open = text.find('(', at);
    const std::string close = ")" + text.substr(at + 1, open - at - 1) + "\"";
    const std::size_t end = text.find(close, open);
    return end == std::string::npos ? text.size() : end + close.size();
  }
  for (++at; at < text.size() && text[at] != mark && (mark == '`' || text[at] != '\n'); ++at)
  {
    at += text[at] == '\\' ? 1 : 0;
  }
  return std::min(at + 1, text.size());
}

// A source without its comments, strings, characters and templates.
std::string CodeOf(const std::string& text)
{
  std::string code;
  for (std::size_t at = 0; at < text.size();)
  {
    if (text.compare(at, 2, "//") == 0)
    {
      at = std::min(text.find('\n', at), text.size());
    }
    else if (text.compare(at, 2, "/*") == 0)
    {
      const std::size_t end = text.find("*/", at + 2);
      at = end == std::string::npos ? text.size() : end + 2;
      code += ' ';
    }
    else if (text[at] == '"' || text[at] == '`' ||
             (text[at] == '\'' && (at == 0 || !IsOfName(text[at - 1]))))
    {
      at = EndOfQuoted(text, at);
      code += ' ';
    }
    else
    {
      code += text[at++];
    }
  }
  return code;
}

// JavaScript without keys that may stay: those of JSON, of messages and of the page's status. They
// stand after a point or before a colon.
std::string WithoutKeys(const std::string& code)
{
  static const std::regex keys(
    R"re(\.(deed|lamp|gliding)\b|\b(deed|lamp|secondLamp|gliding)\s*:)re");
  return std::regex_replace(code, keys, " ");
}

// The words of all identifiers, in lower case: of "SetPrefetchBytes", set, prefetch, bytes.
std::set<std::string> WordsOf(const std::string& code)
{
  std::set<std::string> words;
  std::string word;
  const auto end = [&]
  {
    words.insert(word);
    word.clear();
  };
  for (std::size_t at = 0; at < code.size(); ++at)
  {
    const auto c = static_cast<unsigned char>(code[at]);
    const bool begins =
      std::isupper(c) && at > 0 && std::islower(static_cast<unsigned char>(code[at - 1]));
    if (!std::isalpha(c) || begins)
    {
      end();
    }
    if (std::isalpha(c))
    {
      word += static_cast<char>(std::tolower(c));
    }
  }
  end();
  words.erase("");
  return words;
}

using Pair = std::array<const char*, 2>;

// Words that were replaced, and the words that replace them.
const Pair retired[] = { { "errand", "task" }, { "talk", "connection, stream" },
  { "owed", "outstanding" }, { "owes", "outstanding" }, { "debt", "outstanding request" },
  { "hurry", "retry now" }, { "fleeting", "no-store" }, { "seat", "connection slot" },
  { "team", "rank group" }, { "deed", "command, action" }, { "hollow", "ambient occlusion" },
  { "hollows", "ambient occlusion" }, { "lamp", "light" }, { "lamps", "lights" },
  { "untangle", "repair fold-overs" }, { "untangling", "fold-over repair" },
  { "glide", "geomorph" }, { "glides", "geomorphs" }, { "gliding", "morphing" },
  { "surroundings", "environment" }, { "pose", "home view" }, { "deviations", "geometric errors" },
  { "came", "arrived, received" }, { "former", "parent, earlier" },
  { "painted", "textured, coloured" }, { "silence", "idle timeout" }, { "mend", "repair" },
  { "mended", "repaired" }, { "told", "reported, specified" }, { "untold", "unreported" } };

// Makes a regular expression of each term: its words may be separated by nothing, by "-", or by the
// end of a comment's line.
const char* const terms[] = { "frustum", "level of detail", "screen-space error", "remaining error",
  "geometric error", "geomorph", "fold-over", "ambient occlusion", "occlusion", "prefetch",
  "in flight", "outstanding", "backoff", "rate limit", "stall timeout", "cancel", "hysteresis",
  "connection slot", "rank group", "collective", "scatter", "dependency", "visibility",
  "mixed-resolution", "home view", "immutable", "no-store", "view-dependent refinement",
  "memory budget", "bandwidth", "thread pool", "graceful shutdown", "path traversal",
  "non-manifold", "texture atlas", "anti-aliased", "localization", "clipping plane",
  "quadric error", "checkpoint" };

// What strangers may search the site of documents for.
const char* const searches[] = { "frustum culling", "level of detail", "LOD selection",
  "screen-space error", "geometric error", "geomorph", "hysteresis", "ambient occlusion",
  "prefetch", "in flight", "backoff", "rate limit", "memory budget", "progressive mesh",
  "mesh compression", "mesh simplification", "quadric-error", "edge collapse", "bounding volume",
  "out of core", "ghost", "point cloud", "laser scan", "texture atlas", "clipping plane",
  "watertight", "non-manifold", "graceful shutdown", "path traversal", "denial of service",
  "reverse proxy", "load balancing", "CDN", "CORS", "custom element", "headless", "draco",
  "meshopt" };

std::regex ExpressionOf(const std::string& term)
{
  return std::regex(
    std::regex_replace(term, std::regex("[ -]"), "[-_ ]?(\\n *(//|\\*)? *)?"), std::regex::icase);
}

TEST(Words, AreThoseOfIdentifiers)
{
  EXPECT_EQ(WordsOf(CodeOf("int SetSeatOf(x1'000); // lamp\nconst char* a = \"debt\"; /* owed */"
                           "auto b = R\"x(team \" )x\", '\\'' + isTold;")),
    (std::set<std::string>{
      "int", "set", "seat", "of", "x", "const", "char", "a", "auto", "b", "r", "is", "told" }));
}

TEST(Words, AreThoseOfJavaScriptButForKeys)
{
  EXPECT_EQ(WordsOf(WithoutKeys(
              CodeOf("const team = `told\n${debt}` + data.deed; f({ lamp: x, deed }); // seat"))),
    (std::set<std::string>{ "const", "team", "data", "f", "x", "deed" }));
}

TEST(Words, TermsMayBePartedByLines)
{
  EXPECT_TRUE(std::regex_search("// a stall\n  // timeout", ExpressionOf("stall timeout")));
  EXPECT_TRUE(std::regex_search("double stallTimeout", ExpressionOf("stall timeout")));
  EXPECT_FALSE(std::regex_search("a stalled timeout", ExpressionOf("stall timeout")));
}

TEST(Words, ThatWereReplacedAreInNoIdentifier)
{
  std::size_t sources = 0, scripts = 0;
  for (const auto& [path, text] : ReadSourceTree(KDSTREAM_SOURCE_TREE).texts)
  {
    const bool isScript = IsJavaScript(path);
    if (isScript || IsProductCode(path))
    {
      ++(isScript ? scripts : sources);
      const std::string code = CodeOf(text);
      const std::set<std::string> words = WordsOf(isScript ? WithoutKeys(code) : code);
      for (const auto& [old, now] : retired)
      {
        EXPECT_FALSE(words.contains(old))
          << path << ": \"" << old << "\" in an identifier; say " << now;
      }
    }
  }
  EXPECT_GT(sources, 500U) << "not the tree of this project";
  EXPECT_GT(scripts, 80U) << "not the tree of this project";
}

// Phrases that had to be read twice must not occur. The list has the English sentences, and the
// translations of the page after "=>".
TEST(Words, OfMessagesArePlain)
{
  const std::regex phrases(
    R"re(\b(that|which) (is|are) none\b|\bso many\b|\btold\b|\bin vain\b|)re"
    R"re(\bbehind\b|\bmeanwhile\b|\bnot (as many|carried)\b|\bas many as are\b|)re"
    R"re(\bof VTK's\b|\b(was|were) not there when\b)re");
  EXPECT_TRUE(std::regex_search("a number of elements that is none", phrases));
  std::ifstream list(std::string(KDSTREAM_SOURCE_TREE) + "/Testing/Documents/Messages.txt");
  std::size_t sentences = 0;
  for (std::string line; std::getline(list, line); ++sentences)
  {
    const std::string english = line.substr(0, line.find(" => "));
    EXPECT_FALSE(std::regex_search(english, phrases)) << english;
  }
  EXPECT_GT(sentences, 2000U) << "not the list of messages";
}

TEST(Words, OfTheFieldAreFoundInProductCode)
{
  const SourceTree tree = ReadSourceTree(KDSTREAM_SOURCE_TREE);
  for (const char* term : terms)
  {
    const std::regex expression = ExpressionOf(term);
    EXPECT_TRUE(std::any_of(tree.texts.begin(), tree.texts.end(),
      [&](const auto& each)
      { return IsProductCode(each.first) && std::regex_search(each.second, expression); }))
      << "no product code says \"" << term << "\"";
  }
}

TEST(Words, OfTheFieldAreFoundInDocuments)
{
  const SourceTree tree = ReadSourceTree(KDSTREAM_SOURCE_TREE);
  const auto isDocument = [](const std::string& path)
  {
    return path == "README.md" || (path.starts_with("doc/") && path.ends_with(".md") &&
                                    !path.starts_with("doc/decisions/"));
  };
  for (const char* term : searches)
  {
    const std::regex expression = ExpressionOf(term);
    EXPECT_TRUE(std::any_of(tree.texts.begin(), tree.texts.end(),
      [&](const auto& each)
      { return isDocument(each.first) && std::regex_search(each.second, expression); }))
      << "no document says \"" << term << "\"";
  }
}

}
