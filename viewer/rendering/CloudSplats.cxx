// SPDX-License-Identifier: BSD-3-Clause
// Draws the points of a cloud as round splats: see CloudSplats.h.
#include "viewer/rendering/CloudSplats.h"

#include "viewer/session/appearance/SplatRadii.h"

#include <vtkActor.h>
#include <vtkDataObject.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkShaderProperty.h>
#include <vtkUniforms.h>

#include <algorithm>
#include <array>
#include <string>

namespace kdstream
{
namespace
{

// The shader computes the splat's diameter and radius in pixels, and its distance along the line of
// sight in the eye's unit. In a parallel projection w is 1, and depth is proportional to distance.
// splatPixels: pixels per unit of length at distance 1; smallest and largest diameter in pixels;
// length of the model's unit. splatDepth: nearest, farthest, 1 / their difference, whether the
// projection is parallel.
constexpr const char* vertexDeclarations = "in float splatRadius;\n"
                                           "out vec3 splatVSOutput;\n"
                                           "//VTK::PositionVC::Dec";
constexpr const char* vertexCode =
  "//VTK::PositionVC::Impl\n"
  "splatVSOutput.z = gl_Position.w;\n"
  "if (splatDepth.w > 0.5)\n"
  "{\n"
  "  splatVSOutput.z = mix(splatDepth.x, splatDepth.y, 0.5 + 0.5 * gl_Position.z);\n"
  "}\n"
  "splatVSOutput.x = clamp(2.0 * splatRadius * splatPixels.w * splatPixels.x / gl_Position.w,\n"
  "  splatPixels.y, splatPixels.z);\n"
  "splatVSOutput.y = 0.5 * splatVSOutput.x * gl_Position.w / splatPixels.x;\n";

constexpr const char* fragmentDeclarations = "in vec3 splatVSOutput;\n"
                                             "//VTK::Light::Dec";
constexpr const char* fragmentShape =
  "vec2 splatPlace = (2.0 * gl_PointCoord - 1.0) * splatSquare / splatVSOutput.x;\n"
  "float splatAway = dot(splatPlace, splatPlace);\n"
  "if (splatAway > 1.0) { discard; }\n"
  "float splatZ = -splatVSOutput.z - splatVSOutput.y * splatAway;\n"
  "float splatFar = clamp((-splatZ - splatDepth.x) * splatDepth.z, 0.0, 1.0);\n"
  "gl_FragDepth = splatDepth.w > 0.5 ? splatFar : min(splatFar * splatDepth.y / -splatZ, 1.0);\n";
constexpr const char* fragmentLight =
  "float splatShade = 1.0;\n"
  // VTK normalizes the normal. (0, 0, 0), for a point without one, then is NaN, and this fails.
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

void DrawSplats(vtkActor& actor, vtkPolyDataMapper& mapper, bool isLit)
{
  vtkShaderProperty* shader = actor.GetShaderProperty();
  shader->AddVertexShaderReplacement("//VTK::PositionVC::Dec", true, vertexDeclarations, false);
  shader->AddVertexShaderReplacement("//VTK::PositionVC::Impl", true, vertexCode, false);
  shader->AddFragmentShaderReplacement("//VTK::Light::Dec", true, fragmentDeclarations, false);
  const std::string light = isLit ? fragmentLight : "//VTK::Light::Impl";
  shader->AddFragmentShaderReplacement("//VTK::Light::Impl", true, fragmentShape + light, false);
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

void AimSplats(vtkActor& actor, double largestRadius, const SplatSight& sight)
{
  const auto& [nearest, farthest] = sight.planes;
  const double pixels = 0.5 * sight.height / sight.tangent; // per unit of length at distance 1
  const double square =
    std::clamp(2.0 * largestRadius * sight.scale * pixels / (sight.isParallel ? 1.0 : nearest),
      smallestSplat, largestSplat);
  actor.GetProperty()->SetPointSize(static_cast<float>(square));

  const auto set = [](vtkUniforms* uniforms, const char* name, const std::array<double, 4>& values)
  {
    std::array<float, 4> floats;
    std::transform(values.begin(), values.end(), floats.begin(),
      [](double value) { return static_cast<float>(value); });
    uniforms->SetUniform4f(name, floats.data());
  };
  vtkUniforms* vertex = actor.GetShaderProperty()->GetVertexCustomUniforms();
  vtkUniforms* fragment = actor.GetShaderProperty()->GetFragmentCustomUniforms();
  set(vertex, "splatPixels", { pixels, smallestSplat, largestSplat, sight.scale });
  for (vtkUniforms* const uniforms : { vertex, fragment })
  {
    set(uniforms, "splatDepth",
      { nearest, farthest, 1.0 / (farthest - nearest), sight.isParallel ? 1.0 : 0.0 });
  }
  fragment->SetUniformf("splatSquare", static_cast<float>(square));
}

}
