// SPDX-License-Identifier: BSD-3-Clause
// Ambient occlusion in the phone's picture: see GlesOcclusion.h.
#include "viewer/mobile/GlesOcclusion.h"

#include "viewer/mobile/GlesPrograms.h"
#include "viewer/mobile/GlesShaders.h"
#include "viewer/session/look/OcclusionShaders.h"

#include <utility>

namespace kdstream
{
namespace
{

constexpr std::array<GLint, 2> textureUnits{ 0, 1 }; // of depths and occluded in the shaders

void BindTexture(std::size_t unit, GLuint texture)
{
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D, texture);
}

void MakeTexture(GLuint texture, GLenum format, GLint filter, int width, int height)
{
  BindTexture(0, texture);
  glTexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

}

Result<std::unique_ptr<GlesOcclusion>> GlesOcclusion::Make()
{
  std::unique_ptr<GlesOcclusion> made(new GlesOcclusion);
  const std::array<std::pair<GLuint*, const char*>, 3> programs{ {
    { &made->Occlude, shaders::occlusionFragment },
    { &made->Average, shaders::occlusionMeanFragment },
    { &made->Light, shaders::occlusionLightFragment },
  } };
  for (const auto& [program, text] : programs)
  {
    const bool seesDepths = program != &made->Light;
    const auto compiled = MakeProgram("occlusion's", { shaders::header, shaders::backgroundVertex },
      { shaders::header, seesDepths ? shaders::occlusionDepths : "", text });
    KDSTREAM_TRY(compiled);
    *program = *compiled;
    glUseProgram(*program);
    glUniform1i(glGetUniformLocation(*program, "depths"), textureUnits[0]);
    glUniform1i(glGetUniformLocation(*program, "occluded"), textureUnits[1]);
    glUniform1f(glGetUniformLocation(*program, "strength"), static_cast<float>(occlusionStrength));
  }
  return made;
}

GlesOcclusion::~GlesOcclusion()
{
  this->Free();
  for (const GLuint program : { this->Occlude, this->Average, this->Light })
  {
    glDeleteProgram(program);
  }
}

void GlesOcclusion::Forget()
{
  this->Occlude = this->Average = this->Light = 0;
  this->Targets = {};
  this->Width = this->Height = 0;
}

void GlesOcclusion::Free()
{
  for (Target& target : this->Targets)
  {
    glDeleteFramebuffers(1, &target.framebuffer);
    glDeleteTextures(1, &target.texture);
    target = {};
  }
  this->Width = this->Height = 0;
}

bool GlesOcclusion::Resize(int width, int height)
{
  if (width == this->Width && height == this->Height)
  {
    return true;
  }
  this->Free();
  bool complete = true;
  for (std::size_t i = 0; i < count; ++i)
  {
    Target& target = this->Targets[i];
    glGenTextures(1, &target.texture);
    glGenFramebuffers(1, &target.framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    const bool ofDepths = i == depths;
    MakeTexture(target.texture, ofDepths ? GL_DEPTH_COMPONENT24 : GL_R8,
      i == mean ? GL_LINEAR : GL_NEAREST, width, height);
    glFramebufferTexture2D(GL_FRAMEBUFFER, ofDepths ? GL_DEPTH_ATTACHMENT : GL_COLOR_ATTACHMENT0,
      GL_TEXTURE_2D, target.texture, 0);
    complete &= glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
  }
  this->Width = width;
  this->Height = height;
  if (!complete)
  {
    this->Free();
  }
  return complete;
}

bool GlesOcclusion::BeginDepths(const Viewport& picture)
{
  this->Picture = picture;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &this->Before);
  if (!this->Resize(HalfSide(picture.width), HalfSide(picture.height)))
  {
    glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(this->Before));
    return false;
  }
  glBindFramebuffer(GL_FRAMEBUFFER, this->Targets[depths].framebuffer);
  glViewport(0, 0, this->Width, this->Height);
  glClear(GL_DEPTH_BUFFER_BIT);
  return true;
}

void GlesOcclusion::Use(GLuint program, const GlesProjection& projection) const
{
  glUseProgram(program);
  glUniform4f(glGetUniformLocation(program, "projection"), projection[0], projection[1],
    projection[2], projection[3]);
  const auto reach = static_cast<float>(occlusionReach);
  glUniform4f(glGetUniformLocation(program, "grid"), static_cast<float>(this->Width),
    static_cast<float>(this->Height), reach * static_cast<float>(this->Height),
    2.0f * reach / projection[1]);
}

void GlesOcclusion::Fill(Index target) const
{
  glBindFramebuffer(GL_FRAMEBUFFER, this->Targets[target].framebuffer);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void GlesOcclusion::EndDepths(const GlesProjection& projection, double facet)
{
  glDisable(GL_DEPTH_TEST);
  BindTexture(0, this->Targets[depths].texture);
  this->Use(this->Occlude, projection);
  glUniform1f(glGetUniformLocation(this->Occlude, "facet"), static_cast<float>(facet));
  this->Fill(occluded);
  BindTexture(1, this->Targets[occluded].texture);
  this->Use(this->Average, projection);
  this->Fill(mean);
  glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(this->Before));
}

// Drawn at the depth of the background, where something is in front of it: at the model's outline
// only on those samples of a pixel that belong to the model.
void GlesOcclusion::Darken()
{
  BindTexture(1, this->Targets[mean].texture);
  glUseProgram(this->Light);
  glUniform4f(glGetUniformLocation(this->Light, "area"), 0.0f, 0.0f,
    static_cast<float>(this->Picture.width), static_cast<float>(this->Picture.height));
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ZERO, GL_SRC_COLOR);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}
