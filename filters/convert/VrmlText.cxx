// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/VrmlText.h"

#include "filters/meshio/QuotedText.h"

#include <algorithm>
#include <map>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::size_t deepestBrackets = 400;
constexpr std::uint64_t mostProtoNodes = 1'000'000;

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

// Nodes without geometry. Files have fields of X3D or of other programs in them, for which the
// parser would refuse the whole file.
bool ShowsNothing(std::string_view type)
{
  constexpr std::string_view types[] = { "Viewpoint", "NavigationInfo", "Background", "Fog",
    "WorldInfo", "TimeSensor", "TouchSensor", "PlaneSensor", "SphereSensor", "CylinderSensor",
    "ProximitySensor", "VisibilitySensor", "PositionInterpolator", "OrientationInterpolator",
    "ScalarInterpolator", "ColorInterpolator" };
  return std::find(std::begin(types), std::end(types), type) != std::end(types);
}

class TextChecker
{
public:
  explicit TextChecker(std::string_view file)
    : File(file)
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
                         "' in line " + std::to_string(this->Open.back().line) + " begins");
    }
    return std::move(this->Out);
  }

private:
  struct Bracket
  {
    char bracket = '{';
    std::uint64_t line = 0;
    std::string type;        // of a node: before its bracket
    std::string defined;     // its DEF
    std::string proto;       // the PROTO whose body this is
    std::size_t textEnd = 0; // of the text up to and with the bracket
  };

  Error Wrong(const std::string& what) const
  {
    return { ErrorCode::InvalidInput, "line " + std::to_string(this->Line) + ": " + what };
  }

  Status TakeHeader()
  {
    if (this->File.starts_with("\xEF\xBB\xBF"))
    {
      this->File.remove_prefix(3);
    }
    if (this->File.starts_with("\xFF\xFE") || this->File.starts_with("\xFE\xFF"))
    {
      return Error{ ErrorCode::InvalidInput, "is UTF-16: save it as UTF-8" };
    }
    const std::size_t text = this->File.find_last_not_of(std::string_view("\0\x1a", 2)) + 1;
    this->Out.padding = this->File.size() - text;
    this->File = this->File.substr(0, text);
    this->Out.isFirst = this->File.starts_with("#VRML V1.0");
    if (!this->Out.isFirst && !this->File.starts_with("#VRML V2.0"))
    {
      return Error{ ErrorCode::InvalidInput, this->File.starts_with("#VRML")
                                               ? "is of another version than VRML 1 and 2"
                                               : "is not a VRML 2 file" };
    }
    const auto* const end = std::find_if(this->File.begin(), this->File.end(), IsVrmlLineEnd);
    this->At = static_cast<std::size_t>(end - this->File.begin());
    this->Out.text.reserve(this->File.size() + secondHeader.size());
    this->Out.text = this->Out.isFirst ? firstHeader : secondHeader;
    if (this->At < this->File.size())
    {
      this->TakeLineEnd(); // the header has it
      this->Out.text.pop_back();
    }
    return {};
  }

  // Of all kinds, written as one.
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
      return this->Wrong("a string begins that does not end");
    }
    ++this->At;
    const bool isUrl = !this->Open.empty() &&
                       std::any_of(this->Open.rbegin(),
                         this->Open.rbegin() + std::min<std::ptrdiff_t>(2, std::ssize(this->Open)),
                         [](const Bracket& bracket)
                         { return bracket.type == "Inline" || bracket.type == "WWWInline"; });
    this->Out.text += '"';
    if (isUrl)
    {
      this->Out.text += std::to_string(this->Out.urls.size());
      this->Out.urls.push_back({ std::move(value), line });
    }
    this->Out.text += '"' + lines;
    this->Forget();
    return {};
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
    if (bracket == '{')
    {
      if (!this->Proto.empty() && this->Open.size() == this->ProtoDepth + 1)
      {
        opened.proto = std::exchange(this->Proto, {});
        this->NodesOf[opened.proto] = 0;
      }
      else
      {
        opened.type = this->Last;
        KDSTREAM_TRY(this->CountNode(opened.type));
      }
      opened.defined = std::exchange(this->Defined, {});
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
    if (ShowsNothing(this->Open.back().type))
    {
      this->Clear(this->Open.back());
    }
    this->Open.pop_back();
    this->Forget();
    this->Out.text += bracket;
    ++this->At;
    return {};
  }

  // Empties a node, but for its line ends: errors name lines.
  void Clear(const Bracket& node)
  {
    const auto begin =
      this->Out.text.begin() + static_cast<std::string::difference_type>(node.textEnd);
    const auto lines = std::count(begin, this->Out.text.end(), '\n');
    this->Out.text.resize(node.textEnd);
    this->Out.text.append(static_cast<std::size_t>(lines), '\n');
  }

  // A node, and what its PROTO makes of it.
  Status CountNode(const std::string& type)
  {
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
    while (this->At < this->File.size() && IsVrmlWord(this->File[this->At]))
    {
      const auto c = static_cast<unsigned char>(this->File[this->At]);
      if (c < ' ' || c == 127)
      {
        return this->Wrong("a control character (byte " + std::to_string(c) + ")");
      }
      ++this->At;
    }
    const std::string_view word = this->File.substr(begin, this->At - begin);
    if (this->RouteWords > 0 || (word == "ROUTE" && this->Last != "DEF" && this->Last != "USE"))
    {
      // ROUTE from TO to
      this->RouteWords = word == "ROUTE" ? 3 : this->RouteWords - 1;
      return {};
    }
    if (word == "EXTERNPROTO")
    {
      return Error{ ErrorCode::Unsupported,
        "line " + std::to_string(this->Line) +
          ": a node is defined by EXTERNPROTO, in another file, which is not read: put the PROTO "
          "into this one" };
    }
    if (this->Last == "PROTO")
    {
      this->Proto = word;
      this->ProtoDepth = this->Open.size();
    }
    else if (this->Last == "DEF")
    {
      this->Defined = word;
    }
    else if (this->Last == "USE" &&
             std::any_of(this->Open.begin(), this->Open.end(),
               [&](const Bracket& bracket) { return bracket.defined == word; }))
    {
      return this->Wrong("the node " + QuotedText(word) + " contains itself (USE)");
    }
    this->Out.hasPictures = this->Out.hasPictures || word == "ImageTexture" ||
                            word == "PixelTexture" || word == "MovieTexture" || word == "Texture2";
    this->Last = word;
    this->Out.text += word;
    return {};
  }

  void Forget() { this->Last.clear(); }

  std::string_view File;
  std::size_t At = 0;
  std::uint64_t Line = 1;
  VrmlText Out;
  std::vector<Bracket> Open;
  std::string Last;           // word
  std::string Defined, Proto; // whose bracket is to come
  std::size_t ProtoDepth = 0; // how many brackets were open at its name
  int RouteWords = 0;
  std::map<std::string, std::uint64_t, std::less<>> NodesOf; // of each PROTO
  std::uint64_t ByProtos = 0;
};

}

Result<VrmlText> CheckVrmlText(std::string_view file)
{
  return TextChecker(file).Check();
}

}
