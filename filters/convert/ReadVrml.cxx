// SPDX-License-Identifier: BSD-3-Clause
// Reads VRML 2 and VRML 1, which Coin parses, and joins the scene into one mesh. Steps:
// 1. check the text and make it harmless (VrmlText.h)
// 2. let Coin make a scene of it
// 3. read the shapes, at the places given by their transforms: face sets, grids and points from
//    their fields, solids as Coin's triangles
// 4. read the files that an Inline names, in the same way.
#include "filters/convert/FloatCoordinates.h"
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/JoinParts.h"
#include "filters/convert/PointAttributes.h"
#include "filters/convert/UnpackGzip.h"
#include "filters/convert/VrmlFaces.h"
#include "filters/convert/VrmlText.h"
#include "filters/core/Texts.h"
#include "filters/core/UnusedVertices.h"
#include "filters/core/VectorMath.h"
#include "filters/meshio/ByteSource.h"
#include "filters/meshio/QuotedText.h"
#include "filters/meshio/ShownColors.h"
#include "filters/meshio/TextWords.h"
#include "filters/texture/FilesBeside.h"
#include "filters/texture/LostLooks.h"

#include <Inventor/SoDB.h>
#include <Inventor/SoInput.h>
#include <Inventor/SoPrimitiveVertex.h>
#include <Inventor/VRMLnodes/SoVRMLNodes.h>
#include <Inventor/actions/SoCallbackAction.h>
#include <Inventor/elements/SoLazyElement.h>
#include <Inventor/errors/SoDebugError.h>
#include <Inventor/errors/SoMemoryError.h>
#include <Inventor/errors/SoReadError.h>
#include <Inventor/fields/SoMFColor.h>
#include <Inventor/fields/SoMFFloat.h>
#include <Inventor/fields/SoMFMatrix.h>
#include <Inventor/fields/SoMFRotation.h>
#include <Inventor/fields/SoMFVec2f.h>
#include <Inventor/fields/SoMFVec3f.h>
#include <Inventor/fields/SoMFVec4f.h>
#include <Inventor/fields/SoSFColor.h>
#include <Inventor/fields/SoSFFloat.h>
#include <Inventor/fields/SoSFMatrix.h>
#include <Inventor/fields/SoSFRotation.h>
#include <Inventor/fields/SoSFVec2f.h>
#include <Inventor/fields/SoSFVec3f.h>
#include <Inventor/fields/SoSFVec4f.h>
#include <Inventor/lists/SoFieldList.h>
#include <Inventor/misc/SoProto.h>
#include <Inventor/misc/SoProtoInstance.h>
#include <Inventor/nodes/SoArray.h>
#include <Inventor/nodes/SoCone.h>
#include <Inventor/nodes/SoCube.h>
#include <Inventor/nodes/SoCylinder.h>
#include <Inventor/nodes/SoGroup.h>
#include <Inventor/nodes/SoIndexedFaceSet.h>
#include <Inventor/nodes/SoLOD.h>
#include <Inventor/nodes/SoMaterial.h>
#include <Inventor/nodes/SoMultipleCopy.h>
#include <Inventor/nodes/SoPointSet.h>
#include <Inventor/nodes/SoSeparator.h>
#include <Inventor/nodes/SoShape.h>
#include <Inventor/nodes/SoSphere.h>
#include <Inventor/nodes/SoTransformation.h>
#include <Inventor/nodes/SoVertexProperty.h>
#include <Inventor/nodes/SoWWWInline.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <unordered_map>

namespace kdstream
{
namespace
{

constexpr std::uint64_t mostVrmlBytes = std::uint64_t{ 1 } << 31; // Coin counts in int
constexpr std::size_t deepestNodes = 2000;
constexpr std::uint64_t mostNodes = 10'000'000; // visits, also of nodes that are used again
constexpr std::size_t deepestInlines = 8, mostInlines = 1000;
constexpr std::uint64_t mostGridCorners = std::uint64_t{ 1 } << 28;
// How many corners extrusions may have, counted each time they are used: spine times cross section.
constexpr std::uint64_t mostExtrusionCorners = std::uint64_t{ 1 } << 18;
constexpr std::uint64_t extrusionCornersPerByte = 4;
constexpr const char* unusable = ", whose sizes or numbers make no shape";
// The default colour of a material. A shape without a material is white.
constexpr double vrmlGrey = 0.8;

// --- Coin's messages -----------------------------------------------------------------------------

// Collects Coin's messages during its lifetime. Only one thread may use this at a time.
class CoinMessages
{
public:
  CoinMessages()
  {
    Text().clear();
    SoReadError::setHandlerCallback(Keep, nullptr);
    SoDebugError::setHandlerCallback(PassOver, nullptr); // these are advice to programmers
    SoMemoryError::setHandlerCallback(Keep, nullptr);
  }
  CoinMessages(const CoinMessages&) = delete;
  CoinMessages& operator=(const CoinMessages&) = delete;

