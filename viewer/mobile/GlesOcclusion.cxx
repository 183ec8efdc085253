// SPDX-License-Identifier: BSD-3-Clause
// Draws ambient occlusion into the phone's picture: see GlesOcclusion.h.
#include "viewer/mobile/GlesOcclusion.h"

#include "viewer/mobile/GlesPrograms.h"
#include "viewer/mobile/GlesShaders.h"
#include "viewer/session/appearance/OcclusionShaders.h"

#include <utility>

namespace kdstream
{
namespace
{

void BindTexture(GLint unit, GLuint texture)
{
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D, texture);
}

void MakeTexture(GLuint texture, GLenum format, int width, int height)
{
  BindTexture(0, texture);
  glTexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

}

Result<std::unique_ptr<GlesOcclusion>> GlesOcclusion::Make()
{
  std::unique_ptr<GlesOcclusion> made(new GlesOcclusion);
  const std::array<std::pair<GLuint*, const char*>, 2> programs{ {
    { &made->Occlude, shaders::occlusionFragment },
    { &made->Average, shaders::occlusionMeanFragment },
  } };
  for (const auto& [program, text] : programs)
  {
    const auto compiled = MakeProgram("occlusion's", { shaders::header, shaders::backgroundVertex },
      { shaders::header, shaders::occlusionDepths, text });
    KDSTREAM_TRY(compiled);
    *program = *compiled;
    SetOcclusionUnits(*program);
    glUniform1f(glGetUniformLocation(*program, "strength"), static_cast<float>(occlusionStrength));
  }
  return made;
}

GlesOcclusion::~GlesOcclusion()
{
  this->Free();
  for (const GLuint program : { this->Occlude, this->Average })
  {
    glDeleteProgram(program);
  }
}

void GlesOcclusion::Forget()
{
  this->Occlude = this->Average = 0;
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
    MakeTexture(target.texture, ofDepths ? GL_DEPTH_COMPONENT24 : GL_R8, width, height);
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
  // A texture that is drawn into must not be bound for reading.
  BindTexture(depthsUnit, 0);
  BindTexture(occludedUnit, 0);
  glBindFramebuffer(GL_FRAMEBUFFER, this->Targets[depths].framebuffer);
  glViewport(0, 0, this->Width, this->Height);
  glClear(GL_DEPTH_BUFFER_BIT);
  return true;
}

void GlesOcclusion::Aim(GLuint program) const
{
  const GlesProjection& projection = this->Projection;
  glUniform4f(glGetUniformLocation(program, "projection"), projection[0], projection[1],
    projection[2], projection[3]);
  const auto reach = static_cast<float>(occlusionReach);
  const auto width = static_cast<float>(this->Width), height = static_cast<float>(this->Height);
  glUniform4f(glGetUniformLocation(program, "grid"), width, height, reach * height,
    2.0f * reach / projection[1]);
  glUniform2f(glGetUniformLocation(program, "texels"),
    width / static_cast<float>(this->Picture.width),
    height / static_cast<float>(this->Picture.height));
}

void GlesOcclusion::Fill(Index target) const
{
  glBindFramebuffer(GL_FRAMEBUFFER, this->Targets[target].framebuffer);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void GlesOcclusion::EndDepths(const GlesProjection& projection, double facet)
{
  this->Projection = projection;
  glDisable(GL_DEPTH_TEST);
  BindTexture(depthsUnit, this->Targets[depths].texture);
  glUseProgram(this->Occlude);
  this->Aim(this->Occlude);
  glUniform1f(glGetUniformLocation(this->Occlude, "facet"), static_cast<float>(facet));
  this->Fill(occluded);
  BindTexture(occludedUnit, this->Targets[occluded].texture);
  glUseProgram(this->Average);
  this->Aim(this->Average);
  this->Fill(mean);
  BindTexture(occludedUnit, this->Targets[mean].texture);
  glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(this->Before));
}

}
