// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. Make a primitive for each material; split vertices whose corners have different coordinates.
// 2. Add pictures.
// 3. Write the JSON, which says where everything is and how the model is oriented.
// 4. Write the header, the JSON and the bytes.
#include "filters/app/WriteTextured.h"

#include "filters/core/BitCast.h"
#include "filters/core/VectorMath.h"
#include "filters/meshio/OutputFile.h"
#include "filters/model/JsonWriter.h"
#include "filters/model/ModelDescription.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>

namespace kdstream
{
namespace
{

constexpr std::uint64_t mostBytes = std::numeric_limits<std::uint32_t>::max();
enum ComponentType
{
  UnsignedByte = 5121,
  UnsignedInt = 5125,
  Float = 5126
};

int WrapNumber(TextureWrap wrap)
{
  return wrap == TextureWrap::Clamp ? 33071 : wrap == TextureWrap::Mirror ? 33648 : 10497;
}

class GlbWriter
{
public:
  GlbWriter(const TexturedMesh& textured, const Vec3& up, double metres)
    : Textured(textured)
    , Axes(AxesOf(up))
    , Metres(metres)
    , Normals(FindRole(textured.mesh.attributes, AttributeRole::Normals))
    , Colors(textured.pictures.empty() ? FindRole(textured.mesh.attributes, AttributeRole::Colors)
                                       : nullptr)
  {
    if (textured.mesh.scalarType == ScalarType::Float64)
    {
      Box box;
      std::for_each(textured.mesh.points.begin(), textured.mesh.points.end(),
        [&](const Vec3& point) { box.Add(point); });
      for (std::size_t k = 0; k < 3 && !box.Empty(); ++k)
      {
        this->Origin[k] = box.lo[k] + (box.hi[k] - box.lo[k]) / 2;
      }
    }
  }

  Status Write(const std::filesystem::path& file, const Execution& execution)
  {
    this->AddPrimitives();
    for (const PictureSource& picture : this->Textured.pictures)
    {
      this->Images.push_back(this->AddView(
        { reinterpret_cast<const char*>(picture.bytes.data()), picture.bytes.size() }));
    }
    std::string json = this->Json();
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::uint64_t all = 12 + 8 + json.size() + 8 + this->Bytes.size();
    if (all > mostBytes)
    {
      return Error{ ErrorCode::LimitExceeded,
        std::to_string(all) +
          " bytes, more than a .glb can hold: extract a region, or write an .obj" };
    }
    OutputFile output;
    KDSTREAM_TRY(output.Open(file, execution));
    output.Write("glTF");
    output.WriteLittleEndian(std::uint32_t{ 2 });
    output.WriteLittleEndian(static_cast<std::uint32_t>(all));
    output.WriteLittleEndian(static_cast<std::uint32_t>(json.size()));
    output.Write("JSON");
    output.Write(json);
    output.WriteLittleEndian(static_cast<std::uint32_t>(this->Bytes.size()));
    output.Write(std::string_view("BIN\0", 4));
    output.Write(this->Bytes);
    return output.Finish();
  }

private:
  struct View
  {
    std::size_t begin, size;
  };
  struct Accessor
  {
    std::size_t view, count;
    ComponentType component;
    const char* type;
    bool normalized = false;
    std::vector<double> least{}, most{};
  };
  struct Primitive
  {
    std::size_t material, positions, indices;
    std::optional<std::size_t> normals{}, texture{}, colors{};
  };

  // The directions in the model that become x, y and z in the file: the rows of the node's
  // rotation. Each has length 1 and is orthogonal to the others. The front (FrontOf) becomes +z, as
  // the format requires.
  static std::array<Vec3, 3> AxesOf(const Vec3& up)
  {
    const Vec3 front = FrontOf(up);
    return { Cross(up, front), up, front };
  }

  std::size_t AddView(std::string_view bytes)
  {
    this->Views.push_back({ this->Bytes.size(), bytes.size() });
    this->Bytes.append(bytes);
    this->Bytes.resize((this->Bytes.size() + 3) / 4 * 4, '\0');
    return this->Views.size() - 1;
  }