  // Errors: InvalidInput for the first message, with its line and the text of this line from
  // `text`.
  static Status First(std::string_view text)
  {
    if (Text().empty())
    {
      return {};
    }
    constexpr std::string_view word = "line";
    const std::string_view said = Text();
    const std::size_t at = said.rfind(word);
    const std::size_t digits = said.find_first_of("0123456789", std::min(at, said.size()));
    std::size_t number = 0;
    if (at == std::string_view::npos || digits == std::string_view::npos ||
        std::from_chars(said.data() + digits, said.data() + said.size(), number).ec != std::errc())
    {
      return Error{ ErrorCode::InvalidInput, Meaning(said) };
    }
    std::size_t begin = 0;
    for (std::size_t line = 1; line < number && begin < text.size(); ++line)
    {
      begin = std::min(text.find('\n', begin), text.size() - 1) + 1;
    }
    std::string_view line = text.substr(begin, text.find('\n', begin) - begin);
    TakeBlanks(line);
    return Error{ ErrorCode::InvalidInput,
      "line " + std::to_string(number) + ": " + Meaning(said) +
        (line.empty() ? "" : ", in or before " + QuotedText(line)) };
  }

private:
  static std::string& Text()
  {
    static std::string text;
    return text;
  }
  // Says what Coin's message means, with the name that the message quotes.
  static std::string Meaning(std::string_view said)
  {
    constexpr std::pair<std::string_view, const char*> meanings[] = {
      { "Couldn't read value for field", "a value that this field does not allow" },
      { "Unable to read value", "a value that this field does not allow" },
      { "Unable to read default value", "a value that this field does not allow" },
      { "Unknown field type", "a field of a type that VRML does not have" },
      { "Unknown field", "a field that its node does not have" },
      { "Unknown enumeration", "a word that this field does not allow" },
      { "Unknown SoSFBitMask", "a word that this field does not allow" },
      { "Unknown reference", "USE of a name that no node has" },
      { "Premature end", "the text ends inside a node" },
      { "Premature EOF", "the text ends inside a node" },
      { "premature EOF", "the text ends inside a node" },
      { "after end of scene", "there is text after the last node" },
      { "is not derived from", "a node of a type that is not allowed there" },
      { "ROUTE", "a ROUTE that cannot be read" },
      { "PROTO", "a PROTO that cannot be read" },
    };
    const auto* const found = std::find_if(std::begin(meanings), std::end(meanings),
      [&](const auto& meaning) { return said.find(meaning.first) != said.npos; });
    if (found == std::end(meanings))
    {
      return "it cannot be read as VRML";
    }
    const std::size_t begin = said.find('"');
    const std::size_t end = begin == said.npos ? begin : said.find('"', begin + 1);
    return found->second + (end == said.npos || end == begin + 1
                               ? std::string()
                               : " (" + QuotedText(said.substr(begin + 1, end - begin - 1)) + ")");
  }
  static void Keep(const SoError* error, void*)
  {
    if (Text().empty())
    {
      Text() = error->getDebugString().getString();
      Text() += Text().empty() ? "an error without a message" : "";
    }
  }
  static void PassOver(const SoError*, void*) {}
};

void StartCoin()
{
  static const bool started = []()
  {
    SoDB::init();
    SoInput::clearDirectories();
    // The text has no string that names a file (VrmlText.h), and Coin must not look for one either.
    SoVRMLInline::setReadAsSoFile(FALSE);
    SoWWWInline::setReadAsSoFile(FALSE);
    SoVRMLInline::setFetchURLCallBack([](const SbString&, void*, SoVRMLInline*) {}, nullptr);
    SoWWWInline::setFetchURLCallBack([](const SbString&, void*, SoWWWInline*) {}, nullptr);
    SoProto::setFetchExternProtoCallback(
      [](SoInput*, const SbString*, const int, void*) -> SoProto* { return nullptr; }, nullptr);
    return true;
  }();
  static_cast<void>(started);
}

// The type that Coin has for a kind of node. In VRML 2 this is VRML's own type, if there is one,
// else Inventor's.
SoType TypeOfCoin(const std::string& type, bool isFirst)
{
  const SoType second = SoType::fromName(("VRML" + type).c_str());
  return isFirst || second == SoType::badType() ? SoType::fromName(type.c_str()) : second;
}

// Coin 4.0.3 stops the program where the unknown type is asked what it is derived from.
bool IsDerived(SoType type, SoType from)
{
  return !type.isBad() && type.isDerivedFrom(from);
}

bool IsNodeOfCoin(const std::string& type, bool isFirst)
{
  // "Nurbs…" nodes of Inventor have other fields than those of VRML 2. "File" names a file, which
  // is not opened. "Shape" is only an abstract type in VRML 1.
  const SoType made = TypeOfCoin(type, isFirst);
  return !type.starts_with("Nurbs") && type != "File" &&
         IsDerived(made, SoNode::getClassTypeId()) && made.canCreateInstance();
}

bool HoldsNodesInCoin(const std::string& type)
{
  return SoType::fromName(("VRML" + type).c_str()) == SoType::badType() &&
         IsDerived(SoType::fromName(type.c_str()), SoGroup::getClassTypeId());
}

// How many floats make up a value of a field; 0 for all fields of other types.
std::size_t WidthOfField(const SoField& field)
{
  const SoType type = field.getTypeId();
  const auto is = [&](SoType single, SoType multiple)
  { return type.isDerivedFrom(single) || type.isDerivedFrom(multiple); };
  constexpr std::size_t ofMatrix = 16;
  return is(SoSFFloat::getClassTypeId(), SoMFFloat::getClassTypeId())         ? 1
         : is(SoSFVec2f::getClassTypeId(), SoMFVec2f::getClassTypeId())       ? 2
         : is(SoSFVec3f::getClassTypeId(), SoMFVec3f::getClassTypeId())       ? 3
         : is(SoSFColor::getClassTypeId(), SoMFColor::getClassTypeId())       ? 3
         : is(SoSFVec4f::getClassTypeId(), SoMFVec4f::getClassTypeId())       ? 4
         : is(SoSFRotation::getClassTypeId(), SoMFRotation::getClassTypeId()) ? 4
         : is(SoSFMatrix::getClassTypeId(), SoMFMatrix::getClassTypeId())     ? ofMatrix
                                                                              : 0;
}

// The fields of a node, with the number of floats in a value; empty if Coin cannot create the node.
const std::map<std::string, std::size_t>& FieldsOfCoin(const std::string& type, bool isFirst)
{
  static std::map<std::string, std::map<std::string, std::size_t>> fieldsOf;
  const auto [found, isNew] = fieldsOf.try_emplace((isFirst ? "1" : "2") + type);
  std::map<std::string, std::size_t>& fields = found->second;
  const SoType made = TypeOfCoin(type, isFirst);
  if (isNew && !made.isBad() && made.canCreateInstance())
  {
    auto* const node = static_cast<SoNode*>(made.createInstance());
    node->ref();
    SoFieldList list;
    node->getFields(list);
    for (int i = 0; i < list.getLength(); ++i)
    {
      SbName name;
      if (node->getFieldName(list[i], name))
      {
        fields.emplace(name.getString(), WidthOfField(*list[i]));
      }
    }
    node->unref();
  }
  return fields;
}

// True also for types that Coin cannot create.
bool IsFieldOfCoin(const std::string& type, const std::string& field, bool isFirst)
{
  const auto& fields = FieldsOfCoin(type, isFirst);
  return fields.empty() || fields.contains(field) || field.starts_with("set_");
}

std::size_t WidthOfCoin(const std::string& type, const std::string& field, bool isFirst)
{
  const auto& fields = FieldsOfCoin(type, isFirst);
  const auto found = fields.find(field);
  return found == fields.end() ? 0 : found->second;
}

// --- Transforms ----------------------------------------------------------------------------------

// A transform in doubles: the columns of its matrix, and the image of the origin. Coin's own
// matrices are floats.
struct Transform
{
  std::array<Vec3, 3> axes{ { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } };
  Vec3 origin{};

