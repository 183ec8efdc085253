// SPDX-License-Identifier: BSD-3-Clause
// A tile's picture as VTK draws it. Step "render" of the pipeline picture.
#pragma once

#include "viewer/rendering/SurfaceScene.h"

#include <vtkSmartPointer.h>

class vtkTexture;

namespace kdstream
{

// Its texels are interpolated, and mipmapped where several share a pixel, as in the page. Texture
// coordinates are clamped to the picture.
vtkSmartPointer<vtkTexture> MakeTileTexture(const TilePicture& picture);

}
