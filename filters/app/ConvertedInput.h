// SPDX-License-Identifier: BSD-3-Clause
// Inputs that kdstream-build does not read itself: kdstream-convert, a process of its own, makes a
// PLY of them first.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/meshio/Tolerance.h"
#include "filters/texture/BakeTextures.h"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// With this begins a line of progress of kdstream-convert --progress-lines, which a fraction and
// the step's name follow: "progress 0.25 surface".
inline const std::string convertProgressMark = "progress ";

// With this begins its line of what became of pictures: "textures PICTURES TEXELS TEXELS_PER_VERTEX
// LOSS".
inline const std::string convertTexturesMark = "textures ";

// With this begins its line of a file that the input names, whose path follows.
inline const std::string convertNamedMark = "named ";

// Whether the file's ending is one of those.
bool NeedsConversion(const std::filesystem::path& input);

// A warning, where no kdstream-convert lies beside this program: how to get it. what: is left out.
std::optional<std::string> WhyNoPictures(std::string_view what = "pictures");

// Removes what killed builds have left in the folder: hidden folders with a PLY and pictures. What
// cannot be removed stays. O(entries of the folder).
void RemoveDeadConversions(const std::filesystem::path& folder);

// The PLY; it goes with the object.
class ConvertedInput
{
public:
  // Runs the kdstream-convert that lies beside this program. The PLY lies in a new folder, made in
  // `folder`, and nothing is left of it on an error; RemoveDeadConversions is called for it.
  // arguments: further ones for kdstream-convert. keepPaint: whether pictures go to Paint(), if
  // there are any. Progress is reported as step "convert", and by their names the steps of a
  // reconstruction; the process is ended if that asks to stop. Errors: Cancelled; Unsupported where
  // there is no kdstream-convert; InvalidInput with the text of its own error line, or how it ended
  // without one; InputOutput where the PLY cannot be written, with the file or folder.
  static Result<ConvertedInput> Make(const std::string& input, const std::filesystem::path& folder,
    const std::vector<std::string>& arguments, bool keepPaint, const Execution& execution);

  ConvertedInput(ConvertedInput&& other) noexcept;
  ConvertedInput(const ConvertedInput&) = delete;
  ConvertedInput& operator=(const ConvertedInput&) = delete;
  ConvertedInput& operator=(ConvertedInput&&) = delete;
  ~ConvertedInput();

  std::filesystem::path File() const { return this->Folder / "input.ply"; }
  // PaintFolder.h; may not be there.
  std::filesystem::path Paint() const { return this->Folder / "paint"; }
  // An error of reading the PLY, as one of the input, which is what the user knows.
  Error Blame(Error error) const;
  // What kdstream-convert warned of, without the names of program and file.
  const std::vector<std::string>& Warnings() const { return this->WarningTexts; }
  // The files that it names: materials, pictures, buffers.
  const std::vector<std::filesystem::path>& Named() const { return this->NamedFiles; }
  // What became of its pictures, if there were any; its warnings are among the others.
  const std::optional<BakeReport>& Baked() const { return this->BakedTextures; }
  // What was dropped or forgiven while it was read.
  const Tolerance& GetTolerance() const { return this->Forgiven; }

private:
  ConvertedInput(std::filesystem::path folder, int lock, std::string input);

  std::filesystem::path Folder; // empty once moved from
  int Lock = -1;                // on it: which goes with the process, however that ends
  std::string Input;
  std::vector<std::string> WarningTexts;
  std::vector<std::filesystem::path> NamedFiles;
  std::optional<BakeReport> BakedTextures;
  Tolerance Forgiven;
};

}
