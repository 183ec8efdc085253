// SPDX-License-Identifier: BSD-3-Clause
// VRML and glTF: scenes of many parts, read by VTK and joined to one mesh.
#include "filters/convert/FloatCoordinates.h"
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/GltfBuffers.h"
#include "filters/convert/PointAttributes.h"
#include "filters/convert/PolyDataParts.h"
#include "filters/convert/TextureBake.h"
#include "filters/convert/VtkMessages.h"
#include "filters/meshio/ByteSource.h"
#include "filters/meshio/FileEnding.h"

#include <vtkActor.h>
#include <vtkActorCollection.h>
#include <vtkCompositeDataIterator.h>
#include <vtkFieldData.h>
#include <vtkGLTFReader.h>
#include <vtkImageData.h>
#include <vtkLookupTable.h>
#include <vtkMapper.h>
#include <vtkMatrix4x4.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkRendererCollection.h>
#include <vtkTransform.h>
#include <vtkTransformPolyDataFilter.h>
#include <vtkUnsignedCharArray.h>
#include <vtkVRMLImporter.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <optional>
#include <sstream>

namespace kdstream
{
namespace
{

void AddColors(Mesh& mesh, const std::vector<Color>& colors)
{
  const bool opaque =
    std::all_of(colors.begin(), colors.end(), [](const Color& c) { return c[3] >= 1; });
  Attribute attribute = MakeColors(colors.size(), !opaque);
  for (std::size_t i = 0; i < colors.size(); ++i)
  {
    for (std::size_t k = 0; k < attribute.components; ++k)
    {
      attribute.Set(i, k, 255 * colors[i][k]);
    }
  }
  mesh.attributes.push_back(std::move(attribute));
}

void RemoveAttributes(Mesh& mesh, const std::vector<std::string>& names)
{
  mesh.attributes.erase(
    std::remove_if(mesh.attributes.begin(), mesh.attributes.end(),
      [&](const Attribute& attribute)
      { return std::find(names.begin(), names.end(), attribute.name) != names.end(); }),
    mesh.attributes.end());
}

// --- VRML ----------------------------------------------------------------------------------------

Status CheckVrmlHeader(const std::filesystem::path& file)
{
  Result<ByteSource> source = ByteSource::Open(file);
  KDSTREAM_TRY(source);
  const Result<std::string_view> head = source->Peek(10);
  KDSTREAM_TRY(head);
  if (head->substr(0, 10) != "#VRML V2.0")
  {
    return Error{ ErrorCode::InvalidInput, head->substr(0, 5) == "#VRML"
                                             ? "is of another version than VRML 2"
                                             : "is not a VRML 2 file" };
  }
  return {};
}

// What is written to std::cerr while one lives: VTK's parser of VRML tells of errors there only,
// and keeps what it had read before.
class CapturedErrors
{
public:
  CapturedErrors()
    : Before(std::cerr.rdbuf(this->Text.rdbuf()))
  {
  }
  ~CapturedErrors() { std::cerr.rdbuf(this->Before); }
  CapturedErrors(const CapturedErrors&) = delete;
  CapturedErrors& operator=(const CapturedErrors&) = delete;

