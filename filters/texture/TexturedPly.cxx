// SPDX-License-Identifier: BSD-3-Clause
// Reads PLY files with pictures: see TexturedPly.h. Steps:
// 1. read the mesh with the reader of all PLY files, which checks everything except
// 2. the texture coordinates of the faces' corners, for which the faces are read again.
#include "filters/texture/TexturedPly.h"

#include "filters/core/CutPolygon.h"
#include "filters/core/WithType.h"
#include "filters/meshio/DroppedPoints.h"
#include "filters/meshio/MeshReader.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/QuotedText.h"
#include "filters/meshio/TextWords.h"
#include "filters/meshio/ply/PlyBinaryRecord.h"
#include "filters/meshio/ply/PlyBody.h"
#include "filters/meshio/ply/PlyReader.h"
#include "filters/texture/FilesBeside.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::size_t readChunk = std::size_t{ 1 } << 18; // vertices or faces
constexpr const char* strangeNumber = "a texnumber without a TextureFile";

const PlyElement* FindElement(const PlyHeader& header, std::string_view name)
{
  const auto found = std::find_if(header.elements.begin(), header.elements.end(),
    [&](const PlyElement& element) { return element.name == name; });
  return found == header.elements.end() ? nullptr : &*found;
}

// The number of the property of this name, if isList fits.
std::optional<std::size_t> FindProperty(
  const PlyElement& element, std::string_view name, bool isList)
{
  const std::size_t at = element.Find(name);
  return at < element.properties.size() && element.properties[at].isList == isList
           ? std::optional(at)
           : std::nullopt;
}

bool HasCoordinatesOfVertices(const PlyHeader& header)
{
  static constexpr std::array<std::array<const char*, 2>, 3> names{ { { "u", "v" }, { "s", "t" },
    { "texture_u", "texture_v" } } };
  const PlyElement* const vertices = FindElement(header, "vertex");
  return vertices && std::any_of(names.begin(), names.end(),
                       [&](const auto& pair) {
                         return FindProperty(*vertices, pair[0], false) &&
                                FindProperty(*vertices, pair[1], false);
                       });
}

bool HasCoordinatesOfFaces(const PlyHeader& header)
{
  const PlyElement* const faces = FindElement(header, "face");
  return faces && FindProperty(*faces, "texcoord", true);
}

// Reads the values of a body's records, one after the other. Reading the mesh has already checked
// them.
class PlyValues
{
public:
  PlyValues(ByteSource& source, PlyEncoding encoding)
    : Source(source)
    , Words(source)
    , Encoding(encoding)
  {
  }

  // Goes to the next line of a text; a line may have more values than the header names.
  Status EndLine()
  {
    return this->Encoding == PlyEncoding::Ascii ? this->Words.SkipLine() : Status();
  }

  Result<double> Next(AttributeType type)
  {
    return WithType(type, [this]<class T>() { return this->Next<T>(); });
  }

private:
  template <class T>
  Result<double> Next()
  {
    const Error cut = BadInput("truncated: the file has changed since it was read", Remedy::Retry);
    T value{};
    if (this->Encoding == PlyEncoding::Ascii)
    {
      const Result<std::string_view> word = this->Words.Next();
      KDSTREAM_TRY(word);
      if (ParsePlyNumber(*word, value) != NumberTextError::None)
      {
        return word->empty() ? cut
                             : Error{ ErrorCode::InvalidInput,
                                 QuotedText(*word) + " does not fit the type of its property" };
      }
      return double(value);
    }
    const Result<std::string_view> bytes = this->Source.Peek(sizeof(T));
    KDSTREAM_TRY(bytes);
    if (bytes->size() < sizeof(T))
    {
      return cut;
    }
    value = this->Encoding == PlyEncoding::BinaryBigEndian ? Load<T, true>(bytes->data())
                                                           : Load<T, false>(bytes->data());
    this->Source.Consume(sizeof(T));
    return double(value);
  }

