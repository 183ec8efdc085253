// SPDX-License-Identifier: BSD-3-Clause
// The picture that a window shows, as bytes and as a PNG file: see Picture.h.
#include "viewer/rendering/Picture.h"

#include "filters/files/WriteWhole.h"

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkPointData.h>
#include <vtkRenderWindow.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>

namespace kdstream
{
namespace
{

// Draws the window, and reads its pixels in VTK's order of rows: the lowest first.
Status ReadBack(vtkRenderWindow& window, vtkUnsignedCharArray& pixels)
{
  window.Render();
  const int* size = window.GetSize();
  constexpr int backBuffer = 0;
  window.GetPixelData(0, 0, size[0] - 1, size[1] - 1, backBuffer, &pixels);
  if (pixels.GetNumberOfValues() != vtkIdType{ 3 } * size[0] * size[1])
  {
    return Error{ ErrorCode::InputOutput, "the window's pixels cannot be read" };
  }
  return {};
}

// Copies the rows of a picture of this size in reverse order.
void TurnRows(const WindowPicture& size, const std::uint8_t* from, std::uint8_t* to)
{
  const std::size_t row = 3 * static_cast<std::size_t>(size.width);
  const auto rows = static_cast<std::size_t>(size.height);
  for (std::size_t y = 0; y < rows; ++y)
  {
    std::copy_n(from + y * row, row, to + (rows - 1 - y) * row);
  }
}

}

Result<WindowPicture> Pixels(vtkRenderWindow& window)
{
  const vtkNew<vtkUnsignedCharArray> pixels;
  KDSTREAM_TRY(ReadBack(window, *pixels));
  WindowPicture picture;
  picture.width = window.GetSize()[0];
  picture.height = window.GetSize()[1];
  picture.rgb.resize(static_cast<std::size_t>(pixels->GetNumberOfValues()));
  TurnRows(picture, pixels->GetPointer(0), picture.rgb.data());
  return picture;
}

WindowPicture PartOf(const WindowPicture& picture, int left, int top, int width, int height)
{
  WindowPicture part{ width, height, {} };
  const std::size_t row = 3 * static_cast<std::size_t>(width);
  part.rgb.reserve(row * static_cast<std::size_t>(height));
  for (int y = top; y < top + height; ++y)
  {
    const auto begin = picture.rgb.begin() + 3 * (std::ptrdiff_t{ y } * picture.width + left);
    part.rgb.insert(part.rgb.end(), begin, begin + static_cast<std::ptrdiff_t>(row));
  }
  return part;
}

WindowPicture Stacked(const WindowPicture& upper, const WindowPicture& lower)
{
  WindowPicture both = upper;
  both.height += lower.height;
  both.rgb.insert(both.rgb.end(), lower.rgb.begin(), lower.rgb.end());
  return both;
}

Status WritePng(const WindowPicture& picture, const std::string& file)
{
  const vtkNew<vtkImageData> image;
  image->SetDimensions(picture.width, picture.height, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  TurnRows(picture, picture.rgb.data(), static_cast<std::uint8_t*>(image->GetScalarPointer()));
  const vtkNew<vtkPNGWriter> writer;
  writer->WriteToMemoryOn();
  writer->SetInputData(image);
  writer->Write();
  const vtkUnsignedCharArray* bytes = writer->GetResult();
  if (!bytes || bytes->GetNumberOfValues() == 0)
  {
    return Error{ ErrorCode::InputOutput, file + ": the picture cannot be encoded" };
  }
  const Status written =
    WriteWhole(file, { reinterpret_cast<const char*>(writer->GetResult()->GetPointer(0)),
                       static_cast<std::size_t>(bytes->GetNumberOfValues()) });
  return written ? Status{}
                 : Error{ ErrorCode::InputOutput, file + ": " + written.GetError().message };
}

Status WritePng(vtkRenderWindow& window, const std::string& file)
{
  const auto picture = Pixels(window);
  KDSTREAM_TRY(picture);
  return WritePng(*picture, file);
}

}
