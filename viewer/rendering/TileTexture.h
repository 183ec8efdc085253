// SPDX-License-Identifier: BSD-3-Clause
// A tile's picture as VTK draws it. Step "render" of the pipeline picture.
#pragma once

#include "viewer/rendering/SurfaceScene.h"

#include <vtkSmartPointer.h>

class vtkTexture;

namespace kdstream
{

// Its texels are mixed with their neighbours, and where several share a pixel, in halves and
// quarters of the picture, as the page mixes them. What is beyond the edge is not looked at.
vtkSmartPointer<vtkTexture> MakeTileTexture(const TilePicture& picture);

}
