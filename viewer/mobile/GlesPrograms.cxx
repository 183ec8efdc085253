// SPDX-License-Identifier: BSD-3-Clause
// The programs of GlesRenderer: see GlesPrograms.h.
#include "viewer/mobile/GlesPrograms.h"

#include "viewer/mobile/GlesShaders.h"
#include "viewer/session/Geometry.h"
#include "viewer/session/appearance/OcclusionShaders.h"
#include "viewer/session/appearance/Palette.h"

#include <algorithm>

namespace kdstream
{
namespace
{

bool HasContext()
{
  GLint version = 0; // not changed if there is no context
  glGetIntegerv(GL_MAJOR_VERSION, &version);
  return version >= 3;
}

}

Result<std::unique_ptr<GlesPrograms>> GlesPrograms::Make()
{
  if (!HasContext())
  {
    return Error{ ErrorCode::Unsupported, "no context of OpenGL ES 3.0 or WebGL 2 is current" };
  }
  const auto background =
    MakeProgram("background's", { shaders::header, shaders::backgroundVertex },
      { shaders::header, shaders::backgroundFragment });
  KDSTREAM_TRY(background);
  std::unique_ptr<GlesPrograms> made(new GlesPrograms);
  made->Gradient = *background;
  glGenVertexArrays(1, &made->Empty);
  for (const std::size_t kind : { std::size_t{ 0 }, cloud })
  {
    KDSTREAM_TRY(made->Surface(kind));
  }
  return made;
}

GlesPrograms::~GlesPrograms()
{
  if (this->Empty != 0)
  {
    glDeleteProgram(this->Gradient);
    glDeleteProgram(this->Filling);
    std::for_each(this->Surfaces.begin(), this->Surfaces.end(), glDeleteProgram);
    glDeleteVertexArrays(1, &this->Empty);
  }
}

Result<GLuint> GlesPrograms::Surface(std::size_t kind)
{
  GLuint& program = this->Surfaces[kind];
  if (program == 0)
  {
    const bool isCloud = (kind & cloud) != 0;
    const char* isCut = (kind & cut) != 0 ? "#define CUT\n" : "";
    const char* hasRelief = (kind & relief) != 0 ? "#define RELIEF\n" : "";
    const char* isTextured = (kind & textured) != 0 ? "#define TEXTURED\n" : "";
    const auto made = MakeProgram(isCloud ? "cloud's" : "surface's",
      { shaders::header, isCut, isTextured, shaders::surfaceVertex },
      { shaders::header, isCut, hasRelief, isTextured, shaders::occlusionDepths,
        shaders::occlusionLeft, shaders::darkened, shaders::light,
        isCloud ? shaders::cloudFragment : shaders::surfaceFragment });
    KDSTREAM_TRY(made);
    program = *made;
    SetOcclusionUnits(program);
  }
  return program;
}

Result<GLuint> GlesPrograms::Cap()
{
  if (this->Filling == 0)
  {
    const auto made = MakeProgram("cap's", { shaders::header, shaders::surfaceVertex },
      { shaders::header, shaders::occlusionDepths, shaders::occlusionLeft, shaders::darkened,
        shaders::capFragment });
    KDSTREAM_TRY(made);
    this->Filling = *made;
    SetOcclusionUnits(this->Filling);
  }
  return this->Filling;
}

void SetOcclusionUnits(GLuint program)
{
  glUseProgram(program);
  glUniform1i(glGetUniformLocation(program, "depths"), depthsUnit);
  glUniform1i(glGetUniformLocation(program, "occluded"), occludedUnit);
}

void SetVector(GLuint program, const char* name, const Vec3& v)
{
  glUniform3f(glGetUniformLocation(program, name), static_cast<float>(v[0]),
    static_cast<float>(v[1]), static_cast<float>(v[2]));
}

void SetLighting(GLuint program, const SceneLighting& lighting)
{
  std::array<float, 3 * sceneLights.size()> directions{};
  std::array<float, 3 * sceneLights.size()> colors{};
  for (std::size_t i = 0; i < lighting.lights.size(); ++i)
  {
    const SceneLight& lightSource = lighting.lights[i];
    const Vec3 direction = Normalized(lightSource.position);
    for (std::size_t k = 0; k < 3; ++k)
    {
      directions[3 * i + k] = static_cast<float>(direction[k]);
      colors[3 * i + k] = static_cast<float>(lightSource.color[k] * lightSource.intensity);
    }
  }
  const auto count = static_cast<GLsizei>(lighting.lights.size());
  glUniform3fv(glGetUniformLocation(program, "lightDirection"), count, directions.data());
  glUniform3fv(glGetUniformLocation(program, "lightColor"), count, colors.data());
  glUniform4f(glGetUniformLocation(program, "material"), static_cast<float>(sceneMaterial.ambient),
    static_cast<float>(sceneMaterial.diffuse), static_cast<float>(sceneMaterial.specular),
    static_cast<float>(sceneMaterial.specularPower));
  SetVector(program, "highlightColor",
    Vec3{ stoneColor[0] / 255.0, stoneColor[1] / 255.0, stoneColor[2] / 255.0 });
}

}