  Vec3 Turn(const Vec3& p) const
  {
    return Plus(
      Plus(Times(this->axes[0], p[0]), Times(this->axes[1], p[1])), Times(this->axes[2], p[2]));
  }
  Vec3 Of(const Vec3& p) const { return Plus(this->Turn(p), this->origin); }
  // The transform that applies first `inner`, then this.
  Transform After(const Transform& inner) const
  {
    Transform both;
    for (std::size_t k = 0; k < 3; ++k)
    {
      both.axes[k] = this->Turn(inner.axes[k]);
    }
    both.origin = this->Of(inner.origin);
    return both;
  }
  // The factor by which lengths grow; the largest of the axes.
  double Scale() const
  {
    return std::max({ Length(this->axes[0]), Length(this->axes[1]), Length(this->axes[2]) });
  }
  bool IsIdentity() const
  {
    const Transform none;
    return this->axes == none.axes && this->origin == none.origin;
  }
  double Determinant() const { return Dot(this->axes[0], Cross(this->axes[1], this->axes[2])); }
  // Transforms a normal by the transpose of the inverse, times the determinant.
  Vec3 TurnNormal(const Vec3& n) const
  {
    const auto& [x, y, z] = this->axes;
    return Plus(Plus(Times(Cross(y, z), n[0]), Times(Cross(z, x), n[1])), Times(Cross(x, y), n[2]));
  }
};

double ToDouble(float value)
{
  static const auto notFinite = static_cast<float>(std::atof(vrmlNotFinite));
  return value == notFinite ? std::numeric_limits<double>::quiet_NaN() : double(value);
}

Vec3 ToVec3(const SbVec3f& v)
{
  return { ToDouble(v[0]), ToDouble(v[1]), ToDouble(v[2]) };
}

Transform Translation(const Vec3& by)
{
  Transform t;
  t.origin = by;
  return t;
}

Transform Scale(const Vec3& by)
{
  return { { { { by[0], 0, 0 }, { 0, by[1], 0 }, { 0, 0, by[2] } } }, {} };
}

Transform Rotation(const SbRotation& rotation, bool back = false)
{
  float x = 0, y = 0, z = 0, w = 1;
  rotation.getValue(x, y, z, w);
  Vec3 v{ double(x), double(y), double(z) };
  double real = double(w);
  const double length = std::sqrt(Dot(v, v) + real * real);
  if (!(length > 0))
  {
    return {};
  }
  v = Times(v, (back ? -1 : 1) / length);
  real /= length;
  Transform turned;
  for (Vec3& axis : turned.axes)
  {
    // p + 2 w (v x p) + 2 v x (v x p)
    const Vec3 across = Times(Cross(v, axis), 2);
    axis = Plus(Plus(axis, Times(across, real)), Cross(v, across));
  }
  return turned;
}

// VRML97, 6.52.
Transform Of(const SoVRMLTransform& node)
{
  const Vec3 center = ToVec3(node.center.getValue());
  const SbRotation& along = node.scaleOrientation.getValue();
  return Translation(Plus(ToVec3(node.translation.getValue()), center))
    .After(Rotation(node.rotation.getValue()))
    .After(Rotation(along))
    .After(Scale(ToVec3(node.scale.getValue())))
    .After(Rotation(along, true))
    .After(Translation(Times(center, -1)));
}

Transform Of(const SbMatrix& matrix)
{
  Transform made;
  for (std::size_t k = 0; k < 3; ++k)
  {
    for (std::size_t i = 0; i < 3; ++i)
    {
      made.axes[k][i] = double(matrix[int(k)][int(i)]);
    }
    made.origin[k] = double(matrix[3][int(k)]);
  }
  return made;
}

// --- Values of nodes -----------------------------------------------------------------------------

// The node that is the value of a field; if it is an instance of a PROTO, the node that this makes.
template <class Node>
const Node* NodeOf(const SoSFNode& field)
{
  SoNode* node = field.getValue();
  for (int depth = 0; depth < 100 && node && node->isOfType(SoProtoInstance::getClassTypeId());
       ++depth)
  {
    node = static_cast<SoProtoInstance*>(node)->getRootNode();
  }
  return node && node->isOfType(Node::getClassTypeId()) ? static_cast<const Node*>(node) : nullptr;
}

std::span<const std::int32_t> IndicesOf(const SoMFInt32& field)
{
  return { field.getValues(0), std::size_t(field.getNum()) };
}

std::vector<Vec3> PointsOf(const SoSFNode& field)
{
  std::vector<Vec3> points;
  if (const auto* const node = NodeOf<SoVRMLCoordinate>(field))
  {
    const SbVec3f* const values = node->point.getValues(0);
    points.reserve(std::size_t(node->point.getNum()));
    for (int i = 0; i < node->point.getNum(); ++i)
    {
      points.push_back(ToVec3(values[i]));
    }
  }
  return points;
}

std::vector<Color> ColorsOf(const SoSFNode& field)
{
  std::vector<Color> colors;
  if (const auto* const node = NodeOf<SoVRMLColor>(field))
  {
    const SbColor* const values = node->color.getValues(0);
    for (int i = 0; i < node->color.getNum(); ++i)
    {
      const SbColor& c = values[i];
      colors.push_back({ double(c[0]), double(c[1]), double(c[2]), 1 });
    }
  }
  return colors;
}

std::vector<std::array<float, 3>> NormalsOf(const SoSFNode& field)
{
  std::vector<std::array<float, 3>> normals;
  if (const auto* const node = NodeOf<SoVRMLNormal>(field))
  {
    const SbVec3f* const values = node->vector.getValues(0);
    for (int i = 0; i < node->vector.getNum(); ++i)
    {
      normals.push_back({ values[i][0], values[i][1], values[i][2] });
    }
  }
  return normals;
}

std::vector<std::array<float, 2>> TextureCoordinatesOf(const SoSFNode& field)
{
  std::vector<std::array<float, 2>> found;
  if (const auto* const node = NodeOf<SoVRMLTextureCoordinate>(field))
  {
    const SbVec2f* const values = node->point.getValues(0);
    for (int i = 0; i < node->point.getNum(); ++i)
    {
      found.push_back({ values[i][0], values[i][1] });
    }
  }
  return found;
}

bool IsLength(float value)
{
  return std::isfinite(value) && value > 0;
}

// --- Scenes --------------------------------------------------------------------------------------

// Joins vertices of triangles that have the same place and colour.
class WeldedTriangles
{
public:
  VertexId Add(const SbVec3f& place, const Color& color)
  {
    const std::array<float, 6> values{ place[0] + 0.0F, place[1] + 0.0F, place[2] + 0.0F,
      float(color[0]), float(color[1]), float(color[2]) };
    const auto [found, added] = this->Numbers.try_emplace(
      std::bit_cast<Key>(values), static_cast<VertexId>(this->Points.size()));
    if (added)
    {
      this->Points.push_back(ToVec3(place));
      this->Colors.push_back(color);
    }
    return found->second;
  }

  std::vector<Vec3> Points;
  std::vector<Color> Colors;
  std::vector<Triangle> Triangles;

private:
  using Key = std::array<std::uint32_t, 6>;
  struct HashOfKey
  {
    std::size_t operator()(const Key& key) const
    {
      return std::hash<std::string_view>()(
        { reinterpret_cast<const char*>(key.data()), sizeof(key) });
    }
  };
  std::unordered_map<Key, VertexId, HashOfKey> Numbers;
};

// Traverses scenes and collects their shapes.
class SceneReader
{
public:
  explicit SceneReader(const Execution& execution)
    : Exec(execution)
  {
  }

  Result<ForeignMesh> Read(const std::filesystem::path& file)
  {
    KDSTREAM_TRY(this->ReadFile(file));
    for (ForeignMesh& part : this->Parts)
    {
      this->Tolerated.Add(part.tolerance);
    }
    Result<ForeignMesh> joined = JoinParts(this->Parts);
    KDSTREAM_TRY(joined);
    this->CountNodesLeftOut();
    joined->tolerance = std::move(this->Tolerated);
    joined->named = std::move(this->Named);
    if (this->Shapes == 0 && this->LeftOut.empty() && this->NodesLeftOut.empty() &&
        this->Warnings.empty())
    {
      joined->warnings.emplace_back("it shows no shape");
    }
    for (const auto& [what, count] : this->LeftOut)
    {
      joined->warnings.push_back("left out: " + std::to_string(count) + " " + what);
    }
    joined->warnings.insert(joined->warnings.end(), this->Warnings.begin(), this->Warnings.end());
    const std::vector<std::string> lost = this->Lost.Tell();
    joined->warnings.insert(joined->warnings.end(), lost.begin(), lost.end());
    if (this->LosesDecimals)
    {
      WarnOfFloats(*joined, this->Largest);
    }
    return joined;
  }

private:
  // --- Files

