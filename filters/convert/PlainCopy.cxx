// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/PlainCopy.h"

#include "filters/convert/VtpBlocks.h"
#include "filters/core/SystemReason.h"
#include "filters/meshio/ByteSource.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/PlainText.h"
#include "filters/meshio/TextLines.h"
#include "filters/meshio/TextWords.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

// Whether a \r without \n ends a line.
Result<bool> HasLoneReturns(ByteSource& source)
{
  bool isBehind = false;
  for (source.Seek(source.Start());;)
  {
    const Result<std::string_view> block = source.Peek(
      static_cast<std::size_t>(std::min<std::uint64_t>(ByteSource::blockSize, source.Remaining())));
    KDSTREAM_TRY(block);
    if (block->empty())
    {
      return false;
    }
    for (const char c : *block)
    {
      if (isBehind && c != '\n')
      {
        return true;
      }
      isBehind = c == '\r';
    }
    source.Consume(block->size());
  }
}

// Whether the third line says that this is a text file.
bool IsText(std::string_view begin)
{
  std::size_t at = 0;
  for (int line = 0; line < 2; ++line)
  {
    at = begin.find_first_of("\r\n", at);
    if (at == std::string_view::npos)
    {
      return false;
    }
    at += begin.substr(at).starts_with("\r\n") ? 2 : 1;
  }
  std::string_view third = begin.substr(at);
  return LowercaseText(TakeWord(third)) == "ascii";
}

// If a line has only numbers, perhaps after the name of a part, the line with its numbers as VTK
// reads them.
std::string WithPlainNumbers(std::string_view line)
{
  std::vector<std::string_view> words;
  SplitWords(line, " \t\r", words);
  std::string made;
  bool changed = false;
  for (const std::string_view word : words)
  {
    const std::string name = LowercaseText(word);
    if (made.empty() && (name == "origin" || name == "spacing" || name == "aspect_ratio"))
    {
      made = std::string(word) + ' ';
      continue;
    }
    double value = 0;
    if (ParseNumber(word, value) != NumberTextError::None)
    {
      return std::string(line);
    }
    const std::string plain = std::isfinite(value) ? WithPlainExponent(word) : vtkNotFinite;
    made += plain.empty() ? word : std::string_view(plain);
    made += ' ';
    changed = changed || !plain.empty();
  }
  return changed ? made : std::string(line);
}

}

PlainCopy::PlainCopy(PlainCopy&& other) noexcept
  : Path(std::move(other.Path))
  , Descriptor(std::exchange(other.Descriptor, -1))
{
}

PlainCopy::~PlainCopy()
{
  if (this->Descriptor >= 0)
  {
    ::close(this->Descriptor);
  }
}

Status PlainCopy::Open()
{
  this->Descriptor = ::memfd_create("text", MFD_CLOEXEC);
  if (this->Descriptor < 0)
  {
    return Error{ ErrorCode::InputOutput,
      "there is no memory for a copy of it: " + SystemReason(errno) };
  }
  this->Path = "/proc/self/fd/" + std::to_string(this->Descriptor);
  return {};
}

Status PlainCopy::Write(std::string_view bytes)
{
  while (!bytes.empty())
  {
    const ssize_t written = ::write(this->Descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno != EINTR)
    {
      return Error{ ErrorCode::InputOutput,
        "there is no memory for a copy of it: " + SystemReason(errno) };
    }
    bytes.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
  }
  return {};
}

// Copies the bytes from `begin` to `end`.
Status PlainCopy::Copy(ByteSource& source, std::uint64_t begin, std::uint64_t end)
{
  for (source.Seek(begin); source.Position() < end;)
  {
    const Result<std::string_view> block = source.Peek(static_cast<std::size_t>(
      std::min<std::uint64_t>(ByteSource::blockSize, end - source.Position())));
    KDSTREAM_TRY(block);
    const std::string_view bytes = block->substr(0, end - source.Position());
    if (bytes.empty())
    {
      return {};
    }
    KDSTREAM_TRY(this->Write(bytes));
    source.Consume(bytes.size());
  }
  return {};
}

