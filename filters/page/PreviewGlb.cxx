// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. Decode the preview.
// 2. Convert its vertices to the conventions of glTF.
// 3. Fill the buffer: positions, normals, colours, triangles.
// 4. Write the JSON that describes the buffer, and put both into one file.
#include "filters/page/PreviewGlb.h"

#include "filters/codec/PieceCodec.h"
#include "filters/core/Light.h"
#include "filters/core/UnitVector.h"
#include "filters/core/drawing/PartNormals.h"
#include "filters/model/JsonWriter.h"
#include "filters/model/Units.h"
#include "filters/page/ModelPicture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <new>
#include <string>

namespace kdstream
{

namespace
{

// As in viewer/session/appearance/Palette.h.
constexpr Vec3 stoneOfGlb{ 217.0 / 255, 208.0 / 255, 192.0 / 255 };

// Converts the model's coordinates to those of the file.
struct GlbFrame
{
  std::array<Vec3, 3> axes; // the directions in the model that become x, y and z, of length 1
  Vec3 origin{};
  double scale = 1;

  Vec3 Turned(const Vec3& v) const
  {
    return { Dot(this->axes[0], v), Dot(this->axes[1], v), Dot(this->axes[2], v) };
  }
};

GlbFrame FrameOf(const ModelDescription& model, const Piece& piece)
{
  const HomeView home = model.homeView.value_or(HomeView{});
  const Vec3 up = ScaledUnitVector(home.up).value_or(Vec3{ 0, 1, 0 });
  const Vec3 level = Minus(home.view, Times(up, Dot(home.view, up)));
  constexpr double fromAbove = 0.1; // a first view from above does not show where the front is
  const Vec3 side = Cross(up, Length(level) > fromAbove ? level : FrontOf(up));
  const Vec3 right = ScaledUnitVector(side).value_or(Vec3{ 1, 0, 0 });
  GlbFrame frame;
  frame.axes = { right, up, Cross(right, up) };
  Box box;
  double lowest = piece.positions.empty() ? 0 : Dot(piece.positions[0], up);
  for (const Vec3& position : piece.positions)
  {
    box.Add(position);
    lowest = std::min(lowest, Dot(position, up));
  }
  const Vec3 sides = Minus(box.hi, box.lo), middle = Plus(box.lo, Times(sides, 0.5));
  const double longest = std::max({ sides[0], sides[1], sides[2] });
  frame.origin = Plus(middle, Times(up, lowest - Dot(middle, up)));
  frame.scale = MetresOfUnit(model.unit).value_or(longest > 0 ? 1 / longest : 1);
  return frame;
}

template <class T>
void AppendBytes(std::vector<std::uint8_t>& bytes, const T& value) // little-endian, as we run
{
  const auto at = bytes.size();
  bytes.resize(at + sizeof value);
  std::memcpy(&bytes[at], &value, sizeof value);
}

void AppendVector(std::vector<std::uint8_t>& bytes, const Vec3& v)
{
  for (const double coordinate : v)
  {
    AppendBytes(bytes, static_cast<float>(coordinate));
  }
}

// The parts of the buffer, in their order.
class GlbWriter
{
public:
  GlbWriter(const ModelDescription& model, const Piece& piece)
    : Model(model)
    , Shown(piece)
    , Frame(FrameOf(model, piece))
  {
  }

  std::vector<std::uint8_t> Write()
  {
    this->AppendPositions();
    this->AppendNormals();
    this->AppendColors();
    for (const Triangle& triangle : this->Shown.triangles)
    {
      for (const VertexId corner : triangle)
      {
        AppendBytes(this->Buffer, std::uint32_t{ corner });
      }
    }
    this->EndPart();
    return this->InOneFile(this->Text());
  }

private:
  void AppendPositions()
  {
    for (const Vec3& position : this->Shown.positions)
    {
      Vec3 placed =
        Times(this->Frame.Turned(Minus(position, this->Frame.origin)), this->Frame.scale);
      for (double& coordinate : placed)
      {
        coordinate = static_cast<float>(coordinate); // so that bounds are computed from the rounded
                                                     // values
      }
      this->Bounds.Add(placed);
      AppendVector(this->Buffer, placed);
    }
    this->EndPart();
  }

  void AppendNormals()
  {
    for (const Vec3& sum : SumOfNormals(this->Shown.positions, this->Shown.triangles))
    {
      const Vec3 normal = this->Frame.Turned(ScaledUnitVector(sum).value_or(this->Frame.axes[1]));
      AppendVector(this->Buffer, ScaledUnitVector(normal).value_or(Vec3{ 0, 1, 0 }));
    }
    this->EndPart();
  }

  // Appends colours in linear light, as glTF requires, in 16 bits.
  void AppendColors()
  {
    const auto colors = std::find_if(this->Shown.attributes.begin(), this->Shown.attributes.end(),
      [](const Attribute& each) { return RoleOf(each) == AttributeRole::Colors; });
    this->HasColors = colors != this->Shown.attributes.end();
    if (!this->HasColors)
    {
      return;
    }
    constexpr double most = 65535;
    for (std::size_t i = 0; i < this->Shown.positions.size(); ++i)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        const double light = LinearOfBytes()[static_cast<std::uint8_t>(colors->Get(i, k))];
        AppendBytes(this->Buffer, static_cast<std::uint16_t>(std::lround(most * light)));
      }
      AppendBytes(this->Buffer, static_cast<std::uint16_t>(most));
    }
    this->EndPart();
  }

