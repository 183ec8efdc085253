// A text file line by line, in bounded memory: for the readers of text formats.
#pragma once

#include "filters/core/Result.h"
#include "filters/meshio/ByteSource.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

class TextLines
{
public:
  explicit TextLines(ByteSource source)
    : Source(std::move(source))
  {
  }

  // Goes to the next line; false at the end. Lines end with \n or \r\n. Errors: InputOutput; a line
  // longer than ByteSource::blockSize.
  Result<bool> Next();
  // Valid until the next call of Next.
  std::string_view Line() const { return this->Text; }
  std::uint64_t Number() const { return this->Count; }                        // of the line, from 1
  std::uint64_t End() const { return this->Source.Position() + this->Taken; } // byte after it
  double Fraction() const; // of the file that is read

  // "line 17: message".
  Error Wrong(const std::string& message) const;

private:
  ByteSource Source;
  std::string_view Text;
  std::size_t Taken = 0; // bytes of the current line, its end too
  std::uint64_t Count = 0;
};

// Cuts a line at any of the separators; `words` is emptied first.
void SplitWords(
  std::string_view line, std::string_view separators, std::vector<std::string_view>& words);

}
