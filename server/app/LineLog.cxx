// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/LineLog.h"

#include "filters/core/SystemReason.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

namespace kdstream
{

namespace
{

// Opens the file. Does not wait for a pipe's reader: without one it fails. A new file is private,
// because it says who viewed what.
int OpenFile(const std::string& file)
{
  if (file == "-")
  {
    return STDERR_FILENO;
  }
  constexpr int flags = O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC | O_NOCTTY;
  const int opened = ::open(file.c_str(), flags | O_NONBLOCK, 0640);
  if (opened >= 0)
  {
    ::fcntl(opened, F_SETFL, O_APPEND);
  }
  return opened;
}

void CloseFile(int file)
{
  if (file != STDERR_FILENO)
  {
    ::close(file);
  }
}

// Writes the text. Returns how many bytes were written: all, or as many as the disk took before it
// was full.
std::size_t WriteAll(int file, std::string_view text)
{
  std::size_t done = 0;
  while (done < text.size())
  {
    const auto written = ::write(file, text.data() + done, text.size() - done);
    if (written < 0 && errno != EINTR)
    {
      break;
    }
    done += written < 0 ? 0 : static_cast<std::size_t>(written);
  }
  return done;
}

// Removes the last bytes, which have just been written, if the file ends with them. This is not
// possible in a pipe, or if somebody else has appended to the file.
bool TakeBack(int file, std::size_t bytes)
{
  struct stat found
  {
  };
  const off_t end = ::lseek(file, 0, SEEK_CUR); // the end of the bytes that were appended
  return ::fstat(file, &found) == 0 && S_ISREG(found.st_mode) && found.st_size == end &&
         ::ftruncate(file, end - static_cast<off_t>(bytes)) == 0;
}

// Writes as many whole lines of the text as fit on the disk. Returns the number of bytes written.
// They end within a line only if the beginning of that line could not be removed again.
std::size_t WriteLines(int file, std::string_view text)
{
  const auto written = WriteAll(file, text);
  const auto whole = text.substr(0, written).rfind('\n') + 1; // 0 if no line was written whole
  const bool isCut = written < text.size() && whole < written;
  return isCut && TakeBack(file, written - whole) ? whole : written;
}

std::uint64_t LinesIn(std::string_view text)
{
  return static_cast<std::uint64_t>(std::count(text.begin(), text.end(), '\n'));
}

}

// Shared by the writing thread and the threads that add lines. It may outlive the log, if a pipe
// blocks the writing thread.
struct LineLog::Writer
{
  std::mutex mutex;
  std::condition_variable changed;
  std::string waiting;
  std::string before; // text that still goes to the old file
  std::uint64_t lost = 0;
  std::uint64_t unreported = 0; // lost lines not yet reported
  int failure = 0;              // errno of the last failure to write
  TellLost tellLost = LostAsText;
  int file = -1;
  int next = -1;     // will replace `file`
  bool torn = false; // the file ends in the middle of a line
  bool ending = false, ended = false;

  void Run()
  {
    std::unique_lock lock(this->mutex);
    for (bool last = false; !last;)
    {
      this->changed.wait(
        lock, [this] { return this->ending || this->next >= 0 || !this->waiting.empty(); });
      const int then = std::exchange(this->next, -1);
      last = then < 0 && this->waiting.empty(); // the log is ending
      std::string text;
      text.swap(then < 0 ? this->waiting : this->before);
      this->Write(lock, text);
      if (then >= 0)
      {
        CloseFile(std::exchange(this->file, then));
        this->torn = false;
      }
    }
    CloseFile(this->file);
    this->ended = true;
    this->changed.notify_all();
  }

  // Writes the text, and the number of lines that are missing before or after it. Releases the lock
  // while writing.
  void Write(std::unique_lock<std::mutex>& lock, const std::string& text)
  {
    std::string note;
    try
    {
      note = this->unreported == 0 ? "" : this->tellLost(this->unreported);
    }
    catch (...) // no memory: reported with the next message
    {
    }
    const auto reported = note.empty() ? 0 : std::exchange(this->unreported, 0);
    const int to = this->file;
    lock.unlock();
    const bool repaired = !this->torn || WriteAll(to, "\n") == 1;
    const auto written = repaired ? WriteLines(to, text) : 0;
    const int whyNot = errno;
    const bool noted = written == text.size() && WriteLines(to, note) == note.size();
    lock.lock();
    this->failure = written < text.size() ? whyNot : this->failure;
    const auto missing = LinesIn(std::string_view(text).substr(written));
    this->lost += missing;
    this->unreported += missing + (noted ? 0 : reported);
    this->torn = !repaired || (written < text.size() && written > 0 && text[written - 1] != '\n');
  }
};

std::string LineLog::LostAsText(std::uint64_t count)
{
  return "# " + std::to_string(count) + " lines were lost\n";
}

Result<std::shared_ptr<LineLog>> LineLog::Open(const std::string& file, TellLost tellLost)
{
  auto writer = std::make_shared<Writer>();
  writer->tellLost = tellLost;
  writer->file = OpenFile(file);
  if (writer->file < 0)
  {
    return SystemError("cannot be written", errno);
  }
  return std::shared_ptr<LineLog>(new LineLog(file, std::move(writer)));
}

LineLog::LineLog(std::string file, std::shared_ptr<Writer> writer)
  : File(std::move(file))
  , Lines(std::move(writer))
{
  std::thread([lines = this->Lines] { lines->Run(); }).detach();
}

LineLog::~LineLog()
{
  this->End();
}

void LineLog::End() noexcept
{
  std::unique_lock lock(this->Lines->mutex);
  this->Lines->ending = true;
  this->Lines->changed.notify_all();
  this->Lines->changed.wait_for(
    lock, std::chrono::seconds(1), [this] { return this->Lines->ended; });
}

void LineLog::Add(std::string_view line) noexcept
{
  const std::lock_guard lock(this->Lines->mutex);
  try
  {
    if (this->Lines->waiting.size() + line.size() <= waitingBytes)
    {
      this->Lines->waiting += line;
      this->Lines->changed.notify_all();
      return;
    }
  }
  catch (...) // no memory
  {
  }
  ++this->Lines->lost;
  ++this->Lines->unreported;
}

std::uint64_t LineLog::Lost() const
{
  const std::lock_guard lock(this->Lines->mutex);
  return this->Lines->lost;
}

std::string LineLog::WhyLost() const
{
  const std::lock_guard lock(this->Lines->mutex);
  return this->Lines->failure == 0 ? "" : SystemReason(this->Lines->failure);
}

Status LineLog::Reopen()
{
  const int file = OpenFile(this->File);
  if (file < 0)
  {
    return SystemError("cannot be written", errno);
  }
  const std::lock_guard lock(this->Lines->mutex);
  if (this->Lines->next >= 0)
  {
    CloseFile(this->Lines->next);
  }
  this->Lines->next = file;
  this->Lines->before += this->Lines->waiting;
  this->Lines->waiting.clear();
  this->Lines->changed.notify_all();
  return {};
}

}
