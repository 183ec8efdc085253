// SPDX-License-Identifier: BSD-3-Clause
#include "filters/texture/ObjMaterials.h"

#include "filters/core/Texts.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/ObjStatements.h"
#include "filters/meshio/QuotedText.h"
#include "filters/texture/LostLooks.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::size_t mostStatements = 1024; // different mtllib statements
constexpr std::size_t mostReported = 5;      // names that several materials share

// A map_… statement: options, then a name, which may contain blanks.
class MapStatement
{
public:
  explicit MapStatement(std::string_view text)
    : Rest(text)
  {
  }

  // False if a number is NaN or infinite.
  bool Understand(ObjMaterial& material)
  {
    for (std::string_view option; !(option = this->PeekWord()).empty() && option[0] == '-';)
    {
      this->Take();
      if (option == "-o" || option == "-s" || option == "-t")
      {
        std::array<double, 3> values{ option == "-s" ? 1.0 : 0.0, option == "-s" ? 1.0 : 0.0, 0 };
        if (!this->TakeNumbers(values))
        {
          return false;
        }
        std::array<double, 2>& kept = option == "-o" ? material.offset : material.scale;
        kept = option == "-t" ? kept : std::array<double, 2>{ values[0], values[1] };
      }
      else
      {
        const bool on = this->PeekWord() == "on";
        material.clamp = option == "-clamp" ? on : material.clamp;
        this->Take();
        if (option == "-mm")
        {
          this->Take();
        }
      }
    }
    material.picture = WithoutQuotes(this->Rest);
    return true;
  }

private:
  std::string_view PeekWord() const
  {
    std::string_view rest = this->Rest;
    return TakeWord(rest);
  }
  void Take() { TakeWord(this->Rest); }

  // Takes one to three numbers, as long as another word follows.
  bool TakeNumbers(std::array<double, 3>& values)
  {
    std::size_t count = 0;
    for (; count < values.size(); ++count)
    {
      std::string_view after = this->Rest;
      double value = 0;
      const std::string_view word = TakeWord(after);
      if (ParseNumber(word, value) != NumberTextError::None ||
          Trimmed(after, blanksOfNames).empty())
      {
        break;
      }
      if (!std::isfinite(value))
      {
        return false;
      }
      values[count] = value;
      this->Rest = after;
    }
    return count > 0;
  }

  std::string_view Rest;
};

// Reads "r [g b]", which is sRGB.
bool ReadKd(std::string_view text, ObjMaterial& material)
{
  std::array<double, 3> values{};
  std::size_t count = 0;
  for (std::string_view word = TakeWord(text); !word.empty() && count < 3; word = TakeWord(text))
  {
    if (ParseNumber(word, values[count++]) != NumberTextError::None ||
        !std::isfinite(values[count - 1]))
    {
      return false;
    }
  }
  if (count == 1)
  {
    values[1] = values[2] = values[0];
  }
  // Some programs write bytes. Values a little above white are possible, too.
  constexpr double mostLight = 2, mostByte = 255;
  const double greatest = *std::max_element(values.begin(), values.end());
  const double white = greatest > mostLight && greatest <= mostByte ? mostByte : 1;
  for (std::size_t k = 0; k < 3; ++k)
  {
    material.color[k] = ToLinear(std::clamp(values[k] / white, 0.0, 1.0));
  }
  material.colored = true;
  material.ofBytes = white > 1;
  return count == 1 || count == 3;
}

// The largest of the finite numbers with which a text begins; nothing if there are none.
std::optional<double> LargestNumber(std::string_view text)
{
  std::optional<double> largest;
  for (std::string_view word = TakeWord(text); !word.empty(); word = TakeWord(text))
  {
    double value = 0;
    if (ParseNumber(word, value) != NumberTextError::None || !std::isfinite(value))
    {
      break;
    }
    largest = std::max(largest.value_or(value), value);
  }
  return largest;
}

// Reads values that are not carried. A word that is not a number counts as not given.
void ReadLostLook(std::string_view name, std::string_view text, ObjMaterial& material)
{
  const std::optional<double> value = LargestNumber(text);
  if (!value)
  {
    return;
  }
  if (name == "pm")
  {
    material.metalness = *value;
  }
  else if (name == "pr")
  {
    material.rough = *value < 1;
  }
  else if (name == "ke")
  {
    material.emission = *value;
  }
  else if (name == "d")
  {
    material.opacity = value;
  }
  else if (name == "tr")
  {
    material.transparency = value;
  }
}

// Some programs write Tr 1 for opaque materials. Without d it is ignored, because the surface would
// be invisible.
bool IsTransparent(const ObjMaterial& material)
{
  const double through = material.transparency.value_or(0);
  return material.opacity ? *material.opacity < 1 : through > 0 && through < 1;
}

