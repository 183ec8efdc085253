// SPDX-License-Identifier: BSD-3-Clause
// Steps for a part:
// 1. open its attributes as accessors, plain or decompressed by Draco
// 2. read places (changed by morph targets), normals, colours, texture coordinates and joints
// 3. read the corners, then make triangles by the part's mode.
#include "filters/convert/gltf/GltfMeshes.h"

#include "filters/convert/gltf/GltfAccessors.h"
#include "filters/convert/gltf/GltfCompression.h"
#include "filters/convert/gltf/GltfNodes.h"
#include "filters/core/VectorMath.h"
#include "filters/meshio/DroppedPoints.h"
#include "filters/meshio/QuotedText.h"
#include "filters/meshio/ShownColors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string_view>

namespace kdstream
{
namespace
{

using Json = nlohmann::json;

// Six of glTF's seven modes, with their numbers. Modes 1 to 3 are lines, and 0 is points.
constexpr int linesMode = 1, lineLoop = 2, lineStrip = 3, trianglesMode = 4, triangleStrip = 5,
              triangleFan = 6;
constexpr int mostSets = 4; // sets of joints: at most 16 joints for a point

// The permitted numbers of components, by the beginning of an attribute's name.
struct AttributeKinds
{
  std::string_view name;
  std::size_t least, most; // components
};
constexpr std::array<AttributeKinds, 6> attributeKinds{ { { "POSITION", 3, 3 }, { "NORMAL", 3, 3 },
  { "TEXCOORD_", 2, 2 }, { "COLOR_", 3, 4 }, { "JOINTS_", 4, 4 }, { "WEIGHTS_", 4, 4 } } };

bool IsOfKind(const std::string& name, const GltfAccessor& accessor)
{
  const auto* const kinds = std::find_if(attributeKinds.begin(), attributeKinds.end(),
    [&](const AttributeKinds& each) { return name.starts_with(each.name); });
  return kinds == attributeKinds.end() ||
         (accessor.Components() >= kinds->least && accessor.Components() <= kinds->most &&
           (kinds->name == "JOINTS_" ? accessor.Type() != GltfComponent::Float
                                     : accessor.Type() != GltfComponent::UnsignedInt));
}

std::string NameOf(std::size_t mesh, std::size_t part)
{
  return "mesh " + std::to_string(mesh) + ", part " + std::to_string(part) + ": ";
}

// Whether this is a skirt, which closes gaps between a tile and its neighbours (doc/3dtiles.md).
bool IsSkirt(const Json& part)
{
  return Member(Member(part, "extras"), "skirt") == true;
}

// A point array that is carried without a change.
struct PlainArray
{
  AttributeInfo info;
  std::string attribute; // its name in the file
};

AttributeType TypeOf(GltfComponent component)
{
  switch (component)
  {
    case GltfComponent::Byte:
      return AttributeType::Int8;
    case GltfComponent::UnsignedByte:
      return AttributeType::UInt8;
    case GltfComponent::Short:
      return AttributeType::Int16;
    case GltfComponent::UnsignedShort:
      return AttributeType::UInt16;
    case GltfComponent::UnsignedInt:
      return AttributeType::UInt32;
    case GltfComponent::Float:
      break;
  }
  return AttributeType::Float32;
}

// For each attribute the name of its property, if the property has the same values.
std::map<std::string, std::string> NamesOfProperties(const Json& json)
{
  static constexpr std::array<std::string_view, 5> taken{ "Normals", "TCoords", "texcoord_1", "RGB",
    "RGBA" };
  const Json& metadata = Member(Member(json, "extensions"), "EXT_structural_metadata");
  const Json& classes = Member(Member(metadata, "schema"), "classes");
  std::map<std::string, std::string> names;
  std::set<std::string> used(taken.begin(), taken.end());
  for (const Json& property : Member(metadata, "propertyAttributes"))
  {
    const Json& kind = Member(property, "class");
    const Json& definitions = Member(
      Member(classes, kind.is_string() ? kind.get<std::string>().c_str() : ""), "properties");
    for (const auto& [id, place] : Member(property, "properties").items())
    {
      const Json& attribute = Member(place, "attribute");
      const Json& definition = Member(definitions, id.c_str());
      const Json& reported = Member(definition, "name");
      const std::string name = reported.is_string() ? reported.get<std::string>() : id;
      const auto changes = [](const Json& values)
      { return values.contains("offset") || values.contains("scale"); };
      if (attribute.is_string() && attribute.get_ref<const std::string&>().starts_with("_") &&
          !changes(place) && !changes(definition) && used.insert(name).second)
      {
        names.emplace(attribute.get<std::string>(), name);
      }
    }
  }
  return names;
}

// The part's arrays that the reader does not use itself, in order.
std::vector<PlainArray> PlainArraysOf(
  const Json& accessors, const Json& attributes, const std::map<std::string, std::string>& names)
{
  static constexpr std::array<std::string_view, 4> used{ "POSITION", "NORMAL", "TANGENT",
    "COLOR_0" };
  std::vector<PlainArray> arrays;
  for (const auto& [name, number] : attributes.items())
  {
    const std::size_t at = IndexIn(accessors, number);
    if (std::find(used.begin(), used.end(), name) != used.end() || name.starts_with("JOINTS_") ||
        name.starts_with("WEIGHTS_") || at == CountOf(accessors))
    {
      continue;
    }
    const Json& accessor = accessors[at];
    PlainArray array{ { name, TypeOf(GltfAccessor::TypeIn(accessor)), AttributeAssociation::Point,
                        static_cast<std::uint8_t>(GltfAccessor::ComponentsIn(accessor)) },
      name };
    if (name.starts_with("TEXCOORD_") || Member(accessor, "normalized") == true)
    {
      array.info.type = AttributeType::Float32;
    }
    array.info.name = name == "TEXCOORD_0"   ? "TCoords"
                      : name == "TEXCOORD_1" ? "texcoord_1" // as VTK's reader names it
                                             : name;
    const auto property = names.find(name);
    array.info.name = property == names.end() ? array.info.name : property->second;
    arrays.push_back(std::move(array));
  }
  std::stable_partition(arrays.begin(), arrays.end(),
    [](const PlainArray& array)
    { return array.attribute.starts_with("TEXCOORD_") && array.info.name != array.attribute; });
  return arrays;
}

// Whether an attribute names an accessor that does not exist. The part is then read without it,
// unless it decides where the points are.
bool IsMissing(const Json& accessors, const std::string& name, const Json& number)
{
  return !number.is_null() && IndexIn(accessors, number) == CountOf(accessors) &&
         name != "POSITION" && !name.starts_with("JOINTS_") && !name.starts_with("WEIGHTS_");
}

// Keeps the values of the points that stay; each point has this number of values.
template <class T>
void KeepOf(const std::vector<bool>& stays, std::size_t elements, std::vector<T>& values)
{
  std::size_t end = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
  {
    if (stays[i / elements])
    {
      values[end++] = values[i];
    }
  }
  values.resize(end);
  values.shrink_to_fit();
}

// Keeps some points of a part. REQUIRES: the points that triangles name stay.
void KeepPoints(const std::vector<bool>& stays, GltfPart& part)
{
  std::vector<VertexId> numbers(stays.size());
  VertexId count = 0;
  for (std::size_t i = 0; i < stays.size(); ++i)
  {
    numbers[i] = count;
    count += stays[i] ? 1 : 0;
  }
  KeepOf(stays, 1, part.points);
  KeepOf(stays, 1, part.normals);
  KeepOf(stays, 1, part.colors);
  KeepOf(stays, 1, part.pictures);
  KeepOf(stays, std::max<std::size_t>(1, part.jointsOfPoint), part.joints);
  for (Attribute& array : part.arrays)
  {
    KeepOf(stays, array.TupleSize(), array.values);
  }
  for (Triangle& triangle : part.triangles)
  {
    triangle = { numbers[triangle[0]], numbers[triangle[1]], numbers[triangle[2]] };
  }
}

// For an accessor that other parts use, too: keeps the points that this part's triangles name.
void KeepNamedPoints(GltfPart& part)
{
  std::vector<bool> stays(part.points.size());
  for (const Triangle& triangle : part.triangles)
  {
    for (const VertexId corner : triangle)
    {
      stays[corner] = true;
    }
  }
  if (!part.triangles.empty())
  {
    KeepPoints(stays, part);
  }
}

// Drops points that are not finite, and triangles that name them, before textures are baked to the
// others.
void DropPointsNotFinite(GltfPart& part, const std::string& named, Tolerance& dropped)
{
  std::vector<bool> stays(part.points.size());
  for (std::size_t i = 0; i < stays.size(); ++i)
  {
    stays[i] = IsFinite(part.points[i]);
    if (!stays[i])
    {
      dropped.Count(Lapse::PointNotFinite, 1,
        dropped.Of(Lapse::PointNotFinite) == 0 ? named + "vertex " + std::to_string(i) : "");
    }
  }
  if (std::find(stays.begin(), stays.end(), false) == stays.end())
  {
    return;
  }
  dropped.Count(Lapse::FaceOfDroppedPoint, std::erase_if(part.triangles,
                                             [&](const Triangle& t) {
                                               return !std::all_of(t.begin(), t.end(),
                                                 [&](VertexId corner) { return stays[corner]; });
                                             }));
  KeepPoints(stays, part);
}

std::vector<Triangle> TrianglesOf(int mode, const std::vector<std::uint32_t>& corners)
{
  std::vector<Triangle> triangles;
  const std::size_t count = corners.size();
  if (mode == trianglesMode)
  {
    triangles.reserve(count / 3);
    for (std::size_t i = 0; i + 2 < count; i += 3)
    {
      triangles.push_back({ corners[i], corners[i + 1], corners[i + 2] });
    }
  }
  for (std::size_t i = 2; i < count && (mode == triangleStrip || mode == triangleFan); ++i)
  {
    const std::uint32_t a = corners[mode == triangleFan ? 0 : i - 2], b = corners[i - 1];
    const bool turned = mode == triangleStrip && i % 2 == 1;
    triangles.push_back(turned ? Triangle{ b, a, corners[i] } : Triangle{ a, b, corners[i] });
  }
  return triangles;
}

}

// Reads one part.
class GltfMeshes::Reader
{
public:
  Reader(GltfMeshes& meshes, const Json& json)
    : Meshes(meshes)
    , Accessors(Member(meshes.Document.json, "accessors"))
    , Part(json)
    , Attributes(Member(json, "attributes"))
  {
  }