  Status ReadFile(const std::filesystem::path& file)
  {
    Result<std::string> bytes = ReadBytes(file);
    KDSTREAM_TRY(bytes);
    if (IsGzip(*bytes))
    {
      Result<UnpackedText> unpacked = UnpackGzip(*bytes, mostVrmlBytes - 1);
      KDSTREAM_TRY(unpacked);
      this->Tolerated.Count(Lapse::BytesAfterEnd, unpacked->bytesAfter);
      *bytes = std::move(unpacked->text);
    }
    Result<VrmlText> checked =
      CheckVrmlText(*bytes, { IsNodeOfCoin, IsFieldOfCoin, WidthOfCoin, HoldsNodesInCoin });
    KDSTREAM_TRY(checked);
    for (const auto& [what, left] : checked->leftOut)
    {
      this->LeaveOutNode(what, left.line, left.count);
    }
    *bytes = {};
    this->LosesDecimals = this->LosesDecimals || !checked->floatsSuffice;
    this->Tolerated.Add(checked->tolerance);
    this->MostExtrusionCorners += checked->text.size() * extrusionCornersPerByte;
    if (checked->hasPictures)
    {
      this->Warn("its pictures are not read");
    }
    KDSTREAM_TRY(this->Exec.Report("read", 0));
    SoInput input;
    input.setBuffer(checked->text.data(), checked->text.size());
    const CoinMessages messages;
    SoSeparator* const scene = SoDB::readAll(&input);
    const Status said = CoinMessages::First(checked->text);
    if (!scene || !said)
    {
      return said ? Error{ ErrorCode::InvalidInput, "cannot be read as VRML" } : said.GetError();
    }
    scene->ref();
    Document outer = std::exchange(this->Current, { file, &checked->urls, this->Placed() });
    this->Traverse(*scene);
    this->Current = std::move(outer);
    scene->unref();
    return this->Failure ? Status(*this->Failure) : Status();
  }

  static Result<std::string> ReadBytes(const std::filesystem::path& file)
  {
    Result<ByteSource> source = ByteSource::Open(file);
    KDSTREAM_TRY(source);
    if (source->Size() >= mostVrmlBytes)
    {
      return Error{ ErrorCode::LimitExceeded,
        std::to_string(source->Size()) + " bytes; at most 2147483647 can be read of VRML" };
    }
    std::string bytes;
    bytes.reserve(static_cast<std::size_t>(source->Size()));
    for (;;)
    {
      const auto block = source->Peek(static_cast<std::size_t>(
        std::min<std::uint64_t>(ByteSource::blockSize, source->Remaining())));
      KDSTREAM_TRY(block);
      if (block->empty())
      {
        return bytes;
      }
      bytes += *block;
      source->Consume(block->size());
    }
  }

  // Reads the first of an Inline's files that exists.
  void ReadInline(SoCallbackAction& action, const std::vector<std::string>& numbers)
  {
    std::string missing;
    std::uint64_t lineOfMissing = 0;
    for (const std::string& text : numbers)
    {
      std::size_t number = this->Current.urls->size();
      const std::size_t begin = text.starts_with(vrmlUrlBegin) ? std::strlen(vrmlUrlBegin) : 0;
      std::from_chars(text.data() + begin, text.data() + text.size(), number);
      if (number >= this->Current.urls->size())
      {
        continue;
      }
      const VrmlUrl& url = (*this->Current.urls)[number];
      const std::filesystem::path file = this->FileOf(url.url);
      this->Named.insert(this->Named.end(), file);
      const std::string named =
        "line " + std::to_string(url.line) + ": the Inline " + QuotedText(file.filename().string());
      std::error_code failure;
      if (!std::filesystem::is_regular_file(file, failure))
      {
        lineOfMissing = missing.empty() ? url.line : lineOfMissing;
        missing = missing.empty()
                    ? "the Inline " + QuotedText(url.url) + ", which " + WhyMissing(url.url)
                    : missing;
        continue;
      }
      if (this->Inlines.count(file) > 0 || this->Inlines.size() >= deepestInlines ||
          ++this->InlinesRead > mostInlines)
      {
        this->Fail({ ErrorCode::LimitExceeded,
          this->Inlines.count(file) > 0 ? named + " contains itself"
                                        : named + ": there are too many of them",
          {}, {}, Remedy::Repair });
        return;
      }
      this->Inlines.insert(file);
      this->Transforms.push_back(this->PlacedBy(action));
      const Status read = this->ReadFile(file);
      this->Transforms.pop_back();
      this->Inlines.erase(file);
      if (!read)
      {
        Error error = read.GetError();
        error.message = named + ": " + error.message;
        this->Fail(std::move(error));
      }
      return;
    }
    if (missing.empty())
    {
      this->Warn("an Inline names no file: it is left out");
      return;
    }
    this->LeaveOutNode(missing, lineOfMissing);
  }

  // The file that a URL names: as it is written; else as an address, with file:, %HH, and # before
  // a viewpoint.
  std::filesystem::path FileOf(const std::string& url)
  {
    if (!this->Current.files)
    {
      this->Current.files.emplace(this->Current.file);
    }
    const std::filesystem::path written = this->Current.files->Find(url);
    std::error_code failure;
    if (std::filesystem::is_regular_file(written, failure))
    {
      return written;
    }
    constexpr std::string_view scheme = "file:";
    std::string name = url.substr(url.starts_with(scheme) ? scheme.size() : 0);
    name.resize(std::min(name.size(), name.find('#')));
    return this->Current.files->Find(PercentDecoded(name).value_or(name));
  }

  // --- Traversal

  void Traverse(SoNode& scene)
  {
    SoCallbackAction action;
    const auto before = [&](SoType type, auto* callback)
    { action.addPreCallback(type, callback, this); };
    before(SoNode::getClassTypeId(), Enter);
    action.addPostCallback(SoNode::getClassTypeId(), Leave, this);
    action.addTriangleCallback(SoShape::getClassTypeId(), AddTriangle, this);
    action.apply(&scene);
    this->FinishTriangles();
  }

  static SoCallbackAction::Response Enter(
    void* reader, SoCallbackAction* action, const SoNode* node)
  {
    auto& self = *static_cast<SceneReader*>(reader);
    self.FinishTriangles();
    ++self.Depth;
    if (++self.Nodes > mostNodes || self.Depth > deepestNodes)
    {
      self.Fail({ ErrorCode::LimitExceeded,
        self.Depth > deepestNodes
          ? "its nodes are nested deeper than " + std::to_string(deepestNodes)
          : "its nodes, each time they are used, are more than " + std::to_string(mostNodes) });
    }
    if (self.Nodes % 4096 == 0 && !self.Failure)
    {
      if (const Status reported = self.Exec.Report("read", 0.5); !reported)
      {
        self.Fail(reported.GetError());
      }
    }
    if (self.Failure)
    {
      return SoCallbackAction::ABORT;
    }
    return self.Visit(*action, *node);
  }

  static SoCallbackAction::Response Leave(void* reader, SoCallbackAction*, const SoNode* node)
  {
    auto& self = *static_cast<SceneReader*>(reader);
    --self.Depth;
    if (node->isOfType(SoVRMLTransform::getClassTypeId()) && !self.Transforms.empty())
    {
      self.Transforms.pop_back();
    }
    return self.Failure ? SoCallbackAction::ABORT : SoCallbackAction::CONTINUE;
  }

  template <class Node>
  static const Node* As(const SoNode& node)
  {
    return node.isOfType(Node::getClassTypeId()) ? static_cast<const Node*>(&node) : nullptr;
  }

