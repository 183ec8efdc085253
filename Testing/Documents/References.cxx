// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. every document's anchors, sections and titles
// 2. the links of documents
// 3. the words of documents, and of the comments of sources: each word that looks like a reference
//    is looked up.
#include "Testing/Documents/References.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <iterator>
#include <string_view>

namespace kdstream
{
namespace
{

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 8> topFolders{ "Data", "Examples", "Testing", "cmake", "doc",
  "filters", "server", "viewer" };
constexpr std::array<std::string_view, 5> sourceEndings{ ".h", ".cxx", ".js", ".mjs", ".cmake" };
// Scripts fetch this folder: it is not in a clone.
constexpr std::string_view fetchedModels = "Data/models";

template <class Names>
bool EndsWithOneOf(std::string_view text, const Names& endings)
{
  return std::any_of(endings.begin(), endings.end(),
    [&](std::string_view ending) { return text.size() > ending.size() && text.ends_with(ending); });
}

bool IsDocument(std::string_view path)
{
  return path.size() > 3 && path.ends_with(".md");
}

bool IsRead(std::string_view path)
{
  return IsDocument(path) || EndsWithOneOf(path, sourceEndings) ||
         path.ends_with("CMakeLists.txt") || path == "dev";
}

// Folders that a clone does not have.
bool IsLeftOut(const fs::path& folder, std::string_view path)
{
  const std::string name = folder.filename().string();
  return name == ".git" || name == "node_modules" || path == "build" || path == "out" ||
         path == fetchedModels || fs::exists(folder / "CMakeCache.txt");
}

bool IsWordCharacter(char c)
{
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '/' ||
         c == '-';
}

std::vector<std::string_view> LinesOf(std::string_view text)
{
  std::vector<std::string_view> lines;
  while (!text.empty())
  {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

std::string_view TrimLeft(std::string_view text)
{
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  return text;
}

// Replaces the text between two marks, and the marks, by blanks, so that everything after it keeps
// its place. A mark without an end stays.
void BlankBetween(std::string& text, std::string_view open, std::string_view close)
{
  for (std::size_t at = text.find(open); at != std::string::npos; at = text.find(open, at + 1))
  {
    const std::size_t end = text.find(close, at + open.size());
    if (end != std::string::npos)
    {
      for (std::size_t i = at; i < end + close.size(); ++i)
      {
        text[i] = text[i] == '\n' ? '\n' : ' ';
      }
    }
  }
}

// Removes code from a document. Blocks of code begin and end with a line of ```.
std::string WithoutCode(std::string text)
{
  BlankBetween(text, "```", "```");
  BlankBetween(text, "`", "`");
  return text;
}

// The comments of a source as running text, because sentences continue over line ends. `lineAt` has
// the line of each character.
struct RunningText
{
  std::string text;
  std::vector<std::size_t> lineAt;

  void Append(std::string_view words, std::size_t line)
  {
    this->text.append(words).push_back(' ');
    this->lineAt.resize(this->text.size(), line);
  }
};

// The comment in a line of a source: the whole line, or its end after the code.
std::string_view CommentOf(std::string_view line, std::string_view mark)
{
  const std::string_view begin = TrimLeft(line);
  if (mark == "//" && (begin.starts_with("*") || begin.starts_with("/*")))
  {
    return TrimLeft(begin.substr(begin.find_first_not_of("/*") == std::string_view::npos
                                   ? begin.size()
                                   : begin.find_first_not_of("/*")));
  }
  const std::size_t at = line.find(mark);
  return at == std::string_view::npos ? std::string_view{}
                                      : TrimLeft(line.substr(at + mark.size()));
}

RunningText CommentsOf(std::string_view path, std::string_view text)
{
  const bool script = path.ends_with("CMakeLists.txt") || path.ends_with(".cmake") || path == "dev";
  RunningText comments;
  std::size_t number = 0;
  for (const std::string_view line : LinesOf(text))
  {
    comments.Append(CommentOf(line, script ? "#" : "//"), ++number);
  }
  return comments;
}

RunningText ProseOf(std::string text)
{
  // Targets of links are checked elsewhere; addresses in the web are not checked.
  BlankBetween(text, "](", ")");
  for (const std::string_view scheme : { "https:", "http:" })
  {
    BlankBetween(text, scheme, " ");
  }
  RunningText prose;
  std::size_t number = 0;
  for (const std::string_view line : LinesOf(text))
  {
    prose.Append(line, ++number);
  }
  return prose;
}

// The parts of a document that can be cited.
struct Document
{
  std::set<std::string> anchors;
  std::set<std::string> sections; // "3" of "3. Symbols"
  std::set<std::string> titles;   // headings without numbers, and bold words that begin a line
};

void AddHeading(std::string heading, Document& document)
{
  std::string anchor = AnchorOfHeading(heading);
  for (unsigned again = 1; !document.anchors.insert(anchor).second; ++again)
  {
    anchor = AnchorOfHeading(heading) + "-" + std::to_string(again);
  }
  const std::size_t digits = heading.find_first_not_of("0123456789");
  if (digits != std::string::npos && digits > 0 && heading[digits] == '.')
  {
    document.sections.insert(heading.substr(0, digits));
    heading = TrimLeft(std::string_view(heading).substr(digits + 1));
  }
  document.titles.insert(heading);
}

Document Understand(const std::string& text)
{
  Document document;
  std::string prose = text;
  BlankBetween(prose, "```", "```");
  for (const std::string_view line : LinesOf(prose))
  {
    const std::size_t level = std::min(line.find_first_not_of('#'), line.size());
    if (level > 0 && level < line.size() && line[level] == ' ')
    {
      AddHeading(std::string(TrimLeft(line.substr(level))), document);
    }
    const std::size_t bold = line.starts_with("**") ? line.find("**", 2) : std::string_view::npos;
    if (bold != std::string_view::npos)
    {
      const std::string_view words = line.substr(2, bold - 2);
      document.titles.emplace(words.substr(0, words.find_last_not_of(".:") + 1));
    }
  }
  for (const std::string_view mark : { "<a id=\"", "<a name=\"" })
  {
    for (std::size_t at = prose.find(mark); at != std::string::npos; at = prose.find(mark, at + 1))
    {
      const std::size_t begin = at + mark.size();
      document.anchors.insert(prose.substr(begin, prose.find('"', begin) - begin));
    }
  }
  return document;
}

class ReferenceFinder
{
public:
  explicit ReferenceFinder(const SourceTree& tree)
    : Tree(tree)
  {
    for (const auto& [path, text] : tree.texts)
    {
      if (IsDocument(path))
      {
        this->Documents.emplace(path, Understand(text));
      }
      if (path.ends_with("CMakeLists.txt") || path.ends_with(".cmake"))
      {
        this->BuildFiles += text;
      }
    }
    for (const std::string& path : tree.paths)
    {
      this->Names.insert(fs::path(path).filename().string());
      this->Names.insert(fs::path(path).stem().string());
    }
  }

  std::vector<std::string> Find()
  {
    for (const auto& [path, text] : this->Tree.texts)
    {
      this->File = path;
      if (IsDocument(path))
      {
        this->CheckLinks(text);
        this->CheckWords(ProseOf(text));
      }
      else
      {
        this->CheckWords(CommentsOf(path, text));
      }
    }
    return std::move(this->Dead);
  }

private:
  void Report(std::size_t line, const std::string& what)
  {
    this->Dead.push_back(this->File + ":" + std::to_string(line) + ": " + what);
  }

  bool Exists(const std::string& path) const { return this->Tree.paths.count(path) > 0; }

  std::string FromFile(const std::string& target) const
  {
    const std::string path =
      (fs::path(this->File).parent_path() / target).lexically_normal().string();
    return path.ends_with("/") ? path.substr(0, path.size() - 1) : path;
  }

  void CheckLinks(const std::string& whole)
  {
    const std::string text = WithoutCode(whole);
    for (std::size_t at = text.find("]("); at != std::string::npos; at = text.find("](", at + 1))
    {
      const std::size_t end = text.find_first_of(") \n", at + 2);
      const std::string target = text.substr(at + 2, end - at - 2);
      const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<long>(at), '\n');
      if (target.find(':') == std::string::npos) // not https:, not mailto:
      {
        this->CheckLink(target, static_cast<std::size_t>(line));
      }
    }
  }

  void CheckLink(const std::string& target, std::size_t line)
  {
    const std::size_t hash = std::min(target.find('#'), target.size());
    const std::string path = hash == 0 ? this->File : this->FromFile(target.substr(0, hash));
    if (!this->Exists(path))
    {
      this->Report(line, "link to " + target + ": there is no " + path);
    }
    else if (hash < target.size())
    {
      this->CheckAnchor(path, target.substr(hash + 1), line);
    }
  }

  void CheckAnchor(const std::string& path, const std::string& anchor, std::size_t line)
  {
    const auto document = this->Documents.find(path);
    if (document == this->Documents.end() || document->second.anchors.count(anchor) == 0)
    {
      this->Report(line, path + " has no heading for #" + anchor);
    }
  }

  void CheckWords(const RunningText& running)
  {
    const std::string_view text = running.text;
    for (std::size_t at = 0; at < text.size(); ++at)
    {
      std::size_t end = at;
      while (end < text.size() && IsWordCharacter(text[end]))
      {
        ++end;
      }
      if (end > at)
      {
        this->CheckWord(text.substr(at, end - at), text.substr(end), running.lineAt[at]);
        at = end;
      }
    }
  }

  void CheckWord(std::string_view word, std::string_view after, std::size_t line)
  {
    // Of a pattern such as "Codec.{h,cxx}" or "*.h", only the folder is checked.
    if (!after.empty() && (after[0] == '{' || after[0] == '*' || after[0] == '<'))
    {
      word = word.substr(0, std::min(word.rfind('/'), word.size()));
    }
    while (!word.empty() && (word.back() == '.' || word.back() == '/' || word.back() == '-'))
    {
      word.remove_suffix(1);
      after = {}; // the next word begins another sentence
    }
    const std::string name(word);
    if (IsDocument(name))
    {
      this->CheckCitation(name, after, line);
    }
    else if (name == "decision" || name == "Decision" || name == "decisions")
    {
      this->CheckDecision(TrimLeft(after), line);
    }
    else if (name == "DESIGN" && !IsDocument(this->File))
    {
      this->Report(line, "DESIGN is not a document of this tree: doc/design.md#… is");
    }
    else
    {
      this->CheckName(name, line);
    }
  }

  // A source cites a document by its path from the root; a document may cite it by the end of that
  // path.
  void CheckCitation(const std::string& name, std::string_view after, std::size_t line)
  {
    const auto document =
      IsDocument(this->File)
        ? std::find_if(this->Documents.begin(), this->Documents.end(),
            [&](const auto& each) { return ("/" + each.first).ends_with("/" + name); })
        : this->Documents.find(name);
    if (document == this->Documents.end())
    {
      this->Report(line, "there is no " + name);
      return;
    }
    if (after.starts_with("#"))
    {
      const std::string_view rest = after.substr(1);
      const auto end = std::find_if_not(rest.begin(), rest.end(), IsWordCharacter);
      std::string anchor(rest.begin(), end);
      while (anchor.ends_with("."))
      {
        anchor.pop_back();
      }
      this->CheckAnchor(document->first, anchor, line);
      return;
    }
    if (!after.starts_with(", ") && !after.starts_with(" ("))
    {
      return;
    }
    after.remove_prefix(2);
    if (after.starts_with("section"))
    {
      after.remove_prefix(std::min(after.find_first_of("0123456789"), after.size()));
      const std::string section(after.substr(0, after.find_first_not_of("0123456789")));
      if (document->second.sections.count(section) == 0)
      {
        this->Report(line, document->first + " has no section " + section);
      }
    }
    else if (after.starts_with("\""))
    {
      const std::string title(after.substr(1, after.find('"', 1) - 1));
      if (document->second.titles.count(title) == 0)
      {
        this->Report(line, document->first + " has no \"" + title + "\"");
      }
    }
  }

  void CheckDecision(std::string_view after, std::size_t line)
  {
    const std::string number(after.substr(0, after.find_first_not_of("0123456789")));
    if (number.empty())
    {
      return;
    }
    const std::string begin = "doc/decisions/" +
                              std::string(4 - std::min<std::size_t>(number.size(), 4), '0') +
                              number + "-";
    const auto found = this->Tree.paths.lower_bound(begin);
    if (found == this->Tree.paths.end() || !found->starts_with(begin))
    {
      this->Report(line, "there is no decision " + number);
    }
  }

  // Checks a path, or the name of a source or a test, if the word looks like one. A name that
  // begins with vtk may belong to VTK.
  void CheckName(const std::string& name, std::size_t line)
  {
    const std::size_t slash = name.find('/');
    const bool inTopFolder =
      slash != std::string::npos && std::find(topFolders.begin(), topFolders.end(),
                                      std::string_view(name).substr(0, slash)) != topFolders.end();
    if (inTopFolder || (EndsWithOneOf(name, sourceEndings) && !name.starts_with("vtk")))
    {
      if (!this->IsEndOfAPath(name) && !name.starts_with(fetchedModels))
      {
        this->Report(line, "there is no " + name);
      }
    }
    else if (name.starts_with("Test") && name.size() > 4 &&
             std::isupper(static_cast<unsigned char>(name[4])) != 0 && slash == std::string::npos)
    {
      if (this->Names.count(name) == 0 && this->BuildFiles.find(name) == std::string::npos)
      {
        this->Report(line, "there is no test " + name);
      }
    }
  }

  bool IsEndOfAPath(const std::string& name) const
  {
    if (name.find('/') == std::string::npos)
    {
      return this->Names.count(name) > 0;
    }
    return this->Exists(name) ||
           std::any_of(this->Tree.paths.begin(), this->Tree.paths.end(),
             [end = "/" + name](const std::string& path) { return path.ends_with(end); });
  }

  const SourceTree& Tree;
  std::map<std::string, Document> Documents;
  std::set<std::string> Names; // of files, with and without their endings
  std::string BuildFiles;      // their text; they also name tests that have no source
  std::string File;            // the file that is being checked
  std::vector<std::string> Dead;
};

}

SourceTree ReadSourceTree(const fs::path& root)
{
  SourceTree tree;
  for (auto entry = fs::recursive_directory_iterator(root); entry != fs::end(entry); ++entry)
  {
    const std::string path = entry->path().lexically_relative(root).generic_string();
    if (entry->is_directory() && IsLeftOut(entry->path(), path))
    {
      entry.disable_recursion_pending();
      continue;
    }
    tree.paths.insert(path);
    if (entry->is_regular_file() && IsRead(path))
    {
      std::ifstream file(entry->path(), std::ios::binary);
      tree.texts[path] = { std::istreambuf_iterator<char>(file), {} };
    }
  }
  return tree;
}

std::string AnchorOfHeading(const std::string& heading)
{
  std::string text = heading;
  // Only the text of a link is part of the anchor.
  BlankBetween(text, "](", ")");
  std::string anchor;
  for (const char c : text.substr(0, text.find_last_not_of(' ') + 1))
  {
    const auto byte = static_cast<unsigned char>(c);
    if (c == ' ')
    {
      anchor += '-';
    }
    else if (std::isalnum(byte) != 0 || c == '-' || c == '_' || byte >= 0x80)
    {
      anchor += static_cast<char>(std::tolower(byte));
    }
  }
  return anchor;
}

std::vector<std::string> FindDeadReferences(const SourceTree& tree)
{
  return ReferenceFinder(tree).Find();
}

}
