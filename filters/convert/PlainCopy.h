// SPDX-License-Identifier: BSD-3-Clause
// Rewrites texts for VTK's readers, which do not accept byte order marks, lines that end with a
// single \r, bytes after the text, numbers that are not finite, or anything before DATASET. Part of
// step "convert".
#pragma once

#include "filters/convert/LegacyVtk.h"
#include "filters/core/Result.h"
#include "filters/meshio/ByteSource.h"
#include "filters/meshio/Tolerance.h"

#include <filesystem>
#include <string>

namespace kdstream
{

// Replaces a number that is not finite in a text for VTK. Its magnitude is larger than coordinates
// may have.
inline constexpr const char* vtkNotFinite = "-3.4028230607370965e38";

// A copy of a file in memory, which has a path as long as this object lives; or the file itself,
// unchanged.
class PlainCopy
{
public:
  // An XML file without Ctrl-Z or zeros after its text, which are counted, and without the blanks
  // in its base64. XML with raw data may hold any bytes before its end. Errors: InvalidInput for
  // text in UTF-16 or UTF-32, and for damaged bytes of arrays (VtpBlocks.h); InputOutput.
  static Result<PlainCopy> OfXml(const std::filesystem::path& file, Tolerance& tolerance);
  // A legacy .vtk text file, rewritten likewise; also without a byte order mark, and with \n at the
  // end of each line. numbers: in lines that have only numbers, those that are not finite become
  // vtkNotFinite, and Fortran's exponents (1.0D+00) become those of C. Errors: the same.
  static Result<PlainCopy> OfVtk(
    const std::filesystem::path& file, bool numbers, Tolerance& tolerance);

  // A legacy .vtk file with its DATASET line directly after the head, and without those METADATA
  // blocks that VTK cannot read. Errors: InputOutput.
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
