// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/VtkMessages.h"

#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>

#include <algorithm>
#include <iterator>
#include <string_view>

namespace kdstream
{
namespace
{

constexpr std::size_t mostMessages = 20; // of each kind; a damaged file can cause one for each line

// Some readers only warn if data could not be read, and continue with uninitialized memory. Such a
// warning is an error; all other warnings stay warnings.
bool TellsOfLostData(std::string text)
{
  std::transform(text.begin(), text.end(), text.begin(),
    [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  constexpr std::string_view words[] = { "error reading", "error while reading", "cannot read",
    "can't read", "could not read", "couldn't read", "unable to read", "failed to read",
    "read failed", "premature", "unexpected eof", "unexpected end", "mismatch of datasize",
    "truncated" };
  return std::any_of(std::begin(words), std::end(words),
    [&](std::string_view word) { return text.find(word) != std::string::npos; });
}

class Collector : public vtkOutputWindow
{
public:
  static Collector* New();
  vtkTypeMacro(Collector, vtkOutputWindow);

  void DisplayText(const char*) override {}
  void DisplayErrorText(const char* text) override { Keep(this->Errors, text); }
  void DisplayWarningText(const char* text) override { this->KeepWarning(text); }
  void DisplayGenericWarningText(const char* text) override { this->KeepWarning(text); }
  void DisplayDebugText(const char*) override {}

  std::vector<std::string> Errors, Warnings;

private:
  void KeepWarning(const char* text)
  {
    Keep(TellsOfLostData(PlainVtkMessage(text)) ? this->Errors : this->Warnings, text);
  }

  static void Keep(std::vector<std::string>& messages, const char* text)
  {
    const std::string plain = PlainVtkMessage(text);
    if (messages.size() < mostMessages &&
        std::find(messages.begin(), messages.end(), plain) == messages.end())
    {
      messages.push_back(plain);
    }
  }
};
vtkStandardNewMacro(Collector);

Collector* Current()
{
  return Collector::SafeDownCast(vtkOutputWindow::GetInstance());
}

}

VtkMessages::VtkMessages()
  : Before(vtkOutputWindow::GetInstance())
{
  // VTK's second way to print messages.
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
  const auto collector = vtkSmartPointer<Collector>::New();
  vtkOutputWindow::SetInstance(collector);
}

VtkMessages::~VtkMessages()
{
  vtkOutputWindow::SetInstance(this->Before);
}

Status VtkMessages::FirstError() const
{
  const std::vector<std::string> errors = this->Errors();
  return errors.empty() ? Status() : Status(Error{ ErrorCode::InvalidInput, errors.front() });
}

std::vector<std::string> VtkMessages::Errors() const
{
  const Collector* const collector = Current();
  return collector ? collector->Errors : std::vector<std::string>();
}

std::vector<std::string> VtkMessages::TakeWarnings()
{
  Collector* const collector = Current();
  return collector ? std::exchange(collector->Warnings, {}) : std::vector<std::string>();
}

std::string PlainVtkMessage(const std::string& text)
{
  // A message of the pipeline, which prints the whole request.
  if (text.find("returned failure for request") != std::string::npos)
  {
    return "VTK's reader of this format failed";
  }
  // ERROR: In SOURCE, line 12\nvtkSTLReader (0x55d0): What it is\n\n
  std::string plain = text;
  if (const std::size_t line = plain.find(", line "); line != std::string::npos)
  {
    const std::size_t end = plain.find('\n', line);
    plain.erase(0, end == std::string::npos ? 0 : end + 1);
  }
  if (const std::size_t address = plain.find(" (0x"); address != std::string::npos)
  {
    const std::size_t end = plain.find("): ", address);
    plain.erase(address, end == std::string::npos ? 0 : end + 1 - address);
  }
  constexpr std::size_t longest = 400;
  std::string line;
  for (const char c : plain)
  {
    const bool blank = c == ' ' || (c >= '\t' && c <= '\r');
    if (!blank || (!line.empty() && line.back() != ' '))
    {
      line += blank ? ' ' : c > ' ' && c <= '~' ? c : '?';
    }
  }
  line.erase(line.find_last_not_of(' ') + 1);
  return line.size() > longest ? line.substr(0, longest) + "…" : line;
}

}