  ByteSource& Source;
  TextWords Words;
  PlyEncoding Encoding;
};

class TexturedPlyReader
{
public:
  explicit TexturedPlyReader(std::filesystem::path file)
    : File(std::move(file))
  {
  }

  Result<TexturedFile> Read(const Execution& execution)
  {
    Result<ByteSource> source = ByteSource::Open(this->File);
    KDSTREAM_TRY(source);
    const Result<PlyHeader> header = ReadPlyHeader(*source);
    KDSTREAM_TRY(header);
    if (const PlyElement* strips = FindElement(*header, "tristrips"); strips && strips->count > 0)
    {
      return Error{ ErrorCode::Unsupported,
        "triangle strips with pictures are not read; --textures off reads them without", {}, {},
        Remedy::InMessage };
    }
    KDSTREAM_TRY(this->ReadMesh(execution, HasCoordinatesOfFaces(*header)));
    this->MakeMaterials(*header);
    if (HasCoordinatesOfFaces(*header))
    {
      KDSTREAM_TRY(this->ReadCorners(*source, *header));
      if (this->NoneHas && HasCoordinatesOfVertices(*header))
      {
        this->Out.textured.corners.clear();
        this->Out.textured.materialOf.clear();
        this->TakeCornersOfVertices();
      }
      else
      {
        this->Warn(
          this->Odd, this->FirstOdd, "face", "a texcoord whose length does not match its corners");
        this->Warn(this->Strange, this->FirstStrange, "face", strangeNumber);
      }
      KDSTREAM_TRY(DropNotFiniteFaces(this->TheMesh(), this->BeginsFace, this->Out.tolerance,
        this->Out.textured.corners, this->Out.textured.materialOf));
    }
    else
    {
      this->TakeCornersOfVertices();
    }
    this->DropTextures();
    return std::move(this->Out);
  }

private:
  Mesh& TheMesh() { return this->Out.textured.mesh; }

  // all: also keeps points that are not finite, because the faces' coordinates are read later.
  Status ReadMesh(const Execution& execution, bool all)
  {
    Result<ByteSource> source = ByteSource::Open(this->File);
    KDSTREAM_TRY(source);
    Result<std::unique_ptr<MeshReader>> opened =
      all ? PlyReader::Open(std::move(*source)) : MeshReader::Open(this->File, execution);
    KDSTREAM_TRY(opened);
    MeshReader& reader = **opened;
    this->TheMesh().scalarType = reader.Info().scalarType;
    for (const bool triangles : { false, true })
    {
      for (std::size_t count = 1; count > 0;)
      {
        const Result<std::size_t> read = triangles
                                           ? reader.ReadTriangles(this->TheMesh(), readChunk)
                                           : reader.ReadVertices(this->TheMesh(), readChunk);
        KDSTREAM_TRY(read);
        count = *read;
        const double size = std::max(1.0, double(reader.FileSize()));
        KDSTREAM_TRY(execution.Report("read", double(reader.Position()) / size));
      }
    }
    for (const std::string& name : reader.Info().ignoredAttributes)
    {
      if (name != "face.texcoord" && !name.starts_with("texture "))
      {
        this->Out.warnings.push_back("left out: " + name);
      }
    }
    this->Out.tolerance = reader.Info().tolerance;
    return {};
  }

  // Makes one material for each picture, and a last, white one for faces without a picture.
  void MakeMaterials(const PlyHeader& header)
  {
    TexturedMesh& textured = this->Out.textured;
    FilesBeside files(this->File);
    for (const std::string& name : header.textureFiles)
    {
      TexturedMaterial material;
      material.picture = static_cast<std::uint32_t>(textured.pictures.size());
      material.transform = upsideDown;
      textured.pictures.push_back(
        PictureBeside(files.Find(name), name, "the picture ", " (TextureFile)"));
      textured.materials.push_back(material);
    }
    textured.materials.push_back({});
  }