  // weights: of its morph targets. named: names the part, in messages about what is left out.
  Result<std::optional<GltfPart>> Read(const Json& weights, const std::string& named)
  {
    const double mode = WholeOf(Member(this->Part, "mode"), trianglesMode);
    if (mode < 0 || mode > triangleFan)
    {
      return GltfError("unknown mode " + QuotedText(Member(this->Part, "mode").dump()));
    }
    const Json& position = Member(this->Attributes, "POSITION");
    const std::size_t at = IndexIn(this->Accessors, position);
    const double claimed =
      at < CountOf(this->Accessors) ? WholeOf(Member(this->Accessors[at], "count"), 0) : 1;
    if (claimed < 0)
    {
      return GltfError("'POSITION' has a count that is not a whole number of at least 0");
    }
    // If it claims no points, none are read, even if compressed data has some: ClaimsOf has counted
    // none.
    if (position.is_null() || claimed == 0)
    {
      return std::optional<GltfPart>();
    }
    KDSTREAM_TRY(this->Decompress());
    const Result<GltfAccessor> places = this->Open("POSITION");
    KDSTREAM_TRY(places);
    this->Count = places->Count();
    const bool isShared = this->Meshes.IsShared(this->Part);
    const Result<std::vector<std::uint32_t>> corners = this->ReadCorners();
    if (isShared && corners && corners->size() >= 3)
    {
      this->Named.assign(this->Count, false);
      for (const std::uint32_t corner : *corners)
      {
        this->Named[corner] = true;
      }
    }
    GltfPart part;
    part.points = this->VectorsOf(*places);
    KDSTREAM_TRY(this->ReadAttributes(part, named));
    KDSTREAM_TRY(this->AddShapes(weights, part));
    KDSTREAM_TRY(corners);
    this->Join(static_cast<int>(mode), *corners, named, part);
    this->CountMissing(named, std::max<std::size_t>(1, part.triangles.size()));
    if (isShared)
    {
      KeepNamedPoints(part);
    }
    DropPointsNotFinite(part, named, this->Meshes.DroppedPoints);
    return std::optional(std::move(part));
  }

private:
  // Decompresses KHR_draco_mesh_compression.
  Status Decompress()
  {
    const Json& draco = Member(Member(this->Part, "extensions"), "KHR_draco_mesh_compression");
    if (draco.is_null())
    {
      return {};
    }
    const Json& views = Member(this->Meshes.Document.json, "bufferViews");
    const std::size_t at = IndexIn(views, Member(draco, "bufferView"));
    if (at == CountOf(views))
    {
      return GltfError(NamesNone("bufferView", Member(draco, "bufferView"), views));
    }
    const Result<GltfBuffers::View> view = this->Meshes.Buffers.ViewOf(at);
    if (!view)
    {
      return Within("its bufferView " + std::to_string(at) + " ", view.GetError());
    }
    std::map<std::string, std::uint32_t> numbers;
    std::set<std::string> normalized;
    for (const auto& [name, number] : Member(draco, "attributes").items())
    {
      const double whole = WholeOf(number, -1);
      if (whole < 0 || whole > std::numeric_limits<std::uint32_t>::max())
      {
        return GltfError(QuotedText(name) + " names no attribute of what Draco compressed");
      }
      const std::size_t accessor = IndexIn(this->Accessors, Member(this->Attributes, name.c_str()));
      if (accessor < CountOf(this->Accessors))
      {
        numbers.emplace(name, static_cast<std::uint32_t>(whole));
        if (Member(this->Accessors[accessor], "normalized") == true)
        {
          normalized.insert(name);
        }
      }
    }
    Result<DracoPart> decoded = DecodeDraco(view->bytes, numbers, normalized);
    if (!decoded)
    {
      // A file may also have the uncompressed part, for programs that cannot decompress.
      const std::size_t plain = IndexIn(this->Accessors, Member(this->Attributes, "POSITION"));
      return plain < CountOf(this->Accessors) &&
                 !Member(this->Accessors[plain], "bufferView").is_null()
               ? Status{}
               : Status(decoded.GetError());
    }
    this->Draco = std::move(*decoded);
    return {};
  }

