// SPDX-License-Identifier: BSD-3-Clause
// The points of a cloud as round splats: see CloudSplats.h.
#include "viewer/rendering/CloudSplats.h"

#include "viewer/session/look/SplatRadii.h"

#include <vtkActor.h>
#include <vtkDataObject.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkShaderProperty.h>
#include <vtkUniforms.h>

#include <algorithm>
#include <array>

namespace kdstream
{
namespace
{

// Pixels across, radius, and distance along the line of sight.
constexpr const char* vertexDeclarations = "in float splatRadius;\n"
                                           "out vec3 splatVSOutput;\n"
                                           "//VTK::PositionVC::Dec";
constexpr const char* vertexCode =
  "//VTK::PositionVC::Impl\n"
  "splatVSOutput.z = gl_Position.w;\n"
  "splatVSOutput.x = clamp(2.0 * splatRadius * splatPixels.x / gl_Position.w, splatPixels.y,\n"
  "  splatPixels.z);\n"
  "splatVSOutput.y = 0.5 * splatVSOutput.x * gl_Position.w / splatPixels.x;\n";

constexpr const char* fragmentDeclarations = "in vec3 splatVSOutput;\n"
                                             "//VTK::Light::Dec";
constexpr const char* fragmentCode =
  "vec2 splatPlace = (2.0 * gl_PointCoord - 1.0) * splatSquare / splatVSOutput.x;\n"
  "float splatAway = dot(splatPlace, splatPlace);\n"
  "if (splatAway > 1.0) { discard; }\n"
  "float splatZ = -splatVSOutput.z - splatVSOutput.y * splatAway;\n"
  "float splatFar = clamp((-splatZ - splatDepth.x) * splatDepth.z, 0.0, 1.0);\n"
  "gl_FragDepth = min(splatFar * splatDepth.y / -splatZ, 1.0);\n"
  "float splatShade = 1.0;\n"
  // The normal of a point without one has no length, and then is no number.
  "if (dot(normalVCVSOutput, normalVCVSOutput) > 0.5)\n"
  "{\n"
  "  if (normalVCVSOutput.z < 0.0) { normalVCVSOutput = -normalVCVSOutput; }\n"
  "}\n"
  "else\n"
  "{\n"
  "  normalVCVSOutput = normalize(vec3(0.35 * splatPlace.x, -0.35 * splatPlace.y, 1.0));\n"
  "  splatShade = 1.0 - 0.4 * splatFar;\n"
  "}\n"
  "//VTK::Light::Impl\n"
  "gl_FragData[0].rgb *= splatShade;\n";

}

void DrawSplats(vtkActor& actor, vtkPolyDataMapper& mapper)
{
  vtkShaderProperty* shader = actor.GetShaderProperty();
  shader->AddVertexShaderReplacement("//VTK::PositionVC::Dec", true, vertexDeclarations, false);
  shader->AddVertexShaderReplacement("//VTK::PositionVC::Impl", true, vertexCode, false);
  shader->AddFragmentShaderReplacement("//VTK::Light::Dec", true, fragmentDeclarations, false);
  shader->AddFragmentShaderReplacement("//VTK::Light::Impl", true, fragmentCode, false);
  mapper.MapDataArrayToVertexAttribute(
    "splatRadius", splatRadiusArray, vtkDataObject::FIELD_ASSOCIATION_POINTS);
}

void DrawNoSplats(vtkActor& actor, vtkPolyDataMapper& mapper)
{
  vtkShaderProperty* shader = actor.GetShaderProperty();
  shader->ClearAllVertexShaderReplacements();
  shader->ClearFragmentShaderReplacement("//VTK::Light::Dec", true);
  shader->ClearFragmentShaderReplacement("//VTK::Light::Impl", true);
  shader->GetVertexCustomUniforms()->RemoveAllUniforms();
  shader->GetFragmentCustomUniforms()->RemoveAllUniforms();
  mapper.RemoveAllVertexAttributeMappings();
}

void AimSplats(
  vtkActor& actor, const ClippingPlanes& planes, double largestRadius, double tangent, int height)
{
  const double pixels = 0.5 * height / tangent; // of a length 1 at distance 1
  const double square =
    std::clamp(2.0 * largestRadius * pixels / planes.nearest, smallestSplat, largestSplat);
  actor.GetProperty()->SetPointSize(static_cast<float>(square));

  const auto set3 = [](vtkUniforms* uniforms, const char* name, double x, double y, double z)
  {
    const std::array<float, 3> values{ static_cast<float>(x), static_cast<float>(y),
      static_cast<float>(z) };
    uniforms->SetUniform3f(name, values.data());
  };
  set3(actor.GetShaderProperty()->GetVertexCustomUniforms(), "splatPixels", pixels, smallestSplat,
    largestSplat);
  vtkUniforms* fragment = actor.GetShaderProperty()->GetFragmentCustomUniforms();
  fragment->SetUniformf("splatSquare", static_cast<float>(square));
  set3(fragment, "splatDepth", planes.nearest, planes.farthest,
    1.0 / (planes.farthest - planes.nearest));
}

}
