// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/VrmlText.h"

#include "filters/meshio/NumberText.h"
#include "filters/meshio/QuotedText.h"
#include "filters/meshio/TextWords.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::size_t deepestBrackets = 400, deepestUses = 1000;
constexpr std::uint64_t mostProtoNodes = 1'000'000;
constexpr std::size_t noText = ~std::size_t{ 0 };

constexpr std::string_view secondHeader = "#VRML V2.0 utf8\n", firstHeader = "#VRML V1.0 ascii\n";

bool IsVrmlLineEnd(char c)
{
  return c == '\n' || c == '\r';
}

bool IsVrmlBlank(char c)
{
  return c == ' ' || c == '\t' || c == ',' || IsVrmlLineEnd(c);
}

bool IsVrmlWord(char c)
{
  return !IsVrmlBlank(c) && c != '"' && c != '#' && c != '{' && c != '}' && c != '[' && c != ']';
}

// Whether this is a texture node. Textures are not read, whatever a file says about them.
bool IsTexture(std::string_view type)
{
  return type == "ImageTexture" || type == "PixelTexture" || type == "MovieTexture" ||
         type == "Texture2";
}

// Whether this node has no geometry. Files use fields of X3D or of other programs in such nodes,
// and the parser would refuse the whole file because of these fields.
bool ShowsNothing(std::string_view type)
{
  constexpr std::string_view types[] = { "Viewpoint", "NavigationInfo", "Background", "Fog",
    "WorldInfo", "TimeSensor", "TouchSensor", "PlaneSensor", "SphereSensor", "CylinderSensor",
    "ProximitySensor", "VisibilitySensor", "PositionInterpolator", "OrientationInterpolator",
    "ScalarInterpolator", "ColorInterpolator" };
  return std::find(std::begin(types), std::end(types), type) != std::end(types);
}