  // Handles the node types known here. PRUNE: Coin does not make triangles of the node.
  SoCallbackAction::Response Visit(SoCallbackAction& action, const SoNode& node)
  {
    constexpr auto done = SoCallbackAction::PRUNE;
    if (const auto* const transform = As<SoVRMLTransform>(node))
    {
      this->Transforms.push_back(this->Placed().After(Of(*transform)));
    }
    else if (const auto* const lod = As<SoVRMLLOD>(node))
    {
      // Without ranges, the first level is shown, which is the finest.
      const_cast<SoVRMLLOD*>(lod)->range.setNum(0);
    }
    else if (const auto* const first = As<SoLOD>(node))
    {
      const_cast<SoLOD*>(first)->range.setNum(0);
    }
    else if (const auto* const material = As<SoVRMLMaterial>(node))
    {
      this->LastMaterial = &node;
      auto* const changed = const_cast<SoVRMLMaterial*>(material);
      this->ScaleColor(changed->diffuseColor);
      this->ScaleColor(changed->emissiveColor);
    }
    else if (const auto* const ofInventor = As<SoMaterial>(node))
    {
      this->LastMaterial = &node;
      auto* const changed = const_cast<SoMaterial*>(ofInventor);
      this->ScaleColorsOf(changed->diffuseColor);
      this->ScaleColorsOf(changed->emissiveColor);
    }
    else if (As<SoTransformation>(node) || As<SoArray>(node) || As<SoMultipleCopy>(node))
    {
      this->Current.byMatrix = true;
    }
    else if (const auto* const inlined = As<SoVRMLInline>(node))
    {
      this->ReadInline(action, StringsOf(inlined->url));
      return done;
    }
    else if (const auto* const www = As<SoWWWInline>(node))
    {
      this->ReadInline(action, { www->name.getValue().getString() });
      return done;
    }
    return this->VisitShape(action, node) ? done : SoCallbackAction::CONTINUE;
  }

  // Returns whether the shape was read, or is left out.
  bool VisitShape(SoCallbackAction& action, const SoNode& node)
  {
    if (const auto* const faces = As<SoVRMLIndexedFaceSet>(node))
    {
      this->AddFaceSet(action, *faces);
      return true;
    }
    if (const auto* const grid = As<SoVRMLElevationGrid>(node))
    {
      this->AddGrid(action, *grid);
      return true;
    }
    if (const auto* const points = As<SoVRMLPointSet>(node))
    {
      this->AddPoints(action, *points);
      return true;
    }
    if (const auto* const faces = As<SoIndexedFaceSet>(node))
    {
      this->AddFirstFaceSet(action, *faces);
      return true;
    }
    if (const auto* const points = As<SoPointSet>(node))
    {
      this->AddFirstPoints(action, *points);
      return true;
    }
    if (const auto* const lines = As<SoVRMLIndexedLineSet>(node))
    {
      const std::span<const std::int32_t> index = IndicesOf(lines->coordIndex);
      this->LeaveOut(
        "lines (IndexedLineSet)", std::uint64_t(std::count(index.begin(), index.end(), -1)) +
                                    (!index.empty() && index.back() != -1 ? 1 : 0));
      return true;
    }
    if (!As<SoShape>(node))
    {
      return false;
    }
    std::string type = node.getTypeId().getName().getString();
    type.erase(0, type.starts_with("VRML") ? 4 : 0);
    const auto is = [&](const char* word) { return type.find(word) != std::string::npos; };
    if (is("Text"))
    {
      this->LeaveOut("texts (" + type + ")", 1);
      return true;
    }
    if (is("Line")) // a node of VRML 1
    {
      this->LeaveOut("shapes without triangles (" + type + ")", 1);
      return true;
    }
    if (!IsSolid(node))
    {
      this->LeaveOutNode(QuotedText(type) + ", which VRML does not have");
      return true;
    }
    if (!IsSound(node))
    {
      this->LeaveOutNode(QuotedText(type) + unusable);
      return true;
    }
    // Coin's triangles ignore the orientation.
    const auto* const extrusion = As<SoVRMLExtrusion>(node);
    this->IsClockwise = extrusion && extrusion->ccw.getValue() == 0;
    this->ExtrusionCorners += extrusion ? CornersOf(*extrusion) : 0;
    if (this->ExtrusionCorners > this->MostExtrusionCorners)
    {
      this->Fail(
        { ErrorCode::LimitExceeded, "its extrusions, each time they are used, have more than " +
                                      std::to_string(this->MostExtrusionCorners) + " corners" });
      return true;
    }
    this->NoteLooks(action);
    return false;
  }

  // Whether the node is a solid, for which Coin uses no indices from the file.
  static bool IsSolid(const SoNode& node)
  {
    return As<SoVRMLBox>(node) || As<SoVRMLSphere>(node) || As<SoVRMLCone>(node) ||
           As<SoVRMLCylinder>(node) || As<SoVRMLExtrusion>(node) || As<SoCube>(node) ||
           As<SoSphere>(node) || As<SoCone>(node) || As<SoCylinder>(node);
  }

  // Whether sizes and numbers are valid, for shapes of which Coin makes triangles.
  static bool IsSound(const SoNode& node)
  {
    if (const auto* const box = As<SoVRMLBox>(node))
    {
      const SbVec3f size = box->size.getValue();
      // A box with one side of 0 is a single face.
      const auto isSide = [](float side) { return IsLength(side) || side == 0; };
      return isSide(size[0]) && isSide(size[1]) && isSide(size[2]) &&
             std::count(size.getValue(), size.getValue() + 3, 0.0F) <= 1;
    }
    if (const auto* const sphere = As<SoVRMLSphere>(node))
    {
      return IsLength(sphere->radius.getValue());
    }
    if (const auto* const cone = As<SoVRMLCone>(node))
    {
      return IsLength(cone->bottomRadius.getValue()) && IsLength(cone->height.getValue());
    }
    if (const auto* const cylinder = As<SoVRMLCylinder>(node))
    {
      return IsLength(cylinder->radius.getValue()) && IsLength(cylinder->height.getValue());
    }
    if (const auto* const extrusion = As<SoVRMLExtrusion>(node))
    {
      const auto finite = [](const auto& field, int components)
      {
        for (int i = 0; i < field.getNum(); ++i)
        {
          for (int k = 0; k < components; ++k)
          {
            if (!std::isfinite(field[i][k]))
            {
              return false;
            }
          }
        }
        return true;
      };
      return extrusion->spine.getNum() >= 2 && extrusion->crossSection.getNum() >= 2 &&
             extrusion->orientation.getNum() > 0 && extrusion->scale.getNum() > 0 &&
             finite(extrusion->spine, 3) && finite(extrusion->crossSection, 2) &&
             finite(extrusion->scale, 2);
    }
    return true;
  }

  static std::uint64_t CornersOf(const SoVRMLExtrusion& extrusion)
  {
    return std::uint64_t(extrusion.spine.getNum()) * std::uint64_t(extrusion.crossSection.getNum());
  }

  static std::vector<std::string> StringsOf(const SoMFString& field)
  {
    std::vector<std::string> strings;
    for (int i = 0; i < field.getNum(); ++i)
    {
      strings.emplace_back(field[i].getString());
    }
    return strings;
  }

  // --- Shapes

  Transform Placed() const
  {
    return this->Transforms.empty() ? Transform{} : this->Transforms.back();
  }

  // The transform for a shape. VRML 1 has many kinds of transforms, which files of VRML 2 have
  // sometimes, too: in this case it is Coin's matrix, in floats.
  Transform PlacedBy(SoCallbackAction& action) const
  {
    return this->Current.byMatrix ? this->Current.placed.After(Of(action.getModelMatrix()))
                                  : this->Placed();
  }

  // The appearance of a shape, which the nodes before it define.
  struct Look
  {
    SbColor diffuse, emission;
    float transparency = 0;

