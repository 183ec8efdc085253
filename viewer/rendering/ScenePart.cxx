// SPDX-License-Identifier: BSD-3-Clause
// One part of a surface in a VTK renderer: see ScenePart.h.
#include "viewer/rendering/ScenePart.h"

#include "viewer/rendering/CloudSplats.h"
#include "viewer/rendering/TileTexture.h"
#include "viewer/session/Geometry.h"
#include "viewer/session/appearance/SceneAppearance.h"
#include "viewer/session/appearance/SplatRadii.h"
#include "viewer/session/texture/TexturedCorners.h"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkFloatArray.h>
#include <vtkIdList.h>
#include <vtkOpenGLPolyDataMapper.h>
#include <vtkOpenGLVertexBufferObject.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkShaderProperty.h>
#include <vtkTexture.h>
#include <vtkTypeInt32Array.h>
#include <vtkUniforms.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <utility>

namespace kdstream
{
namespace
{

vtkSmartPointer<vtkPoints> RelativePoints(std::span<const Vec3> points, const Vec3& center)
{
  const vtkNew<vtkFloatArray> coordinates;
  coordinates->SetNumberOfComponents(3);
  coordinates->SetNumberOfTuples(static_cast<vtkIdType>(points.size()));
  float* out = coordinates->GetPointer(0);
  for (const Vec3& point : points)
  {
    out = std::transform(point.begin(), point.end(), center.begin(), out,
      [](double p, double c) { return static_cast<float>(p - c); });
  }
  auto result = vtkSmartPointer<vtkPoints>::New();
  result->SetData(coordinates);
  return result;
}

// Makes cells of `size` corners each. corner(i) gives the corners, i from 0 to count × size - 1.
template <class Corner>
vtkSmartPointer<vtkCellArray> Cells(std::size_t count, std::size_t size, const Corner& corner)
{
  const vtkNew<vtkTypeInt32Array> offsets;
  const vtkNew<vtkTypeInt32Array> corners;
  const std::size_t all = count * size;
  offsets->SetNumberOfValues(static_cast<vtkIdType>(count) + 1);
  corners->SetNumberOfValues(static_cast<vtkIdType>(all));
  for (std::size_t i = 0; i <= count; ++i)
  {
    offsets->SetValue(static_cast<vtkIdType>(i), static_cast<vtkTypeInt32>(i * size));
  }
  for (std::size_t i = 0; i < all; ++i)
  {
    corners->SetValue(static_cast<vtkIdType>(i), static_cast<vtkTypeInt32>(corner(i)));
  }
  auto cells = vtkSmartPointer<vtkCellArray>::New();
  cells->SetData(offsets, corners);
  return cells;
}

void RaiseReliefOf(vtkActor& actor, double relief, double pixels)
{
  vtkUniforms* uniforms = actor.GetShaderProperty()->GetFragmentCustomUniforms();
  uniforms->SetUniformf("relief", static_cast<float>(relief));
  uniforms->SetUniformf("reliefPixels", static_cast<float>(pixels));
}

// Lights every fragment of a surface on the visible side. VTK flips the normal if the triangle
// itself faces away; this is undone. Otherwise a fold-over of a simplified level would be black
// among neighbours whose normals face the eye.
//
// Near an outline, interpolated normals may face away although the triangle still faces the eye, at
// coarse levels by up to fifty degrees. Such normals are clamped to the outline: if they were
// flipped to the eye, they would be lit like the other side. If the angle is larger, the triangle
// is a fold-over.
//
// Relief: where normals diverge, there is a ridge; where they converge, a furrow.
void FaceNormalsToTheEye(vtkActor& actor)
{
  actor.GetShaderProperty()->AddFragmentShaderReplacement("//VTK::Light::Impl", true,
    "if (!gl_FrontFacing) { normalVCVSOutput = -normalVCVSOutput; }\n"
    "if (normalVCVSOutput.z < 0.0)\n"
    "{\n"
    "  normalVCVSOutput = gl_FrontFacing && normalVCVSOutput.z > -0.8\n"
    "    ? normalize(vec3(normalVCVSOutput.xy, 0.0)) : -normalVCVSOutput;\n"
    "}\n"
    "float reliefBend = clamp(reliefPixels * normalVCVSOutput.z *\n"
    "  (dFdx(normalVCVSOutput.x) + dFdy(normalVCVSOutput.y)), -1.0, 1.0);\n"
    "//VTK::Light::Impl\n"
    "gl_FragData[0].rgb *= 1.0 + relief * reliefBend;\n",
    false);
  RaiseReliefOf(actor, 0, 0);
}

// Lets the texture replace the colour before lighting, because VTK would multiply highlights by it,
// too.
void TextureBeforeLight(vtkActor& actor)
{
  vtkShaderProperty* shader = actor.GetShaderProperty();
  shader->AddFragmentShaderReplacement("//VTK::Color::Impl", true,
    "//VTK::Color::Impl\n"
    "vec3 texel = texture(actortexture, tcoordVCVSOutput).rgb;\n"
    "ambientColor *= texel;\n"
    "diffuseColor *= texel;\n",
    false);
  shader->AddFragmentShaderReplacement("//VTK::TCoord::Impl", true, "", false);
}

void RemoveTexture(vtkActor& actor)
{
  vtkShaderProperty* shader = actor.GetShaderProperty();
  for (const char* place : { "//VTK::Color::Impl", "//VTK::TCoord::Impl" })
  {
    shader->ClearFragmentShaderReplacement(place, true);
  }
}

// Discards fragments above the section. The mapper's clipping planes are not used for this: at
// edges of the surface they are evaluated beside it, so single pixels that should be cut away
// remain.
void DiscardWhatIsAbove(vtkActor& actor)
{
  vtkShaderProperty* shader = actor.GetShaderProperty();
  shader->AddVertexShaderReplacement(
    "//VTK::Clip::Dec", true, "centroid out float sectionAbove;\n//VTK::Clip::Dec", false);
  shader->AddVertexShaderReplacement("//VTK::Clip::Impl", true,
    "sectionAbove = dot(section.xyz, vertexMC.xyz) + section.w;\n//VTK::Clip::Impl", false);
  shader->AddFragmentShaderReplacement(
    "//VTK::Clip::Dec", true, "centroid in float sectionAbove;\n//VTK::Clip::Dec", false);
  shader->AddFragmentShaderReplacement(
    "//VTK::Clip::Impl", true, "if (sectionAbove > 0.0) { discard; }\n//VTK::Clip::Impl", false);
}

void DiscardNothing(vtkActor& actor)
{
  vtkShaderProperty* shader = actor.GetShaderProperty();
  for (const char* place : { "//VTK::Clip::Dec", "//VTK::Clip::Impl" })
  {
    shader->ClearVertexShaderReplacement(place, true);
    shader->ClearFragmentShaderReplacement(place, true);
  }
  shader->GetVertexCustomUniforms()->RemoveUniform("section");
}

// Returns one normal for each point; (0, 0, 0) if there is none, because VTK needs normals to light
// points.
vtkSmartPointer<vtkFloatArray> Normals(std::size_t points, const UnitNormals& normals)
{
  auto result = vtkSmartPointer<vtkFloatArray>::New();
  result->SetName("Normals");
  result->SetNumberOfComponents(3);
  result->SetNumberOfTuples(static_cast<vtkIdType>(points));
  result->FillValue(0.0f);
  float* out = result->GetPointer(0);
  for (const auto& normal : normals)
  {
    out = std::copy(normal.begin(), normal.end(), out);
  }
  return result;
}

vtkSmartPointer<vtkFloatArray> Radii(const Surface& cloud)
{
  const std::vector<float> radii = SplatRadii(cloud);
  auto result = vtkSmartPointer<vtkFloatArray>::New();
  result->SetName(splatRadiusArray);
  result->SetNumberOfTuples(static_cast<vtkIdType>(radii.size()));
  std::copy(radii.begin(), radii.end(), result->GetPointer(0));
  return result;
}

// Makes an array of `count` colours; colorAt(i) gives them, i from 0 to count - 1.
template <class ColorAt>
vtkSmartPointer<vtkUnsignedCharArray> Colors(std::size_t count, const ColorAt& colorAt)
{
  auto colors = vtkSmartPointer<vtkUnsignedCharArray>::New();
  colors->SetName("Colors");
  colors->SetNumberOfComponents(3);
  colors->SetNumberOfTuples(static_cast<vtkIdType>(count));
  unsigned char* out = colors->GetPointer(0);
  for (std::size_t i = 0; i < count; ++i)
  {
    const Color color = colorAt(i);
    out = std::copy(color.begin(), color.end(), out);
  }
  return colors;
}

// Gives each vertex of a textured surface the values of the point that it stands for.
Surface Split(const Surface& surface, const TexturedCorners& textured)
{
  Surface split;
  split.triangles = textured.triangles;
  for (const VertexId point : textured.points)
  {
    split.points.push_back(surface.points[point]);
    split.sources.push_back(surface.sources[point]);
  }
  for (const Attribute& array : surface.attributes)
  {
    Attribute values{ array.Info(), {} };
    for (const VertexId point : textured.points)
    {
      values.Append(array, point);
    }
    split.attributes.push_back(std::move(values));
  }
  return split;
}

UnitNormals Split(const UnitNormals& normals, const TexturedCorners& textured)
{
  UnitNormals split;
  for (std::size_t i = 0; i < textured.points.size() && !normals.empty(); ++i)
  {
    split.push_back(normals[textured.points[i]]);
  }
  return split;
}

// Nothing needs to be flipped: VTK puts the picture's top row, which is its first, at coordinate 0,
// and places are counted downwards from that row.
vtkSmartPointer<vtkFloatArray> Places(const TexturedCorners& textured)
{
  auto result = vtkSmartPointer<vtkFloatArray>::New();
  result->SetName("Places");
  result->SetNumberOfComponents(2);
  result->SetNumberOfTuples(static_cast<vtkIdType>(textured.places.size()));
  float* out = result->GetPointer(0);
  for (const auto& place : textured.places)
  {
    out = std::copy(place.begin(), place.end(), out);
  }
  return result;
}

void SetUpMaterial(vtkActor& actor)
{
  vtkProperty* front = actor.GetProperty();
  front->SetColor(stoneColor[0] / 255.0, stoneColor[1] / 255.0, stoneColor[2] / 255.0);
  front->SetAmbient(sceneMaterial.ambient);
  front->SetDiffuse(sceneMaterial.diffuse);
  front->SetSpecular(sceneMaterial.specular);
  front->SetSpecularPower(sceneMaterial.specularPower);
}

}

ScenePart::ScenePart()
{
  SetUpMaterial(*this->Drawing);
  this->Drawing->GetProperty()->GetDiffuseColor(this->Plain.data());
  this->Mapper->SetInputData(this->Drawn);
  // The coordinates are already relative to the centre; VTK's own shift would shift them a second
  // time.
  if (auto* openGl = vtkOpenGLPolyDataMapper::SafeDownCast(this->Mapper))
  {
    openGl->SetVBOShiftScaleMethod(vtkOpenGLVertexBufferObject::DISABLE_SHIFT_SCALE);
  }
  this->Drawing->SetMapper(this->Mapper);
}

ScenePart::~ScenePart() = default;

bool ScenePart::ShowTextured(const SurfacePart& part, const UnitNormals& normals,
  const TreeDepths& depths, const Vec3& center, const SceneStyle& style,
  const TextureSource& textureSource)
{
  if (!CanTexture(part.surface, part.corners, *textureSource.tile))
  {
    return false;
  }
  if (this->Tile != textureSource.tile)
  {
    const auto picture = textureSource.decoder(*textureSource.tile);
    if (!picture)
    {
      return false;
    }
    this->Texture = MakeTileTexture(*picture);
    this->Tile = textureSource.tile;
  }
  const TexturedCorners textured =
    TexturedCornersOf(part.surface, part.corners, *textureSource.tile);
  const auto texture = this->Texture; // Show releases it
  this->Show(Split(part.surface, textured), Split(normals, textured), depths, center, style);
  this->Texture = texture;
  this->Tile = textureSource.tile;
  this->Drawn->GetPointData()->SetTCoords(Places(textured));
  this->IsTextured = true;
  this->SetStyle(style);
  return true;
}

void ScenePart::LetGoOfTexture()
{
  this->Tile = nullptr;
  this->Texture = nullptr;
  this->IsTextured = false;
}

void ScenePart::Show(const Surface& surface, const UnitNormals& normals, const TreeDepths& depths,
  const Vec3& center, const SceneStyle& style)
{
  this->LetGoOfTexture();
  this->IsCloud = surface.triangles.empty();
  this->Extent = BoundsAround(surface, center);
  const std::size_t cells = this->IsCloud ? surface.points.size() : surface.triangles.size();
  this->Drawn->Initialize();
  this->Drawn->SetPoints(RelativePoints(surface.points, center));
  this->LargestRadius = 0.0;
  if (this->IsCloud)
  {
    this->Drawn->SetVerts(Cells(cells, 1, [](std::size_t i) { return i; }));
    const auto radii = Radii(surface);
    this->Drawn->GetPointData()->AddArray(radii);
    this->LargestRadius = cells > 0 ? radii->GetRange()[1] : 0.0;
    this->Extent = Enlarged(this->Extent, this->LargestRadius);
  }
  else
  {
    this->Drawn->SetPolys(
      Cells(cells, 3, [&](std::size_t i) { return surface.triangles[i / 3][i % 3]; }));
  }
  this->Drawn->GetPointData()->SetNormals(Normals(surface.points.size(), normals));
  this->TakeColors(surface, depths);
  this->AddShaders();
  this->SetStyle(style);
}

void ScenePart::AddShaders()
{
  DrawNoSplats(*this->Drawing, *this->Mapper);
  if (this->IsCut)
  {
    DiscardNothing(*this->Drawing); // until the section is set again
    this->IsCut = false;
  }
  if (this->IsCloud)
  {
    DrawSplats(*this->Drawing, *this->Mapper, this->IsLit);
  }
  else if (this->IsLit)
  {
    FaceNormalsToTheEye(*this->Drawing);
  }
}

void ScenePart::TakeColors(const Surface& surface, const TreeDepths& depths)
{
  this->Arrays.attributes.clear();
  const Attribute* own = OwnColors(surface);
  std::copy_if(surface.attributes.begin(), surface.attributes.end(),
    std::back_inserter(this->Arrays.attributes),
    [own](const Attribute& array) { return &array == own || IsScalar(array); });
  this->Sources.resize(surface.points.size());
  std::transform(surface.sources.begin(), surface.sources.end(), this->Sources.begin(),
    [&depths](const Surface::Source& source) { return ColorSourceOf(source, depths); });
}

// Returns null if the points have no colours of this kind.
vtkSmartPointer<vtkUnsignedCharArray> ScenePart::PointColors(const Coloring& coloring) const
{
  const Attribute* array = ColoredBy(this->Arrays, coloring);
  return array ? Colors(this->Sources.size(),
                   [&](std::size_t i) { return PointColor(*array, coloring, i); })
               : nullptr;
}

// Gives a colour for each cell that is drawn (triangle, or point of a cloud).
vtkSmartPointer<vtkUnsignedCharArray> ScenePart::CellColors(SurfaceColoring coloring) const
{
  if (this->IsCloud)
  {
    return Colors(
      this->Sources.size(), [&](std::size_t i) { return ColorOf(this->Sources[i], coloring); });
  }
  vtkCellArray* triangles = this->Drawn->GetPolys();
  const vtkNew<vtkIdList> corners;
  return Colors(static_cast<std::size_t>(triangles->GetNumberOfCells()),
    [&](std::size_t i)
    {
      triangles->GetCellAtId(static_cast<vtkIdType>(i), corners);
      const auto of = [&](vtkIdType k)
      { return this->Sources[static_cast<std::size_t>(corners->GetId(k))]; };
      return ColorOf(Together(Together(of(0), of(1)), of(2)), coloring);
    });
}

void ScenePart::SetStyle(const SceneStyle& style)
{
  if (style.flat && !this->IsCloud)
  {
    this->Drawing->GetProperty()->SetInterpolationToFlat();
  }
  else
  {
    this->Drawing->GetProperty()->SetInterpolationToPhong();
  }
  const SurfaceColoring kind = style.coloring.kind;
  const bool textured = kind == SurfaceColoring::Own && this->IsTextured;
  const auto ofPoints = textured ? nullptr : this->PointColors(style.coloring);
  const bool bySource = kind == SurfaceColoring::Partition || kind == SurfaceColoring::Resolution;
  if (textured != (this->Drawing->GetTexture() != nullptr))
  {
    this->Tint(textured);
    textured ? TextureBeforeLight(*this->Drawing) : RemoveTexture(*this->Drawing);
  }
  this->Drawing->SetTexture(textured ? this->Texture.Get() : nullptr);
  this->Mapper->SetScalarVisibility(ofPoints || bySource);
  this->Drawn->GetPointData()->SetScalars(ofPoints);
  this->Drawn->GetCellData()->SetScalars(bySource ? this->CellColors(kind).Get() : nullptr);
  if (ofPoints)
  {
    this->Mapper->SetScalarModeToUsePointData();
  }
  else
  {
    this->Mapper->SetScalarModeToUseCellData();
  }
  this->Mapper->SetColorModeToDirectScalars();
}

// VTK multiplies a texture by the colour, so the colour must be white for it.
void ScenePart::Tint(bool textured)
{
  const std::array<double, 3> color = textured ? std::array{ 1.0, 1.0, 1.0 } : this->Plain;
  this->Drawing->GetProperty()->SetDiffuseColor(color.data());
  this->Drawing->GetProperty()->SetAmbientColor(color.data());
}

void ScenePart::SetMaterial(vtkProperty& material)
{
  this->Drawing->GetProperty()->DeepCopy(&material);
  material.GetDiffuseColor(this->Plain.data());
  this->Tint(this->Drawing->GetTexture() != nullptr);
}

void ScenePart::Aim(const SplatSight& sight)
{
  if (std::exchange(this->IsLit, sight.isLit) != sight.isLit)
  {
    this->AddShaders();
  }
  if (this->IsCloud)
  {
    kdstream::AimSplats(*this->Drawing, this->LargestRadius, sight);
  }
}

void ScenePart::CutBy(const std::optional<SectionPlane>& plane, const Vec3& center)
{
  const bool isNew = plane.has_value() != this->IsCut;
  this->IsCut = plane.has_value();
  if (isNew)
  {
    this->IsCut ? DiscardWhatIsAbove(*this->Drawing) : DiscardNothing(*this->Drawing);
  }
  if (plane)
  {
    const std::array<float, 4> values{ static_cast<float>(plane->normal[0]),
      static_cast<float>(plane->normal[1]), static_cast<float>(plane->normal[2]),
      static_cast<float>(plane->Above(center)) };
    this->Drawing->GetShaderProperty()->GetVertexCustomUniforms()->SetUniform4f(
      "section", values.data());
  }
}

void ScenePart::RaiseRelief(double relief, double pixels)
{
  if (!this->IsCloud && this->IsLit)
  {
    RaiseReliefOf(*this->Drawing, relief, pixels);
  }
}

}