  std::string Get() const { return PlainVtkMessage(this->Text.str()); }

private:
  std::ostringstream Text;
  std::streambuf* Before;
};

// The colour that a material has which names none. A shape without a material is white.
constexpr double vrmlGrey = 0.8;

Result<ForeignMesh> ReadActor(vtkActor& actor, const Execution& execution)
{
  auto* const mapper = vtkPolyDataMapper::SafeDownCast(actor.GetMapper());
  if (!mapper || mapper->GetNumberOfInputConnections(0) == 0)
  {
    return ForeignMesh{};
  }
  mapper->GetInputAlgorithm()->Update();
  vtkPolyData* const shape = mapper->GetInput();
  vtkNew<vtkTransform> place;
  place->SetMatrix(actor.GetMatrix());
  vtkNew<vtkTransformPolyDataFilter> moved;
  moved->SetInputData(shape);
  moved->SetTransform(place);
  moved->Update();
  Result<ForeignMesh> part = ReadPolyData(*moved->GetOutput(), execution);
  KDSTREAM_TRY(part);
  Mesh& mesh = part->mesh;
  // Of arrays that the importer itself needs.
  part->warnings.erase(
    std::remove_if(part->warnings.begin(), part->warnings.end(),
      [](const std::string& warning) { return warning.rfind("dropped: ", 0) == 0; }),
    part->warnings.end());
  mesh.attributes.erase(
    std::remove_if(mesh.attributes.begin(), mesh.attributes.end(),
      [](const Attribute& attribute) { return RoleOf(attribute) == AttributeRole::Other; }),
    mesh.attributes.end());
  // The importer confuses the numbers of colours; its table has the colours themselves in order,
  // which is that of the points where there are as many.
  auto* const table = mapper->GetScalarVisibility()
                        ? vtkLookupTable::SafeDownCast(mapper->GetLookupTable())
                        : nullptr;
  const auto points = static_cast<vtkIdType>(mesh.points.size());
  const bool colored = table && points > 0 && table->GetNumberOfTableValues() == points;
  if (table && !colored)
  {
    part->warnings.push_back("colours are dropped: there are not as many as vertices");
  }
  double diffuse[3];
  actor.GetProperty()->GetDiffuseColor(diffuse);
  if (colored)
  {
    std::vector<Color> colors(mesh.points.size(), Color{ 1, 1, 1, 1 });
    for (std::size_t i = 0; i < colors.size(); ++i)
    {
      const double* const value = table->GetTableValue(static_cast<vtkIdType>(i));
      std::copy(value, value + 3, colors[i].begin());
    }
    AddColors(mesh, colors);
  }
  else if (std::any_of(
             diffuse, diffuse + 3, [](double v) { return std::abs(v - vrmlGrey) > 0.01; }) &&
           std::any_of(diffuse, diffuse + 3, [](double v) { return v < 1; }))
  {
    AddColors(
      mesh, std::vector<Color>(mesh.points.size(), Color{ diffuse[0], diffuse[1], diffuse[2], 1 }));
  }
  return part;
}

// --- glTF ----------------------------------------------------------------------------------------

vtkDataArray* FieldArray(vtkPolyData& part, const char* name, int components)
{
  vtkDataArray* const array = part.GetFieldData()->GetArray(name);
  return array && array->GetNumberOfTuples() > 0 && array->GetNumberOfComponents() >= components
           ? array
           : nullptr;
}

TextureWrap WrapOf(unsigned short value)
{
  constexpr unsigned short clampToEdge = 33071, mirroredRepeat = 33648; // as glTF names them
  return value == clampToEdge      ? TextureWrap::Clamp
         : value == mirroredRepeat ? TextureWrap::Mirror
                                   : TextureWrap::Repeat;
}

// Nothing where the picture cannot be read. The texels stay VTK's.
std::optional<TexturePicture> PictureOf(const vtkGLTFReader::GLTFTexture& texture)
{
  int size[3]{};
  if (texture.Image)
  {
    texture.Image->GetDimensions(size);
  }
  auto* const texels = size[0] > 0 && size[1] > 0 ? vtkUnsignedCharArray::SafeDownCast(
                                                      texture.Image->GetPointData()->GetScalars())
                                                  : nullptr;
  if (!texels || texels->GetNumberOfTuples() < vtkIdType{ size[0] } * size[1] ||
      texels->GetNumberOfComponents() > 4)
  {
    return std::nullopt;
  }
  const auto values = static_cast<std::size_t>(texels->GetNumberOfValues());
  return TexturePicture{ static_cast<std::size_t>(size[0]), static_cast<std::size_t>(size[1]),
    static_cast<std::size_t>(texels->GetNumberOfComponents()),
    std::span<const std::uint8_t>(texels->GetPointer(0), values), WrapOf(texture.WrapSValue),
    WrapOf(texture.WrapTValue) };
}

// What textures had, and what is left of it.
struct BakedTotal
{
  double texels = 0, vertices = 0, triangles = 0;
  double loss = 0; // × triangles

  std::string Tell() const
  {
    char text[200];
    std::snprintf(text, sizeof text,
      "textures are baked to the colours of vertices: about %.3g texels a vertex; the picture is "
      "%.1f grey values of 255 off on average",
      this->texels / this->vertices, this->loss / this->triangles);
    return text;
  }
};

// What colours a part, baked to its vertices: base colour factor, base colour texture, and the
// vertices' own. Nothing if all of them are white.
class MaterialBaker
{
public:
  MaterialBaker(
    vtkPolyData& part, vtkGLTFReader& reader, std::vector<std::string>& warnings, BakedTotal& total)
    : Part(part)
    , Reader(reader)
    , Warnings(warnings)
    , Total(total)
  {
  }

