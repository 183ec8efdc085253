// SPDX-License-Identifier: BSD-3-Clause
// Steps: 1. triangles in an order that compresses well, vertices in the order of their use
// 2. vertices as numbers of few bits  3. each array compressed  4. the JSON that tells where all
// that lies.
#include "filters/app/TileGlb.h"

#include "filters/core/Light.h"
#include "filters/core/VectorMath.h"
#include "filters/model/JsonWriter.h"

#ifdef KDSTREAM_HAS_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::uint64_t mostGlbBytes = std::numeric_limits<std::uint32_t>::max();
constexpr double mostShort = 65535;
// Of 16-bit indices the largest one is no index.
constexpr std::size_t mostShortVertices = 65535;

enum TileComponent
{
  TileByte = 5120,
  TileShort = 5123,
  TileInt = 5125,
  TileFloat = 5126
};

constexpr const char* meshoptName = "EXT_meshopt_compression";

// Little-endian, whatever the machine.
template <class T>
void AppendNumber(std::string& bytes, T value)
{
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if constexpr (std::endian::native == std::endian::big)
  {
    std::reverse(raw, raw + sizeof(T));
  }
  bytes.append(raw, sizeof(T));
}

std::uint16_t ShortOf(double part)
{
  return static_cast<std::uint16_t>(std::lround(std::clamp(part, 0.0, 1.0) * mostShort));
}

class TileGlb
{
public:
  TileGlb(const TileMesh& mesh, const TileFrame& frame, TileCompression compression)
    : From(mesh)
    , Frame(frame)
    , Small(compression == TileCompression::Meshopt)
  {
  }

  Result<std::string> Encode()
  {
    this->Order();
    this->AddVertices();
    if (!this->From.triangles.empty())
    {
      this->Triangles = this->AddIndices(this->Shown);
    }
    if (!this->Under.empty())
    {
      this->Skirts = this->AddIndices(this->Under);
    }
    if (!this->From.picture.empty())
    {
      this->Picture = this->AddPlain(
        { reinterpret_cast<const char*>(this->From.picture.data()), this->From.picture.size() }, 0,
        0);
    }
    return this->Join();
  }

private:
  using Indices = std::vector<unsigned>;

  struct View
  {
    std::size_t begin = 0, size = 0;   // of what is in the file
    std::size_t count = 0, stride = 0; // of what it is once it is decompressed
    std::size_t fallback = 0;          // where that would be
    int target = 0;
    const char* mode = nullptr; // null: not compressed
    const char* filter = nullptr;
  };
  struct Accessor
  {
    std::size_t view = 0, count = 0;
    TileComponent component = TileFloat;
    const char* type = "";
    bool normalized = false;
    std::vector<double> least{}, most{};
  };

  // ---- the order of triangles and vertices

  Indices Flat(const std::vector<Triangle>& triangles) const
  {
    Indices flat;
    flat.reserve(3 * triangles.size());
    for (const Triangle& t : triangles)
    {
      flat.insert(flat.end(), t.begin(), t.end());
    }
#ifdef KDSTREAM_HAS_MESHOPTIMIZER
    if (this->Small && !flat.empty())
    {
      Indices ordered(flat.size());
      meshopt_optimizeVertexCacheStrip(
        ordered.data(), flat.data(), flat.size(), this->From.points.size());
      return ordered;
    }
#endif
    return flat;
  }

  void Order()
  {
    this->Shown = this->Flat(this->From.triangles);
    this->Under = this->Flat(this->From.skirts);
    if (this->Shown.empty())
    {
      this->OrderPoints();
      return;
    }
    std::vector<unsigned> numbers(this->From.points.size(), noVertex);
    for (Indices* indices : { &this->Shown, &this->Under })
    {
      for (unsigned& index : *indices)
      {
        unsigned& number = numbers[index];
        if (number == noVertex)
        {
          number = static_cast<unsigned>(this->Used.size());
          this->Used.push_back(index);
        }
        index = number;
      }
    }
  }

  // Those of a cloud: near ones together.
  void OrderPoints()
  {
    const std::size_t count = this->From.points.size();
    this->Used.resize(count);
    for (std::size_t v = 0; v < count; ++v)
    {
      this->Used[v] = static_cast<unsigned>(v);
    }
#ifdef KDSTREAM_HAS_MESHOPTIMIZER
    if (this->Small)
    {
      std::vector<float> places;
      const Box box = this->BoundsOfUsed();
      for (const Vec3& point : this->From.points)
      {
        for (std::size_t k = 0; k < 3; ++k)
        {
          places.push_back(float(point[k] - box.lo[k]));
        }
      }
      std::vector<unsigned> rank(count);
      meshopt_spatialSortRemap(rank.data(), places.data(), count, 3 * sizeof(float));
      for (std::size_t v = 0; v < count; ++v)
      {
        this->Used[rank[v]] = static_cast<unsigned>(v);
      }
    }
#endif
  }

