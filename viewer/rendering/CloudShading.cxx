// Shading for points: see CloudShading.h.
#include "viewer/rendering/CloudShading.h"

#include <vtkObjectFactory.h>
#include <vtkRenderState.h>
#include <vtkRenderer.h>

#include <algorithm>

namespace kdstream
{

vtkStandardNewMacro(CloudShading);

void CloudShading::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}

void CloudShading::Render(const vtkRenderState* state)
{
  int width = 0;
  int height = 0;
  state->GetRenderer()->GetTiledSize(&width, &height);
  constexpr int smallest = 4;
  if (std::min(width, height) < smallest)
  {
    this->DelegatePass->Render(state);
    return;
  }
  this->Superclass::Render(state);
}

}