  bool Has(const std::string& name) const
  {
    const Json& number = Member(this->Attributes, name.c_str());
    return !number.is_null() && !IsMissing(this->Accessors, name, number);
  }

  void CountMissing(const std::string& named, std::size_t triangles)
  {
    for (const auto& [name, number] : this->Attributes.items())
    {
      if (IsMissing(this->Accessors, name, number))
      {
        this->Meshes.DroppedPoints.Count(Lapse::AttributeMissing, triangles,
          named + QuotedText(name) + " " + NamesNone("accessor", number, this->Accessors));
        return;
      }
    }
  }

  // Opens an attribute of `Attributes`; its kind must be one that is read.
  Result<GltfAccessor> Open(const std::string& name)
  {
    const auto found =
      this->Draco ? this->Draco->attributes.find(name) : decltype(this->Draco->attributes.end())();
    Result<GltfAccessor> accessor = this->Draco && found != this->Draco->attributes.end()
                                      ? Result<GltfAccessor>(found->second)
                                      : this->OpenIn(this->Attributes, name);
    KDSTREAM_TRY(accessor);
    if (!IsOfKind(name, *accessor))
    {
      const Json& number = Member(this->Attributes, name.c_str());
      const std::size_t at = IndexIn(this->Accessors, number);
      const Json none;
      const Json& json = at < CountOf(this->Accessors) ? this->Accessors[at] : none;
      return GltfError(QuotedText(name) + " has a type that cannot be read: type " +
                       QuotedText(Member(json, "type").dump()) + ", componentType " +
                       QuotedText(Member(json, "componentType").dump()));
    }
    if (name != "POSITION" && accessor->Count() != this->Count)
    {
      return GltfError(QuotedText(name) + " has another number of elements than 'POSITION'");
    }
    return accessor;
  }

