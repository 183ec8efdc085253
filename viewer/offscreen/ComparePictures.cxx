// SPDX-License-Identifier: BSD-3-Clause
// Compares a picture with its baseline, for kdstream_add_picture_test:
//   compare_pictures PICTURE.png BASELINE.png TOLERANCE DIFFERENCE.png
// The measure is the one of vtkImageDifference; VTK's own regression tests require it to be below
// 10. It ignores alpha, and differences below 16 of 255 from a pixel or one of its neighbours.
// Above the tolerance, the exit status is 1, and the difference is written. A message says if the
// baseline is missing, has another size, or is not of 8-bit RGB or RGBA.
#include <vtkImageData.h>
#include <vtkImageDifference.h>
#include <vtkImageExtractComponents.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>
#include <vtkPNGWriter.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>

namespace
{

// Returns false, with a message, if the file is not a picture of 8-bit RGB or RGBA. rgb: the
// picture without alpha.
bool Read(const char* file, vtkImageExtractComponents& rgb)
{
  vtkNew<vtkPNGReader> reader;
  if (!std::filesystem::is_regular_file(file) || !reader->CanReadFile(file))
  {
    std::cerr << file << " cannot be read as a PNG file\n";
    return false;
  }
  reader->SetFileName(file);
  reader->Update();
  vtkImageData* const picture = reader->GetOutput();
  const int components = picture->GetNumberOfScalarComponents();
  if (picture->GetScalarType() != VTK_UNSIGNED_CHAR || components < 3)
  {
    std::cerr << file << " is not an 8-bit RGB or RGBA picture: it has " << components
              << " components of " << picture->GetScalarTypeAsString() << '\n';
    return false;
  }
  rgb.SetInputConnection(reader->GetOutputPort());
  rgb.SetComponents(0, 1, 2);
  rgb.Update();
  return true;
}

}

int main(int argc, char* argv[])
{
  if (argc != 5)
  {
    return 2;
  }
  char* end = nullptr;
  const double tolerance = std::strtod(argv[3], &end);
  if (end == argv[3] || *end != '\0' || !std::isfinite(tolerance) || tolerance < 0)
  {
    std::cerr << "the tolerance must be a number of at least 0, not " << argv[3] << '\n';
    return 2;
  }
  vtkNew<vtkImageExtractComponents> picture;
  vtkNew<vtkImageExtractComponents> baseline;
  if (!Read(argv[1], *picture))
  {
    return 1;
  }
  if (!Read(argv[2], *baseline))
  {
    std::cerr << "the picture of this run is " << argv[1] << "; if it is right: cp " << argv[1]
              << ' ' << argv[2] << '\n';
    return 1;
  }
  int size[3];
  int wanted[3];
  picture->GetOutput()->GetDimensions(size);
  baseline->GetOutput()->GetDimensions(wanted);
  if (size[0] != wanted[0] || size[1] != wanted[1])
  {
    std::cerr << argv[1] << " has " << size[0] << " x " << size[1] << " pixels, " << argv[2] << ' '
              << wanted[0] << " x " << wanted[1] << '\n';
    return 1;
  }
  vtkNew<vtkImageDifference> difference;
  difference->SetInputConnection(picture->GetOutputPort());
  difference->SetImageConnection(baseline->GetOutputPort());
  difference->Update();
  const double error = difference->GetThresholdedError();
  std::cout << "the picture differs by " << error << " (at most " << argv[3] << ")\n";
  if (error <= tolerance)
  {
    return 0;
  }
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputConnection(difference->GetOutputPort());
  writer->SetFileName(argv[4]);
  writer->Write();
  std::cerr << "picture: " << argv[1] << "\nbaseline: " << argv[2] << "\ndifference: " << argv[4]
            << '\n';
  return 1;
}