LostLooks LooksOf(const std::vector<ObjMaterial>& materials)
{
  LostLooks lost;
  for (const ObjMaterial& material : materials)
  {
    for (const auto& [look, is] : { std::pair{ LostLook::Metalness, material.metalness > 0 },
           { LostLook::Roughness, material.metalness > 0 && material.rough },
           { LostLook::Emission, material.emission > 0 },
           { LostLook::Transparency, IsTransparent(material) } })
    {
      if (is)
      {
        lost.Add(look, QuotedText(material.name));
      }
    }
  }
  return lost;
}

bool IsOtherMap(std::string_view name)
{
  static constexpr std::array<std::string_view, 5> others{ "bump", "norm", "disp", "decal",
    "refl" };
  return name.starts_with("map_") || std::find(others.begin(), others.end(), name) != others.end();
}

}

namespace
{

// Splits names with blanks: each ends in .mtl.
std::vector<std::string_view> CutAfterEndings(std::string_view names)
{
  constexpr std::string_view ending = ".mtl ";
  std::vector<std::string_view> cut;
  std::string lower = LowercaseText(names);
  std::replace(lower.begin(), lower.end(), '\t', ' ');
  for (std::size_t begin = 0; begin < names.size() && cut.size() < mostObjLibraries;)
  {
    const std::size_t found = lower.find(ending, begin);
    const std::size_t end = found == lower.npos ? names.size() : found + ending.size();
    cut.push_back(Trimmed(names.substr(begin, end - begin), blanksOfNames));
    begin = end;
  }
  return cut;
}

}

void ObjLibraries::Add(std::string_view names, std::uint64_t line)
{
  std::error_code failed;
  const auto isFile = [&](std::string_view name)
  { return std::filesystem::is_regular_file(this->Files.Find(name), failed); };
  const std::string_view whole = Trimmed(names, blanksOfNames);
  if (this->Statements.contains(whole))
  {
    return;
  }
  std::vector<std::string_view> words;
  for (std::string_view word = TakeWord(names); !word.empty() && words.size() <= mostObjLibraries;
       word = TakeWord(names))
  {
    words.push_back(word);
  }
  // The limit exists because each name is searched for in folders, which takes time.
  if (this->Statements.size() == mostStatements || words.size() > mostObjLibraries)
  {
    this->TellTooMany("line " + std::to_string(line) + ": libraries of materials");
    return;
  }
  this->Statements.emplace(whole);
  const bool several = !isFile(whole) && std::any_of(words.begin(), words.end(), isFile);
  if (!several)
  {
    const std::vector<std::string_view> cut = CutAfterEndings(whole);
    words =
      !isFile(whole) && std::any_of(cut.begin(), cut.end(), isFile) ? cut : std::vector{ whole };
  }
  for (const std::string_view word : words)
  {
    this->Read(this->Files.Find(word), WithoutQuotes(word), line);
  }
}

void ObjLibraries::TellTooMany(const std::string& what)
{
  if (!this->TooMany)
  {
    this->Found.warnings.push_back(
      what + " are left out: more than " + std::to_string(mostObjLibraries) + " libraries");
  }
  this->TooMany = true;
}

void ObjLibraries::AddOwn()
{
  std::filesystem::path own = this->Files.MeshFile();
  own.replace_extension(".mtl");
  std::error_code failed;
  if (!this->Opened && std::filesystem::is_regular_file(own, failed))
  {
    this->Found.warnings = { (this->Seen.empty()
                                 ? "names materials but no library: "
                                 : "the libraries of materials that it names are not there: ") +
                             QuotedText(own.filename().string()) + " is taken" };
    this->Read(own, own.filename().string(), 0);
  }
}