  Result<GltfAccessor> OpenIn(const Json& attributes, const std::string& name)
  {
    const Json& number = Member(attributes, name.c_str());
    const std::size_t at = IndexIn(this->Accessors, number);
    return at < CountOf(this->Accessors)
             ? GltfAccessor::Open(this->Meshes.Document, this->Meshes.Buffers, at)
             : GltfError(QuotedText(name) + " " + NamesNone("accessor", number, this->Accessors));
  }

  // Whether to read a point. If other parts use the accessor, too, only points that this part names
  // are read.
  bool Needs(std::size_t point) const { return this->Named.empty() || this->Named[point]; }

  std::vector<Vec3> VectorsOf(const GltfAccessor& accessor) const
  {
    std::vector<Vec3> vectors(accessor.Count());
    for (std::size_t i = 0; i < vectors.size(); ++i)
    {
      if (!this->Needs(i))
      {
        continue;
      }
      vectors[i] = { accessor.Part(i, 0), accessor.Part(i, 1), accessor.Part(i, 2) };
    }
    return vectors;
  }

  Status ReadAttributes(GltfPart& part, const std::string& named)
  {
    const std::vector<GltfMaterial>& materials = this->Meshes.Materials;
    part.material = std::min(
      IndexIn(Member(this->Meshes.Document.json, "materials"), Member(this->Part, "material")),
      materials.size());
    if (this->Has("NORMAL"))
    {
      const Result<GltfAccessor> normals = this->Open("NORMAL");
      KDSTREAM_TRY(normals);
      part.normals = this->VectorsOf(*normals);
    }
    if (this->Has("COLOR_0"))
    {
      const Result<GltfAccessor> colors = this->Open("COLOR_0");
      KDSTREAM_TRY(colors);
      this->ReadColors(*colors, part.colors, named);
    }
    const std::string pictures =
      "TEXCOORD_" +
      std::to_string(part.material < materials.size() ? materials[part.material].coordinates : 0);
    if (this->Has(pictures))
    {
      const Result<GltfAccessor> coordinates = this->Open(pictures);
      KDSTREAM_TRY(coordinates);
      part.pictures.resize(this->Count);
      for (std::size_t i = 0; i < this->Count; ++i)
      {
        if (!this->Needs(i))
        {
          continue;
        }
        part.pictures[i] = { float(coordinates->Part(i, 0)), float(coordinates->Part(i, 1)) };
      }
    }
    for (const PlainArray& array :
      PlainArraysOf(this->Accessors, this->Attributes, this->Meshes.ArrayNames))
    {
      const Result<GltfAccessor> values = this->Open(array.attribute);
      KDSTREAM_TRY(values);
      if (values->Components() != array.info.components)
      {
        return GltfError(QuotedText(array.attribute) +
                         " has another type in its accessor than in the compressed data");
      }
      Attribute& read = part.arrays.emplace_back();
      static_cast<AttributeInfo&>(read) = array.info;
      read.values.resize(this->Count * read.TupleSize());
      for (std::size_t i = 0; i < this->Count; ++i)
      {
        for (std::size_t k = 0; k < read.components && this->Needs(i); ++k)
        {
          read.Set(i, k, values->Part(i, k));
        }
      }
    }
    return this->ReadJoints(part);
  }

