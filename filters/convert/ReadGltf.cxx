// SPDX-License-Identifier: BSD-3-Clause
// glTF: scenes of many parts, read by VTK and joined to one mesh.
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/GltfScene.h"
#include "filters/convert/JoinParts.h"
#include "filters/convert/PolyDataParts.h"
#include "filters/convert/VtkMessages.h"
#include "filters/texture/BakeTextures.h"

#include <vtkCompositeDataIterator.h>
#include <vtkFieldData.h>
#include <vtkGLTFReader.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
namespace kdstream
{
namespace
{

void RemoveAttributes(Mesh& mesh, const std::vector<std::string>& names)
{
  mesh.attributes.erase(
    std::remove_if(mesh.attributes.begin(), mesh.attributes.end(),
      [&](const Attribute& attribute)
      { return std::find(names.begin(), names.end(), attribute.name) != names.end(); }),
    mesh.attributes.end());
}

vtkDataArray* FieldArray(vtkPolyData& part, const char* name, int components)
{
  vtkDataArray* const array = part.GetFieldData()->GetArray(name);
  return array && array->GetNumberOfTuples() > 0 && array->GetNumberOfComponents() >= components
           ? array
           : nullptr;
}

// A part's paint: its material's, and its vertices' own, which multiply it.
class PartPaint
{
public:
  explicit PartPaint(vtkPolyData& part)
    : Part(part)
  {
    if (vtkDataArray* const factor = FieldArray(part, "BaseColorMultiplier", 3))
    {
      for (int k = 0; k < std::min(4, factor->GetNumberOfComponents()); ++k)
      {
        this->Factor[std::size_t(k)] = factor->GetComponent(0, k);
      }
      this->HasMaterial = true;
    }
    this->Opaque = FieldArray(part, "ForceOpaque", 1) != nullptr;
    vtkPointData* const data = part.GetPointData();
    this->Own = data->GetArray("COLOR_0");
    this->Own = this->Own ? this->Own : data->GetScalars();
    if (this->Own &&
        (this->Own->GetNumberOfComponents() < 3 || this->Own->GetNumberOfComponents() > 4))
    {
      this->Own = nullptr;
    }
  }

  // In a scene whose materials have their number as red (GltfScene): which that is.
  std::size_t MaterialNumber(std::size_t count) const
  {
    const double number = this->HasMaterial ? this->Factor[0] : double(count);
    return number >= 0 && number < double(count) ? static_cast<std::size_t>(std::lround(number))
                                                 : count;
  }

  // The colour of the material that the part names by its number.
  void Use(const std::vector<GltfMaterial>& materials)
  {
    const std::size_t number = this->MaterialNumber(materials.size());
    const TexturedMaterial paint =
      number < materials.size() ? materials[number].paint : TexturedMaterial{};
    this->Factor = paint.factor;
    this->Opaque = paint.opaque;
  }

  // In linear light; white where there are none.
  Color OwnColor(std::size_t point) const
  {
    const double scale = !this->Own                                       ? 1
                         : this->Own->GetDataType() == VTK_UNSIGNED_CHAR  ? 255
                         : this->Own->GetDataType() == VTK_UNSIGNED_SHORT ? 65535
                                                                          : 1;
    Color color{ 1, 1, 1, 1 };
    for (int k = 0; this->Own && k < this->Own->GetNumberOfComponents(); ++k)
    {
      color[std::size_t(k)] = this->Own->GetComponent(static_cast<vtkIdType>(point), k) / scale;
    }
    return color;
  }

  // Where nothing has a picture: factor and own colours. Nothing if all of them are white.
  void Paint(Mesh& mesh) const
  {
    if (!this->Own && this->Factor == Color{ 1, 1, 1, 1 })
    {
      return;
    }
    std::vector<Color> colors(mesh.points.size());
    for (std::size_t i = 0; i < colors.size(); ++i)
    {
      const Color own = this->OwnColor(i);
      for (std::size_t k = 0; k < 4; ++k)
      {
        const double light = own[k] * this->Factor[k];
        colors[i][k] = std::clamp(k < 3 ? FromLinear(light) : light, 0.0, 1.0);
      }
      colors[i][3] = this->Opaque ? 1 : colors[i][3];
    }
    AddColors(mesh, colors);
  }

private:
  vtkPolyData& Part;
  Color Factor{ 1, 1, 1, 1 };
  bool HasMaterial = false, Opaque = false;
  vtkDataArray* Own = nullptr;
};

// The parts of a scene with pictures, as one mesh that they paint.
class PaintedScene
{
public:
  explicit PaintedScene(GltfScene& scene)
    : Count(scene.read.materials.size())
  {
    for (const GltfMaterial& material : scene.read.materials)
    {
      this->Textured.materials.push_back(material.paint);
      this->Sets.push_back(material.coordinates);
    }
    this->Textured.materials.push_back({}); // of parts without one
    this->Sets.push_back(0);
    this->Textured.pictures = std::move(scene.read.pictures);
  }