// Whether a word means NaN or infinity, as programs of several systems print it: nan, -inf,
// nan(ind), 1.#QNAN, -1.#IND.
bool IsNotFiniteWord(std::string_view word)
{
  std::string small(word.substr(word.starts_with('-') || word.starts_with('+') ? 1 : 0));
  std::transform(small.begin(), small.end(), small.begin(),
    [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return small.starts_with("1.#") || small == "nan" || small.starts_with("nan(") ||
         small == "inf" || small == "infinity";
}

// Whether a whole number does not fit into 32 bits: the parser would keep only the lower bits.
bool IsTooLargeWholeNumber(std::string_view word)
{
  std::int32_t value = 0;
  word.remove_prefix(word.starts_with('+') ? 1 : 0);
  if (word.starts_with("0x") || word.starts_with("0X"))
  {
    constexpr std::size_t digits = 8; // a number of 32 bits
    const std::size_t first = word.find_first_not_of('0', 2);
    return first != word.npos && word.size() - first > digits;
  }
  const auto read = std::from_chars(word.data(), word.data() + word.size(), value);
  return read.ec == std::errc::result_out_of_range;
}

// Whether the word is a whole number below -1.
bool IsNegativeIndex(std::string_view word)
{
  std::int32_t value = 0;
  const auto read = std::from_chars(word.data(), word.data() + word.size(), value);
  return read.ec == std::errc() && read.ptr == word.data() + word.size() && value < -1;
}

// Whether "-1." continues with "#IND" or the like, which is then not a comment.
bool GoesOnAsNotFinite(std::string_view word, std::string_view after)
{
  constexpr std::string_view kinds[] = { "#IND", "#QNAN", "#SNAN", "#INF" };
  return (word == "1." || word == "-1." || word == "+1.") &&
         std::any_of(std::begin(kinds), std::end(kinds),
           [&](std::string_view kind)
           {
             const char next = after.size() > kind.size() ? after[kind.size()] : ' ';
             return after.starts_with(kind) && ((next >= '0' && next <= '9') || !IsVrmlWord(next));
           });
}

// A name that the parser accepts (VRML97, A.3; in VRML 1 only letters, digits, _ and +). Each other
// character becomes _ and two hexadecimal digits.
std::string NameForParser(std::string_view name, bool isFirst)
{
  std::string made;
  for (const char c : name)
  {
    constexpr std::string_view notFirst = "0123456789+-", never = "#'.\\()";
    const bool isWord = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' ||
                        (!made.empty() && c >= '0' && c <= '9');
    const bool isTaken = isFirst ? isWord || c == '+'
                                 : never.find(c) == std::string_view::npos &&
                                     (!made.empty() || notFirst.find(c) == std::string_view::npos);
    if (isTaken)
    {
      made += c;
      continue;
    }
    constexpr std::string_view digits = "0123456789abcdef";
    const auto byte = static_cast<unsigned char>(c);
    made += { '_', digits[byte >> 4U], digits[byte & 15U] };
  }
  return made;
}

// How many floats make up a value of a field type, as a PROTO names it (SFVec3f); 0 for all other
// types.
std::size_t WidthOfType(std::string_view type)
{
  constexpr std::pair<std::string_view, std::size_t> widths[] = { { "Float", 1 }, { "Vec2f", 2 },
    { "Vec3f", 3 }, { "Color", 3 }, { "Rotation", 4 } };
  const bool isField = type.starts_with("SF") || type.starts_with("MF");
  const auto* const found = std::find_if(std::begin(widths), std::end(widths),
    [&](const auto& width) { return isField && type.substr(2) == width.first; });
  return found == std::end(widths) ? 0 : found->second;
}

class TextChecker
{
public:
  TextChecker(std::string_view file, const VrmlLibrary& library)
    : File(file)
    , Library(library)
  {
  }

  Result<VrmlText> Check()
  {
    KDSTREAM_TRY(this->TakeHeader());
    while (this->At < this->File.size())
    {
      KDSTREAM_TRY(this->Step());
    }
    if (!this->Open.empty())
    {
      return this->Wrong("ends inside what a '" + std::string(1, this->Open.back().bracket) +
                           "' in line " + std::to_string(this->Open.back().line) + " begins",
        Remedy::CopyAgain);
    }
    this->Out.floatsSuffice = this->Precision.FloatsSuffice();
    return std::move(this->Out);
  }

private:
  struct Bracket
  {
    char bracket = '{';
    std::uint64_t line = 0;
    std::string type;                  // word before the bracket: a node's type or a field
    std::size_t defined = 0;           // number of the DEF that names it
    std::string name;                  // the name that DEF gives it
    std::string proto;                 // for the body of a PROTO: its name in the output
    std::string protoName;             // the name of that PROTO in the file
    std::size_t textEnd = 0;           // end of the output, after the bracket
    bool isLeftOut = false;            // a node that is left out
    bool isOfProto = false;            // a node that a PROTO makes
    bool hasKnownFields = false;       // all fields of the node are known
    bool isFieldNamed = false;         // the last word is the name of a field
    bool hasChildren = false;          // there was a field `children`
    bool isListOpen = false;           // a list was opened for nodes without a field
    std::size_t noFieldBegin = noText; // output offset of an unknown field
    std::size_t firstNodeEnd = noText; // body of a PROTO: output offset after the first node
    std::size_t height = 0;            // nesting depth of its content
  };

  // The node of a name; set from its DEF on.
  struct Definition
  {
    std::size_t number = 0;
    std::size_t height = 0; // known after the node's end
  };
  using Definitions = std::map<std::string, Definition, std::less<>>;

  Error Wrong(const std::string& what, Remedy remedy = Remedy::Unknown) const
  {
    return BadInput("line " + std::to_string(this->Line) + ": " + what, remedy);
  }

  Status TakeHeader()
  {
    if (this->File.starts_with("\xEF\xBB\xBF"))
    {
      this->File.remove_prefix(3);
    }
    if (this->File.starts_with("\xFF\xFE") || this->File.starts_with("\xFE\xFF"))
    {
      return BadInput("is UTF-16: save it as UTF-8", Remedy::InMessage);
    }
    const std::size_t text = this->File.find_last_not_of(std::string_view("\0\x1a", 2)) + 1;
    const auto zeros =
      std::count(this->File.begin() + static_cast<std::ptrdiff_t>(text), this->File.end(), '\0');
    this->Out.tolerance.Count(Lapse::PaddedEnd, static_cast<std::uint64_t>(zeros));
    this->File = this->File.substr(0, text);
    const std::string head = LowercaseText(this->File.substr(0, secondHeader.size()));
    this->Out.isFirst = head.starts_with("#vrml v1.0");
    if (!this->Out.isFirst && !head.starts_with("#vrml v2.0"))
    {
      return head.starts_with("#vrml")
               ? BadInput("has another version than VRML 1 and 2", Remedy::SaveOtherwise)
               : BadInput("is not a VRML file: its first line does not begin with '#VRML'",
                   Remedy::Rename);
    }
    const auto* const end = std::find_if(this->File.begin(), this->File.end(), IsVrmlLineEnd);
    this->At = static_cast<std::size_t>(end - this->File.begin());
    this->Out.text.reserve(this->File.size() + secondHeader.size());
    this->Out.text = this->Out.isFirst ? firstHeader : secondHeader;
    if (this->At < this->File.size())
    {
      this->TakeLineEnd(); // firstHeader already has a line break
      this->Out.text.pop_back();
    }
    return {};
  }

  // Takes a line break of any kind; each is written as one '\n'.
  void TakeLineEnd()
  {
    const bool two = this->File.substr(this->At).starts_with("\r\n");
    this->At += two ? 2 : 1;
    this->Out.text += '\n';
    ++this->Line;
  }

  Status Step()
  {
    const char c = this->File[this->At];
    if (IsVrmlLineEnd(c))
    {
      this->TakeLineEnd();
    }
    else if (c == '#')
    {
      while (this->At < this->File.size() && !IsVrmlLineEnd(this->File[this->At]))
      {
        ++this->At;
      }
    }
    else if (c == '"')
    {
      return this->TakeString();
    }
    else if (c == '{' || c == '[')
    {
      return this->OpenBracket(c);
    }
    else if (c == '}' || c == ']')
    {
      return this->CloseBracket(c);
    }
    else if (IsVrmlBlank(c))
    {
      this->Out.text += c;
      ++this->At;
    }
    else
    {
      return this->TakeWord();
    }
    return {};
  }

  Status TakeString()
  {
    const std::uint64_t line = this->Line;
    std::string value;
    std::string lines;
    for (++this->At; this->At < this->File.size() && this->File[this->At] != '"'; ++this->At)
    {
      char c = this->File[this->At];
      if (c == '\\' && this->At + 1 < this->File.size())
      {
        c = this->File[++this->At];
      }
      if (c == '\n' || (c == '\r' && !this->File.substr(this->At + 1).starts_with("\n")))
      {
        lines += '\n';
        ++this->Line;
      }
      value += c;
    }
    if (this->At == this->File.size())
    {
      this->Line = line;
      return this->Wrong("a string has no closing quote");
    }
    ++this->At;
    this->Out.text += '"';
    if (this->MayBeUrl())
    {
      this->Out.text += vrmlUrlBegin + std::to_string(this->Out.urls.size());
      this->Out.urls.push_back({ std::move(value), line });
    }
    this->Out.text += '"' + lines;
    this->EndValue();
    this->Forget();
    this->EndExtern();
    return {};
  }

  // Whether the field may be the url of an Inline, set directly or through a field of a PROTO.
  bool MayBeUrl() const
  {
    return (!this->Proto.empty() && this->Open.size() > this->ProtoDepth) ||
           std::any_of(this->Open.rbegin(),
             this->Open.rbegin() + std::min<std::ptrdiff_t>(2, std::ssize(this->Open)),
             [&](const Bracket& bracket)
             {
               return bracket.type == "Inline" || bracket.type == "WWWInline" ||
                      (bracket.bracket == '{' && this->NodesOf.contains(bracket.type));
             });
  }

  // Ends EXTERNPROTO Name [ … ] "url", or [ "url" … ]: all of it is removed, because its nodes are
  // in another file.
  void EndExtern()
  {
    if (this->Extern && this->Open.size() == this->Extern->depth && ++this->Extern->ended == 2)
    {
      this->Clear(this->Extern->textBegin);
      this->Extern.reset();
    }
  }

  Status OpenBracket(char bracket)
  {
    if (this->Open.size() == deepestBrackets)
    {
      return this->Wrong("nodes are nested deeper than " + std::to_string(deepestBrackets));
    }
    Bracket& opened = this->Open.emplace_back();
    opened.bracket = bracket;
    opened.line = this->Line;
    opened.type = this->Last;
    if (bracket == '{')
    {
      if (!this->Proto.empty() && this->Open.size() == this->ProtoDepth + 1)
      {
        opened.type.clear();
        opened.proto = std::exchange(this->Proto, {});
        opened.protoName = std::exchange(this->ProtoName, {});
        this->NodesOf[opened.proto] = 0;
        this->Scopes.emplace_back();
        this->Hidden.emplace_back();
      }
      else
      {
        this->TakeProtoName(opened);
        KDSTREAM_TRY(this->CountNode(opened.type));
        this->LeaveOut(opened);
      }
      opened.name = std::exchange(this->Defined, {});
      if (!opened.name.empty())
      {
        opened.defined = this->Scopes.back()[opened.name].number = ++this->DefinedNodes;
      }
    }
    else if (this->Open.size() > 1)
    {
      const Bracket& node = this->Open[this->Open.size() - 2];
      this->LookForCommas(this->WidthOf(node, opened.type), opened.type, this->At + 1);
    }
    this->Last.clear();
    this->Out.text += bracket;
    opened.textEnd = this->Out.text.size();
    ++this->At;
    return {};
  }

  Status CloseBracket(char bracket)
  {
    if (this->Open.empty() || (this->Open.back().bracket == '{') != (bracket == '}'))
    {
      return this->Wrong("a '" + std::string(1, bracket) + "' closes nothing");
    }
    const Bracket closed = std::move(this->Open.back());
    this->Open.pop_back();
    if (this->Extern && this->Open.size() < this->Extern->depth)
    {
      this->Extern.reset(); // an outer bracket closes before it ends
    }
    if (closed.noFieldBegin != noText)
    {
      this->Clear(closed.noFieldBegin);
    }
    this->Out.text += closed.isListOpen ? "]" : "";
    if (closed.isLeftOut ||
        (bracket == '}' && (ShowsNothing(closed.type) || IsTexture(closed.type))))
    {
      this->Clear(closed.textEnd);
    }
    // Only the first node in the body of a PROTO is shown (VRML97, 4.8.3).
    if (!closed.proto.empty() && closed.firstNodeEnd != noText)
    {
      this->Clear(closed.firstNodeEnd);
    }
    this->Out.text += bracket;
    ++this->At;
    if (bracket == '}' && closed.proto.empty() && !this->Open.empty() &&
        !this->Open.back().proto.empty() && this->Open.back().firstNodeEnd == noText)
    {
      this->Open.back().firstNodeEnd = this->Out.text.size();
    }
    this->EndValue();
    const std::size_t height = closed.height + (bracket == '}' ? 1 : 0);
    if (!closed.proto.empty())
    {
      this->Scopes.pop_back();
      this->HeightOf[closed.proto] = height;
      this->EndProto(closed);
    }
    else
    {
      if (const auto found = this->Scopes.back().find(closed.name);
          found != this->Scopes.back().end() && found->second.number == closed.defined)
      {
        found->second.height = height;
      }
      KDSTREAM_TRY(this->Hold(height));
    }
    this->Forget();
    this->EndExtern();
    return {};
  }

  // A new name for a PROTO if the file declares its name again: the library would use the first
  // PROTO for all nodes. The nodes that follow, and the PROTO's own body, get the new name, too.
  std::string NameOfProto(std::string_view name)
  {
    std::string written(name);
    if (!this->NodesOf.contains(written))
    {
      return written;
    }
    const auto found = this->ProtoNames.find(name);
    const bool isSecond = found != this->ProtoNames.end() && !found->second.written.empty() &&
                          found->second.scope == this->Hidden.size();
    if (isSecond && !std::exchange(this->HasProtoTwice, true))
    {
      this->Out.tolerance.Tell("a second PROTO " + QuotedText(name) + " (line " +
                               std::to_string(this->Line) + "): nodes after it take that one");
    }
    while (this->NodesOf.contains(written))
    {
      written = std::string(name) + "_" + std::to_string(++this->ProtosNamed);
    }
    return written;
  }

  // If the node is an instance of a PROTO of this file, replaces its type by the PROTO's name in
  // the output.
  void TakeProtoName(Bracket& node)
  {
    const auto found = this->ProtoNames.find(node.type);
    node.isOfProto = found != this->ProtoNames.end() && !found->second.written.empty();
    if (node.isOfProto && found->second.written != node.type)
    {
      this->Out.text.replace(this->LastBegin, node.type.size(), found->second.written);
      node.type = found->second.written;
    }
  }

  // From here to the end of the scope, `name` means the PROTO with the output name `written`; if
  // this is empty, no PROTO.
  void DeclareProto(const std::string& name, const std::string& written)
  {
    NamedProto& proto = this->ProtoNames[name];
    this->Hidden.back().emplace_back(
      name, std::exchange(proto, NamedProto{ written, this->Hidden.size() }));
  }

  // Ends the declarations made in the body of a PROTO.
  void EndProto(const Bracket& body)
  {
    const auto inside = std::move(this->Hidden.back());
    this->Hidden.pop_back();
    std::for_each(inside.rbegin(), inside.rend(),
      [&](const auto& hidden) { this->ProtoNames[hidden.first] = hidden.second; });
    this->DeclareProto(body.protoName, body.proto);
  }

  // Records how deep the content of a bracket is nested.
  Status Hold(std::size_t height)
  {
    if (height > deepestUses)
    {
      return this->Wrong(
        "nodes that are used again (USE) are nested deeper than " + std::to_string(deepestUses));
    }
    if (!this->Open.empty())
    {
      this->Open.back().height = std::max(this->Open.back().height, height);
    }
    return {};
  }

  // Removes the output from `begin` on, but keeps line breaks, because errors name lines.
  void Clear(std::size_t begin)
  {
    const auto lines =
      std::count(this->Out.text.begin() + static_cast<std::string::difference_type>(begin),
        this->Out.text.end(), '\n');
    this->Out.text.resize(begin);
    this->Out.text.append(static_cast<std::size_t>(lines), '\n');
  }

  // Turns a node of an unknown kind into an empty group.
  void LeaveOut(Bracket& node)
  {
    const bool isExtern = this->Externs.contains(node.type);
    node.hasKnownFields = node.isOfProto;
    if (node.type.empty() || node.isOfProto)
    {
      return;
    }
    if (!isExtern && this->Library.isNode(node.type, this->Out.isFirst))
    {
      node.hasKnownFields = node.type != "Script";
      return;
    }
    const std::string_view next = this->NextWord(this->At + 1);
    if (this->Out.isFirst && (next == "fields" || next == "isA"))
    {
      return; // the node declares its own fields
    }
    node.isLeftOut = true;
    this->Out.text.replace(this->LastBegin, node.type.size(), "Group");
    const bool isInside = std::any_of(this->Open.begin(), this->Open.end() - 1,
      [](const Bracket& outer) { return outer.isLeftOut || ShowsNothing(outer.type); });
    if (!isInside && !ShowsNothing(node.type))
    {
      VrmlLeftOut& left =
        this->Out.leftOut[QuotedText(node.type) +
                          (isExtern ? ", which EXTERNPROTO takes from another file"
                            : this->NodesOf.contains(node.type)
                              ? ", which is a PROTO only within the body of another"
                              : ", which VRML does not have")];
      left.line = left.count++ == 0 ? this->Line : left.line;
    }
  }

  // The next word or bracket, after blanks and comments.
  std::string_view NextWord(std::size_t at) const
  {
    while (at < this->File.size() && (IsVrmlBlank(this->File[at]) || this->File[at] == '#'))
    {
      const bool isComment = this->File[at] == '#';
      for (++at; isComment && at < this->File.size() && !IsVrmlLineEnd(this->File[at]);)
      {
        ++at;
      }
    }
    std::size_t end = at;
    while (end < this->File.size() && IsVrmlWord(this->File[end]))
    {
      ++end;
    }
    return this->File.substr(at, std::max<std::size_t>(end - at, 1));
  }

  // Leaves out unknown fields with their values: everything up to the next field or, in VRML 1, to
  // the next node.
  void LookForField(std::string_view word)
  {
    if (this->Open.empty() || this->Extern)
    {
      return;
    }
    if (!this->Open.back().hasKnownFields)
    {
      this->LookInInterface(word);
      return;
    }
    Bracket& node = this->Open.back();
    const char first = word.front();
    const bool isWord =
      (first >= 'a' && first <= 'z') || (first >= 'A' && first <= 'Z') || first == '_';
    constexpr std::string_view others[] = { "TRUE", "FALSE", "NULL", "IS", "DEF", "USE", "PROTO",
      "EXTERNPROTO" };
    const std::string_view next = isWord ? this->NextWord(this->At) : std::string_view();
    const bool isChild = next == "{" || word == "DEF" || word == "USE";
    const bool wasNamed = std::exchange(node.isFieldNamed, false);
    const bool isValue = wasNamed && !isChild;
    if (this->Out.isFirst && isChild)
    {
      this->EndField(node);
    }
    if (!this->Out.isFirst && word != "DEF" && this->Last == "DEF")
    {
      node.isFieldNamed = wasNamed; // the node itself follows
    }
    else if (!this->Out.isFirst && isChild)
    {
      if (!wasNamed)
      {
        this->TakeNodeWithoutField(node, word);
      }
      node.isFieldNamed = word == "DEF";
    }
    if (!isWord || isValue || isChild || word.back() == ')' || this->Last == "DEF" ||
        this->Last == "USE" || this->Last == "IS" || this->Last == "PROTO" ||
        std::find(std::begin(others), std::end(others), word) != std::end(others))
    {
      return;
    }
    if (word == "fields" || word == "isA")
    {
      node.hasKnownFields = false; // the node declares its own fields
      return;
    }
    this->EndField(node);
    node.isFieldNamed = true;
    node.hasChildren = node.hasChildren || word == "children";
    if (next != "[")
    {
      this->LookForCommas(this->WidthOf(node, std::string(word)), std::string(word), this->At);
    }
    const std::string_view other =
      next == "IS" && !this->Out.isFirst
        ? this->NextWord(static_cast<std::size_t>(next.data() - this->File.data()) + next.size())
        : std::string_view();
    if (this->IsEventOfProto(other))
    {
      node.noFieldBegin = this->Out.text.size(); // events are not needed: nothing is animated
    }
    else if (const std::optional<std::string> wrong = this->WrongField(node, word, other))
    {
      node.noFieldBegin = this->Out.text.size();
      this->CountField(QuotedText(word) + " of " + QuotedText(node.type) + " (line " +
                       std::to_string(this->Line) + ")" + *wrong);
    }
  }

  struct ProtoField
  {
    std::size_t width = 0; // of a value, in floats
    bool isEvent = false;
  };

  // Handles a word in the interface of a PROTO: the name of a field follows its type.
  void LookInInterface(std::string_view word)
  {
    const Bracket& interface = this->Open.back();
    if (interface.bracket != '[' || this->Proto.empty())
    {
      return;
    }
    const std::string field(word);
    if (this->Last.starts_with("SF") || this->Last.starts_with("MF"))
    {
      this->ProtoFields[this->Proto][field] = { WidthOfType(this->Last), this->IsEvent };
    }
    else if (word == "field" || word == "exposedField" || word == "eventIn" || word == "eventOut")
    {
      this->IsEvent = word.starts_with("event");
    }
    if (this->NextWord(this->At) != "[")
    {
      this->LookForCommas(this->WidthOf(interface, field), field, this->At);
    }
  }

  // The PROTO's field of this name, or null. An exposedField t is also called set_t and t_changed.
  const ProtoField* FieldOfProto(const std::string& proto, std::string_view field) const
  {
    const auto fields = this->ProtoFields.find(proto);
    if (fields == this->ProtoFields.end())
    {
      return nullptr;
    }
    constexpr std::string_view set = "set_", changed = "_changed";
    auto found = fields->second.find(field);
    if (found == fields->second.end() && field.starts_with(set))
    {
      found = fields->second.find(field.substr(set.size()));
    }
    else if (found == fields->second.end() && field.ends_with(changed))
    {
      found = fields->second.find(field.substr(0, field.size() - changed.size()));
    }
    return found == fields->second.end() ? nullptr : &found->second;
  }

  bool HasField(const Bracket& node, std::string_view field) const
  {
    return node.isOfProto
             ? this->FieldOfProto(node.type, field) != nullptr
             : this->Library.hasField(node.type, std::string(field), this->Out.isFirst);
  }

  // The innermost open body of a PROTO; null outside of all of them.
  const Bracket* ProtoBody() const
  {
    const auto found = std::find_if(this->Open.rbegin(), this->Open.rend(),
      [](const Bracket& bracket) { return !bracket.proto.empty(); });
    return found == this->Open.rend() ? nullptr : &*found;
  }

  bool IsEventOfProto(std::string_view field) const
  {
    const Bracket* const body = field.empty() ? nullptr : this->ProtoBody();
    const ProtoField* const found = body ? this->FieldOfProto(body->proto, field) : nullptr;
    return found && found->isEvent;
  }

  // What is wrong with a field, so that it is left out; nothing if it is right. other: if the field
  // IS a field of the PROTO, the name of that field.
  std::optional<std::string> WrongField(
    const Bracket& node, std::string_view field, std::string_view other) const
  {
    const Bracket* const body = this->ProtoBody();
    const std::string is = ", which IS " + QuotedText(other);
    if (!other.empty() && !body)
    {
      return is + " outside of a PROTO";
    }
    const ProtoField* const found =
      other.empty() ? nullptr : this->FieldOfProto(body->proto, other);
    if (!other.empty() && !found)
    {
      return is + ", but its PROTO " + QuotedText(body->protoName) + " has no such field";
    }
    const std::size_t width = this->WidthOf(node, std::string(field));
    if (found && width > 0 && width != found->width)
    {
      return is + ", a field of another type";
    }
    return this->HasField(node, field) ? std::nullopt : std::optional<std::string>("");
  }

  // The number of floats in a value of a field; 0 for fields of other types, and for texture
  // coordinates, which are not read.
  std::size_t WidthOf(const Bracket& node, const std::string& field) const
  {
    if (node.hasKnownFields && !node.isOfProto)
    {
      return node.type.starts_with("TextureCoordinate")
               ? 0
               : this->Library.widthOf(node.type, field, this->Out.isFirst);
    }
    const ProtoField* const found =
      this->FieldOfProto(node.bracket == '[' ? this->Proto : node.type, field);
    return found ? found->width : 0;
  }

  // Finds out what commas mean in the numbers of a field, which begin at `begin`.
  void LookForCommas(std::size_t width, const std::string& field, std::size_t begin)
  {
    VrmlNumbers numbers{ width, this->File[begin - 1] == '[', 0 };
    if (width == 0)
    {
      return;
    }
    if (field == "height")
    {
      numbers.all = this->WholeNumberOf("xDimension") * this->WholeNumberOf("zDimension");
    }
    const VrmlCommaReading read = ReadVrmlCommas(this->File.substr(begin), numbers);
    const std::string place = QuotedText(field) + " (line " + std::to_string(this->Line) + ")";
    if (read.commas == VrmlCommas::Decimal)
    {
      this->CommasEnd = begin + read.size;
      if (!std::exchange(this->HasDecimalCommas, true))
      {
        this->Out.tolerance.Tell(
          "commas are taken as decimal commas, as in 1,5; the first in " + place);
      }
    }
    else if (read.commas == VrmlCommas::Either && !std::exchange(this->HasOtherCommas, true))
    {
      this->Out.tolerance.Tell(
        "commas between digits are taken to separate numbers; the first in " + place +
        ", where they could be decimal commas");
    }
  }

  // The value of a field of the open node, whether it comes before its list or after; 0 if it is
  // not given.
  std::size_t WholeNumberOf(std::string_view field) const
  {
    std::size_t begin = this->File.rfind('{', this->At);
    const std::size_t end = std::min(this->File.find('}', this->At), this->File.size());
    begin = begin == std::string_view::npos ? 0 : begin;
    const std::string_view node = this->File.substr(begin, end - begin);
    const std::size_t at = node.find(field);
    std::string_view rest = node.substr(std::min(at, node.size()));
    kdstream::TakeWord(rest);
    std::size_t number = 0;
    constexpr std::size_t most = 1U << 31U;
    return ParseNumber(kdstream::TakeWord(rest), number) == NumberTextError::None && number < most
             ? number
             : 0;
  }

  bool IsDecimalComma(std::size_t at) const
  {
    const auto isDigit = [&](std::size_t k)
    { return k < this->File.size() && this->File[k] >= '0' && this->File[k] <= '9'; };
    return at < this->CommasEnd && this->File[at] == ',' && isDigit(at - 1) && isDigit(at + 1);
  }

  // Counts an unknown field, unless an outer node is left out as a whole.
  void CountField(const std::string& place)
  {
    const bool isInside = std::any_of(
      this->Open.begin(), this->Open.end(), [](const Bracket& outer) { return outer.isLeftOut; });
    this->Out.tolerance.Count(Lapse::FieldNotKnown, isInside ? 0 : 1, place);
  }

  // Handles a node in a place where a field name is expected. It counts as a child of the outer
  // node, if that may have children; else it is left out.
  void TakeNodeWithoutField(Bracket& node, std::string_view word)
  {
    if (node.isListOpen)
    {
      return;
    }
    this->EndField(node);
    const std::string place = QuotedText(word) + " of " + QuotedText(node.type) + " (line " +
                              std::to_string(this->Line) + ")";
    if (this->Library.holdsNodes(node.type))
    {
      return;
    }
    if (node.hasChildren || !this->HasField(node, "children"))
    {
      node.noFieldBegin = this->Out.text.size();
      this->CountField(place + ", a node without a field");
      return;
    }
    if (!std::exchange(this->HasNodesWithoutField, true))
    {
      this->Out.tolerance.Tell(
        place + " is where a field's name is expected: it is read as a child of the node");
    }
    node.isListOpen = true;
    node.hasChildren = true;
    this->Out.text += "children [ ";
  }

  // Ends the value of a field, a string or a bracket; after this comes the name of the next field.
  void EndValue()
  {
    if (!this->Open.empty())
    {
      this->Open.back().isFieldNamed = false;
    }
  }

  void EndField(Bracket& node)
  {
    this->Out.text += std::exchange(node.isListOpen, false) ? "] " : "";
    if (node.noFieldBegin != noText)
    {
      this->Clear(std::exchange(node.noFieldBegin, noText));
    }
  }

  // Counts a node, and the nodes that its PROTO makes.
  Status CountNode(const std::string& type)
  {
    if (const auto made = this->HeightOf.find(type); made != this->HeightOf.end())
    {
      KDSTREAM_TRY(this->Hold(made->second));
    }
    const auto found = this->NodesOf.find(type);
    const std::uint64_t nodes = 1 + (found == this->NodesOf.end() ? 0 : found->second);
    std::uint64_t* total = &this->ByProtos;
    for (const Bracket& bracket : this->Open)
    {
      if (!bracket.proto.empty())
      {
        if (bracket.proto == type)
        {
          return this->Wrong("the PROTO " + QuotedText(type) + " contains itself");
        }
        total = &this->NodesOf[bracket.proto];
      }
    }
    *total += nodes > 1 || total != &this->ByProtos ? nodes : 0;
    if (*total > mostProtoNodes)
    {
      return Error{ ErrorCode::LimitExceeded, "line " + std::to_string(this->Line) +
                                                ": PROTOs make more than " +
                                                std::to_string(mostProtoNodes) + " nodes of it" };
    }
    return {};
  }

  Status TakeWord()
  {
    const std::size_t begin = this->At;
    while (this->At < this->File.size() &&
           (IsVrmlWord(this->File[this->At]) || this->IsDecimalComma(this->At) ||
             GoesOnAsNotFinite(
               this->File.substr(begin, this->At - begin), this->File.substr(this->At, 6))))
    {
      const auto c = static_cast<unsigned char>(this->File[this->At]);
      if (c < ' ' || c == 127)
      {
        return this->Wrong("a control character (byte " + std::to_string(c) + ")");
      }
      ++this->At;
    }
    std::string_view word = this->File.substr(begin, this->At - begin);
    std::string withPoint;
    if (begin < this->CommasEnd && word.find(',') != word.npos)
    {
      withPoint = word;
      std::replace(withPoint.begin(), withPoint.end(), ',', '.');
      word = withPoint;
    }
    // ROUTE from TO to; and X3D's EXPORT node AS name.
    const bool isExport = this->Open.empty() && (word == "EXPORT" || word == "AS");
    const int after = word == "ROUTE" ? 3 : isExport ? 1 : 0;
    if (this->RouteWords > 0 || (after > 0 && this->Last != "DEF" && this->Last != "USE"))
    {
      this->RouteWords = after > 0 ? after : this->RouteWords - 1;
      return {};
    }
    const bool isName = this->Last == "DEF" || this->Last == "USE";
    if (word == "EXTERNPROTO" && !isName)
    {
      this->Extern = { this->Out.text.size(), this->Open.size() };
    }
    if (this->Last == "EXTERNPROTO")
    {
      this->Externs.emplace(word);
      this->DeclareProto(std::string(word), {});
    }
    this->LookForField(word);
    std::string written(word);
    if (isName)
    {
      written = NameForParser(word, this->Out.isFirst);
    }
    else if (!this->Open.empty() && this->Open.back().bracket == '[' &&
             (this->Open.back().type == "point" || this->Open.back().type == "height"))
    {
      this->Precision.Add(word);
      written = IsNotFiniteWord(word)                      ? vrmlNotFinite
                : word.find('#') != std::string_view::npos ? "nan" // the parser refuses this
                                                           : written;
    }
    else if (word.find('#') != std::string_view::npos)
    {
      written = "nan"; // the parser refuses this
    }
    else if (this->IsWholeNumberField() && IsTooLargeWholeNumber(word))
    {
      return this->Wrong(QuotedText(word) + " is too large for an index or a count");
    }
    else if (this->IsIndexInList() && IsNegativeIndex(word))
    {
      return this->Wrong(QuotedText(word) + " is not an index, and only -1 ends a face");
    }
    if (const std::string plain = WithPlainExponent(word); !isName && !plain.empty())
    {
      written = plain;
    }
    if (this->Last == "PROTO")
    {
      const bool isPlain = written == word; // otherwise the parser refuses the name
      written = isPlain ? this->NameOfProto(word) : written;
      this->Proto = isPlain ? written : std::string(word);
      this->ProtoName = word;
      this->ProtoDepth = this->Open.size();
    }
    else if (this->Last == "DEF")
    {
      this->Defined = word;
    }
    else if (this->Last == "USE")
    {
      const Result<bool> used = this->Use(word);
      KDSTREAM_TRY(used);
      if (!*used)
      {
        const bool isInList = this->Open.back().bracket == '[';
        this->Out.text.replace(this->LastBegin, this->Last.size(), isInList ? "" : "NULL");
        written.clear();
      }
    }
    this->Out.hasPictures = this->Out.hasPictures || IsTexture(word);
    this->Last = word;
    this->LastBegin = this->Out.text.size();
    this->Out.text += written;
    return {};
  }

  // Whether the field has whole numbers that decide what is shown.
  bool IsWholeNumberField() const
  {
    const bool isInList = !this->Open.empty() && this->Open.back().bracket == '[';
    const std::string_view field = isInList ? std::string_view(this->Open.back().type) : this->Last;
    return field.ends_with("Index") || field == "whichChoice" || field == "whichChild" ||
           field == "xDimension" || field == "zDimension" || field == "numPoints";
  }

  bool IsIndexInList() const
  {
    return !this->Open.empty() && this->Open.back().bracket == '[' &&
           std::string_view(this->Open.back().type).ends_with("Index");
  }

  // Whether the USE can stay. A Script may refer to the nodes around it, even to itself, because it
  // shows nothing: such a USE is removed.
  Result<bool> Use(std::string_view name)
  {
    const auto found = this->Scopes.back().find(name);
    if (found == this->Scopes.back().end())
    {
      return true;
    }
    if (std::any_of(this->Open.begin(), this->Open.end(),
          [&](const Bracket& bracket) { return bracket.defined == found->second.number; }))
    {
      if (std::any_of(this->Open.begin(), this->Open.end(),
            [](const Bracket& bracket) { return bracket.type == "Script"; }))
      {
        return false;
      }
      return this->Wrong("the node " + QuotedText(name) + " contains itself (USE)");
    }
    KDSTREAM_TRY(this->Hold(found->second.height));
    return true;
  }

  void Forget() { this->Last.clear(); }

  struct ExternProto
  {
    std::size_t textBegin = 0; // output offset where it begins
    std::size_t depth = 0;     // how many brackets were open there
    int ended = 0;             // how many of its two lists have ended: fields, urls
  };

  std::string_view File;
  const VrmlLibrary& Library;
  std::size_t At = 0;
  std::uint64_t Line = 1;
  VrmlText Out;
  DecimalPrecision Precision;
  std::vector<Bracket> Open;
  std::string Last;           // the last word
  std::size_t LastBegin = 0;  // offset of Last in the output
  std::string Defined, Proto; // names for the next bracket
  std::string ProtoName;      // Proto's name in the file
  std::size_t ProtoDepth = 0; // how many brackets were open at Proto's name
  int RouteWords = 0;
  std::map<std::string, std::uint64_t, std::less<>> NodesOf; // how many nodes each PROTO makes
  std::map<std::string, std::size_t, std::less<>> HeightOf;  // how deep each PROTO is nested
  std::uint64_t ByProtos = 0;
  std::optional<ExternProto> Extern;
  std::set<std::string, std::less<>> Externs;
  std::vector<Definitions> Scopes{ 1 }; // of the file, and of each open body of a PROTO
  struct NamedProto
  {
    std::string written;   // its name in the output; empty: no PROTO
    std::size_t scope = 0; // number of the declaring scope, from 1
  };
  // PROTOs by their names in the file; and for each scope, the PROTOs that its own have hidden.
  std::map<std::string, NamedProto, std::less<>> ProtoNames;
  std::vector<std::vector<std::pair<std::string, NamedProto>>> Hidden{ 1 };
  std::uint64_t ProtosNamed = 0;
  bool HasProtoTwice = false; // whether this was reported
  std::size_t DefinedNodes = 0;
  bool HasNodesWithoutField = false; // whether this was reported
  std::map<std::string, std::map<std::string, ProtoField, std::less<>>, std::less<>> ProtoFields;
  bool IsEvent = false;                                  // the last word: eventIn or eventOut
  std::size_t CommasEnd = 0;                             // end of the numbers with decimal commas
  bool HasDecimalCommas = false, HasOtherCommas = false; // whether they were reported
};

}

Result<VrmlText> CheckVrmlText(std::string_view file, const VrmlLibrary& library)
{
  return TextChecker(file, library).Check();
}

}