  // glTF's float colours go from 0 to 1; some programs write them up to 255 or 65535.
  void ReadColors(
    const GltfAccessor& accessor, std::vector<Color>& colors, const std::string& named)
  {
    ColorWhite white;
    colors.assign(this->Count, Color{ 1, 1, 1, 1 });
    for (std::size_t i = 0; i < this->Count; ++i)
    {
      for (std::size_t k = 0; k < accessor.Components() && this->Needs(i); ++k)
      {
        colors[i][k] = accessor.Part(i, k, true);
        if (k < 3)
        {
          white.Add(colors[i][k]);
        }
      }
    }
    const double most = white.White();
    for (Color& color : colors)
    {
      for (std::size_t k = 0; k < color.size() && most > 1; ++k)
      {
        color[k] /= k < 3 || color[k] > 1 ? most : 1;
      }
    }
    const std::string doubt = white.Doubt();
    if ((most > 1 || !doubt.empty()) && this->Meshes.BrightParts.insert(named).second &&
        this->Meshes.FirstBright.empty())
    {
      this->Meshes.FirstBright = named + "in COLOR_0 " + std::to_string(static_cast<int>(most)) +
                                 " is white" + (doubt.empty() ? "" : ", " + doubt);
    }
  }

  Status ReadJoints(GltfPart& part)
  {
    for (int set = 0; set < mostSets; ++set)
    {
      const std::string number = std::to_string(set);
      if (!this->Has("JOINTS_" + number) || !this->Has("WEIGHTS_" + number))
      {
        return {};
      }
      const Result<GltfAccessor> joints = this->Open("JOINTS_" + number);
      KDSTREAM_TRY(joints);
      const Result<GltfAccessor> weights = this->Open("WEIGHTS_" + number);
      KDSTREAM_TRY(weights);
      std::vector<std::pair<std::uint32_t, double>> all;
      const std::size_t before = part.jointsOfPoint;
      for (std::size_t i = 0; i < this->Count; ++i)
      {
        all.insert(all.end(), part.joints.begin() + static_cast<std::ptrdiff_t>(i * before),
          part.joints.begin() + static_cast<std::ptrdiff_t>((i + 1) * before));
        for (std::size_t k = 0; k < 4; ++k)
        {
          all.push_back({ static_cast<std::uint32_t>(std::max(0.0, joints->Get(i, k))),
            weights->Part(i, k, true) });
        }
      }
      part.joints = std::move(all);
      part.jointsOfPoint += 4;
    }
    return {};
  }

  // Adds morph targets by their weights.
  Status AddShapes(const Json& weights, GltfPart& part)
  {
    const Json& targets = Member(this->Part, "targets");
    for (std::size_t i = 0; i < std::min(CountOf(targets), CountOf(weights)); ++i)
    {
      const double weight = NumberOf(weights[i], 0);
      if (weight == 0)
      {
        continue;
      }
      for (const auto& [name, vectors] :
        { std::pair{ "POSITION", &part.points }, std::pair{ "NORMAL", &part.normals } })
      {
        if (Member(targets[i], name).is_null() || vectors->empty())
        {
          continue;
        }
        const Result<GltfAccessor> moved = this->OpenIn(targets[i], name);
        KDSTREAM_TRY(moved);
        if (!IsOfKind(name, *moved) || moved->Count() != this->Count)
        {
          return GltfError(
            "its shape " + std::to_string(i) + ": " + QuotedText(name) +
            " has another type or another number of elements than the part's attribute");
        }
        for (std::size_t v = 0; v < this->Count; ++v)
        {
          for (std::size_t k = 0; k < 3; ++k)
          {
            (*vectors)[v][k] += weight * moved->Part(v, k);
          }
        }
      }
    }
    return {};
  }