  // Reads the corners of each face, and repeats them for each of its triangles.
  Status ReadCorners(ByteSource& source, const PlyHeader& header)
  {
    const std::unique_ptr<PlyBody> body = PlyBody::Make(header, source);
    for (const PlyElement& element : header.elements)
    {
      if (element.name != "face")
      {
        KDSTREAM_TRY(body->SkipRecords(element, 0, element.count));
        continue;
      }
      PlyValues values(source, header.encoding);
      for (std::uint64_t face = 0; face < element.count; ++face)
      {
        if (Status read = this->ReadFace(values, element, face); !read)
        {
          return Error{ read.GetError().code,
            "face " + std::to_string(face) + ": " + read.GetError().message };
        }
        if (this->Out.tolerance.Of(Lapse::ValuesNotNamed) > 0)
        {
          KDSTREAM_TRY(values.EndLine());
        }
      }
      break; // the rest is not read; words may be read ahead
    }
    if (this->Out.textured.corners.size() != this->TheMesh().triangles.size())
    {
      return BadInput("truncated: the file has changed since it was read", Remedy::Retry);
    }
    return {};
  }

  void Warn(
    std::uint64_t count, std::uint64_t first, const std::string& element, const std::string& what)
  {
    if (count > 0)
    {
      this->Out.warnings.push_back(
        std::to_string(count) + " " + element + (count == 1 ? " has " : "s have ") + what +
        " (the first is " + element + " " + std::to_string(first) + "): they are drawn white");
    }
  }

  Status ReadFace(PlyValues& values, const PlyElement& element, std::uint64_t face)
  {
    double number = 0;
    this->Coordinates.clear();
    this->Corners.clear();
    const std::size_t corners = element.FindCorners(), coordinates = element.Find("texcoord");
    for (std::size_t p = 0; p < element.properties.size(); ++p)
    {
      const PlyProperty& property = element.properties[p];
      const Result<double> count = property.isList ? values.Next(property.countType) : 1.0;
      KDSTREAM_TRY(count);
      for (double i = 0; i < *count; ++i)
      {
        const Result<double> value = values.Next(property.type);
        KDSTREAM_TRY(value);
        if (p == corners)
        {
          KDSTREAM_TRY(this->AddCorner(*value));
        }
        if (property.isList && p == coordinates)
        {
          this->Coordinates.push_back(static_cast<float>(*value));
        }
        number = !property.isList && property.name == "texnumber" ? *value : number;
      }
    }
    this->AddFace(number, face);
    return {};
  }

  Status AddCorner(double vertex)
  {
    const std::vector<Vec3>& points = this->TheMesh().points;
    if (!(vertex >= 0 && vertex < double(points.size())))
    {
      return BadInput("truncated: the file has changed since it was read", Remedy::Retry);
    }
    this->Corners.push_back(points[static_cast<std::size_t>(vertex)]);
    return {};
  }

  // Cuts the face as the mesh's reader did.
  void AddFace(double number, std::uint64_t face)
  {
    TexturedMesh& textured = this->Out.textured;
    const bool has = this->Coordinates.size() == 2 * this->Corners.size();
    if (!has && this->Odd++ == 0)
    {
      this->FirstOdd = face;
    }
    this->NoneHas = this->NoneHas && this->Coordinates.empty();
    const bool known = this->CheckNumber(number, face);
    const auto none = static_cast<std::uint32_t>(textured.pictures.size());
    const auto at = [&](std::size_t corner) {
      return PictureCoordinate{ this->Coordinates[2 * corner], this->Coordinates[2 * corner + 1] };
    };
    bool first = true;
    for (const Triangle& t : this->Cutter.Cut(this->Corners))
    {
      const auto no = noPictureCoordinate;
      textured.corners.push_back(
        has ? std::array{ at(t[0]), at(t[1]), at(t[2]) } : std::array{ no, no, no });
      textured.materialOf.push_back(has && known ? static_cast<std::uint32_t>(number) : none);
      this->BeginsFace.push_back(std::exchange(first, false));
    }
  }

