// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. Put triangles into an order that compresses well, and vertices into the order of their use.
// 2. Store vertices as numbers of few bits.
// 3. Compress each array.
// 4. Write the JSON that says where everything is.
#include "filters/tiles/TileGlb.h"

#include "filters/core/BitCast.h"
#include "filters/core/Light.h"
#include "filters/core/VectorMath.h"
#include "filters/model/JsonWriter.h"

#ifdef KDSTREAM_HAS_DRACO
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#endif
#ifdef KDSTREAM_HAS_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::uint64_t mostGlbBytes = std::numeric_limits<std::uint32_t>::max();
constexpr double mostShort = 65535;
// The largest whole number, of either sign, in the float format for wide meshes.
constexpr double mostWide = (1U << 22U) - 1;
// The largest 16-bit number is reserved, and must not be an index.
constexpr std::size_t mostShortVertices = 65535;

enum TileComponent
{
  TileByte = 5120,
  TileShort = 5123,
  TileInt = 5125,
  TileFloat = 5126
};

constexpr const char* meshoptName = "EXT_meshopt_compression";
constexpr const char* dracoName = "KHR_draco_mesh_compression";
constexpr const char* metadataName = "EXT_structural_metadata";

// The nearest number of 24 bits. Its multiples by small whole numbers are exact.
double RoundedToFewBits(double value)
{
  constexpr int bits = 24;
  int exponent = 0;
  const double part = std::frexp(value, &exponent);
  return std::ldexp(std::round(std::ldexp(part, bits)), exponent - bits);
}

std::uint16_t ShortOf(double part)
{
  return static_cast<std::uint16_t>(std::lround(std::clamp(part, 0.0, 1.0) * mostShort));
}

// Whether an encoded picture has alpha, judging by its header: the colour type of a PNG, the flag
// in the first chunk of a WebP.
bool MayHaveAlpha(std::span<const std::uint8_t> picture, TileImage format)
{
  const auto bit = [&](std::size_t at, unsigned mask)
  { return at < picture.size() && (picture[at] & mask) != 0; };
  if (format == TileImage::Png)
  {
    return bit(25, 4U);
  }
  if (format != TileImage::Webp || picture.size() < 16)
  {
    return false;
  }
  const std::string chunk(picture.begin() + 12, picture.begin() + 16);
  return chunk == "VP8X" ? bit(20, 0x10U) : chunk == "VP8L" && bit(24, 0x10U);
}