  Box BoundsOfUsed() const
  {
    Box box;
    for (const unsigned v : this->Used)
    {
      box.Add(this->From.points[v]);
    }
    return box;
  }

  // ---- bytes

  std::size_t AddPlain(std::string_view bytes, std::size_t stride, int target)
  {
    this->Bytes.resize((this->Bytes.size() + 3) / 4 * 4, '\0');
    View view;
    view.begin = this->Bytes.size();
    view.size = bytes.size();
    view.stride = stride;
    view.target = target;
    this->Bytes.append(bytes);
    this->Views.push_back(view);
    return this->Views.size() - 1;
  }

  // Of the bytes of what it is once it is decompressed.
  std::size_t AddCompressed(std::string_view bytes, std::size_t count, std::size_t stride,
    int target, const char* mode, const char* filter)
  {
    const std::size_t number = this->AddPlain(bytes, stride, target);
    View& view = this->Views[number];
    view.count = count;
    view.mode = mode;
    view.filter = filter;
    view.fallback = this->FallbackBytes;
    this->FallbackBytes += (count * stride + 3) / 4 * 4;
    return number;
  }

  // values: of all vertices. filter: what decoders do afterwards; null: nothing.
  std::size_t AddAttribute(
    const std::string& values, Accessor accessor, const char* filter = nullptr)
  {
    constexpr int arrayBuffer = 34962;
    const std::size_t count = this->Used.size(), stride = values.size() / count;
#ifdef KDSTREAM_HAS_MESHOPTIMIZER
    if (this->Small)
    {
      std::string packed(meshopt_encodeVertexBufferBound(count, stride), '\0');
      packed.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(packed.data()),
        packed.size(), values.data(), count, stride));
      accessor.view = this->AddCompressed(packed, count, stride, arrayBuffer, "ATTRIBUTES", filter);
    }
    else
#endif
    {
      accessor.view = this->AddPlain(values, stride, arrayBuffer);
    }
    static_cast<void>(filter);
    accessor.count = count;
    this->Accessors.push_back(std::move(accessor));
    return this->Accessors.size() - 1;
  }

  std::size_t AddIndices(const Indices& indices)
  {
    constexpr int elementBuffer = 34963;
    const bool isShort = this->Used.size() <= mostShortVertices;
    Accessor accessor{ 0, indices.size(), isShort ? TileShort : TileInt, "SCALAR" };
#ifdef KDSTREAM_HAS_MESHOPTIMIZER
    if (this->Small)
    {
      std::string packed(meshopt_encodeIndexBufferBound(indices.size(), this->Used.size()), '\0');
      packed.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(packed.data()),
        packed.size(), indices.data(), indices.size()));
      accessor.view = this->AddCompressed(
        packed, indices.size(), isShort ? 2 : 4, elementBuffer, "TRIANGLES", nullptr);
    }
    else