  std::size_t AddAccessor(const std::string& bytes, Accessor accessor)
  {
    accessor.view = this->AddView(bytes);
    this->Accessors.push_back(std::move(accessor));
    return this->Accessors.size() - 1;
  }

  void AddPrimitives()
  {
    const std::vector<std::size_t> order = TrianglesByMaterial(this->Textured);
    for (auto begin = order.begin(); begin != order.end();)
    {
      const std::uint32_t material = this->Textured.materialOf[*begin];
      const auto end = std::find_if(begin, order.end(),
        [&](std::size_t t) { return this->Textured.materialOf[t] != material; });
      this->AddPrimitive(material, { begin, end });
      begin = end;
    }
  }

  // As floats, as in the format; zeros if the corner has none.
  PictureCoordinate CoordinateOf(const TexturedMaterial& material, std::size_t t, std::size_t k)
  {
    const PictureCoordinate& corner = this->Textured.corners[t][k];
    if (material.picture == noPicture || !std::isfinite(corner[0]) || !std::isfinite(corner[1]))
    {
      return { 0, 0 };
    }
    if (IsIdentity(material.transform))
    {
      return corner;
    }
    const auto place = PictureCoordinateOf(material, corner);
    return { float(place[0]), float(place[1]) };
  }

  void AddPrimitive(std::uint32_t number, const std::vector<std::size_t>& triangles)
  {
    const TexturedMaterial& material = this->Textured.materials[number];
    struct Hash
    {
      std::size_t operator()(const std::pair<VertexId, std::uint64_t>& corner) const
      {
        return corner.first * std::size_t{ 0x9E3779B97F4A7C15 } ^
               std::hash<std::uint64_t>()(corner.second);
      }
    };
    std::unordered_map<std::pair<VertexId, std::uint64_t>, std::uint32_t, Hash> numbers;
    std::vector<VertexId> vertices;
    std::string indices, places;
    for (const std::size_t t : triangles)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        const PictureCoordinate at = this->CoordinateOf(material, t, k);
        const VertexId vertex = this->Textured.mesh.triangles[t][k];
        const auto [entry, isNew] = numbers.try_emplace(
          { vertex, BitCast<std::uint64_t>(at) }, static_cast<std::uint32_t>(vertices.size()));
        if (isNew)
        {
          vertices.push_back(vertex);
          AppendNumber(places, at[0]);
          AppendNumber(places, at[1]);
        }
        AppendNumber(indices, entry->second);
      }
    }
    Primitive primitive{ number, this->AddPositions(vertices),
      this->AddAccessor(indices, { 0, 3 * triangles.size(), UnsignedInt, "SCALAR" }) };
    if (material.picture != noPicture)
    {
      primitive.texture = this->AddAccessor(places, { 0, vertices.size(), Float, "VEC2" });
    }
    if (this->Normals)
    {
      primitive.normals = this->AddNormals(vertices);
    }
    if (this->Colors)
    {
      primitive.colors = this->AddColors(vertices);
    }
    this->Primitives.push_back(primitive);
  }

  std::size_t AddPositions(const std::vector<VertexId>& vertices)
  {
    std::string bytes;
    Box box;
    for (const VertexId vertex : vertices)
    {
      Vec3 place{};
      for (std::size_t k = 0; k < 3; ++k)
      {
        const auto value = float(this->Textured.mesh.points[vertex][k] - this->Origin[k]);
        AppendNumber(bytes, value);
        place[k] = value;
      }
      box.Add(place);
    }
    return this->AddAccessor(
      bytes, { 0, vertices.size(), Float, "VEC3", false, { box.lo.begin(), box.lo.end() },
               { box.hi.begin(), box.hi.end() } });
  }

