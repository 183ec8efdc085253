// SPDX-License-Identifier: BSD-3-Clause
// Rewrites texts for VTK's readers. These do not accept byte order marks, lines that end with only
// \r, bytes after the text, numbers that are not finite, or anything before DATASET. Part of step
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

// Written in place of a number that is not finite in a text for VTK: larger than coordinates may
// be.
inline constexpr const char* vtkNotFinite = "-3.4028230607370965e38";

// A file in memory, which has a name as long as this lives; or another file as it is.
class PlainCopy
{
public:
  // An XML file without what follows its text: Ctrl-Z, or zeros, which are counted; and without the
  // blanks in its base64. XML with raw data may hold any bytes before that. Errors: InvalidInput
  // for text in UTF-16 or UTF-32, and for damaged bytes of arrays (VtpBlocks.h); InputOutput.
  static Result<PlainCopy> OfXml(const std::filesystem::path& file, Tolerance& tolerance);
  // A legacy .vtk text file: likewise, and without a byte order mark, with \n at the end of each
  // line. numbers: in lines of only numbers, those that are not finite become vtkNotFinite, and
  // exponents of Fortran (1.0D+00) become those of C. Errors: the same.
  static Result<PlainCopy> OfVtk(
    const std::filesystem::path& file, bool numbers, Tolerance& tolerance);

  // A legacy .vtk file with its DATASET line directly after the head, and without the METADATA that
  // VTK does not read. Errors: InputOutput.
  static Result<PlainCopy> WithDatasetFirst(
    const std::filesystem::path& file, const VtkOrder& order);

  PlainCopy(PlainCopy&& other) noexcept;
  PlainCopy(const PlainCopy&) = delete;
  PlainCopy& operator=(const PlainCopy&) = delete;
  PlainCopy& operator=(PlainCopy&&) = delete;
  ~PlainCopy();

  // The path of the copy, or of the file itself if nothing had to be changed.
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
