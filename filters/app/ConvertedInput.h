// SPDX-License-Identifier: BSD-3-Clause
// Inputs that kdstream-build does not read itself: kdstream-convert, a process of its own, makes a
// PLY of them first.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/meshio/Tolerance.h"
#include "filters/outofcore/files/LockedFolder.h"
#include "filters/texture/BakeTextures.h"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// A progress line of kdstream-convert --progress-lines begins with this mark; a fraction and the
// step's name follow: "progress 0.25 surface".
inline const std::string convertProgressMark = "progress ";

// The line that says what became of textures' images begins with this mark: "textures PICTURES
// TEXELS TEXELS_PER_VERTEX LOSS".
inline const std::string convertTexturesMark = "textures ";

// kdstream-convert's line about a file that the input names begins with this; the path follows.
inline const std::string convertNamedMark = "named ";

// Whether the file's ending is one of those.
bool NeedsConversion(const std::filesystem::path& input);

// A warning, where no kdstream-convert lies beside this program: how to get it. what: is left out.
std::optional<std::string> WhyNoPictures(std::string_view what = "pictures");

// The PLY; it goes with the object.
class ConvertedInput
{
public:
  // Runs the kdstream-convert that lies beside this program. The PLY is written into a new folder
  // in `folder`, which is removed on an error; RemoveDeadFolders is called for `folder`. arguments:
  // more arguments for kdstream-convert. keepTextures: whether textures are kept for Paint(), if
  // there are any. Progress is reported as step "convert"; the steps of a reconstruction are
  // reported by their own names. The process is ended on a cancel. Errors: Cancelled; Unsupported
  // if kdstream-convert is not installed; InvalidInput with the text of its error line, or, without
  // one, how it ended; InputOutput where the PLY cannot be written, with the file or folder.
  static Result<ConvertedInput> Make(const std::string& input, const std::filesystem::path& folder,
    const std::vector<std::string>& arguments, bool keepTextures, const Execution& execution);

  ConvertedInput(ConvertedInput&& other) noexcept;
  ConvertedInput(const ConvertedInput&) = delete;
  ConvertedInput& operator=(const ConvertedInput&) = delete;
  ConvertedInput& operator=(ConvertedInput&&) = delete;
  ~ConvertedInput();

  std::filesystem::path File() const { return this->Folder.path / "input.ply"; }
  // TextureFolder.h; may not be there.
  std::filesystem::path TextureFolderPath() const { return this->Folder.path / "paint"; }
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
  ConvertedInput(LockedFolder folder, std::string input);

  LockedFolder Folder; // without a path once moved from
  std::string Input;
  std::vector<std::string> WarningTexts;
  std::vector<std::filesystem::path> NamedFiles;
  std::optional<BakeReport> BakedTextures;
  Tolerance Forgiven;
};

// A whole mesh from a file of any format that the programs take: by MeshReader, or by
// kdstream-convert, whose PLY is put into the system's folder for temporary files. Memory: the
// mesh. Errors: those of MeshReader and ConvertedInput, without the file's name.
Result<Mesh> ReadAnyMesh(const std::string& file, const Execution& execution);

}
