// SPDX-License-Identifier: BSD-3-Clause
// Plays a recording (Recording.h) and writes the trace (TracedSession.h) to a file: the same
// sources natively and as WebAssembly under Node.
//
//   ReplaySession RECORDING TRACE      exit code 2 if the recording cannot be read
//   ReplaySession --compare A B        exit code 1 if the files differ, and where
//
// The trace goes to a file, because Node loses what it has not yet written to a pipe when it ends.
#include "viewer/client/Testing/Replay/TracedSession.h"

#include <cstdio>
#include <memory>
#include <optional>
#include <string>

using namespace kdstream::testing;

namespace
{

struct CloseFile
{
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

std::optional<std::string> ReadWhole(const char* name)
{
  const File file(std::fopen(name, "rb"));
  if (!file)
  {
    std::fprintf(stderr, "%s: cannot be read\n", name);
    return std::nullopt;
  }
  std::string content, block(1 << 20, 0);
  while (const std::size_t bytes = std::fread(block.data(), 1, block.size(), file.get()))
  {
    content.append(block, 0, bytes);
  }
  return content;
}

int Replay(const char* recordingName, const char* traceName)
{
  const auto recording = ReadWhole(recordingName);
  const File trace(std::fopen(traceName, "wb"));
  if (!recording || !trace)
  {
    return 2;
  }
  bool written = true;
  TracedSession session(
    [&trace, &written](std::string_view line)
    {
      written = written && std::fwrite(line.data(), 1, line.size(), trace.get()) == line.size() &&
                std::fputc('\n', trace.get()) == '\n';
    });
  for (std::string_view rest = *recording; !rest.empty();)
  {
    const auto input = TakeInput(rest);
    if (!input)
    {
      std::fprintf(stderr, "%s: %s\n", recordingName, input.GetError().message.c_str());
      return 2;
    }
    (void)session.Apply(*input);
  }
  session.Finish();
  return written && std::fflush(trace.get()) == 0 ? 0 : 2;
}

int Compare(const char* firstName, const char* secondName)
{
  const auto first = ReadWhole(firstName), second = ReadWhole(secondName);
  if (!first || !second)
  {
    return 2;
  }
  std::size_t line = 1;
  for (std::size_t a = 0, b = 0; a < first->size() || b < second->size(); ++line)
  {
    const std::size_t endA = std::min(first->find('\n', a), first->size());
    const std::size_t endB = std::min(second->find('\n', b), second->size());
    if (first->compare(a, endA + 1 - a, *second, b, endB + 1 - b) != 0)
    {
      std::fprintf(stderr, "line %zu differs:\n%s: %s\n%s: %s\n", line, firstName,
        first->substr(a, endA - a).c_str(), secondName, second->substr(b, endB - b).c_str());
      return 1;
    }
    a = std::min(endA + 1, first->size());
    b = std::min(endB + 1, second->size());
  }
  if (line < 100)
  {
    std::fprintf(stderr, "%s has %zu lines: nothing was compared\n", firstName, line - 1);
    return 1;
  }
  std::printf("%zu lines are the same\n", line - 1);
  return 0;
}

}

int main(int count, char** arguments)
{
  if (count == 4 && std::string(arguments[1]) == "--compare")
  {
    return Compare(arguments[2], arguments[3]);
  }
  if (count != 3)
  {
    std::fprintf(stderr, "usage: ReplaySession RECORDING TRACE | --compare A B\n");
    return 2;
  }
  return Replay(arguments[1], arguments[2]);
}
