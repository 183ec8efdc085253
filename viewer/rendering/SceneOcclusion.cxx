// SPDX-License-Identifier: BSD-3-Clause
// Ambient occlusion in a VTK renderer's picture: see SceneOcclusion.h.
#include "viewer/rendering/SceneOcclusion.h"

#include "viewer/session/appearance/OcclusionShaders.h"

#include <vtkCamera.h>
#include <vtkOpenGLFramebufferObject.h>
#include <vtkOpenGLQuadHelper.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLShaderCache.h>
#include <vtkOpenGLState.h>
#include <vtkRenderer.h>
#include <vtkShaderProgram.h>
#include <vtkTextureObject.h>

#include <GL/gl.h> // only for constants; no function is called

#include <array>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <string>
#include <utility>

namespace kdstream
{
namespace
{

// Both attributes give a corner's position: VTK would report an error if one were not used.
constexpr const char* vertexShader = R"(//VTK::System::Dec
in vec4 ndCoordIn;
in vec2 texCoordIn;
void main()
{
  gl_Position = vec4(0.5 * ndCoordIn.xy + texCoordIn - 0.5, 1.0, 1.0);
})";
constexpr const char* header = "//VTK::System::Dec\n";

// Computes a depth for the middle of each 2 × 2 pixels of an area (the area's left and bottom edge
// in the window, its width and height). For a surface it is the mean of two samples on either side
// of the middle, if both belong to the same surface. For a cloud, whose splats are not one surface,
// it is one of the samples.
std::string GatherShader(int samples)
{
  const bool many = samples > 1;
  return std::string(header) + "#define SAMPLES sampler2D" + (many ? "MS" : "") +
         "\nconst int lastSample = " + std::to_string(many ? samples - 1 : 0) + R"(;
uniform SAMPLES depths;
uniform vec4 area;
uniform vec4 projection;
uniform vec4 grid;
uniform float likeness; // largest distance between samples of one surface, relative to the reach
out vec4 fragment;
float distanceOf(float depth)
{
  return projection.w / (2.0 * depth - 1.0 + projection.z);
}
void main()
{
  vec2 pixel = 2.0 * floor(gl_FragCoord.xy);
  vec2 most = area.zw - 1.0;
  float one = texelFetch(depths, ivec2(area.xy + min(pixel, most)), lastSample).x;
  float other = texelFetch(depths, ivec2(area.xy + min(pixel + 1.0, most)), 0).x;
  float between = abs(distanceOf(one) - distanceOf(other));
  bool alike = max(one, other) < 1.0 && between < likeness * grid.w * distanceOf(one);
  fragment = vec4(alike ? 0.5 * (one + other) : one);
})";
}

std::string WithDepths(const char* shader)
{
  return std::string(header) + shaders::occlusionDepths + shader;
}

// Computes the factor for each sample; 1 for the background. A driver that cannot shade samples
// separately uses the depth of a pixel's first sample for all of them.
std::string LightShader(int samples)
{
  return std::string(header) + "#extension GL_ARB_sample_shading : enable\n" +
         (samples > 1 ? "#define SAMPLES sampler2DMS\n" : "#define SAMPLES sampler2D\n") +
         (samples > 1 ? "#ifdef GL_ARB_sample_shading\n#define SHADES\n#endif\n" : "") +
         shaders::occlusionDepths + shaders::occlusionLeft + R"(
uniform SAMPLES drawn;
uniform vec4 area;
out vec4 fragment;
void main()
{
#ifdef SHADES
  int number = gl_SampleID;
#else
  int number = 0;
#endif
  float depth = texelFetch(drawn, ivec2(gl_FragCoord.xy), number).x;
  float left = 1.0;
  if (depth < 1.0)
  {
    left = lightLeft(0.5 * (gl_FragCoord.xy - area.xy), distanceOf(depth));
  }
  fragment = vec4(vec3(left), 1.0);
})";
}

}

// The part of the window that the renderer draws into, in pixels, and the renderer's projection.
struct SceneOcclusion::Area
{
  std::array<float, 4> place;
  std::array<int, 2> half;
  std::array<float, 4> projection;
  float likeness, facet;
  std::array<float, 4> Grid() const
  {
    const auto reach = static_cast<float>(occlusionReach);
    const auto height = static_cast<float>(this->half[1]);
    return { static_cast<float>(this->half[0]), height, reach * height,
      2.0f * reach / this->projection[1] };
  }
};

SceneOcclusion::SceneOcclusion() = default;
SceneOcclusion::~SceneOcclusion() = default;

// Makes textures and programs for the window, unless there already are some of this size.
bool SceneOcclusion::Prepare(
  vtkOpenGLRenderWindow& window, vtkTextureObject& depths, const Area& area)
{
  const int samples = static_cast<int>(depths.GetSamples());
  if (&window != this->Window || samples != this->Samples || !this->Gather)
  {
    this->Window = &window;
    this->Samples = samples;
    this->Sides[0] = 0;
    const auto make = [&window](const std::string& fragmentShader)
    {
      return std::make_unique<vtkOpenGLQuadHelper>(
        &window, vertexShader, fragmentShader.c_str(), "");
    };
    this->Gather = make(GatherShader(samples));
    this->Occlude = make(WithDepths(shaders::occlusionFragment));
    this->Average = make(WithDepths(shaders::occlusionMeanFragment));
    this->Light = make(LightShader(samples));
  }
  for (const auto* pass : { &this->Gather, &this->Occlude, &this->Average, &this->Light })
  {
    if (!(*pass)->Program || !(*pass)->Program->GetCompiled())
    {
      return false;
    }
  }
  if (this->Sides[0] != area.half[0] || this->Sides[1] != area.half[1])
  {
    for (vtkTextureObject* texture : { this->Depths.Get(), this->Occluded.Get(), this->Mean.Get() })
    {
      texture->ReleaseGraphicsResources(&window);
      texture->SetContext(&window);
      texture->SetMinificationFilter(vtkTextureObject::Nearest);
      texture->SetMagnificationFilter(vtkTextureObject::Nearest);
      texture->SetWrapS(vtkTextureObject::ClampToEdge);
      texture->SetWrapT(vtkTextureObject::ClampToEdge);
      texture->Allocate2D(static_cast<unsigned>(area.half[0]), static_cast<unsigned>(area.half[1]),
        1, texture == this->Depths ? VTK_FLOAT : VTK_UNSIGNED_CHAR);
    }
    this->Framebuffer->SetContext(&window);
    std::copy(area.half.begin(), area.half.end(), this->Sides);
  }
  return true;
}