  Result<std::vector<std::uint32_t>> ReadCorners()
  {
    std::vector<std::uint32_t> corners;
    const Json& indices = Member(this->Part, "indices");
    if (this->Draco)
    {
      corners = std::move(this->Draco->corners);
    }
    else if (indices.is_null())
    {
      corners.resize(this->Count);
      for (std::size_t i = 0; i < this->Count; ++i)
      {
        corners[i] = static_cast<std::uint32_t>(i);
      }
      return corners;
    }
    else
    {
      const Result<GltfAccessor> accessor = this->OpenIn(this->Part, "indices");
      KDSTREAM_TRY(accessor);
      const Json& json = this->Accessors[IndexIn(this->Accessors, indices)];
      const GltfComponent type = accessor->Type();
      if (accessor->Components() != 1 ||
          (type != GltfComponent::UnsignedByte && type != GltfComponent::UnsignedShort &&
            type != GltfComponent::UnsignedInt) ||
          (Member(json, "bufferView").is_null() && Member(json, "sparse").is_null()))
      {
        return GltfError("'indices' are not whole numbers");
      }
      corners.resize(accessor->Count());
      for (std::size_t i = 0; i < corners.size(); ++i)
      {
        corners[i] = static_cast<std::uint32_t>(accessor->Get(i, 0));
      }
    }
    const auto bad = std::find_if(
      corners.begin(), corners.end(), [&](std::uint32_t corner) { return corner >= this->Count; });
    return bad == corners.end()
             ? Result<std::vector<std::uint32_t>>(std::move(corners))
             : GltfError("its index " + std::to_string(bad - corners.begin()) + " names vertex " +
                         std::to_string(*bad) + ", but there are " + std::to_string(this->Count));
  }

  void Join(
    int mode, const std::vector<std::uint32_t>& corners, const std::string& named, GltfPart& part)
  {
    const std::size_t count = corners.size();
    part.lines = mode == linesMode                       ? count / 2
                 : mode == lineLoop || mode == lineStrip ? std::min<std::size_t>(count, 1)
                                                         : 0;
    // Draco's data is triangles, whatever the mode is.
    part.triangles = TrianglesOf(this->Draco ? trianglesMode : mode, corners);
    if (mode == trianglesMode && count % 3 > 0)
    {
      this->Meshes.DroppedPoints.Count(Lapse::FaceTooSmall, 1,
        named + "the last of " + std::to_string(count) +
          (Member(this->Part, "indices").is_null() ? " vertices" : " indices") +
          " of triangles, which is not a multiple of three");
    }
  }

