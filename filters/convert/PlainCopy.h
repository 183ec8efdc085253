// SPDX-License-Identifier: BSD-3-Clause
// Texts as VTK's readers want them, which know no byte order marks, no lines that end with \r
// alone, nothing behind the text, no number that is not finite, and DATASET first. Part of step
// "convert".
#pragma once

#include "filters/convert/LegacyVtk.h"
#include "filters/core/Result.h"
#include "filters/meshio/ByteSource.h"
#include "filters/meshio/Tolerance.h"

#include <filesystem>
#include <string>

namespace kdstream
{

// What stands for a number that is not finite in a text that VTK reads: larger than places may be.
inline constexpr const char* vtkNotFinite = "-3.4028230607370965e38";

// A file in memory, which has a name as long as this lives; or another file as it is.
class PlainCopy
{
public:
  // Without what is after the text: Ctrl-Z, and zeros, which are counted. Of XML, where that may
  // be any bytes before. Errors: InvalidInput for text in UTF-16 or UTF-32; InputOutput.
  static Result<PlainCopy> OfXml(const std::filesystem::path& file, Tolerance& tolerance);
  // Of a legacy .vtk file that is a text, also without a byte order mark, and with \n at the end of
  // each line. numbers: in lines of only numbers those that are not finite become vtkNotFinite,
  // and exponents of Fortran (1.0D+00) those of C. Errors: the same.
  static Result<PlainCopy> OfVtk(
    const std::filesystem::path& file, bool numbers, Tolerance& tolerance);

  // Of a legacy .vtk file with its line of DATASET after the head, and without the METADATA that
  // VTK does not read. Errors: InputOutput.
  static Result<PlainCopy> WithDatasetFirst(
    const std::filesystem::path& file, const VtkOrder& order);

  PlainCopy(PlainCopy&& other) noexcept;
  PlainCopy(const PlainCopy&) = delete;
  PlainCopy& operator=(const PlainCopy&) = delete;
  PlainCopy& operator=(PlainCopy&&) = delete;
  ~PlainCopy();

  // Of the copy, or of the file where nothing had to be changed.
  const std::filesystem::path& File() const { return this->Path; }

private:
  explicit PlainCopy(std::filesystem::path file)
    : Path(std::move(file))
  {
  }
  Status Open();
  Status Write(std::string_view bytes);
  Status Copy(ByteSource& source, std::uint64_t begin, std::uint64_t end);

  std::filesystem::path Path;
  int Descriptor = -1;
};

}