void ObjLibraries::Read(
  const std::filesystem::path& file, std::string_view asNamed, std::uint64_t line)
{
  const std::string named =
    "line " + std::to_string(line) + ": the materials " + QuotedText(asNamed);
  if (std::find(this->Seen.begin(), this->Seen.end(), file) != this->Seen.end())
  {
    return;
  }
  if (this->Seen.size() == mostObjLibraries)
  {
    this->TellTooMany(named + " and what follows");
    return;
  }
  this->Seen.push_back(file);
  Result<ByteSource> source = ByteSource::Open(file);
  if (!source || source->Size() > mostObjLibraryBytes)
  {
    const std::string why = source ? "are more than 64 MiB"
                            : source.GetError().code == ErrorCode::NotFound
                              ? WhyMissing(asNamed, true)
                              : source.GetError().message;
    this->Found.warnings.push_back(named + " " + why + ": they are drawn white");
    return;
  }
  this->Opened = true;
  const std::filesystem::path home = this->Files.MeshFile().parent_path();
  const bool isBesideMesh = file.parent_path() == home;
  const std::string folder = (file.parent_path().lexically_relative(home) / "").generic_string();
  const auto isFile = [&](const std::string& name)
  {
    std::error_code failed;
    return std::filesystem::is_regular_file(this->Files.Find(name), failed);
  };
  ObjStatements statements(std::move(*source));
  ObjMaterial* material = nullptr;
  const std::string library = file.filename().string();
  std::size_t wrong = 0;
  for (;;)
  {
    const Result<bool> more = statements.Next();
    const std::string place = library + ", line " + std::to_string(statements.GetLines().Number());
    if (!more)
    {
      this->Found.warnings.push_back(library + ": " + more.GetError().message);
      return;
    }
    if (!*more)
    {
      return;
    }
    const std::string_view name = statements.Name(), rest = statements.Rest();
    const std::string_view written = statements.Written();
    bool understood = true;
    if (name == "newmtl")
    {
      std::vector<ObjMaterial>& all = this->Found.materials;
      if (all.size() == mostObjMaterials)
      {
        this->Found.warnings.push_back(place + ": more than " + std::to_string(mostObjMaterials) +
                                       " materials: the rest is left out");
        return;
      }
      all.push_back({});
      material = &all.back();
      material->name = Trimmed(rest, blanksOfNames);
      material->library = library;
    }
    else if (material && name == "kd")
    {
      understood = ReadKd(rest, *material);
      if (material->ofBytes && !std::exchange(this->WarnedOfBytes, true))
      {
        this->Found.warnings.push_back(
          place + ": " + QuotedText("Kd " + std::string(Trimmed(rest, blanksOfNames))) +
          " is taken for a colour from 0 to 255");
      }
    }
    else if (material && name == "map_kd")
    {
      ObjMaterial changed = *material;
      changed.place = place;
      understood = MapStatement(rest).Understand(changed) && !changed.picture.empty();
      if (!isBesideMesh && understood && !isFile(changed.picture))
      {
        const std::string plain(WithoutQuotes(changed.picture));
        const std::string last = plain.substr(plain.find_last_of("/\\") + 1);
        for (const std::string& beside : { folder + plain, folder + last })
        {
          changed.picture = isFile(beside) ? beside : changed.picture;
        }
      }
      *material = understood ? changed : *material;
    }
    else if (!IsOtherMap(name))
    {
      if (material)
      {
        ReadLostLook(name, rest, *material);
      }
    }
    else if (this->OtherMaps.size() < 20 &&
             std::find(this->OtherMaps.begin(), this->OtherMaps.end(), written) ==
               this->OtherMaps.end())
    {
      this->OtherMaps.emplace_back(written.substr(0, 40));
    }
    if (!understood && ++wrong <= 3)
    {
      const std::string statement = std::string(written) + std::string(rest);
      std::string_view words = rest;
      this->Found.warnings.push_back(place + " cannot be read" + DecimalCommaHint(TakeWord(words)) +
                                     ": " + QuotedText(statement));
    }
  }
}

void MaterialNames::Add(std::string_view name, std::uint32_t number)
{
  if (this->Exact.emplace(name, number).second)
  {
    const auto [at, added] = this->Folded.emplace(Fold(name), number);
    at->second = added ? at->second : std::nullopt;
  }
}

std::optional<std::uint32_t> MaterialNames::Find(std::string_view name) const
{
  const auto exact = this->Exact.find(name);
  if (exact != this->Exact.end())
  {
    return exact->second;
  }
  const auto folded = this->Folded.find(Fold(name));
  return folded == this->Folded.end() ? std::nullopt : folded->second;
}

std::string MaterialNames::Fold(std::string_view name)
{
  return FoldedName(WithoutQuotes(WithoutComment(name)));
}

void ObjLibraries::TellDifferent(const ObjMaterial& first, const ObjMaterial& other)
{
  if (++this->Different <= mostReported)
  {
    this->Found.warnings.push_back(
      "the material " + QuotedText(first.name) + " is in " + QuotedText(first.library) +
      (first.library == other.library
          ? " twice with different values: the first is used"
          : " and, with different values, in " + QuotedText(other.library) +
              ": the first is used for all faces"));
  }
}

ObjMaterials ObjLibraries::Take()
{
  if (!this->OtherMaps.empty())
  {
    std::string names;
    for (const std::string& name : this->OtherMaps)
    {
      names += (names.empty() ? "" : ", ") + name;
    }
    this->Found.warnings.push_back("left out: textures of materials: " + names);
  }
  this->Found.libraries = std::move(this->Seen);
  // If several materials have the same name, the first one stays.
  std::vector<ObjMaterial>& all = this->Found.materials;
  std::stable_sort(all.begin(), all.end(),
    [](const ObjMaterial& a, const ObjMaterial& b) { return a.name < b.name; });
  const auto first = std::unique(all.begin(), all.end(),
    [this](const ObjMaterial& a, const ObjMaterial& b)
    {
      if (a.name == b.name && (a.color != b.color || a.picture != b.picture))
      {
        this->TellDifferent(a, b);
      }
      return a.name == b.name;
    });
  all.erase(first, all.end());
  if (this->Different > mostReported)
  {
    this->Found.warnings.push_back(
      std::to_string(this->Different - mostReported) +
      " further materials are defined twice with different values: the first is used");
  }
  for (std::string& sentence : LooksOf(all).Tell())
  {
    this->Found.warnings.push_back(std::move(sentence));
  }
  return std::move(this->Found);
}

}
