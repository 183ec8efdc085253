// Shading for points, which have no normals. Internal to viewer/rendering.
#pragma once

#include <vtkEDLShading.h>

namespace kdstream
{

// VTK's eye-dome lighting, which darkens a pixel by how far its neighbours stand before it. It
// works on a picture of a quarter of the size as well, so views of less than 4 pixels, which
// VTK 9.1 fails on, are drawn without it.
class CloudShading final : public vtkEDLShading
{
public:
  static CloudShading* New();
  vtkTypeMacro(CloudShading, vtkEDLShading);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  // REQUIRES: a delegate pass, which draws the points.
  void Render(const vtkRenderState* state) override;

protected:
  CloudShading() = default;
  ~CloudShading() override = default;
};

}