Result<PlainCopy> PlainCopy::WithDatasetFirst(
  const std::filesystem::path& file, const VtkOrder& order)
{
  PlainCopy copy(file);
  if (order.end == 0 && order.leftOut.empty())
  {
    return copy;
  }
  Result<ByteSource> source = ByteSource::Open(file);
  KDSTREAM_TRY(source);
  KDSTREAM_TRY(copy.Open());
  const std::uint64_t size = source->Size();
  for (const auto& [begin, end] : { std::pair{ std::uint64_t{ 0 }, order.headEnd },
         { order.begin, order.end }, { order.headEnd, order.begin }, { order.end, size } })
  {
    std::uint64_t at = begin;
    for (const auto& [first, after] : order.leftOut)
    {
      if (first >= begin && after <= end)
      {
        KDSTREAM_TRY(copy.Copy(*source, at, first));
        at = after;
      }
    }
    KDSTREAM_TRY(copy.Copy(*source, at, end));
  }
  return copy;
}

Result<PlainCopy> PlainCopy::OfXml(const std::filesystem::path& file, Tolerance& tolerance)
{
  Result<ByteSource> source = ByteSource::Open(file);
  KDSTREAM_TRY(source);
  const std::uint64_t size = source->Size();
  const Result<std::uint64_t> zeros = CropToText(*source);
  KDSTREAM_TRY(zeros);
  const Result<bool> blanks = CheckVtpBlocks(*source, [](std::string_view) { return Status(); });
  KDSTREAM_TRY(blanks);
  PlainCopy copy(file);
  if (source->Size() == size && !*blanks)
  {
    return copy;
  }
  tolerance.Count(Lapse::PaddedEnd, *zeros, "byte " + std::to_string(source->Size()));
  KDSTREAM_TRY(copy.Open());
  KDSTREAM_TRY(CheckVtpBlocks(*source, [&](std::string_view bytes) { return copy.Write(bytes); }));
  return copy;
}

Result<PlainCopy> PlainCopy::OfVtk(
  const std::filesystem::path& file, bool numbers, Tolerance& tolerance)
{
  constexpr std::size_t longestHead = 2048, longestLine = std::size_t{ 1 } << 31U;
  Result<ByteSource> source = ByteSource::Open(file);
  KDSTREAM_TRY(source);
  Result<ByteSource> lines = source->Again();
  KDSTREAM_TRY(lines);
  const std::uint64_t size = source->Size();
  const Result<std::uint64_t> zeros = CropToText(*source);
  KDSTREAM_TRY(zeros);
  const Result<std::string_view> head = source->Peek(
    static_cast<std::size_t>(std::min<std::uint64_t>(longestHead, source->Remaining())));
  KDSTREAM_TRY(head);
  PlainCopy copy(file);
  if (!IsText(*head))
  {
    return copy;
  }
  const Result<bool> returns = HasLoneReturns(*source);
  KDSTREAM_TRY(returns);
  if (!numbers && !*returns && source->Start() == 0 && source->Size() == size)
  {
    return copy;
  }
  tolerance.Count(Lapse::PaddedEnd, *zeros, "byte " + std::to_string(source->Size()));
  KDSTREAM_TRY(copy.Open());
  TextLines text(std::move(*lines), longestLine);
  for (std::string gathered;; gathered.clear())
  {
    Result<bool> more = true;
    while (*more && gathered.size() < ByteSource::blockSize)
    {
      more = text.Next();
      KDSTREAM_TRY(more);
      if (*more)
      {
        gathered += numbers ? WithPlainNumbers(text.Line()) : std::string(text.Line());
        gathered += '\n';
      }
    }
    KDSTREAM_TRY(copy.Write(gathered));
    if (!*more)
    {
      return copy;
    }
  }
}

}