    bool Emits() const { return IsLight(this->emission); }
    // A material that only emits light, as in unlit scenes, has the colour of this light.
    bool IsUnlit() const { return !IsLight(this->diffuse) && this->Emits(); }
    static bool IsLight(const SbColor& c) { return c[0] > 0 || c[1] > 0 || c[2] > 0; }
  };

  // The appearance by the material of this index; by the first material if there is none.
  static Look LookOf(SoCallbackAction& action, int index = 0)
  {
    SbColor ambient, specular;
    float shininess = 0;
    Look look;
    action.getMaterial(ambient, look.diffuse, specular, look.emission, shininess, look.transparency,
      index < CountOfMaterials(action) ? std::max(index, 0) : 0);
    return look;
  }

  static int CountOfMaterials(SoCallbackAction& action)
  {
    return SoLazyElement::getInstance(action.getState())->getNumDiffuse();
  }

  static Color ColorOf(const SbColor& c) { return { double(c[0]), double(c[1]), double(c[2]), 1 }; }

  static Color MaterialOf(SoCallbackAction& action, int index = 0)
  {
    const Look look = LookOf(action, index);
    return ColorOf(look.IsUnlit() ? look.emission : look.diffuse);
  }

  // Points and lines are not lit: their colour is the light that their material emits.
  static Color MaterialOfPoints(SoCallbackAction& action)
  {
    const Look look = LookOf(action);
    return ColorOf(look.Emits() ? look.emission : look.diffuse);
  }

  // Notes which properties of a lit shape's material are left out.
  void NoteLooks(SoCallbackAction& action)
  {
    const Look look = LookOf(action);
    const bool emits = look.Emits() && !look.IsUnlit();
    if (!this->LastMaterial || (!emits && !(look.transparency > 0)))
    {
      return;
    }
    Material& material = this->Current.materials[this->LastMaterial];
    if (material.name.empty())
    {
      const std::string name = this->LastMaterial->getName().getString();
      material.name = name.empty() ? std::to_string(this->Materials++) : QuotedText(name);
    }
    if (emits && !std::exchange(material.emits, true))
    {
      this->Lost.Add(LostLook::Emission, material.name);
    }
    if (look.transparency > 0 && !std::exchange(material.isTransparent, true))
    {
      this->Lost.Add(LostLook::Transparency, material.name);
    }
  }

