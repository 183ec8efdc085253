// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/rendering/TileTexture.h"

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLTexture.h>
#include <vtkTextureObject.h>

#include <algorithm>

namespace kdstream
{
namespace
{

// Uses the mipmap level (half or quarter of the picture) that fits the size of a pixel, as the web
// page does (viewer/mobile/GlesBuffers.cxx). The margins of charts are wide enough for these
// levels.
class TileTexture : public vtkOpenGLTexture
{
public:
  static TileTexture* New();
  vtkTypeMacro(TileTexture, vtkOpenGLTexture);

  void Load(vtkRenderer* renderer) override
  {
    this->Superclass::Load(renderer);
    if (vtkTextureObject* const object = this->TextureObject)
    {
      object->SetMinificationFilter(vtkTextureObject::LinearMipmapNearest);
      object->SetMaxLevel(2);
      object->SetMaximumAnisotropicFiltering(1);
      object->SendParameters();
    }
  }

protected:
  TileTexture() = default;
};
vtkStandardNewMacro(TileTexture);

}

vtkSmartPointer<vtkTexture> MakeTileTexture(const TilePicture& picture)
{
  const vtkNew<vtkImageData> image;
  image->SetDimensions(static_cast<int>(picture.width), static_cast<int>(picture.height), 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  std::copy(picture.texels.begin(), picture.texels.end(),
    static_cast<unsigned char*>(image->GetScalarPointer()));
  auto texture = vtkSmartPointer<TileTexture>::New();
  texture->SetInputDataObject(image);
  texture->InterpolateOn();
  texture->MipmapOn();
  texture->RepeatOff();
  texture->EdgeClampOn();
  return texture;
}

}