  // In the order in which parts are joined.
  void Add(vtkPolyData& part, const Mesh& mesh)
  {
    const PartPaint paint(part);
    const std::size_t material = paint.MaterialNumber(this->Count);
    vtkPointData* const data = part.GetPointData();
    const std::string name = "TEXCOORD_" + std::to_string(this->Sets[material]);
    vtkDataArray* coordinates = data->GetArray(name.c_str());
    coordinates = coordinates || this->Sets[material] > 0 ? coordinates : data->GetTCoords();
    const bool has = coordinates && coordinates->GetNumberOfComponents() >= 2;
    for (const Triangle& t : mesh.triangles)
    {
      std::array<PictureCoordinate, 3>& corners = this->Textured.corners.emplace_back();
      for (std::size_t k = 0; k < 3; ++k)
      {
        const auto point = static_cast<vtkIdType>(t[k]);
        corners[k] = has ? PictureCoordinate{ float(coordinates->GetComponent(point, 0)),
          float(coordinates->GetComponent(point, 1)) }
                         : noPictureCoordinate;
      }
      this->Textured.materialOf.push_back(static_cast<std::uint32_t>(material));
    }
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
    {
      this->Own.push_back(paint.OwnColor(i));
      this->AnyOwn = this->AnyOwn || this->Own.back() != Color{ 1, 1, 1, 1 };
    }
  }

  Status Bake(ForeignMesh& joined, const TextureOptions& options, const Execution& execution)
  {
    this->Textured.mesh = std::move(joined.mesh);
    TextureOptions used = options;
    if (this->AnyOwn && !options.paintFolder.empty())
    {
      used.paintFolder.clear();
      joined.warnings.push_back(
        "colours of vertices are multiplied in: the pictures themselves are not kept");
    }
    Result<BakeReport> report = BakeTexturesAndKeepPaint(this->Textured, used, execution);
    KDSTREAM_TRY(report);
    joined.mesh = std::move(this->Textured.mesh);
    this->MultiplyByOwn(joined.mesh.attributes);
    joined.warnings.insert(joined.warnings.end(), report->warnings.begin(), report->warnings.end());
    joined.baked = std::move(*report);
    return {};
  }

private:
  // REQUIRES: the colours were baked.
  void MultiplyByOwn(std::vector<Attribute>& arrays) const
  {
    Attribute& colors = *std::find_if(arrays.begin(), arrays.end(),
      [](const Attribute& array) { return RoleOf(array) == AttributeRole::Colors; });
    for (std::size_t i = 0; this->AnyOwn && i < this->Own.size(); ++i)
    {
      for (std::size_t k = 0; k < colors.components; ++k)
      {
        const auto byte = static_cast<std::size_t>(colors.Get(i, k));
        colors.Set(i, k,
          k < 3 ? ByteOfLinear(LinearOfBytes()[byte] * this->Own[i][k])
                : double(byte) * std::clamp(this->Own[i][k], 0.0, 1.0));
      }
    }
  }

  TexturedMesh Textured;
  std::size_t Count;
  std::vector<int> Sets; // of texture coordinates, of each material
  std::vector<Color> Own;
  bool AnyOwn = false; // that is not white, as modellers write where nothing was painted
};

}

Result<ForeignMesh> ReadGltf(
  const std::filesystem::path& file, const TextureOptions& textures, const Execution& execution)
{
  Result<GltfScene> scene = GltfScene::Open(file);
  KDSTREAM_TRY(scene);
  const bool painted = scene->HasPictures() && textures.bake;
  VtkMessages messages;
  vtkNew<vtkGLTFReader> reader;
  reader->SetFileName(scene->Readable().c_str());
  reader->ApplyDeformationsToGeometryOn();
  KDSTREAM_TRY(execution.Report("read", 0));
  reader->UpdateInformation();
  scene->HasRead();
  KDSTREAM_TRY(messages.FirstError());
  reader->Update();
  KDSTREAM_TRY(messages.FirstError());
  std::vector<ForeignMesh> parts;
  std::optional<PaintedScene> scenePaint;
  if (painted)
  {
    scenePaint.emplace(*scene);
  }
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
    RemoveAttributes(part->mesh, { "COLOR_0", "RGB", "RGBA" });
    if (painted)
    {
      scenePaint->Add(*block, part->mesh);
      RemoveAttributes(part->mesh, { "TCoords", "TEXCOORD_0", "TEXCOORD_1" });
    }
    else
    {
      PartPaint paint(*block);
      if (scene->IsCopy())
      {
        paint.Use(scene->read.materials);
      }
      paint.Paint(part->mesh);
    }
    RemoveAttributes(part->mesh, { "JOINTS_0", "WEIGHTS_0", "tangents", "TANGENT" });
    parts.push_back(std::move(*part));
  }
  Result<ForeignMesh> joined = JoinParts(parts);
  KDSTREAM_TRY(joined);
  for (std::string& warning : messages.TakeWarnings())
  {
    joined->warnings.push_back(std::move(warning));
  }
  joined->named = std::move(scene->named);
  if (scene->incomplete)
  {
    joined->warnings.push_back(std::move(*scene->incomplete));
  }
  joined->warnings.insert(
    joined->warnings.end(), scene->read.warnings.begin(), scene->read.warnings.end());
  if (painted && !joined->mesh.points.empty())
  {
    KDSTREAM_TRY(scenePaint->Bake(*joined, textures, execution));
  }
  else if (scene->HasPictures())
  {
    joined->warnings.push_back("pictures are left out");
  }
  return joined;
}

}