  // Colours go from 0 to 1. Some programs write them up to 255: such colours are divided by 255.
  void ScaleColors(std::vector<Color>& colors, const std::string& node)
  {
    constexpr double mostBright = 2;
    ColorWhite seen;
    double most = 0;
    for (const Color& color : colors)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        seen.Add(color[k]);
        most = std::max(most, color[k]);
      }
    }
    if (!(most > 1))
    {
      return;
    }
    const double white = most > mostBright ? seen.White() : 1;
    const std::string doubt =
      white == seen.White() ? seen.Doubt() : "and numbers above it count as white";
    this->Warn("in a node " + node + " " + std::to_string(static_cast<int>(white)) + " is white" +
               (doubt.empty() ? "" : ", " + doubt));
    for (Color& color : colors)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        color[k] /= white;
      }
    }
  }

  std::vector<Color> ColorsOfNode(const SoSFNode& field)
  {
    std::vector<Color> colors = ColorsOf(field);
    this->ScaleColors(colors, "Color");
    return colors;
  }

  void ScaleColor(SoSFColor& field)
  {
    const std::vector<Color> before{ ColorOf(field.getValue()) };
    std::vector<Color> colors = before;
    this->ScaleColors(colors, "Material");
    if (colors != before)
    {
      field.setValue(float(colors[0][0]), float(colors[0][1]), float(colors[0][2]));
    }
  }

  void ScaleColorsOf(SoMFColor& field)
  {
    std::vector<Color> before;
    for (int i = 0; i < field.getNum(); ++i)
    {
      before.push_back(ColorOf(field[i]));
    }
    std::vector<Color> colors = before;
    this->ScaleColors(colors, "Material");
    for (int i = 0; i < field.getNum() && colors != before; ++i)
    {
      const Color& color = colors[static_cast<std::size_t>(i)];
      field.set1Value(i, float(color[0]), float(color[1]), float(color[2]));
    }
  }

  static bool IsColored(const Color& color)
  {
    const auto any = [&](auto test) { return std::any_of(color.begin(), color.begin() + 3, test); };
    return any([](double v) { return std::abs(v - vrmlGrey) > 0.01; }) &&
           any([](double v) { return v < 1; });
  }

  std::string NameOf(const SoNode& node)
  {
    const std::string name = node.getName().getString();
    return "shape " + std::to_string(this->Shapes++) +
           (name.empty() ? "" : " (" + QuotedText(name) + ")");
  }

  void AddFaceSet(SoCallbackAction& action, const SoVRMLIndexedFaceSet& node)
  {
    const std::vector<Vec3> points = PointsOf(node.coord);
    VrmlFaces faces;
    faces.points = points;
    // If several shapes share the coordinates by USE, only points in use are kept. Otherwise each
    // shape would have all of them.
    faces.isShared = node.coord.getValue() && node.coord.getValue()->getRefCount() > 1;
    faces.index = IndicesOf(node.coordIndex);
    faces.clockwise = node.ccw.getValue() == 0;
    const std::vector<Color> colors = this->ColorsOfNode(node.color);
    faces.colorValues = colors;
    faces.colors = { colors.size(), node.colorPerVertex.getValue() != 0,
      IndicesOf(node.colorIndex) };
    const auto normals = NormalsOf(node.normal);
    faces.normalValues = normals;
    faces.normals = { node.normalPerVertex.getValue() != 0 ? normals.size() : 0, true,
      IndicesOf(node.normalIndex) };
    const auto ofTexture = TextureCoordinatesOf(node.texCoord);
    faces.coordinateValues = ofTexture;
    faces.coordinates = { ofTexture.size(), true, IndicesOf(node.texCoordIndex) };
    this->AddFaces(action, node, faces);
  }

  // VRML97, 6.17: rows along x, one row after the other along z, heights along y.
  void AddGrid(SoCallbackAction& action, const SoVRMLElevationGrid& node)
  {
    const auto columns = std::int64_t(node.xDimension.getValue());
    const auto rows = std::int64_t(node.zDimension.getValue());
    if (columns < 2 || rows < 2 || columns * rows > std::int64_t(mostGridCorners) ||
        std::int64_t(node.height.getNum()) < columns * rows)
    {
      this->LeaveOutNode(std::string("'ElevationGrid'") + unusable);
      return;
    }
    std::vector<Vec3> points;
    std::vector<std::int32_t> index;
    const float* const heights = node.height.getValues(0);
    for (std::int64_t z = 0; z < rows; ++z)
    {
      for (std::int64_t x = 0; x < columns; ++x)
      {
        const auto at = static_cast<std::int32_t>(z * columns + x);
        points.push_back({ double(x) * double(node.xSpacing.getValue()), ToDouble(heights[at]),
          double(z) * double(node.zSpacing.getValue()) });
        if (x + 1 < columns && z + 1 < rows)
        {
          const auto below = at + static_cast<std::int32_t>(columns);
          index.insert(index.end(), { at, below, below + 1, at + 1, -1 });
        }
      }
    }
    VrmlFaces faces;
    faces.points = points;
    faces.index = index;
    faces.clockwise = node.ccw.getValue() == 0;
    const std::vector<Color> colors = this->ColorsOfNode(node.color);
    faces.colorValues = colors;
    faces.colors = { colors.size(), node.colorPerVertex.getValue() != 0, {} };
    const auto normals = NormalsOf(node.normal);
    faces.normalValues = normals;
    faces.normals = { node.normalPerVertex.getValue() != 0 ? normals.size() : 0, true, {} };
    this->AddFaces(action, node, faces);
  }

  // Face sets of VRML 1: earlier nodes have set their coordinates, materials and hints.
  void AddFirstFaceSet(SoCallbackAction& action, const SoIndexedFaceSet& node)
  {
    const OwnProperties own(action, node);
    const std::vector<Vec3> points = FirstPointsOf(action);
    const std::vector<Color> materials = FirstMaterialsOf(action);
    const std::vector<std::int32_t> inOrder = NumbersInOrder(IndicesOf(node.coordIndex));
    VrmlFaces faces;
    faces.points = points;
    faces.index = IndicesOf(node.coordIndex);
    faces.clockwise = action.getVertexOrdering() == SoShapeHints::CLOCKWISE;
    faces.material = MaterialOf(action);
    faces.colorValues = materials;
    const std::span<const std::int32_t> specified = IndicesOf(node.materialIndex);
    const bool isSpecified =
      specified.size() > 1 || (!specified.empty() && specified[0] >= 0); // the default is [ -1 ]
    const auto index = isSpecified ? specified : std::span<const std::int32_t>();
    switch (action.getMaterialBinding())
    {
      case SoMaterialBinding::PER_PART:
      case SoMaterialBinding::PER_FACE:
        faces.colors = { materials.size(), false, {} };
        break;
      case SoMaterialBinding::PER_PART_INDEXED:
      case SoMaterialBinding::PER_FACE_INDEXED:
        faces.colors = { materials.size(), false, index };
        break;
      case SoMaterialBinding::PER_VERTEX:
        faces.colors = { materials.size(), true, inOrder };
        break;
      case SoMaterialBinding::PER_VERTEX_INDEXED:
        faces.colors = { materials.size(), true, index };
        break;
      default:
        break;
    }
    this->NoteLooks(action);
    Result<ForeignMesh> read = ReadVrmlFaces(faces, this->NameOf(node));
    if (!read)
    {
      this->Fail(read.GetError());
      return;
    }
    this->AddWelded(*read, faces.material, this->PlacedBy(action));
  }

  // Adds a mesh with its own colours, or else with one colour.
  void AddWelded(const ForeignMesh& read, const Color& color, const Transform& placed)
  {
    const Attribute* const colors =
      read.mesh.attributes.empty() ? nullptr : &read.mesh.attributes.front();
    WeldedTriangles welded;
    for (Triangle triangle : read.mesh.triangles)
    {
      for (VertexId& corner : triangle)
      {
        Color own = color;
        for (std::size_t k = 0; k < 3 && colors; ++k)
        {
          own[k] = colors->Get(corner, k) / 255;
        }
        const Vec3& point = read.mesh.points[corner];
        corner = welded.Add({ float(point[0]), float(point[1]), float(point[2]) }, own);
      }
      welded.Triangles.push_back(triangle);
    }
    this->AddTriangles(std::move(welded), placed, read.tolerance);
  }

  void AddFirstPoints(SoCallbackAction& action, const SoPointSet& node)
  {
    const OwnProperties own(action, node);
    std::vector<Vec3> points = FirstPointsOf(action);
    const std::vector<Color> materials = FirstMaterialsOf(action);
    const auto begin = static_cast<std::size_t>(std::max(node.startIndex.getValue(), 0));
    points.erase(
      points.begin(), points.begin() + static_cast<std::ptrdiff_t>(std::min(begin, points.size())));
    if (const std::int32_t count = node.numPoints.getValue(); count >= 0)
    {
      points.resize(std::min(points.size(), static_cast<std::size_t>(count)));
    }
    VrmlFaces faces;
    faces.points = points;
    if (action.getMaterialBinding() != SoMaterialBinding::OVERALL)
    {
      faces.colorValues = materials;
      faces.colors = { materials.size(), true, {} };
    }
    this->AddFaces(action, node, faces, MaterialOfPoints(action));
  }

  // During its lifetime, properties of an Inventor shape are taken from the shape's own node.
  class OwnProperties
  {
  public:
    OwnProperties(SoCallbackAction& action, const SoVertexShape& node)
      : State(*action.getState())
    {
      this->State.push();
      if (auto* const own = static_cast<SoVertexProperty*>(node.vertexProperty.getValue()))
      {
        own->doAction(&action);
      }
    }
    ~OwnProperties() { this->State.pop(); }
    OwnProperties(const OwnProperties&) = delete;
    OwnProperties& operator=(const OwnProperties&) = delete;

  private:
    SoState& State;
  };

  static std::vector<Vec3> FirstPointsOf(SoCallbackAction& action)
  {
    std::vector<Vec3> points;
    for (std::int32_t i = 0; i < action.getNumCoordinates(); ++i)
    {
      points.push_back(ToVec3(action.getCoordinate3(i)));
    }
    return points;
  }

  static std::vector<Color> FirstMaterialsOf(SoCallbackAction& action)
  {
    std::vector<Color> materials;
    for (int i = 0; i < CountOfMaterials(action); ++i)
    {
      materials.push_back(MaterialOf(action, i));
    }
    return materials;
  }

  // Numbers the corners in their order, as indices.
  static std::vector<std::int32_t> NumbersInOrder(std::span<const std::int32_t> index)
  {
    std::vector<std::int32_t> numbers(index.begin(), index.end());
    std::int32_t corner = 0;
    for (std::int32_t& number : numbers)
    {
      number = number < 0 ? -1 : corner++;
    }
    return numbers;
  }

  void AddPoints(SoCallbackAction& action, const SoVRMLPointSet& node)
  {
    const std::vector<Vec3> points = PointsOf(node.coord);
    VrmlFaces faces;
    faces.points = points;
    const std::vector<Color> colors = this->ColorsOfNode(node.color);
    faces.colorValues = colors;
    faces.colors = { colors.size(), true, {} };
    this->AddFaces(action, node, faces, MaterialOfPoints(action));
  }

  void AddFaces(SoCallbackAction& action, const SoNode& node, VrmlFaces& faces)
  {
    this->NoteLooks(action);
    this->AddFaces(action, node, faces, MaterialOf(action));
  }

  void AddFaces(
    SoCallbackAction& action, const SoNode& node, VrmlFaces& faces, const Color& material)
  {
    faces.hasMaterial = IsColored(material);
    faces.material = faces.hasMaterial ? material : Color{ 1, 1, 1, 1 };
    Result<ForeignMesh> part = ReadVrmlFaces(faces, this->NameOf(node));
    if (!part)
    {
      this->Fail(part.GetError());
      return;
    }
    if (faces.isShared)
    {
      TakeUnusedVertices(part->mesh, FindUsedVertices(part->mesh));
    }
    this->AddPart(std::move(*part), this->PlacedBy(action));
  }

  static void AddTriangle(void* reader, SoCallbackAction* action, const SoPrimitiveVertex* a,
    const SoPrimitiveVertex* b, const SoPrimitiveVertex* c)
  {
    auto& self = *static_cast<SceneReader*>(reader);
    if (self.Failure)
    {
      return;
    }
    if (!self.Collected)
    {
      self.Collected = std::make_unique<WeldedTriangles>();
      self.CollectedAt = self.PlacedBy(*action);
    }
    Triangle triangle{};
    const std::array<const SoPrimitiveVertex*, 3> corners{ a, b, c };
    for (std::size_t k = 0; k < 3; ++k)
    {
      triangle[k] = self.Collected->Add(
        corners[k]->getPoint(), MaterialOf(*action, corners[k]->getMaterialIndex()));
    }
    if (self.IsClockwise)
    {
      std::swap(triangle[1], triangle[2]);
    }
    self.Collected->Triangles.push_back(triangle);
  }

  // Adds the triangles that Coin has made of the last shape.
  void FinishTriangles()
  {
    if (this->Collected)
    {
      const std::unique_ptr<WeldedTriangles> collected = std::move(this->Collected);
      ++this->Shapes;
      this->AddTriangles(std::move(*collected), this->CollectedAt, {});
    }
  }

  void AddTriangles(WeldedTriangles welded, const Transform& placed, const Tolerance& tolerance)
  {
    ForeignMesh part;
    part.tolerance = tolerance;
    part.mesh.points = std::move(welded.Points);
    part.mesh.triangles = std::move(welded.Triangles);
    if (std::any_of(welded.Colors.begin(), welded.Colors.end(), IsColored))
    {
      AddColors(part.mesh, welded.Colors);
    }
    this->AddPart(std::move(part), placed);
  }

  void AddPart(ForeignMesh part, const Transform& placed)
  {
    Mesh& mesh = part.mesh;
    const bool identity = placed.IsIdentity();
    Box before, after;
    for (Vec3& point : mesh.points)
    {
      before.Add(point);
      point = identity ? point : placed.Of(point); // keeps -0 as it is
      after.Add(point);
    }
    this->Largest = std::max(this->Largest, LargestCoordinate(before) * placed.Scale());
    // Coordinates become floats, unless a transform has moved the shape so far away that floats
    // would lose it.
    const double largest = LargestCoordinate(after);
    const bool coarse =
      largest > LargestCoordinate(before) && FloatsAreCoarse(largest, LongestSideOf(after));
    mesh.scalarType = coarse ? ScalarType::Float64 : ScalarType::Float32;
    if (mesh.scalarType == ScalarType::Float32)
    {
      for (Vec3& point : mesh.points)
      {
        for (double& x : point)
        {
          const auto rounded = double(static_cast<float>(x));
          this->LosesDecimals = this->LosesDecimals || rounded != x;
          x = rounded;
        }
      }
    }
    const bool mirrors = placed.Determinant() < 0;
    for (Triangle& t : mesh.triangles)
    {
      if (mirrors)
      {
        std::swap(t[1], t[2]);
      }
    }
    for (Attribute& attribute : mesh.attributes)
    {
      if (RoleOf(attribute) == AttributeRole::Normals)
      {
        TurnNormals(attribute, placed, mirrors);
      }
    }
    this->Points += mesh.points.size();
    if (const Status count = CheckPointCount(this->Points); !count)
    {
      this->Fail(count.GetError());
      return;
    }
    this->Parts.push_back(std::move(part));
  }

  static void TurnNormals(Attribute& normals, const Transform& placed, bool mirrors)
  {
    for (std::size_t i = 0; i < normals.TupleCount(); ++i)
    {
      Vec3 n{ normals.Get(i, 0), normals.Get(i, 1), normals.Get(i, 2) };
      const double length = Length(n);
      n = placed.TurnNormal(n);
      const double turned = Length(n);
      const double factor = turned > 0 ? (mirrors ? -1 : 1) * length / turned : 0;
      for (std::size_t k = 0; k < 3; ++k)
      {
        normals.Set(i, k, n[k] * factor);
      }
    }
  }

  // --- What is reported

  void Fail(const Error& error) { this->Failure = this->Failure ? this->Failure : error; }
  void Warn(const std::string& warning)
  {
    if (std::find(this->Warnings.begin(), this->Warnings.end(), warning) == this->Warnings.end() &&
        this->Warnings.size() < 100)
    {
      this->Warnings.push_back(warning);
    }
  }
  void LeaveOut(const std::string& what, std::uint64_t count)
  {
    if (count > 0)
    {
      this->LeftOut[what] += count;
    }
  }

  // Records a node that is left out. which: the node, and why.
  void LeaveOutNode(const std::string& which, std::uint64_t line = 0, std::uint64_t count = 1)
  {
    VrmlLeftOut& left = this->NodesLeftOut[which];
    left.line = left.count == 0 ? line : left.line;
    left.count += count;
  }

  // Counts these nodes as one kind of lapse, and names some of them: those in the first lines.
  void CountNodesLeftOut()
  {
    constexpr std::size_t mostNamed = 5;
    std::vector<std::pair<std::string, VrmlLeftOut>> kinds(
      this->NodesLeftOut.begin(), this->NodesLeftOut.end());
    std::stable_sort(kinds.begin(), kinds.end(),
      [](const auto& a, const auto& b) // nodes without a line come last
      { return a.second.line - 1 < b.second.line - 1; });
    std::uint64_t count = 0;
    std::string names;
    for (std::size_t i = 0; i < kinds.size(); ++i)
    {
      const auto& [which, left] = kinds[i];
      count += left.count;
      if (i < mostNamed)
      {
        names += (i > 0 ? "; " : "") + which +
                 (left.line > 0 ? " (line " + std::to_string(left.line) + ")" : "") +
                 (left.count > 1 ? ", " + std::to_string(left.count) + " times" : "");
      }
    }
    names += kinds.size() > mostNamed ? "; and others" : "";
    this->Tolerated.Count(Lapse::NodeLeftOut, count, names);
  }

  // A material's name for messages, and which of its values were given.
  struct Material
  {
    std::string name;
    bool emits = false, isTransparent = false;
  };

  struct Document
  {
    std::filesystem::path file;
    const std::vector<VrmlUrl>* urls = nullptr;
    Transform placed;      // the transform of the Inline that names this file
    bool byMatrix = false; // transforms that VRML 2 does not have were used
    std::map<const SoNode*, Material> materials{};
    std::optional<FilesBeside> files{};
  };

  const Execution& Exec;
  Document Current;
  std::vector<Transform> Transforms;
  std::size_t Depth = 0, Shapes = 0;
  std::uint64_t Nodes = 0, Points = 0;
  std::set<std::filesystem::path> Inlines; // files being read, to detect cycles
  std::size_t InlinesRead = 0;
  std::unique_ptr<WeldedTriangles> Collected;
  Transform CollectedAt;
  bool IsClockwise = false; // faces of the shape that Coin triangulates
  std::uint64_t ExtrusionCorners = 0, MostExtrusionCorners = mostExtrusionCorners;
  const SoNode* LastMaterial = nullptr;
  std::size_t Materials = 0; // how many without a name were reported
  LostLooks Lost;
  double Largest = 0;         // largest coordinate that was read
  bool LosesDecimals = false; // whether floats lose decimals

  std::vector<ForeignMesh> Parts;
  Tolerance Tolerated;
  std::vector<std::filesystem::path> Named;
  std::map<std::string, std::uint64_t> LeftOut; // nodes that a mesh cannot hold: lines, texts
  VrmlNodesLeftOut NodesLeftOut;
  std::vector<std::string> Warnings;
  std::optional<Error> Failure;
};

}

Result<ForeignMesh> ReadVrml(const std::filesystem::path& file, const Execution& execution)
{
  StartCoin();
  return SceneReader(execution).Read(file);
}

}
