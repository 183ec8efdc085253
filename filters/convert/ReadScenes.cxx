// SPDX-License-Identifier: BSD-3-Clause
// VRML and glTF: scenes of many parts, read by VTK and joined to one mesh.
#include "filters/convert/FloatCoordinates.h"
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/GltfBuffers.h"
#include "filters/convert/PointAttributes.h"
#include "filters/convert/PolyDataParts.h"
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
#include <iostream>
#include <optional>
#include <sstream>

namespace kdstream
{
namespace
{

using Color = std::array<double, 4>; // 0-1

// sRGB, as pictures and our vertex colours are, to linear light, in which materials multiply, and
// back.
double ToLinear(double value)
{
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}
double FromLinear(double value)
{
  return value <= 0.0031308 ? value * 12.92 : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
}

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

// The texel nearest to a texture coordinate, whose v counts from the top of the picture; pictures
// repeat.
class Texture
{
public:
  explicit Texture(vtkImageData* image)
  {
    if (image)
    {
      image->GetDimensions(this->Size.data());
      this->Texels = vtkUnsignedCharArray::SafeDownCast(image->GetPointData()->GetScalars());
    }
  }

  bool Usable() const
  {
    return this->Texels && this->Size[0] > 0 && this->Size[1] > 0 &&
           this->Texels->GetNumberOfTuples() >= vtkIdType{ this->Size[0] } * this->Size[1];
  }

  Color At(double u, double v) const
  {
    const auto cell = [](double t, int size)
    {
      const double repeated = t - std::floor(t);
      return vtkIdType{ std::clamp(static_cast<int>(repeated * size), 0, size - 1) };
    };
    // VTK's pictures begin at the bottom.
    const vtkIdType row = this->Size[1] - 1 - cell(v, this->Size[1]);
    const vtkIdType texel = row * this->Size[0] + cell(u, this->Size[0]);
    const int components = this->Texels->GetNumberOfComponents();
    const auto get = [&](int k) { return this->Texels->GetTypedComponent(texel, k) / 255.0; };
    Color color{ get(0), get(0), get(0), 1 };
    if (components >= 3)
    {
      color = { get(0), get(1), get(2), components > 3 ? get(3) : 1 };
    }
    else if (components == 2)
    {
      color[3] = get(1);
    }
    return color;
  }

private:
  std::array<int, 3> Size{};
  vtkUnsignedCharArray* Texels = nullptr;
};

// What colours a part, baked to its vertices: base colour factor, base colour texture, and the
// vertices' own. Nothing if all of them are white.
class MaterialBaker
{
public:
  MaterialBaker(vtkPolyData& part, vtkGLTFReader& reader, std::vector<std::string>& warnings)
    : Part(part)
    , Reader(reader)
    , Warnings(warnings)
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
      Texture texture(this->Reader.GetGLTFTexture(number).Image);
      if (texture.Usable() && this->Coordinates && this->Coordinates->GetNumberOfComponents() >= 2)
      {
        this->Picture = texture;
      }
    }
    this->Warnings.push_back(
      this->Picture ? "textures are baked to the colours of vertices: what is finer than "
                      "the mesh is lost"
                    : "a texture is dropped: its picture or coordinates cannot be read");
  }

  Color ColorOf(vtkIdType point, vtkDataArray* own) const
  {
    const Color texel = this->Picture ? this->Picture->At(this->Coordinates->GetComponent(point, 0),
                                          this->Coordinates->GetComponent(point, 1))
                                      : Color{ 1, 1, 1, 1 };
    const double scale = own && own->GetDataType() == VTK_UNSIGNED_CHAR    ? 255
                         : own && own->GetDataType() == VTK_UNSIGNED_SHORT ? 65535
                                                                           : 1;
    Color color{};
    for (std::size_t k = 0; k < 4; ++k)
    {
      const bool has = own && static_cast<int>(k) < own->GetNumberOfComponents();
      const double vertex = has ? own->GetComponent(point, static_cast<int>(k)) / scale : 1;
      const double light = (k < 3 ? ToLinear(texel[k]) : texel[k]) * this->Factor[k] * vertex;
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
  std::optional<Texture> Picture;
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
    MaterialBaker(*block, *reader, warnings).Bake(part->mesh);
    RemoveAttributes(part->mesh, { "JOINTS_0", "WEIGHTS_0", "tangents", "TANGENT" });
    part->warnings.insert(part->warnings.end(), warnings.begin(), warnings.end());
    parts.push_back(std::move(*part));
  }
  return Join(parts, messages);
}

}
