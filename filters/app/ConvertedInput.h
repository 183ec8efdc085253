// SPDX-License-Identifier: BSD-3-Clause
// Inputs that kdstream-build does not read itself: kdstream-convert, a separate process, first
// converts them to a PLY.
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

// A progress line of kdstream-convert --progress-lines begins with this mark. A fraction and the
// name of the step follow: "progress 0.25 surface".
inline const std::string convertProgressMark = "progress ";

// The line with the results of baking textures begins with this mark: "textures PICTURES TEXELS
// TEXELS_PER_VERTEX LOSS".
inline const std::string convertTexturesMark = "textures ";

// A line about a file to which the input refers begins with this mark; the path follows.
inline const std::string convertNamedMark = "named ";

// Whether kdstream-convert must read files with this extension.
bool NeedsConversion(const std::filesystem::path& input);

// If there is no kdstream-convert in the folder of this program: a warning that says how to get it.
// what: names, for the warning, the things that are left out of the model.
std::optional<std::string> WhyNoPictures(std::string_view what = "pictures");

// A PLY made by kdstream-convert; it is removed with this object.
class ConvertedInput
{
public:
  // Runs the kdstream-convert beside this program. It writes the PLY into a new folder in `folder`,
  // which is removed after an error; RemoveDeadFolders is called for `folder`. arguments: further
  // arguments for kdstream-convert. keepTextures: whether textures are kept in TextureFolderPath(),
  // if there are any. Progress is reported as step "convert"; the steps of a reconstruction are
  // reported by their own names. When cancelled, the process is ended. Errors: Cancelled;
  // Unsupported if kdstream-convert is not installed; InvalidInput with the text of its error line,
  // or if there is none, how it ended; InputOutput, with the file or folder, if the PLY cannot be
  // written.
  static Result<ConvertedInput> Make(const std::string& input, const std::filesystem::path& folder,
    const std::vector<std::string>& arguments, bool keepTextures, const Execution& execution);

  ConvertedInput(ConvertedInput&& other) noexcept;
  ConvertedInput(const ConvertedInput&) = delete;
  ConvertedInput& operator=(const ConvertedInput&) = delete;
  ConvertedInput& operator=(ConvertedInput&&) = delete;
  ~ConvertedInput();

  std::filesystem::path File() const { return this->Folder.path / "input.ply"; }
  // A TextureFolder.h; it may not exist.
  std::filesystem::path TextureFolderPath() const { return this->Folder.path / "paint"; }
  // Turns an error of reading the PLY into one of the input, which is what the user knows.
  Error Blame(Error error) const;
  // Warnings of kdstream-convert, without the names of program and file.
  const std::vector<std::string>& Warnings() const { return this->WarningTexts; }
  // The files to which the input refers: materials, pictures, buffers.
  const std::vector<std::filesystem::path>& Named() const { return this->NamedFiles; }
  // The result of baking its pictures, if it had any. Warnings about them are in Warnings().
  const std::optional<BakeReport>& Baked() const { return this->BakedTextures; }
  // What was dropped or repaired while the input was read.
  const Tolerance& GetTolerance() const { return this->Forgiven; }

private:
  ConvertedInput(LockedFolder folder, std::string input);

  LockedFolder Folder; // without a path after a move
  std::string Input;
  std::vector<std::string> WarningTexts;
  std::vector<std::filesystem::path> NamedFiles;
  std::optional<BakeReport> BakedTextures;
  Tolerance Forgiven;
};

// Reads a whole mesh from a file of any format that the programs accept: by MeshReader; or by
// kdstream-convert, whose PLY is put into the system's folder for temporary files. Memory: the
// mesh. Errors: those of MeshReader and ConvertedInput, without the name of the file.
Result<Mesh> ReadAnyMesh(const std::string& file, const Execution& execution);

}
