// SPDX-License-Identifier: BSD-3-Clause
// The programs of GlesRenderer. Internal to viewer/mobile.
#pragma once

#include "filters/core/Result.h"
#include "viewer/session/appearance/SceneAppearance.h"

#include <GLES3/gl3.h>

#include <array>
#include <cstddef>
#include <initializer_list>
#include <memory>

namespace kdstream
{

// Threads and context: as for GlesRenderer.
class GlesPrograms
{
public:
  // Variants of the program: add those that apply.
  static constexpr std::size_t cloud = 1;
  static constexpr std::size_t cut = 2;      // cut by a section
  static constexpr std::size_t relief = 4;   // not for clouds
  static constexpr std::size_t textured = 8; // not for clouds

  // Errors: Unsupported if no context of OpenGL ES 3.0 or WebGL 2 is current, or if a shader does
  // not compile, with the driver's message.
  static Result<std::unique_ptr<GlesPrograms>> Make();
  ~GlesPrograms();
  GlesPrograms(const GlesPrograms&) = delete;
  GlesPrograms& operator=(const GlesPrograms&) = delete;

  // Call this when the context was lost: nothing is deleted.
  void Forget() { this->Empty = 0; }

  GLuint Background() const { return this->Gradient; }
  // A vertex array for drawing without attributes.
  GLuint EmptyArray() const { return this->Empty; }
  // Programs that not every view needs are compiled when they are first used. Errors: as for Make.
  Result<GLuint> Surface(std::size_t kind);
  Result<GLuint> Cap();

private:
  GlesPrograms() = default;

  GLuint Gradient = 0, Filling = 0, Empty = 0;
  std::array<GLuint, 16> Surfaces{}; // index: kind; 0: not compiled yet
};

// The texture units of the samplers `depths` and `occluded` for ambient occlusion.
inline constexpr GLint depthsUnit = 1, occludedUnit = 2;
// The program is in use afterwards.
void SetOcclusionUnits(GLuint program);

void SetVector(GLuint program, const char* name, const Vec3& v);
// Sets the uniforms for light and material. REQUIRES: the program is in use.
void SetLighting(GLuint program, const SceneLighting& lighting);

// Compiles and links a program. The texts of a shader are concatenated. name: for messages. Errors:
// Unsupported, with the driver's message.
Result<GLuint> MakeProgram(const char* name, std::initializer_list<const char*> vertexTexts,
  std::initializer_list<const char*> fragmentTexts);

}