#endif
    {
      std::string bytes;
      for (const unsigned index : indices)
      {
        isShort ? AppendNumber(bytes, static_cast<std::uint16_t>(index))
                : AppendNumber(bytes, static_cast<std::uint32_t>(index));
      }
      accessor.view = this->AddPlain(bytes, 0, elementBuffer);
    }
    this->Accessors.push_back(std::move(accessor));
    return this->Accessors.size() - 1;
  }

  // ---- vertices

  void AddVertices()
  {
    this->AddPositions();
    if (!this->From.normals.empty())
    {
      this->AddNormals();
    }
    if (!this->From.places.empty())
    {
      this->AddPlaces();
    }
    if (!this->From.colors.empty())
    {
      this->AddColors();
    }
  }

  // Where the numbers of positions begin, and how far apart they are.
  void ChooseLattice()
  {
    const Box box = this->BoundsOfUsed();
    double side = 0;
    for (std::size_t k = 0; k < 3; ++k)
    {
      side = std::max(side, box.hi[k] - box.lo[k]);
      this->Begin[k] = this->Small ? box.lo[k] : box.lo[k] + (box.hi[k] - box.lo[k]) / 2;
    }
    if (!this->Small || !(side > 0))
    {
      return;
    }
    this->Step = side / mostShort;
    if (this->Frame.latticeStep > 0)
    {
      const double finest = this->Step * mostShort / (mostShort - 1); // it begins below the box
      for (this->Step = this->Frame.latticeStep; this->Step < finest;)
      {
        this->Step *= 2;
      }
      for (std::size_t k = 0; k < 3; ++k)
      {
        const double origin = this->Frame.latticeOrigin[k];
        this->Begin[k] =
          origin + std::floor((this->Begin[k] - origin) / this->Step + 1e-9) * this->Step;
      }
    }
  }

  void AddPositions()
  {
    this->ChooseLattice();
    std::string bytes;
    Box stored;
    for (const unsigned v : this->Used)
    {
      Vec3 place = Minus(this->From.points[v], this->Begin);
      for (double& value : place)
      {
        if (this->Small)
        {
          value = std::clamp(std::round(value / this->Step), 0.0, mostShort);
          AppendNumber(bytes, static_cast<std::uint16_t>(value));
        }
        else
        {
          value = float(value);
          AppendNumber(bytes, float(value));
        }
      }
      if (this->Small)
      {
        AppendNumber(bytes, std::uint16_t{ 0 }); // vertices begin at multiples of four bytes
      }
      stored.Add(place);
    }
    Accessor accessor{ 0, 0, this->Small ? TileShort : TileFloat, "VEC3", false,
      { stored.lo.begin(), stored.lo.end() }, { stored.hi.begin(), stored.hi.end() } };
    this->Attributes.emplace_back("POSITION", this->AddAttribute(bytes, std::move(accessor)));
  }

  void AddNormals()
  {
#ifdef KDSTREAM_HAS_MESHOPTIMIZER
    if (this->Small)
    {
      std::vector<float> values;
      for (const unsigned v : this->Used)
      {
        for (const double value : this->From.normals[v])
        {
          values.push_back(float(value));
        }
        values.push_back(0);
      }
      constexpr std::size_t stride = 4;
      std::string bytes(stride * this->Used.size(), '\0');
      meshopt_encodeFilterOct(bytes.data(), this->Used.size(), stride, 8, values.data());
      this->Attributes.emplace_back(
        "NORMAL", this->AddAttribute(bytes, { 0, 0, TileByte, "VEC3", true }, "OCTAHEDRAL"));
      return;
    }
#endif
    std::string bytes;
    for (const unsigned v : this->Used)
    {
      for (const double value : this->From.normals[v])
      {
        AppendNumber(bytes, float(value));
      }
    }
    this->Attributes.emplace_back("NORMAL", this->AddAttribute(bytes, { 0, 0, TileFloat, "VEC3" }));
  }

  void AddPlaces()
  {
    std::string bytes;
    for (const unsigned v : this->Used)
    {
      for (const float value : this->From.places[v])
      {
        this->Small ? AppendNumber(bytes, ShortOf(value)) : AppendNumber(bytes, value);
      }
    }
    this->Attributes.emplace_back(
      "TEXCOORD_0", this->AddAttribute(
                      bytes, { 0, 0, this->Small ? TileShort : TileFloat, "VEC2", this->Small }));
  }

  void AddColors()
  {
    std::string bytes;
    for (const unsigned v : this->Used)
    {
      const auto& color = this->From.colors[v];
      for (std::size_t k = 0; k < 4; ++k)
      {
        AppendNumber(bytes, ShortOf(k < 3 ? LinearOfBytes()[color[k]] : color[k] / 255.0));
      }
    }
    this->Attributes.emplace_back(
      "COLOR_0", this->AddAttribute(bytes, { 0, 0, TileShort, "VEC4", true }));
  }

  // ---- the file

  Result<std::string> Join() const
  {
    std::string json = this->Json();
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::size_t binary = (this->Bytes.size() + 3) / 4 * 4;
    const std::uint64_t all = 12 + 8 + std::uint64_t{ json.size() } + 8 + binary;
    if (all > mostGlbBytes)
    {
      return Error{ ErrorCode::LimitExceeded,
        std::to_string(all) + " bytes, more than a .glb can hold: choose a coarser level" };
    }
    std::string file = "glTF";
    AppendNumber(file, std::uint32_t{ 2 });
    AppendNumber(file, static_cast<std::uint32_t>(all));
    AppendNumber(file, static_cast<std::uint32_t>(json.size()));
    file += "JSON" + json;
    AppendNumber(file, static_cast<std::uint32_t>(binary));
    file.append("BIN\0", 4);
    file += this->Bytes;
    file.resize(static_cast<std::size_t>(all), '\0');
    return file;
  }

  bool UsesWebp() const
  {
    return this->Picture && this->From.pictureFormat == TileImage::Webp;
  }
  bool IsUnlit() const
  {
    return this->From.normals.empty() && this->From.triangles.empty();
  }

  std::string Json() const
  {
    JsonWriter json;
    json.BeginObject().Key("asset").BeginObject().Member("version", "2.0");
    json.Member("generator", "KdStream");
    if (!this->Frame.copyright.empty())
    {
      json.Member("copyright", this->Frame.copyright); // clients show it
    }
    json.EndObject();
    this->PutExtensions(json);
    json.Member("scene", 0).Key("scenes").BeginArray().BeginObject().Key("nodes").BeginArray();
    json.Put(0).EndArray().EndObject().EndArray();
    json.Key("nodes").BeginArray().BeginObject().Member("mesh", 0);
    this->PutMatrix(json);
    json.EndObject().EndArray();
    this->PutMesh(json);
    this->PutMaterial(json);
    this->PutAccessors(json);
    this->PutViews(json);
    json.EndObject();
    return json.Text();
  }

  void PutExtensions(JsonWriter& json) const
  {
    std::vector<std::string> required, used;
    if (this->Small)
    {
      required = { meshoptName, "KHR_mesh_quantization" };
    }
    if (this->UsesWebp())
    {
      required.emplace_back("EXT_texture_webp");
    }
    used = required;
    if (this->IsUnlit())
    {
      used.emplace_back("KHR_materials_unlit");
    }
    if (!used.empty())
    {
      json.Member("extensionsUsed", used);
    }
    if (!required.empty())
    {
      json.Member("extensionsRequired", required);
    }
  }

  void PutMatrix(JsonWriter& json) const
  {
    const double step = this->Step * this->Frame.scale;
    const Vec3 place = Times(Minus(this->Begin, this->Frame.origin), this->Frame.scale);
    json.Key("matrix").BeginArray();
    for (std::size_t column = 0; column < 4; ++column)
    {
      for (const Vec3& axis : this->Frame.axes)
      {
        json.Put((column < 3 ? axis[column] * step : Dot(axis, place)) + 0.0); // no -0
      }
      json.Put(column < 3 ? 0 : 1);
    }
    json.EndArray();
  }

  void PutPrimitive(JsonWriter& json, std::optional<std::size_t> indices, bool isSkirt) const
  {
    json.BeginObject().Key("attributes").BeginObject();
    for (const auto& [name, accessor] : this->Attributes)
    {
      json.Member(name, accessor);
    }
    json.EndObject();
    if (indices)
    {
      json.Member("indices", *indices);
    }
    else
    {
      json.Member("mode", 0);
    }
    json.Member("material", 0);
    if (isSkirt)
    {
      json.Key("extras").BeginObject().Member("skirt", true).EndObject();
    }
    json.EndObject();
  }

  void PutMesh(JsonWriter& json) const
  {
    json.Key("meshes").BeginArray().BeginObject().Key("primitives").BeginArray();
    this->PutPrimitive(json, this->Triangles, false);
    if (this->Skirts)
    {
      this->PutPrimitive(json, this->Skirts, true);
    }
    json.EndArray().EndObject().EndArray();
  }

  void PutMaterial(JsonWriter& json) const
  {
    json.Key("materials").BeginArray().BeginObject().Key("pbrMetallicRoughness").BeginObject();
    if (this->Picture)
    {
      json.Key("baseColorTexture").BeginObject().Member("index", 0).EndObject();
    }
    json.Member("metallicFactor", 0).Member("roughnessFactor", 1).EndObject();
    if (this->IsUnlit())
    {
      json.Key("extensions").BeginObject().Key("KHR_materials_unlit").BeginObject().EndObject();
      json.EndObject();
    }
    const auto isClear = [](const auto& color) { return color[3] < 255; };
    if (std::any_of(this->From.colors.begin(), this->From.colors.end(), isClear))
    {
      json.Member("alphaMode", "BLEND");
    }
    json.Member("doubleSided", true).EndObject().EndArray();
    if (!this->Picture)
    {
      return;
    }
    const TileImage format = this->From.pictureFormat;
    json.Key("images").BeginArray().BeginObject();
    json.Member("mimeType", "image/" + std::string(NameOf(format)));
    json.Member("bufferView", *this->Picture).EndObject().EndArray();
    constexpr int linear = 9729, clamp = 33071;
    json.Key("samplers").BeginArray().BeginObject().Member("magFilter", linear);
    json.Member("minFilter", linear).Member("wrapS", clamp).Member("wrapT", clamp);
    json.EndObject().EndArray().Key("textures").BeginArray().BeginObject().Member("sampler", 0);
    if (format == TileImage::Webp)
    {
      json.Key("extensions").BeginObject().Key("EXT_texture_webp").BeginObject();
      json.Member("source", 0).EndObject().EndObject();
    }
    else
    {
      json.Member("source", 0);
    }
    json.EndObject().EndArray();
  }

  void PutAccessors(JsonWriter& json) const
  {
    json.Key("accessors").BeginArray();
    for (const Accessor& accessor : this->Accessors)
    {
      json.BeginObject().Member("bufferView", accessor.view);
      json.Member("componentType", static_cast<int>(accessor.component));
      json.Member("count", accessor.count).Member("type", accessor.type);
      if (accessor.normalized)
      {
        json.Member("normalized", true);
      }
      if (!accessor.least.empty())
      {
        json.Member("min", accessor.least).Member("max", accessor.most);
      }
      json.EndObject();
    }
    json.EndArray();
  }

  void PutViews(JsonWriter& json) const
  {
    json.Key("bufferViews").BeginArray();
    for (const View& view : this->Views)
    {
      const bool packed = view.mode != nullptr;
      json.BeginObject().Member("buffer", packed ? 1 : 0);
      json.Member("byteOffset", packed ? view.fallback : view.begin);
      json.Member("byteLength", packed ? view.count * view.stride : view.size);
      constexpr int arrayBuffer = 34962;
      if (view.stride > 0 && view.target == arrayBuffer)
      {
        json.Member("byteStride", view.stride);
      }
      if (view.target > 0)
      {
        json.Member("target", view.target);
      }
      if (packed)
      {
        json.Key("extensions").BeginObject().Key(meshoptName).BeginObject().Member("buffer", 0);
        json.Member("byteOffset", view.begin).Member("byteLength", view.size);
        json.Member("byteStride", view.stride).Member("count", view.count);
        json.Member("mode", view.mode);
        if (view.filter)
        {
          json.Member("filter", view.filter);
        }
        json.EndObject().EndObject();
      }
      json.EndObject();
    }
    json.EndArray().Key("buffers").BeginArray().BeginObject();
    json.Member("byteLength", this->Bytes.size()).EndObject();
    if (this->FallbackBytes > 0)
    {
      json.BeginObject().Member("byteLength", this->FallbackBytes);
      json.Key("extensions").BeginObject().Key(meshoptName).BeginObject();
      json.Member("fallback", true).EndObject().EndObject().EndObject();
    }
    json.EndArray();
  }

  const TileMesh& From;
  const TileFrame& Frame;
  const bool Small;
  Indices Shown, Under;       // the triangles', and the skirts', numbers among the used vertices
  std::vector<unsigned> Used; // vertices of the mesh
  Vec3 Begin{};               // where the numbers of positions are 0
  double Step = 1;            // between two of them
  std::string Bytes;          // of the binary chunk
  std::size_t FallbackBytes = 0;
  std::vector<View> Views;
  std::vector<Accessor> Accessors;
  std::vector<std::pair<const char*, std::size_t>> Attributes;
  std::optional<std::size_t> Triangles, Skirts, Picture;
};

}

bool HasMeshoptCompression()
{
#ifdef KDSTREAM_HAS_MESHOPTIMIZER
  return true;
#else
  return false;
#endif
}

Result<std::string> EncodeTileGlb(
  const TileMesh& mesh, const TileFrame& frame, TileCompression compression)
{
  if (compression == TileCompression::Meshopt && !HasMeshoptCompression())
  {
    return Error{ ErrorCode::Unsupported,
      "libmeshoptimizer-dev was not there when KdStream was built: use --compression none", {}, {},
      Remedy::Told };
  }
#ifdef KDSTREAM_HAS_MESHOPTIMIZER
  // Those of the extension, for all threads.
  static const bool isSet = (meshopt_encodeVertexVersion(0), meshopt_encodeIndexVersion(1), true);
  static_cast<void>(isSet);
#endif
  return TileGlb(mesh, frame, compression).Encode();
}

}