  void EndPart() { this->Ends.push_back(this->Buffer.size()); }

  std::string Text() const
  {
    JsonWriter json;
    json.BeginObject()
      .Key("asset")
      .BeginObject()
      .Member("version", "2.0")
      .Member("generator", "KdStream");
    if (!this->Model.credit.empty())
    {
      json.Member("copyright", this->Model.credit);
    }
    json.EndObject().Member("scene", 0);
    json.Key("scenes").PutJson(R"([{"nodes":[0]}])").Key("nodes").PutJson(R"([{"mesh":0}])");
    this->PutMesh(json);
    this->PutAccessors(json);
    json.EndObject();
    return json.Text();
  }

  void PutMesh(JsonWriter& json) const
  {
    json.Key("meshes").BeginArray().BeginObject().Key("primitives").BeginArray().BeginObject();
    json.Key("attributes").BeginObject().Member("POSITION", 0).Member("NORMAL", 1);
    if (this->HasColors)
    {
      json.Member("COLOR_0", 2);
    }
    json.EndObject().Member("indices", this->Ends.size() - 1).Member("material", 0);
    json.EndObject().EndArray().EndObject().EndArray();
    json.Key("materials").BeginArray().BeginObject().Member("doubleSided", true);
    json.Key("pbrMetallicRoughness").BeginObject();
    json.Key("baseColorFactor").BeginArray();
    for (const double part : stoneOfGlb)
    {
      json.Put(this->HasColors ? 1.0 : ToLinear(part));
    }
    json.Put(1.0).EndArray().Member("metallicFactor", 0).Member("roughnessFactor", 0.8);
    json.EndObject().EndObject().EndArray();
  }

  void PutAccessors(JsonWriter& json) const
  {
    constexpr int ofFloat = 5126, ofUint16 = 5123, ofUint32 = 5125;
    const auto vertices = this->Shown.positions.size();
    json.Key("accessors").BeginArray();
    for (std::size_t part = 0; part < this->Ends.size(); ++part)
    {
      const bool isIndices = part + 1 == this->Ends.size(), isColors = part == 2 && !isIndices;
      json.BeginObject()
        .Member("bufferView", part)
        .Member("componentType", isIndices  ? ofUint32
                                 : isColors ? ofUint16
                                            : ofFloat)
        .Member("count", isIndices ? 3 * this->Shown.triangles.size() : vertices)
        .Member("type", isIndices  ? "SCALAR"
                        : isColors ? "VEC4"
                                   : "VEC3");
      if (isColors)
      {
        json.Member("normalized", true);
      }
      if (part == 0)
      {
        json.Member("min", this->Bounds.lo).Member("max", this->Bounds.hi);
      }
      json.EndObject();
    }
    json.EndArray().Key("bufferViews").BeginArray();
    for (std::size_t part = 0; part < this->Ends.size(); ++part)
    {
      const auto begin = part == 0 ? 0 : this->Ends[part - 1];
      constexpr int ofVertices = 34962, ofIndices = 34963;
      json.BeginObject()
        .Member("buffer", 0)
        .Member("byteOffset", begin)
        .Member("byteLength", this->Ends[part] - begin)
        .Member("target", part + 1 == this->Ends.size() ? ofIndices : ofVertices)
        .EndObject();
    }
    json.EndArray().Key("buffers").BeginArray().BeginObject();
    json.Member("byteLength", this->Buffer.size()).EndObject().EndArray();
  }

  // The size of each part is a multiple of 4 bytes.
  std::vector<std::uint8_t> InOneFile(std::string text) const
  {
    text.resize((text.size() + 3) / 4 * 4, ' ');
    constexpr std::uint32_t magic = 0x46546C67, version = 2, ofJson = 0x4E4F534A,
                            ofBytes = 0x4E4942;
    constexpr std::size_t headers = 12 + 8 + 8;
    std::vector<std::uint8_t> file;
    file.reserve(headers + text.size() + this->Buffer.size());
    for (const std::size_t word : { std::size_t{ magic }, std::size_t{ version },
           headers + text.size() + this->Buffer.size(), text.size(), std::size_t{ ofJson } })
    {
      AppendBytes(file, static_cast<std::uint32_t>(word));
    }
    file.insert(file.end(), text.begin(), text.end());
    AppendBytes(file, static_cast<std::uint32_t>(this->Buffer.size()));
    AppendBytes(file, ofBytes);
    file.insert(file.end(), this->Buffer.begin(), this->Buffer.end());
    return file;
  }

  const ModelDescription& Model;
  const Piece& Shown;
  const GlbFrame Frame;
  std::vector<std::uint8_t> Buffer;
  std::vector<std::size_t> Ends; // where each part ends
  Box Bounds;
  bool HasColors = false;
};

}

bool HasPreviewGlb(const ModelDescription& model)
{
  return HasPicture(model) && model.primitive == PrimitiveType::Triangles;
}

Result<std::vector<std::uint8_t>> EncodePreviewGlb(
  const ModelDescription& model, std::span<const std::uint8_t> blob)
{
  try
  {
    const auto piece = DecodePreview(model, blob);
    KDSTREAM_TRY(piece);
    if (piece->triangles.empty())
    {
      return Error{ ErrorCode::NotFound, "the preview has no triangles" };
    }
    return GlbWriter(model, *piece).Write();
  }
  catch (const std::bad_alloc&)
  {
    return Error{ ErrorCode::LimitExceeded, "out of memory for a preview" };
  }
}

}