  void Bake(Mesh& mesh)
  {
    if (vtkDataArray* const factor = FieldArray(this->Part, "BaseColorMultiplier", 3))
    {
      for (int k = 0; k < std::min(4, factor->GetNumberOfComponents()); ++k)
      {
        this->Factor[std::size_t(k)] = factor->GetComponent(0, k);
      }
    }
    if (FieldArray(this->Part, "ForceOpaque", 1))
    {
      this->Opaque = true;
    }
    this->FindTexture();
    vtkPointData* const data = this->Part.GetPointData();
    vtkDataArray* own = data->GetArray("COLOR_0");
    own = own ? own : data->GetScalars();
    if (own && (own->GetNumberOfComponents() < 3 || own->GetNumberOfComponents() > 4))
    {
      own = nullptr;
    }
    const bool white = this->Factor == Color{ 1, 1, 1, 1 };
    if (!own && white && !this->Picture)
    {
      return;
    }
    this->BakePicture(mesh);
    std::vector<Color> colors(mesh.points.size(), this->Factor);
    for (std::size_t i = 0; i < colors.size(); ++i)
    {
      colors[i] = this->ColorOf(static_cast<vtkIdType>(i), own);
    }
    AddColors(mesh, colors);
  }

private:
  void FindTexture()
  {
    vtkDataArray* const index = FieldArray(this->Part, "BaseColorTextureIndex", 1);
    if (!index)
    {
      return;
    }
    vtkDataArray* const set = FieldArray(this->Part, "BaseColorTexCoordIndex", 1);
    const std::string name =
      "TEXCOORD_" + std::to_string(set ? static_cast<int>(set->GetComponent(0, 0)) : 0);
    vtkPointData* const data = this->Part.GetPointData();
    this->Coordinates = data->GetArray(name.c_str());
    this->Coordinates = this->Coordinates ? this->Coordinates : data->GetTCoords();
    const auto number = static_cast<vtkIdType>(index->GetComponent(0, 0));
    if (number >= 0 && number < this->Reader.GetNumberOfTextures())
    {
      this->Held = this->Reader.GetGLTFTexture(number);
      const std::optional<TexturePicture> picture = PictureOf(this->Held);
      if (picture && this->Coordinates && this->Coordinates->GetNumberOfComponents() >= 2)
      {
        this->Picture = picture;
      }
    }
    if (!this->Picture)
    {
      this->Warnings.push_back("a texture is dropped: its picture or coordinates cannot be read");
    }
  }

  void BakePicture(const Mesh& mesh)
  {
    if (!this->Picture)
    {
      return;
    }
    std::vector<PlaceOnTexture> coordinates(mesh.points.size());
    for (std::size_t i = 0; i < coordinates.size(); ++i)
    {
      const auto point = static_cast<vtkIdType>(i);
      coordinates[i] = { this->Coordinates->GetComponent(point, 0),
        this->Coordinates->GetComponent(point, 1) };
    }
    BakedTexture baked = BakeTexture(*this->Picture, coordinates, mesh.points, mesh.triangles);
    this->Total.texels += baked.texels;
    this->Total.vertices += double(mesh.points.size());
    this->Total.triangles += double(mesh.triangles.size());
    this->Total.loss += baked.loss * double(mesh.triangles.size());
    this->Texels = std::move(baked.colors);
  }

  Color ColorOf(vtkIdType point, vtkDataArray* own) const
  {
    const Color texel =
      this->Texels.empty() ? Color{ 1, 1, 1, 1 } : this->Texels[static_cast<std::size_t>(point)];
    const double scale = own && own->GetDataType() == VTK_UNSIGNED_CHAR    ? 255
                         : own && own->GetDataType() == VTK_UNSIGNED_SHORT ? 65535
                                                                           : 1;
    Color color{};
    for (std::size_t k = 0; k < 4; ++k)
    {
      const bool has = own && static_cast<int>(k) < own->GetNumberOfComponents();
      const double vertex = has ? own->GetComponent(point, static_cast<int>(k)) / scale : 1;
      const double light = texel[k] * this->Factor[k] * vertex;
      color[k] = std::clamp(k < 3 ? FromLinear(light) : light, 0.0, 1.0);
    }
    color[3] = this->Opaque ? 1 : color[3];
    return color;
  }