  // Adds normals; they have length 1, as the format requires.
  std::size_t AddNormals(const std::vector<VertexId>& vertices)
  {
    std::string bytes;
    for (const VertexId v : vertices)
    {
      Vec3 normal{ this->Normals->Get(v, 0), this->Normals->Get(v, 1), this->Normals->Get(v, 2) };
      const double length = std::hypot(normal[0], normal[1], normal[2]);
      normal = length > 0 && std::isfinite(length) ? normal : Vec3{ 0, 0, 1 };
      const double divisor = length > 0 && std::isfinite(length) ? length : 1;
      for (const double value : normal)
      {
        AppendNumber(bytes, float(value / divisor));
      }
    }
    return this->AddAccessor(bytes, { 0, vertices.size(), Float, "VEC3" });
  }

  // Adds colours in linear light, as the format requires.
  std::size_t AddColors(const std::vector<VertexId>& vertices)
  {
    std::string bytes;
    const bool alpha = this->Colors->components == 4;
    for (const VertexId v : vertices)
    {
      for (std::size_t k = 0; k < 4; ++k)
      {
        const double byte = k < 3 || alpha ? this->Colors->Get(v, k) : 255;
        AppendNumber(
          bytes, float(k < 3 ? LinearOfBytes()[static_cast<std::size_t>(byte)] : byte / 255));
      }
    }
    return this->AddAccessor(bytes, { 0, vertices.size(), Float, "VEC4" });
  }

  // ---- JSON

  std::string Json() const
  {
    JsonWriter json;
    json.BeginObject().Key("asset").BeginObject().Member("version", "2.0");
    json.Member("generator", "KdStream").EndObject();
    json.Member("scene", 0).Key("scenes").BeginArray().BeginObject().Key("nodes").BeginArray();
    json.Put(0).EndArray().EndObject().EndArray();
    json.Key("nodes").BeginArray().BeginObject().Member("mesh", 0);
    this->PutPlace(json);
    json.EndObject().EndArray();
    this->PutMesh(json);
    this->PutMaterials(json);
    this->PutImages(json);
    this->PutAccessors(json);
    json.Key("bufferViews").BeginArray();
    for (const View& view : this->Views)
    {
      json.BeginObject().Member("buffer", 0).Member("byteOffset", view.begin);
      json.Member("byteLength", view.size).EndObject();
    }
    json.EndArray().Key("buffers").BeginArray().BeginObject();
    json.Member("byteLength", this->Bytes.size()).EndObject().EndArray().EndObject();
    return json.Text();
  }

  // Writes the node's position, rotation and scale.
  void PutPlace(JsonWriter& json) const
  {
    if (this->Axes[1] != Vec3{ 0, 1, 0 })
    {
      json.Key("matrix").BeginArray();
      for (std::size_t column = 0; column < 4; ++column)
      {
        for (const Vec3& axis : this->Axes)
        {
          const double value = column < 3 ? axis[column] : Dot(axis, this->Origin);
          json.Put(value * this->Metres + 0.0); // avoids -0
        }
        json.Put(column < 3 ? 0 : 1);
      }
      json.EndArray();
      return;
    }
    if (this->Origin != Vec3{})
    {
      const auto& [x, y, z] = this->Origin;
      json.Member("translation", Vec3{ x * this->Metres, y * this->Metres, z * this->Metres });
    }
    if (this->Metres != 1)
    {
      json.Member("scale", Vec3{ this->Metres, this->Metres, this->Metres });
    }
  }

  void PutMesh(JsonWriter& json) const
  {
    json.Key("meshes").BeginArray().BeginObject().Key("primitives").BeginArray();
    for (const Primitive& primitive : this->Primitives)
    {
      json.BeginObject().Key("attributes").BeginObject().Member("POSITION", primitive.positions);
      for (const auto& [name, accessor] : { std::pair{ "NORMAL", primitive.normals },
             { "TEXCOORD_0", primitive.texture }, { "COLOR_0", primitive.colors } })
      {
        if (accessor)
        {
          json.Member(name, *accessor);
        }
      }
      json.EndObject().Member("indices", primitive.indices);
      json.Member("material", primitive.material).EndObject();
    }
    json.EndArray().EndObject().EndArray();
  }

