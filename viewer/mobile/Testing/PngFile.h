// SPDX-License-Identifier: BSD-3-Clause
// Pictures as PNG files, for the tests of viewer/mobile.
#pragma once

#include "viewer/mobile/Testing/Images.h"

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>
#include <vtkPNGWriter.h>

#include <algorithm>
#include <string>

namespace kdstream::test
{

// VTK counts rows from the bottom, so the top row becomes its last.
inline void WritePngFile(const std::string& file, const Image& pixels, int width, int height)
{
  const vtkNew<vtkImageData> image;
  image->SetDimensions(width, height, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  for (int y = 0; y < height; ++y)
  {
    std::copy_n(pixels.data() + 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(y),
      3 * static_cast<std::size_t>(width),
      static_cast<std::uint8_t*>(image->GetScalarPointer(0, height - 1 - y, 0)));
  }
  const vtkNew<vtkPNGWriter> writer;
  writer->SetFileName(file.c_str());
  writer->SetInputData(image);
  writer->Write();
}

// Reads a picture; empty if there is no such file, or if it has another size or type.
inline Image ReadPngFile(const std::string& file, int width, int height)
{
  const vtkNew<vtkPNGReader> reader;
  if (!reader->CanReadFile(file.c_str()))
  {
    return {};
  }
  reader->SetFileName(file.c_str());
  reader->Update();
  vtkImageData* image = reader->GetOutput();
  const int* size = image->GetDimensions();
  if (size[0] != width || size[1] != height || image->GetNumberOfScalarComponents() != 3)
  {
    return {};
  }
  Image pixels(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y)
  {
    std::copy_n(static_cast<const std::uint8_t*>(image->GetScalarPointer(0, height - 1 - y, 0)),
      3 * static_cast<std::size_t>(width),
      pixels.data() + 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(y));
  }
  return pixels;
}

}