  vtkPolyData& Part;
  vtkGLTFReader& Reader;
  std::vector<std::string>& Warnings;
  Color Factor{ 1, 1, 1, 1 };
  bool Opaque = false;
  BakedTotal& Total;
  vtkGLTFReader::GLTFTexture Held{}; // whose picture this is
  std::optional<TexturePicture> Picture;
  std::vector<Color> Texels; // of each point, in linear light; empty without a picture
  vtkDataArray* Coordinates = nullptr;
};

Result<ForeignMesh> Join(std::vector<ForeignMesh>& parts, VtkMessages& messages)
{
  std::uint64_t points = 0;
  for (const ForeignMesh& part : parts)
  {
    points += part.mesh.points.size();
  }
  if (points >= noVertex)
  {
    return Error{ ErrorCode::LimitExceeded,
      std::to_string(points) + " points; at most 4294967294 can be read" };
  }
  ForeignMesh joined = JoinParts(parts);
  for (std::string& warning : messages.TakeWarnings())
  {
    joined.warnings.push_back(std::move(warning));
  }
  return joined;
}

}

Result<ForeignMesh> ReadVrml(const std::filesystem::path& file, const Execution& execution)
{
  KDSTREAM_TRY(CheckVrmlHeader(file));
  VtkMessages messages;
  vtkNew<vtkVRMLImporter> importer;
  importer->SetFileName(file.c_str());
  KDSTREAM_TRY(execution.Report("read", 0));
  {
    const CapturedErrors errors;
    importer->Update();
    if (!errors.Get().empty())
    {
      return Error{ ErrorCode::InvalidInput, errors.Get() };
    }
  }
  KDSTREAM_TRY(messages.FirstError());
  if (!importer->GetRenderer())
  {
    return Error{ ErrorCode::InvalidInput, "is not a VRML 2 file" };
  }
  std::vector<ForeignMesh> parts;
  vtkActorCollection* const actors = importer->GetRenderer()->GetActors();
  vtkCollectionSimpleIterator position;
  actors->InitTraversal(position);
  while (vtkActor* const actor = actors->GetNextActor(position))
  {
    Result<ForeignMesh> part = ReadActor(*actor, execution);
    KDSTREAM_TRY(part);
    parts.push_back(std::move(*part));
  }
  Result<ForeignMesh> joined = Join(parts, messages);
  if (joined)
  {
    WarnOfFloats(*joined);
  }
  return joined;
}

Result<ForeignMesh> ReadGltf(const std::filesystem::path& file, const Execution& execution)
{
  if (FileEnding(file) == ".gltf")
  {
    KDSTREAM_TRY(CheckGltfBuffers(file));
  }
  VtkMessages messages;
  vtkNew<vtkGLTFReader> reader;
  reader->SetFileName(file.c_str());
  reader->ApplyDeformationsToGeometryOn();
  KDSTREAM_TRY(execution.Report("read", 0));
  reader->Update();
  KDSTREAM_TRY(messages.FirstError());
  std::vector<ForeignMesh> parts;
  BakedTotal total;
  const auto blocks = vtk::TakeSmartPointer(reader->GetOutput()->NewIterator());
  for (blocks->InitTraversal(); !blocks->IsDoneWithTraversal(); blocks->GoToNextItem())
  {
    auto* const block = vtkPolyData::SafeDownCast(blocks->GetCurrentDataObject());
    if (!block || block->GetNumberOfPoints() == 0)
    {
      continue;
    }
    Result<ForeignMesh> part = ReadPolyData(*block, execution);
    KDSTREAM_TRY(part);
    std::vector<std::string> warnings;
    RemoveAttributes(part->mesh, { "COLOR_0", "RGB", "RGBA" });
    MaterialBaker(*block, *reader, warnings, total).Bake(part->mesh);
    RemoveAttributes(part->mesh, { "JOINTS_0", "WEIGHTS_0", "tangents", "TANGENT" });
    part->warnings.insert(part->warnings.end(), warnings.begin(), warnings.end());
    parts.push_back(std::move(*part));
  }
  if (total.triangles > 0)
  {
    parts.front().warnings.push_back(total.Tell());
  }
  return Join(parts, messages);
}

}