  void PutMaterials(JsonWriter& json) const
  {
    json.Key("materials").BeginArray();
    for (std::size_t i = 0; i < this->Textured.materials.size(); ++i)
    {
      const TexturedMaterial& material = this->Textured.materials[i];
      json.BeginObject().Member("name", material.name).Key("pbrMetallicRoughness").BeginObject();
      if (material.picture != noPicture)
      {
        // A texture for each material, because wrap modes belong to the texture.
        json.Key("baseColorTexture").BeginObject().Member("index", this->TextureOf(i)).EndObject();
      }
      else
      {
        json.Key("baseColorFactor").BeginArray();
        std::for_each(material.color.begin(), material.color.end(),
          [&](double value) { json.Put(std::clamp(value, 0.0, 1.0)); });
        json.EndArray();
      }
      json.Member("metallicFactor", 0).Member("roughnessFactor", 1).EndObject();
      if (!material.opaque)
      {
        json.Member("alphaMode", "BLEND");
      }
      json.Member("doubleSided", true).EndObject();
    }
    json.EndArray();
  }

  // The number of a material among those with pictures.
  std::size_t TextureOf(std::size_t material) const
  {
    return static_cast<std::size_t>(std::count_if(this->Textured.materials.begin(),
      this->Textured.materials.begin() + static_cast<std::ptrdiff_t>(material),
      [](const TexturedMaterial& other) { return other.picture != noPicture; }));
  }

  void PutImages(JsonWriter& json) const
  {
    if (this->Images.empty())
    {
      return;
    }
    json.Key("images").BeginArray();
    for (std::size_t i = 0; i < this->Images.size(); ++i)
    {
      json.BeginObject().Member("name", this->Textured.pictures[i].name);
      json.Member("mimeType", "image/png").Member("bufferView", this->Images[i]).EndObject();
    }
    json.EndArray().Key("samplers").BeginArray();
    std::size_t textures = 0;
    for (const TexturedMaterial& material : this->Textured.materials)
    {
      if (material.picture != noPicture)
      {
        json.BeginObject().Member("magFilter", 9729).Member("minFilter", 9729);
        json.Member("wrapS", WrapNumber(material.wrapU));
        json.Member("wrapT", WrapNumber(material.wrapV)).EndObject();
      }
    }
    json.EndArray().Key("textures").BeginArray();
    for (const TexturedMaterial& material : this->Textured.materials)
    {
      if (material.picture != noPicture)
      {
        json.BeginObject().Member("sampler", textures++);
        json.Member("source", material.picture).EndObject();
      }
    }
    json.EndArray();
  }

  void PutAccessors(JsonWriter& json) const
  {
    json.Key("accessors").BeginArray();
    for (const Accessor& accessor : this->Accessors)
    {
      json.BeginObject().Member("bufferView", accessor.view);
      json.Member("componentType", static_cast<int>(accessor.component));
      json.Member("count", accessor.count).Member("type", accessor.type);
      for (const auto& [name, values] :
        { std::pair{ "min", &accessor.least }, { "max", &accessor.most } })
      {
        if (!values->empty())
        {
          json.Key(name).BeginArray();
          std::for_each(values->begin(), values->end(), [&](double value) { json.Put(value); });
          json.EndArray();
        }
      }
      json.EndObject();
    }
    json.EndArray();
  }

  const TexturedMesh& Textured;
  const std::array<Vec3, 3> Axes;
  const double Metres;
  const Attribute* const Normals;
  const Attribute* const Colors;
  Vec3 Origin{};
  std::string Bytes; // of the binary chunk
  std::vector<View> Views;
  std::vector<Accessor> Accessors;
  std::vector<Primitive> Primitives;
  std::vector<std::size_t> Images; // indices of views
};

}

Status WriteGlb(const std::filesystem::path& file, const TexturedMesh& textured, const Vec3& up,
  double metres, const Execution& execution)
{
  return GlbWriter(textured, up, metres).Write(file, execution);
}

}
