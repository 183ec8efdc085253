// SPDX-License-Identifier: BSD-3-Clause
// For the tests: makes the input of an example, or checks the example's picture.
//   ExampleProbe make-mesh FILE.ply          writes a sphere of about 30,000 points
//   ExampleProbe check-picture FILE.png N    succeeds if at least N hues (of 36) fill 0.5 % each
//   ExampleProbe make-picture FILE.png N [C] writes a grey N x N picture of C components (3: RGB)
#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkPLYWriter.h>
#include <vtkPNGReader.h>
#include <vtkPNGWriter.h>
#include <vtkPointData.h>
#include <vtkSphereSource.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iostream>
#include <string>

namespace
{

int MakeMesh(const char* file)
{
  vtkNew<vtkSphereSource> sphere;
  sphere->SetThetaResolution(200);
  sphere->SetPhiResolution(150);
  vtkNew<vtkPLYWriter> writer;
  writer->SetInputConnection(sphere->GetOutputPort());
  writer->SetFileName(file);
  return writer->Write() == 1 ? EXIT_SUCCESS : EXIT_FAILURE;
}

int MakePicture(const char* file, int side, int components)
{
  vtkNew<vtkImageData> picture;
  picture->SetDimensions(side, side, 1);
  picture->AllocateScalars(VTK_UNSIGNED_CHAR, components);
  picture->GetPointData()->GetScalars()->Fill(128);
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputData(picture);
  writer->SetFileName(file);
  writer->Write();
  return writer->GetErrorCode() == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

int CheckPicture(const char* file, std::size_t hues)
{
  vtkNew<vtkPNGReader> reader;
  reader->SetFileName(file);
  reader->Update();
  vtkImageData* const picture = reader->GetOutput();
  int size[3];
  picture->GetDimensions(size);
  std::array<int, 37> pixels{};
  for (int y = 0; y < size[1]; ++y)
  {
    for (int x = 0; x < size[0]; ++x)
    {
      double rgb[3], hsv[3];
      for (int k = 0; k < 3; ++k)
      {
        rgb[k] = picture->GetScalarComponentAsDouble(x, y, 0, k) / 255;
      }
      vtkMath::RGBToHSV(rgb, hsv);
      if (hsv[1] > 0.1 && hsv[2] > 0.2)
      {
        ++pixels[static_cast<std::size_t>(hsv[0] * 36)];
      }
    }
  }
  const int least = size[0] * size[1] / 200;
  const auto found = static_cast<std::size_t>(
    std::count_if(pixels.begin(), pixels.end(), [&](int count) { return count > least; }));
  std::cout << size[0] << " x " << size[1] << " pixels, " << found << " hues\n";
  return found >= hues ? EXIT_SUCCESS : EXIT_FAILURE;
}

}

int main(int argc, char* argv[])
{
  const std::string what = argc > 1 ? argv[1] : "";
  if (what == "make-mesh" && argc == 3)
  {
    return MakeMesh(argv[2]);
  }
  if (what == "make-picture" && (argc == 4 || argc == 5))
  {
    return MakePicture(argv[2], std::atoi(argv[3]), argc == 5 ? std::atoi(argv[4]) : 3);
  }
  if (what == "check-picture" && argc == 4)
  {
    return CheckPicture(argv[2], std::strtoul(argv[3], nullptr, 10));
  }
  return 2;
}
