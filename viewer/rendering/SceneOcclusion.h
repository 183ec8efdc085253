// SPDX-License-Identifier: BSD-3-Clause
// Adds ambient occlusion to a VTK renderer's picture, by the passes of
// viewer/session/appearance/OcclusionShaders.h. Internal to viewer/rendering.
#pragma once

#include <vtkNew.h>
#include <vtkWeakPointer.h>

#include <initializer_list>
#include <memory>
#include <utility>

class vtkOpenGLFramebufferObject;
class vtkOpenGLQuadHelper;
class vtkOpenGLRenderWindow;
class vtkRenderer;
class vtkTextureObject;

namespace kdstream
{

// Threads: only the window's thread.
class SceneOcclusion
{
public:
  SceneOcclusion();
  ~SceneOcclusion();
  SceneOcclusion(const SceneOcclusion&) = delete;
  SceneOcclusion& operator=(const SceneOcclusion&) = delete;

  // Darkens what the renderer has drawn, before its window shows it: call this at the renderer's
  // EndEvent. Does nothing if the window is not an OpenGL window, or if its depths cannot be read.
  // facet: FacetLength of what is drawn; 0 for a cloud.
  void Darken(vtkRenderer& renderer, double facet);

private:
  struct Area;

  bool Prepare(vtkOpenGLRenderWindow& window, vtkTextureObject& depths, const Area& area);
  void Run(vtkOpenGLQuadHelper& pass, vtkTextureObject& target, const Area& area,
    std::initializer_list<std::pair<const char*, vtkTextureObject*>> sources);

  vtkWeakPointer<vtkOpenGLRenderWindow> Window; // the window that owns the following
  vtkNew<vtkOpenGLFramebufferObject> Framebuffer;
  vtkNew<vtkTextureObject> Depths, Occluded, Mean;
  std::unique_ptr<vtkOpenGLQuadHelper> Gather, Occlude, Average, Light;
  int Samples = 0; // samples that Gather reads
  int Sides[2]{};  // of the textures
};

}