  GltfMeshes& Meshes;
  const Json& Accessors;
  const Json& Part;
  const Json& Attributes;
  std::optional<DracoPart> Draco;
  std::size_t Count = 0;   // number of points
  std::vector<bool> Named; // shared places: those that this part names; else empty
};

GltfMeshes::GltfMeshes(
  const GltfDocument& document, GltfBuffers& buffers, const std::vector<GltfMaterial>& materials)
  : Document(document)
  , Buffers(buffers)
  , Materials(materials)
  , ArrayNames(NamesOfProperties(document.json))
{
  for (const Json& mesh : Member(document.json, "meshes"))
  {
    for (const Json& part : Member(mesh, "primitives"))
    {
      ++this->PartsOfPlaces[this->PlacesOf(part)];
    }
  }
}

Tolerance GltfMeshes::Dropped() const
{
  Tolerance all = this->DroppedPoints;
  if (const std::size_t parts = this->BrightParts.size(); parts > 0)
  {
    all.Tell(this->FirstBright +
             (parts > 1 ? "; the same or alike in " + std::to_string(parts - 1) + " more parts"
                        : std::string()));
  }
  return all;
}

std::size_t GltfMeshes::PlacesOf(const Json& part) const
{
  return IndexIn(
    Member(this->Document.json, "accessors"), Member(Member(part, "attributes"), "POSITION"));
}

bool GltfMeshes::IsShared(const Json& part) const
{
  const auto found = this->PartsOfPlaces.find(this->PlacesOf(part));
  const double mode = WholeOf(Member(part, "mode"), trianglesMode);
  return mode >= trianglesMode && !Member(part, "indices").is_null() &&
         found != this->PartsOfPlaces.end() && found->second > 1 &&
         Member(Member(part, "extensions"), "KHR_draco_mesh_compression").is_null();
}

void GltfMeshes::Claims::Add(const Claims& other)
{
  this->points += other.points;
  this->triangles += other.triangles;
  this->parts += other.parts;
  this->coloured += other.coloured;
  this->zeros += other.zeros;
  this->skirts += other.skirts;
  for (const auto& [info, count] : other.arrays)
  {
    const auto found = std::find_if(this->arrays.begin(), this->arrays.end(),
      [&, &wanted = info](const auto& known) { return known.first == wanted; });
    if (found == this->arrays.end())
    {
      this->arrays.push_back({ info, count });
    }
    else
    {
      found->second += count;
    }
  }
}

// The count of an accessor; 0 if there is no accessor.
Result<double> GltfMeshes::CountedBy(const Json& number) const
{
  const Json& accessors = Member(this->Document.json, "accessors");
  const std::size_t at = IndexIn(accessors, number);
  if (at == CountOf(accessors))
  {
    return 0;
  }
  // A sparse accessor is checked later by the reader, because opening it takes memory.
  if (!Member(accessors[at], "bufferView").is_null() && Member(accessors[at], "sparse").is_null())
  {
    const Result<GltfAccessor> held = GltfAccessor::Open(this->Document, this->Buffers, at);
    KDSTREAM_TRY(held);
  }
  return std::max(0.0, WholeOf(Member(accessors[at], "count"), 0));
}

// How many elements of a part have no bytes in the file. Compressed data does not count: it has its
// bytes elsewhere.
std::uint64_t GltfMeshes::ZerosOf(const Json& part) const
{
  const Json& accessors = Member(this->Document.json, "accessors");
  std::uint64_t zeros = 0;
  const auto add = [&](const Json& number)
  {
    const std::size_t at = IndexIn(accessors, number);
    const double count = at < CountOf(accessors) ? WholeOf(Member(accessors[at], "count"), 0) : 0;
    // Larger counts are refused when they are read.
    if (count > 0 && count <= double(GltfAccessor::mostZeros) &&
        Member(accessors[at], "bufferView").is_null())
    {
      zeros += static_cast<std::uint64_t>(count);
    }
  };
  if (Member(Member(part, "extensions"), "KHR_draco_mesh_compression").is_null())
  {
    add(Member(part, "indices"));
    for (const Json& number : Member(part, "attributes"))
    {
      add(number);
    }
  }
  return zeros;
}

Result<GltfMeshes::Claims> GltfMeshes::ClaimsOf(std::size_t mesh) const
{
  const Json& parts = Member(Member(this->Document.json, "meshes")[mesh], "primitives");
  Claims claims;
  for (std::size_t i = 0; i < CountOf(parts); ++i)
  {
    if (IsSkirt(parts[i]))
    {
      ++claims.skirts;
      continue;
    }
    const Json &attributes = Member(parts[i], "attributes"), &indices = Member(parts[i], "indices");
    const auto has = [&](const char* name)
    {
      const Json& number = Member(attributes, name);
      return !number.is_null() &&
             !IsMissing(Member(this->Document.json, "accessors"), name, number);
    };
    const Result<double> points = this->CountedBy(Member(attributes, "POSITION"));
    const Result<double> corners = indices.is_null() ? points : this->CountedBy(indices);
    if (!points || !corners)
    {
      return Within(NameOf(mesh, i), (points ? corners : points).GetError());
    }
    if (*points == 0)
    {
      continue;
    }
    const std::size_t material =
      IndexIn(Member(this->Document.json, "materials"), Member(parts[i], "material"));
    const bool tinted = material < this->Materials.size() &&
                        this->Materials[material].textured.factor != Color{ 1, 1, 1, 1 };
    const bool apart = NumberOf(Member(parts[i], "mode"), trianglesMode) == trianglesMode;
    const double most = this->IsShared(parts[i]) ? std::min(*points, *corners) : *points;
    Claims claimed{ static_cast<std::uint64_t>(most),
      static_cast<std::uint64_t>(apart ? *corners / 3 : *corners), 1,
      tinted || has("COLOR_0") ? 1U : 0U, this->ZerosOf(parts[i]) };
    if (has("NORMAL"))
    {
      claimed.arrays.push_back(
        { { "Normals", AttributeType::Float32, AttributeAssociation::Point, 3 }, 1 });
    }
    for (PlainArray& array :
      PlainArraysOf(Member(this->Document.json, "accessors"), attributes, this->ArrayNames))
    {
      claimed.arrays.push_back({ std::move(array.info), 1 });
    }
    claims.Add(claimed);
    if (claims.points >= noVertex)
    {
      break; // too many points; an error follows later
    }
  }
  return claims;
}

Result<std::vector<GltfPart>> GltfMeshes::PartsOf(std::size_t mesh, const Json& weights)
{
  const Json& json = Member(this->Document.json, "meshes")[mesh];
  const Json& parts = Member(json, "primitives");
  std::vector<GltfPart> read;
  for (std::size_t i = 0; i < CountOf(parts); ++i)
  {
    const std::string named = NameOf(mesh, i);
    if (IsSkirt(parts[i]))
    {
      continue;
    }
    Result<std::optional<GltfPart>> part =
      Reader(*this, parts[i]).Read(weights.is_null() ? Member(json, "weights") : weights, named);
    if (!part)
    {
      return Within(named, part.GetError());
    }
    if (*part && !(*part)->points.empty())
    {
      read.push_back(std::move(**part));
    }
  }
  return read;
}

Status ApplyGltfSkin(const GltfDocument& document, GltfBuffers& buffers, const GltfNodes& nodes,
  std::size_t skin, GltfPart& part)
{
  const Json& json = Member(document.json, "skins")[skin];
  const Json& joints = Member(json, "joints");
  const Json& matrices = Member(json, "inverseBindMatrices");
  const std::string named = "skin " + std::to_string(skin) + ": ";
  std::optional<GltfAccessor> inverse;
  if (!matrices.is_null())
  {
    const Json& accessors = Member(document.json, "accessors");
    const std::size_t at = IndexIn(accessors, matrices);
    if (at == CountOf(accessors))
    {
      return GltfError(named + NamesNone("accessor", matrices, accessors));
    }
    Result<GltfAccessor> opened = GltfAccessor::Open(document, buffers, at);
    KDSTREAM_TRY(opened);
    if (opened->Components() != 16 || opened->Count() < CountOf(joints))
    {
      return GltfError(named + "its inverseBindMatrices do not have a matrix for each joint");
    }
    inverse = std::move(*opened);
  }
  std::vector<GltfPlace> places(CountOf(joints));
  for (std::size_t i = 0; i < places.size(); ++i)
  {
    const Json& all = Member(document.json, "nodes");
    const std::size_t node = IndexIn(all, joints[i]);
    if (node == CountOf(all))
    {
      return GltfError(named + NamesNone("node", joints[i], all));
    }
    GltfPlace bound;
    for (std::size_t k = 0; inverse && k < 3; ++k)
    {
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        bound.axes[axis][k] = inverse->Get(i, 4 * axis + k);
      }
      bound.origin[k] = inverse->Get(i, 12 + k);
    }
    places[i] = Combined(nodes.PlaceInScene(node), bound);
  }
  std::vector<bool> mirrored(part.points.size());
  for (std::size_t v = 0; v < part.points.size(); ++v)
  {
    GltfPlace place{ { Vec3{}, Vec3{}, Vec3{} }, {} };
    double sum = 0;
    for (std::size_t k = 0; k < part.jointsOfPoint; ++k)
    {
      const auto& [joint, weight] = part.joints[v * part.jointsOfPoint + k];
      if (weight == 0)
      {
        continue;
      }
      if (joint >= places.size())
      {
        return GltfError(named + "vertex " + std::to_string(v) + " names joint " +
                         std::to_string(joint) + ", but there are " +
                         std::to_string(places.size()));
      }
      for (std::size_t axis = 0; axis < 3; ++axis)
      {
        place.axes[axis] = Plus(place.axes[axis], Times(places[joint].axes[axis], weight));
      }
      place.origin = Plus(place.origin, Times(places[joint].origin, weight));
      sum += weight;
    }
    for (std::size_t axis = 0; axis < 3 && sum != 0; ++axis)
    {
      place.axes[axis] = Times(place.axes[axis], 1 / sum);
    }
    place = sum != 0 ? GltfPlace{ place.axes, Times(place.origin, 1 / sum) } : GltfPlace{};
    part.points[v] = place.Of(part.points[v]);
    if (!part.normals.empty())
    {
      part.normals[v] = place.OfNormal(part.normals[v]);
    }
    mirrored[v] = place.Determinant() < 0;
  }
  for (Triangle& triangle : part.triangles)
  {
    if (mirrored[triangle[0]])
    {
      std::swap(triangle[1], triangle[2]);
    }
  }
  return {};
}

}