bool IsPlainLetter(char c)
{
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

std::string InCapitals(std::string text)
{
  std::transform(text.begin(), text.end(), text.begin(),
    [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  return text;
}

// Identifiers for the names of arrays. They consist of letters, digits and _, and differ even if
// case is ignored.
std::vector<std::string> IdentifiersOf(const std::vector<TileArray>& arrays)
{
  std::vector<std::string> identifiers;
  for (const TileArray& array : arrays)
  {
    std::string identifier =
      IsPlainLetter(array.name.empty() ? '_' : array.name.front()) ? "" : "_";
    for (const char c : array.name)
    {
      identifier += IsPlainLetter(c) || (c >= '0' && c <= '9') ? c : '_';
    }
    const auto isTaken = [&](const std::string& other)
    { return InCapitals(other) == InCapitals(identifier); };
    while (std::any_of(identifiers.begin(), identifiers.end(), isTaken))
    {
      identifier += "_";
    }
    identifiers.push_back(std::move(identifier));
  }
  return identifiers;
}

class TileGlb
{
public:
  TileGlb(const TileMesh& mesh, const TileFrame& frame, TileCompression compression)
    : From(mesh)
    , Frame(frame)
    , Small(compression == TileCompression::Meshopt)
    , IsDraco(compression == TileCompression::Draco && !mesh.triangles.empty())
    , Identifiers(IdentifiersOf(mesh.arrays))
  {
  }

  Result<std::string> Encode()
  {
    this->Order();
    this->ChooseLattice();
    KDSTREAM_TRY(this->IsDraco ? this->AddPacked() : this->AddPlainPrimitives());
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

  // A mesh primitive of the file.
  struct Primitive
  {
    std::optional<std::size_t> indices;
    std::vector<std::pair<std::string, std::size_t>> attributes; // with the numbers of their
                                                                 // accessors
    bool isSkirt = false;
    std::optional<std::size_t> packed = {};                // the view of the data that Draco
                                                           // compressed
    std::vector<std::pair<std::string, int>> numbers = {}; // ids of the compressed attributes
  };

  struct View
  {
    std::size_t begin = 0, size = 0;   // in the file
    std::size_t count = 0, stride = 0; // decompressed elements
    std::size_t fallback = 0;          // offset of the uncompressed data in the fallback buffer
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
    bool hasView = true; // false for attributes that Draco compressed
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
      this->ShownVertices = this->ShownVertices == 0 ? this->Used.size() : this->ShownVertices;
    }
  }

  // Orders the points of a cloud, so that points near each other are consecutive.
  void OrderPoints()
  {
    const std::size_t count = this->From.points.size();
    this->Used.resize(count);
    for (std::size_t v = 0; v < count; ++v)
    {
      this->Used[v] = static_cast<unsigned>(v);
    }
    this->ShownVertices = count;
#ifdef KDSTREAM_HAS_MESHOPTIMIZER
    if (this->Small)
    {
      std::vector<float> places;
      const Box box = this->BoundsOfUsed(count);
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

  // The bounds of the first `count` used vertices; displayed ones come before those of skirts.
  Box BoundsOfUsed(std::size_t count) const
  {
    Box box;
    for (std::size_t i = 0; i < count; ++i)
    {
      box.Add(this->From.points[this->Used[i]]);
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

  // Adds a compressed bufferView; bytes: the decompressed data.
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

  // values: for all vertices. filter: what decoders apply after decompression; null: nothing.
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

  // ---- by Draco

#ifdef KDSTREAM_HAS_DRACO
  // The vertices of a primitive, in the order of their use.
  struct Packing
  {
    draco::Mesh mesh;
    std::vector<unsigned> used; // numbers in From of the used vertices
    Primitive made;
  };

  template <class T>
  void PackAttribute(Packing& packing, const std::string& name, draco::GeometryAttribute::Type kind,
    draco::DataType type, TileComponent component, const std::vector<T>& values,
    std::size_t components, bool normalized = false)
  {
    static constexpr const char* types[] = { "SCALAR", "VEC2", "VEC3", "VEC4" };
    draco::GeometryAttribute attribute;
    const std::size_t stride = components * sizeof(T);
    attribute.Init(kind, nullptr, static_cast<std::uint8_t>(components), type, normalized,
      static_cast<std::int64_t>(stride), 0);
    const auto count = static_cast<std::uint32_t>(packing.used.size());
    const int number = packing.mesh.AddAttribute(attribute, true, count);
    draco::PointAttribute& packed = *packing.mesh.attribute(number);
    for (std::uint32_t v = 0; v < count; ++v)
    {
      packed.SetAttributeValue(draco::AttributeValueIndex(v), values.data() + v * components);
    }
    Accessor accessor{ 0, 0, component, types[components - 1], normalized };
    accessor.hasView = false;
    this->Accessors.push_back(std::move(accessor));
    packing.made.attributes.emplace_back(name, this->Accessors.size() - 1);
    packing.made.numbers.emplace_back(name, static_cast<int>(packed.unique_id()));
  }

  void PackPositions(Packing& packing)
  {
    std::vector<float> values;
    Box stored;
    for (const unsigned v : packing.used)
    {
      Vec3 place = this->OnLattice(this->From.points[v]);
      stored.Add(place);
      values.insert(values.end(), { float(place[0]), float(place[1]), float(place[2]) });
    }
    this->PackAttribute(packing, "POSITION", draco::GeometryAttribute::POSITION, draco::DT_FLOAT32,
      TileFloat, values, 3);
    this->Accessors.back().least.assign(stored.lo.begin(), stored.lo.end());
    this->Accessors.back().most.assign(stored.hi.begin(), stored.hi.end());
  }

  void PackOthers(Packing& packing)
  {
    std::vector<float> normals, places;
    std::vector<std::uint16_t> colors;
    for (const unsigned v : packing.used)
    {
      for (std::size_t k = 0; k < 3 && !this->From.normals.empty(); ++k)
      {
        normals.push_back(float(this->From.normals[v][k]));
      }
      for (std::size_t k = 0; k < 2 && !this->From.places.empty(); ++k)
      {
        places.push_back(this->From.places[v][k]);
      }
      for (std::size_t k = 0; k < 4 && !this->From.colors.empty(); ++k)
      {
        colors.push_back(this->LinearShort(v, k));
      }
    }
    if (!normals.empty())
    {
      this->PackAttribute(packing, "NORMAL", draco::GeometryAttribute::NORMAL, draco::DT_FLOAT32,
        TileFloat, normals, 3);
    }
    if (!places.empty())
    {
      this->PackAttribute(packing, "TEXCOORD_0", draco::GeometryAttribute::TEX_COORD,
        draco::DT_FLOAT32, TileFloat, places, 2);
    }
    if (!colors.empty())
    {
      this->PackAttribute(packing, "COLOR_0", draco::GeometryAttribute::COLOR, draco::DT_UINT16,
        TileShort, colors, 4, true);
    }
    for (std::size_t a = 0; a < this->From.arrays.size(); ++a)
    {
      const TileArray& array = this->From.arrays[a];
      std::vector<float> values;
      for (const unsigned v : packing.used)
      {
        const auto begin = array.values.begin() + static_cast<std::ptrdiff_t>(v * array.components);
        values.insert(values.end(), begin, begin + static_cast<std::ptrdiff_t>(array.components));
      }
      this->PackAttribute(packing, this->AttributeOf(a), draco::GeometryAttribute::GENERIC,
        draco::DT_FLOAT32, TileFloat, values, array.components);
    }
  }

  Status Pack(const Indices& corners, bool isSkirt)
  {
    Packing packing;
    packing.made.isSkirt = isSkirt;
    std::vector<unsigned> numbers(this->Used.size(), noVertex);
    packing.mesh.SetNumFaces(corners.size() / 3);
    for (std::uint32_t f = 0; f < corners.size() / 3; ++f)
    {
      draco::Mesh::Face face;
      for (std::size_t k = 0; k < 3; ++k)
      {
        unsigned& number = numbers[corners[3 * f + k]];
        if (number == noVertex)
        {
          number = static_cast<unsigned>(packing.used.size());
          packing.used.push_back(this->Used[corners[3 * f + k]]);
        }
        face[k] = draco::PointIndex(number);
      }
      packing.mesh.SetFace(draco::FaceIndex(f), face);
    }
    packing.mesh.set_num_points(static_cast<std::uint32_t>(packing.used.size()));
    const std::size_t first = this->Accessors.size();
    this->PackPositions(packing);
    this->PackOthers(packing);
    draco::Encoder encoder;
    constexpr int speed = 3, normalBits = 8, placeBits = 14;
    const int positionBits = this->IsWide ? 23 : 16;
    const auto begin = float(this->IsWide ? -mostWide : 0);
    const float origin[] = { begin, begin, begin };
    const double range = this->IsWide ? (1U << 23U) - 1 : mostShort; // with steps of 1
    encoder.SetSpeedOptions(speed, speed);
    encoder.SetTrackEncodedProperties(true);
    encoder.SetAttributeExplicitQuantization(
      draco::GeometryAttribute::POSITION, positionBits, 3, origin, float(range));
    encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, normalBits);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, placeBits);
    draco::EncoderBuffer buffer;
    const auto encode = [&](draco::MeshEncoderMethod method)
    {
      buffer.Clear();
      encoder.SetEncodingMethod(method);
      return encoder.EncodeMeshToBuffer(packing.mesh, &buffer).ok() &&
             encoder.num_encoded_faces() == corners.size() / 3;
    };
    // The first method loses triangles that use a vertex twice.
    if (!encode(draco::MESH_EDGEBREAKER_ENCODING) && !encode(draco::MESH_SEQUENTIAL_ENCODING))
    {
      return Error{ ErrorCode::Unsupported,
        "libdraco does not compress a tile: use --compression none or meshopt", {}, {},
        Remedy::InMessage };
    }
    for (std::size_t i = first; i < this->Accessors.size(); ++i)
    {
      this->Accessors[i].count = encoder.num_encoded_points(); // Draco may split vertices
    }
    Accessor indices{ 0, corners.size(),
      encoder.num_encoded_points() <= mostShortVertices ? TileShort : TileInt, "SCALAR" };
    indices.hasView = false;
    this->Accessors.push_back(std::move(indices));
    packing.made.indices = this->Accessors.size() - 1;
    packing.made.packed = this->AddPlain({ buffer.data(), buffer.size() }, 0, 0);
    this->Primitives.push_back(std::move(packing.made));
    return {};
  }
#endif

  Status AddPacked()
  {
#ifdef KDSTREAM_HAS_DRACO
    KDSTREAM_TRY(this->Pack(this->Shown, false));
    if (!this->Under.empty())
    {
      KDSTREAM_TRY(this->Pack(this->Under, true));
    }
#endif
    return {};
  }

  // ---- vertices

  Status AddPlainPrimitives()
  {
    this->AddVertices();
    Primitive shown{ std::nullopt, this->Attributes };
    if (!this->From.triangles.empty())
    {
      shown.indices = this->AddIndices(this->Shown);
    }
    this->Primitives.push_back(std::move(shown));
    if (!this->Under.empty())
    {
      this->Primitives.push_back({ this->AddIndices(this->Under), this->Attributes, true });
    }
    return {};
  }

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
    this->AddArrays();
  }

  bool IsRounded() const
  {
    return this->Small || this->IsDraco;
  }

  // Chooses origin and step of the lattice for positions.
  void ChooseLattice()
  {
    const Box box = this->BoundsOfUsed(this->Used.size());
    double side = 0;
    for (std::size_t k = 0; k < 3; ++k)
    {
      side = std::max(side, box.hi[k] - box.lo[k]);
      this->Begin[k] = this->IsRounded() ? box.lo[k] : box.lo[k] + (box.hi[k] - box.lo[k]) / 2;
    }
    if (!this->IsRounded())
    {
      return;
    }
    this->Step = side > 0 ? side / mostShort : 1;
    if (!(this->Frame.latticeStep > 0))
    {
      return;
    }
    const double finest = side / (mostShort - 1); // the lattice begins below the box
    this->IsWide = this->SharesLattice() && this->Frame.latticeStep < finest;
    for (this->Step = this->Frame.latticeStep; !this->IsWide && this->Step < finest;)
    {
      this->Step *= 2;
    }
    const Box shown = this->BoundsOfUsed(this->ShownVertices);
    for (std::size_t k = 0; k < 3; ++k)
    {
      const double origin = this->Frame.latticeOrigin[k];
      const double begin =
        this->IsWide ? shown.lo[k] + (shown.hi[k] - shown.lo[k]) / 2 : this->Begin[k];
      this->First[k] = std::floor((begin - origin) / this->Step + 1e-9);
      this->Begin[k] = origin + this->First[k] * this->Step;
    }
  }

  // Whether adjacent meshes use the same lattice.
  bool SharesLattice() const
  {
    return this->IsRounded() && this->Frame.latticeStep > 0 && this->Frame.finestStep > 0;
  }

  // The point as stored in the file: whole numbers of steps, or floats.
  Vec3 OnLattice(const Vec3& point) const
  {
    Vec3 place = Minus(point, this->Begin);
    for (std::size_t k = 0; k < 3; ++k)
    {
      // On a shared lattice steps are counted from its origin, so that all meshes round alike.
      place[k] = this->SharesLattice()
                   ? std::floor((point[k] - this->Frame.latticeOrigin[k]) / this->Step + 0.5) -
                       this->First[k]
                 : this->IsRounded() ? std::round(place[k] / this->Step)
                                     : double(float(place[k]));
      if (this->IsRounded())
      {
        place[k] =
          std::clamp(place[k], this->IsWide ? -mostWide : 0, this->IsWide ? mostWide : mostShort) +
          0.0; // avoids -0
      }
    }
    return place;
  }

  // A whole number in the format of the filter EXPONENTIAL: the lower three bytes, times 2^0.
  static std::uint32_t WithoutExponent(double whole)
  {
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(whole)) & 0xFFFFFFU;
  }

  void AddPositions()
  {
    const bool isShort = this->Small && !this->IsWide;
    std::string bytes;
    Box stored;
    for (const unsigned v : this->Used)
    {
      const Vec3 place = this->OnLattice(this->From.points[v]);
      for (const double value : place)
      {
        isShort       ? AppendNumber(bytes, static_cast<std::uint16_t>(value))
        : this->Small ? AppendNumber(bytes, WithoutExponent(value))
                      : AppendNumber(bytes, float(value));
      }
      if (isShort)
      {
        AppendNumber(bytes, std::uint16_t{ 0 }); // each vertex takes a multiple of four bytes
      }
      stored.Add(place);
    }
    Accessor accessor{ 0, 0, isShort ? TileShort : TileFloat, "VEC3", false,
      { stored.lo.begin(), stored.lo.end() }, { stored.hi.begin(), stored.hi.end() } };
    const char* const filter = this->Small && this->IsWide ? "EXPONENTIAL" : nullptr;
    this->Attributes.emplace_back(
      "POSITION", this->AddAttribute(bytes, std::move(accessor), filter));
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

  std::uint16_t LinearShort(unsigned v, std::size_t k) const
  {
    const std::uint8_t byte = this->From.colors[v][k];
    return ShortOf(k < 3 ? LinearOfBytes()[byte] : byte / 255.0);
  }

  void AddColors()
  {
    std::string bytes;
    for (const unsigned v : this->Used)
    {
      for (std::size_t k = 0; k < 4; ++k)
      {
        AppendNumber(bytes, this->LinearShort(v, k));
      }
    }
    this->Attributes.emplace_back(
      "COLOR_0", this->AddAttribute(bytes, { 0, 0, TileShort, "VEC4", true }));
  }

  std::string AttributeOf(std::size_t array) const
  {
    return "_" + InCapitals(this->Identifiers[array]);
  }

  void AddArrays()
  {
    static constexpr const char* types[] = { "SCALAR", "VEC2", "VEC3", "VEC4" };
    for (std::size_t a = 0; a < this->From.arrays.size(); ++a)
    {
      const TileArray& array = this->From.arrays[a];
      std::string bytes;
      for (const unsigned v : this->Used)
      {
        for (std::size_t k = 0; k < array.components; ++k)
        {
          AppendNumber(bytes, array.values[v * array.components + k]);
        }
      }
      this->Attributes.emplace_back(this->AttributeOf(a),
        this->AddAttribute(bytes, { 0, 0, TileFloat, types[array.components - 1] }));
    }
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
      json.Member("copyright", this->Frame.copyright); // viewers display it
    }
    json.EndObject();
    this->PutExtensions(json);
    this->PutMetadata(json);
    json.Member("scene", 0).Key("scenes").BeginArray().BeginObject().Key("nodes").BeginArray();
    json.Put(0).EndArray().EndObject().EndArray();
    json.Key("nodes").BeginArray().BeginObject().Member("mesh", 0);
    this->PutMatrix(json);
    json.EndObject().EndArray();
    this->PutMesh(json);
    this->PutMaterials(json);
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
    if (this->IsDraco)
    {
      required.emplace_back(dracoName);
    }
    if (this->UsesWebp())
    {
      required.emplace_back("EXT_texture_webp");
    }
    used = required;
    if (!this->From.arrays.empty())
    {
      used.emplace_back(metadataName);
    }
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

  // Writes the names and types of the properties for arrays.
  void PutMetadata(JsonWriter& json) const
  {
    static constexpr const char* types[] = { "SCALAR", "VEC2", "VEC3", "VEC4" };
    const std::vector<TileArray>& arrays = this->From.arrays;
    if (arrays.empty())
    {
      return;
    }
    json.Key("extensions").BeginObject().Key(metadataName).BeginObject();
    json.Key("schema").BeginObject().Member("id", "arrays").Key("classes").BeginObject();
    json.Key("vertex").BeginObject().Key("properties").BeginObject();
    for (std::size_t a = 0; a < arrays.size(); ++a)
    {
      json.Key(this->Identifiers[a]).BeginObject().Member("name", arrays[a].name);
      json.Member("type", types[arrays[a].components - 1]).Member("componentType", "FLOAT32");
      json.EndObject();
    }
    json.EndObject().EndObject().EndObject().EndObject();
    json.Key("propertyAttributes").BeginArray().BeginObject().Member("class", "vertex");
    json.Key("properties").BeginObject();
    for (std::size_t a = 0; a < arrays.size(); ++a)
    {
      json.Key(this->Identifiers[a]).BeginObject();
      json.Member("attribute", this->AttributeOf(a)).EndObject();
    }
    json.EndObject().EndObject().EndArray().EndObject().EndObject();
  }

  void PutMatrix(JsonWriter& json) const
  {
    double step = this->Step * this->Frame.scale;
    Vec3 place = Times(Minus(this->Begin, this->Frame.origin), this->Frame.scale);
    if (this->SharesLattice())
    {
      const double finest = this->Frame.finestStep;
      const double unit = RoundedToFewBits(finest * this->Frame.scale);
      step = std::round(this->Step / finest) * unit;
      for (std::size_t k = 0; k < 3; ++k)
      {
        place[k] = std::round((this->Begin[k] - this->Frame.origin[k]) / finest) * unit;
      }
    }
    json.Key("matrix").BeginArray();
    for (std::size_t column = 0; column < 4; ++column)
    {
      for (const Vec3& axis : this->Frame.axes)
      {
        json.Put((column < 3 ? axis[column] * step : Dot(axis, place)) + 0.0); // avoids -0
      }
      json.Put(column < 3 ? 0 : 1);
    }
    json.EndArray();
  }

  void PutPrimitive(JsonWriter& json, const Primitive& primitive) const
  {
    json.BeginObject().Key("attributes").BeginObject();
    for (const auto& [name, accessor] : primitive.attributes)
    {
      json.Member(name, accessor);
    }
    json.EndObject();
    if (primitive.indices)
    {
      json.Member("indices", *primitive.indices);
    }
    else
    {
      json.Member("mode", 0);
    }
    json.Member("material", primitive.isSkirt ? 1 : 0);
    this->PutExtensionsOf(json, primitive);
    if (primitive.isSkirt)
    {
      json.Key("extras").BeginObject().Member("skirt", true).EndObject();
    }
    json.EndObject();
  }

  void PutExtensionsOf(JsonWriter& json, const Primitive& primitive) const
  {
    if (!primitive.packed && this->From.arrays.empty())
    {
      return;
    }
    json.Key("extensions").BeginObject();
    if (primitive.packed)
    {
      json.Key(dracoName).BeginObject().Member("bufferView", *primitive.packed);
      json.Key("attributes").BeginObject();
      for (const auto& [name, number] : primitive.numbers)
      {
        json.Member(name, number);
      }
      json.EndObject().EndObject();
    }
    if (!this->From.arrays.empty())
    {
      json.Key(metadataName).BeginObject().Key("propertyAttributes").BeginArray().Put(0).EndArray();
      json.EndObject();
    }
    json.EndObject();
  }

  void PutMesh(JsonWriter& json) const
  {
    json.Key("meshes").BeginArray().BeginObject().Key("primitives").BeginArray();
    for (const Primitive& primitive : this->Primitives)
    {
      this->PutPrimitive(json, primitive);
    }
    json.EndArray().EndObject().EndArray();
  }

  void PutMaterial(JsonWriter& json, bool doubleSided) const
  {
    json.BeginObject().Key("pbrMetallicRoughness").BeginObject();
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
    if (std::any_of(this->From.colors.begin(), this->From.colors.end(), isClear) ||
        MayHaveAlpha(this->From.picture, this->From.pictureFormat))
    {
      json.Member("alphaMode", "BLEND");
    }
    json.Member("doubleSided", doubleSided).EndObject();
  }

  // Skirts are one-sided. If they were two-sided, clients would reverse the normals of the back of
  // a skirt, which would show as a dark point in each pixel of a border that neither tile covers.
  void PutMaterials(JsonWriter& json) const
  {
    json.Key("materials").BeginArray();
    this->PutMaterial(json, true);
    if (!this->Under.empty())
    {
      this->PutMaterial(json, false);
    }
    json.EndArray();
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
      json.BeginObject();
      if (accessor.hasView)
      {
        json.Member("bufferView", accessor.view);
      }
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
  const bool Small, IsDraco;
  const std::vector<std::string> Identifiers; // of arrays
  Indices Shown, Under;          // of triangles and of skirts, as numbers of used vertices
  std::vector<unsigned> Used;    // their numbers in the mesh
  std::size_t ShownVertices = 0; // how many used vertices are displayed; the others are only in
                                 // skirts
  Vec3 Begin{};                  // the point whose stored position is 0
  Vec3 First{};                  // number of Begin on the lattice
  double Step = 1;               // distance of lattice points
  bool IsWide = false;           // positions need more than 16 bits
  std::string Bytes;             // of the binary chunk
  std::size_t FallbackBytes = 0;
  std::vector<View> Views;
  std::vector<Accessor> Accessors;
  std::vector<std::pair<std::string, std::size_t>> Attributes; // of all primitives except those of
                                                               // Draco
  std::vector<Primitive> Primitives;
  std::optional<std::size_t> Picture;
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

bool HasDracoCompression()
{
#ifdef KDSTREAM_HAS_DRACO
  return true;
#else
  return false;
#endif
}

Result<std::string> EncodeTileGlb(
  const TileMesh& mesh, const TileFrame& frame, TileCompression compression)
{
  if (compression == TileCompression::Draco && !HasDracoCompression())
  {
    return Error{ ErrorCode::Unsupported,
      "this program was built without libdraco-dev: use another --compression", {}, {},
      Remedy::InMessage };
  }
  if (compression == TileCompression::Meshopt && !HasMeshoptCompression())
  {
    return Error{ ErrorCode::Unsupported,
      "this program was built without libmeshoptimizer-dev: use --compression none", {}, {},
      Remedy::InMessage };
  }
#ifdef KDSTREAM_HAS_MESHOPTIMIZER
  // Sets the versions of the encoder to those of the extension, for all threads.
  static const bool isSet = (meshopt_encodeVertexVersion(0), meshopt_encodeIndexVersion(1), true);
  static_cast<void>(isSet);
#endif
  return TileGlb(mesh, frame, compression).Encode();
}

}
