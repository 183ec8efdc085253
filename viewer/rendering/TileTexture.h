// SPDX-License-Identifier: BSD-3-Clause
// A tile's picture as a VTK texture. Step "render" of the pipeline picture.
#pragma once

#include "viewer/rendering/SurfaceScene.h"

#include <vtkSmartPointer.h>

class vtkTexture;

namespace kdstream
{

// Texels are interpolated; where several share a pixel, mipmaps are used, as in the web page.
// Texture coordinates are clamped to the picture.
vtkSmartPointer<vtkTexture> MakeTileTexture(const TilePicture& picture);

}