  // Whether a face, or triangle, names an existing picture.
  bool CheckNumber(double number, std::uint64_t element)
  {
    const bool known = number >= 0 && number < double(this->Out.textured.pictures.size());
    if (!known && this->Strange++ == 0)
    {
      this->FirstStrange = element;
    }
    return known;
  }

  void TakeCornersOfVertices()
  {
    this->Strange = 0;
    TexturedMesh& textured = this->Out.textured;
    const std::vector<Attribute>& arrays = this->TheMesh().attributes;
    const auto found = std::find_if(arrays.begin(), arrays.end(),
      [](const Attribute& attribute)
      { return RoleOf(attribute) == AttributeRole::TextureCoordinates; });
    const auto numbers = std::find_if(arrays.begin(), arrays.end(),
      [](const Attribute& attribute) {
        return attribute.name == "texnumber" && attribute.association == AttributeAssociation::Cell;
      });
    const auto none = static_cast<std::uint32_t>(textured.pictures.size());
    for (const Triangle& t : this->TheMesh().triangles)
    {
      std::array<PictureCoordinate, 3>& corners = textured.corners.emplace_back();
      for (std::size_t k = 0; k < 3; ++k)
      {
        corners[k] = found == arrays.end() ? noPictureCoordinate
                                           : PictureCoordinate{ float(found->Get(t[k], 0)),
                                               float(found->Get(t[k], 1)) };
      }
      const std::size_t triangle = textured.materialOf.size();
      const double number = numbers == arrays.end() ? 0 : numbers->Get(triangle, 0);
      const bool known = this->CheckNumber(number, triangle);
      textured.materialOf.push_back(known ? static_cast<std::uint32_t>(number) : none);
    }
    this->Warn(this->Strange, this->FirstStrange, "triangle", strangeNumber);
  }

  // Drops the arrays that pictures replace.
  void DropTextures()
  {
    std::vector<Attribute>& arrays = this->TheMesh().attributes;
    if (std::any_of(arrays.begin(), arrays.end(),
          [](const Attribute& attribute) { return RoleOf(attribute) == AttributeRole::Colors; }))
    {
      this->Out.warnings.push_back("vertex colours are left out: textures replace them");
    }
    std::erase_if(arrays,
      [](const Attribute& attribute)
      {
        const AttributeRole role = RoleOf(attribute);
        return role == AttributeRole::Colors || role == AttributeRole::TextureCoordinates ||
               attribute.name == "texnumber";
      });
  }

  std::filesystem::path File;
  TexturedFile Out;
  std::vector<float> Coordinates; // of the current face
  std::vector<Vec3> Corners;      // of the current face
  PolygonCutter Cutter;
  std::vector<bool> BeginsFace; // for each triangle
  bool NoneHas = true;          // no face so far has a texcoord
  std::uint64_t Odd = 0, FirstOdd = 0, Strange = 0, FirstStrange = 0;
};

}

bool HasColorsOfVertices(const PlyHeader& header)
{
  const PlyElement* const vertices = FindElement(header, "vertex");
  return vertices && std::any_of(vertices->properties.begin(), vertices->properties.end(),
                       [](const PlyProperty& property)
                       {
                         const std::string name = FoldedName(property.name);
                         return !property.isList && (name == "red" || name == "r" ||
                                                      name == "diffuse_red" || name == "diffuse_r");
                       });
}

bool HasPictures(const PlyHeader& header)
{
  const auto holds = [&](std::string_view name)
  {
    const PlyElement* const element = FindElement(header, name);
    return element && element->count > 0;
  };
  return (holds("face") || holds("tristrips")) && !header.textureFiles.empty() &&
         (HasCoordinatesOfFaces(header) || HasCoordinatesOfVertices(header));
}

Result<TexturedFile> ReadTexturedPly(const std::filesystem::path& file, const Execution& execution)
{
  return TexturedPlyReader(file).Read(execution);
}

}