// Fills the target with the result of the pass.
void SceneOcclusion::Run(vtkOpenGLQuadHelper& pass, vtkTextureObject& target, const Area& area,
  std::initializer_list<std::pair<const char*, vtkTextureObject*>> sources)
{
  this->Framebuffer->Bind();
  this->Framebuffer->AddColorAttachment(0, &target);
  this->Framebuffer->ActivateDrawBuffer(0);
  this->Window->GetShaderCache()->ReadyShaderProgram(pass.Program);
  for (const auto& [name, texture] : sources)
  {
    texture->Activate();
    pass.Program->SetUniformi(name, texture->GetTextureUnit());
  }
  pass.Program->SetUniform4f("area", area.place.data());
  pass.Program->SetUniform4f("grid", area.Grid().data());
  pass.Program->SetUniform4f("projection", area.projection.data());
  pass.Program->SetUniformf("likeness", area.likeness);
  pass.Program->SetUniformf("facet", area.facet);
  pass.Program->SetUniformf("strength", static_cast<float>(occlusionStrength));
  pass.Render();
  for (const auto& [name, texture] : sources)
  {
    texture->Deactivate();
  }
}

void SceneOcclusion::Darken(vtkRenderer& renderer, double facet)
{
  auto* window = vtkOpenGLRenderWindow::SafeDownCast(renderer.GetRenderWindow());
  vtkOpenGLFramebufferObject* drawn = window ? window->GetRenderFramebuffer() : nullptr;
  vtkTextureObject* depths = drawn ? drawn->GetDepthAttachmentAsTextureObject() : nullptr;
  vtkTextureObject* colors = drawn ? drawn->GetColorAttachmentAsTextureObject(0) : nullptr;
  int left = 0;
  int bottom = 0;
  int width = 0;
  int height = 0;
  renderer.GetTiledSizeAndOrigin(&width, &height, &left, &bottom);
  if (!depths || !colors || width < 1 || height < 1)
  {
    return;
  }
  vtkCamera* camera = renderer.GetActiveCamera();
  const double scale = 1.0 / std::tan(camera->GetViewAngle() * std::numbers::pi / 360.0);
  const double* range = camera->GetClippingRange();
  const double depth = range[1] - range[0];
  Area area{};
  area.place = { static_cast<float>(left), static_cast<float>(bottom), static_cast<float>(width),
    static_cast<float>(height) };
  area.half = { HalfSide(width), HalfSide(height) };
  area.projection = { static_cast<float>(scale * height / width), static_cast<float>(scale),
    static_cast<float>(-(range[1] + range[0]) / depth),
    static_cast<float>(-2.0 * range[1] * range[0] / depth) };
  area.likeness = facet > 0.0 ? 0.5f : 0.0f;
  area.facet = static_cast<float>(facet);
  if (!this->Prepare(*window, *depths, area))
  {
    return;
  }
  vtkOpenGLState* state = window->GetState();
  const vtkOpenGLState::ScopedglViewport viewport(state);
  const vtkOpenGLState::ScopedglScissor scissor(state);
  const vtkOpenGLState::ScopedglDepthMask mask(state);
  const vtkOpenGLState::ScopedglBlendFuncSeparate blending(state);
  const vtkOpenGLState::ScopedglEnableDisable blend(state, GL_BLEND);
  const vtkOpenGLState::ScopedglEnableDisable test(state, GL_DEPTH_TEST);
  state->vtkglDepthMask(GL_FALSE);
  state->vtkglDisable(GL_BLEND);
  state->vtkglDisable(GL_DEPTH_TEST);
  state->PushFramebufferBindings();
  state->vtkglViewport(0, 0, area.half[0], area.half[1]);
  state->vtkglScissor(0, 0, area.half[0], area.half[1]);
  this->Run(*this->Gather, *this->Depths, area, { { "depths", depths } });
  this->Run(*this->Occlude, *this->Occluded, area, { { "depths", this->Depths } });
  this->Run(*this->Average, *this->Mean, area,
    { { "depths", this->Depths }, { "occluded", this->Occluded } });
  // The depths are not attached here, because the pass reads them.
  state->vtkglViewport(left, bottom, width, height);
  state->vtkglScissor(left, bottom, width, height);
  state->vtkglEnable(GL_BLEND);
  state->vtkglBlendFuncSeparate(GL_ZERO, GL_SRC_COLOR, GL_ZERO, GL_ONE);
  this->Run(*this->Light, *colors, area,
    { { "depths", this->Depths }, { "occluded", this->Mean }, { "drawn", depths } });
  this->Framebuffer->RemoveColorAttachment(0);
  state->PopFramebufferBindings();
}

}
