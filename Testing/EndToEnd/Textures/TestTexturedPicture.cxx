// SPDX-License-Identifier: BSD-3-Clause
// A textured model that was cut up and extracted is drawn by VTK, and compared with the original
// model: seams and charts must be invisible.
#include "Testing/EndToEnd/Textures/TexturedFiles.h"
#include "viewer/offscreen/OffscreenWindow.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkTexture.h>
#include <vtkUnsignedCharArray.h>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

constexpr int side = 700; // pixels

class TestTexturedPicture : public TexturedTest
{
protected:
  using Pixels = std::vector<std::uint8_t>; // RGB

  // Draws the file from three sides.
  std::vector<Pixels> Draw(const std::string& file)
  {
    const TexturedMesh textured = this->ReadWithTextures(file);
    const std::vector<Picture> pictures = PicturesOf(textured);
    auto window = MakeOffscreenWindow(WindowBackend::Auto, side, side);
    EXPECT_TRUE(window) << window.GetError().message;
    vtkNew<vtkRenderer> renderer;
    renderer->SetBackground(0, 0, 0);
    (*window)->AddRenderer(renderer);
    for (std::uint32_t material = 0; material < textured.materials.size(); ++material)
    {
      AddMaterial(textured, material, pictures, *renderer);
    }
    std::vector<Pixels> views;
    for (const Vec3& from : { Vec3{ 0.1, 0.2, 1 }, Vec3{ 0.7, -0.2, 0.7 }, Vec3{ -0.6, 0.5, 0.6 } })
    {
      renderer->GetActiveCamera()->SetFocalPoint(0, 0, 0);
      renderer->GetActiveCamera()->SetPosition(from[0], from[1], from[2]);
      renderer->ResetCamera();
      (*window)->Render();
      vtkNew<vtkUnsignedCharArray> pixels;
      (*window)->GetPixelData(0, 0, side - 1, side - 1, 0, pixels);
      views.emplace_back(pixels->GetPointer(0), pixels->GetPointer(0) + 3 * side * side);
    }
    return views;
  }

  // The share of the object's pixels that differ by more than 8.
  static double Differing(const std::vector<Pixels>& a, const std::vector<Pixels>& b)
  {
    double object = 0, differing = 0;
    for (std::size_t view = 0; view < a.size(); ++view)
    {
      for (std::size_t i = 0; i < a[view].size(); i += 3)
      {
        int most = 0, light = 0;
        for (std::size_t k = i; k < i + 3; ++k)
        {
          most = std::max(most, std::abs(a[view][k] - b[view][k]));
          light += a[view][k];
        }
        object += light > 0;
        differing += most > 8;
      }
    }
    EXPECT_GT(object, 100000);
    return differing / object;
  }

private:
  // Adds a material without light; its texels are interpolated as renderers do by default.
  static void AddMaterial(const TexturedMesh& textured, std::uint32_t number,
    const std::vector<Picture>& pictures, vtkRenderer& renderer)
  {
    const TexturedMaterial& material = textured.materials[number];
    vtkNew<vtkPoints> points;
    vtkNew<vtkCellArray> cells;
    vtkNew<vtkFloatArray> places;
    places->SetNumberOfComponents(2);
    for (std::size_t t = 0; t < textured.mesh.triangles.size(); ++t)
    {
      if (textured.materialOf[t] != number)
      {
        continue;
      }
      vtkIdType ids[3];
      for (std::size_t k = 0; k < 3; ++k)
      {
        const PictureCoordinate& corner = textured.corners[t][k];
        const auto place = PlaceOf(material, corner[0], corner[1]);
        ids[k] =
          points->InsertNextPoint(textured.mesh.points[textured.mesh.triangles[t][k]].data());
        places->InsertNextTuple2(place[0], 1 - place[1]);
      }
      cells->InsertNextCell(3, ids);
    }
    vtkNew<vtkPolyData> surface;
    surface->SetPoints(points);
    surface->SetPolys(cells);
    vtkNew<vtkPolyDataMapper> mapper;
    vtkNew<vtkActor> actor;
    if (material.picture != noPicture)
    {
      surface->GetPointData()->SetTCoords(places);
      actor->SetTexture(TextureOf(pictures[material.picture], material));
    }
    else
    {
      actor->GetProperty()->SetColor(FromLinear(material.color[0]), FromLinear(material.color[1]),
        FromLinear(material.color[2]));
    }
    mapper->SetInputData(surface);
    actor->SetMapper(mapper);
    actor->GetProperty()->LightingOff();
    renderer.AddActor(actor);
  }

  static vtkNew<vtkTexture> TextureOf(const Picture& picture, const TexturedMaterial& material)
  {
    vtkNew<vtkImageData> image;
    image->SetDimensions(int(picture.width), int(picture.height), 1);
    image->AllocateScalars(VTK_UNSIGNED_CHAR, int(picture.components));
    const std::size_t row = picture.width * picture.components;
    for (std::size_t y = 0; y < picture.height; ++y) // from the bottom row
    {
      std::copy_n(picture.texels.data() + (picture.height - 1 - y) * row, row,
        static_cast<std::uint8_t*>(image->GetScalarPointer()) + y * row);
    }
    vtkNew<vtkTexture> texture;
    texture->SetInputData(image);
    texture->InterpolateOn();
    texture->SetWrap(
      material.wrapU == TextureWrap::Clamp ? vtkTexture::ClampToEdge : vtkTexture::Repeat);
    return texture;
  }
};

}

TEST_F(TestTexturedPicture, NothingIsSeenOfTiles)
{
  this->WriteHardObj("hard", 7, 40);
  ASSERT_EQ(RunTool(this->Folder, "generate",
              { "statue", "statue.obj", "--vertices", "20000", "--picture-side", "512", "--quiet" })
              .exitCode,
    0);
  for (const std::string name : { "hard", "statue" })
  {
    const std::vector<Pixels> whole = this->Draw(name + ".obj");
    for (const std::string quality : { "lossless", "90" })
    {
      ASSERT_EQ(this
                  ->Build({ name + ".obj", "-o", "m.kds", "--quiet", "--precision", "lossless",
                    "--vertices-per-partition", "500", "--texture-quality", quality })
                  .exitCode,
        0);
      ASSERT_EQ(
        this->Store({ "extract", "m.kds", "--all", "-o", "out.obj", "--quiet" }).exitCode, 0);
      const double differing = Differing(whole, this->Draw("out.obj"));
      this->RecordProperty(name + " " + quality, std::to_string(differing));
      EXPECT_LE(differing, 0.005) << name << " " << quality;
    }
  }
}
