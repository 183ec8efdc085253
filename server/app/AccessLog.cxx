// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/AccessLog.h"

#include "filters/core/SystemReason.h"
#include "filters/model/JsonWriter.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <ctime>
#include <mutex>
#include <string_view>
#include <thread>
#include <utility>

namespace kdstream
{

namespace
{

// The first 1,000 characters, with quotes and everything but printable ASCII as \xHH, so that a
// client cannot break the line.
std::string Escaped(const std::string& text)
{
  std::string safe;
  for (const char c : text.substr(0, 1000))
  {
    if (c > ' ' && c <= '~' && c != '"' && c != '\\')
    {
      safe += c;
      continue;
    }
    char code[8];
    std::snprintf(
      code, sizeof code, "\\x%02x", static_cast<unsigned>(static_cast<unsigned char>(c)));
    safe += code;
  }
  return safe;
}

// Does not wait for a pipe's reader: without one it fails.
int OpenFile(const std::string& file)
{
  if (file == "-")
  {
    return STDERR_FILENO;
  }
  constexpr int flags = O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC | O_NOCTTY;
  const int opened = ::open(file.c_str(), flags | O_NONBLOCK, 0644);
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

// What cannot be written, on a full disk mostly, is lost.
void WriteAll(int file, std::string_view text)
{
  while (!text.empty())
  {
    const auto written = ::write(file, text.data(), text.size());
    if (written < 0 && errno != EINTR)
    {
      return;
    }
    text.remove_prefix(written < 0 ? 0 : static_cast<std::size_t>(written));
  }
}

std::string UtcNow()
{
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char time[32];
  return { time, std::strftime(time, sizeof time, "%Y-%m-%dT%H:%M:%SZ", &utc) };
}

std::string LineOf(const PartitionRecord& record)
{
  JsonWriter json;
  json.BeginObject()
    .Member("time", UtcNow())
    .Member("sub", record.subject)
    .Member("jti", record.token)
    .Member("client", record.client)
    .Member("model", record.model)
    .Member("digest", record.digest)
    .Member("partition", record.partition)
    .Member("bytes", record.bytes)
    .EndObject();
  return json.Text() + "\n";
}

std::string LineOf(const AccessRecord& record)
{
  char numbers[80];
  std::snprintf(numbers, sizeof numbers, "\" %u %llu %.1f\n", record.status,
    static_cast<unsigned long long>(record.bytes), record.seconds * 1000);
  return UtcNow() + " " + record.client + " \"" + Escaped(record.method) + " " +
         Escaped(record.target) + numbers;
}

}

// What the thread that writes shares with those who have lines for it. It may outlive the log,
// where it is stuck in a pipe.
struct AccessLog::Writer
{
  std::mutex mutex;
  std::condition_variable changed;
  std::string waiting;
  std::string before; // what goes to the old file yet
  std::uint64_t lost = 0;
  Form form = Form::Text;
  int file = -1;
  int next = -1; // takes the place of `file`
  bool ending = false, ended = false;

  void Run()
  {
    std::unique_lock lock(this->mutex);
    for (;;)
    {
      this->changed.wait(
        lock, [this] { return this->ending || this->next >= 0 || !this->waiting.empty(); });
      const int then = std::exchange(this->next, -1);
      if (then < 0 && this->waiting.empty() && this->lost == 0)
      {
        break; // is ending
      }
      std::string text;
      text.swap(then < 0 ? this->waiting : this->before);
      if (this->lost != 0)
      {
        const auto count = std::to_string(std::exchange(this->lost, 0));
        text += this->form == Form::Text ? "# " + count + " lines are lost\n"
                                         : "{\"lost\":" + count + "}\n";
      }
      const int to = this->file;
      lock.unlock();
      WriteAll(to, text);
      lock.lock();
      if (then >= 0)
      {
        CloseFile(std::exchange(this->file, then));
      }
    }
    CloseFile(this->file);
    this->ended = true;
    this->changed.notify_all();
  }
};

Result<std::shared_ptr<AccessLog>> AccessLog::Open(const std::string& file, Form form)
{
  auto writer = std::make_shared<Writer>();
  writer->form = form;
  writer->file = OpenFile(file);
  if (writer->file < 0)
  {
    return SystemError("cannot be written", errno);
  }
  return std::shared_ptr<AccessLog>(new AccessLog(file, std::move(writer)));
}

AccessLog::AccessLog(std::string file, std::shared_ptr<Writer> writer)
  : File(std::move(file))
  , Lines(std::move(writer))
{
  std::thread([lines = this->Lines] { lines->Run(); }).detach();
}

AccessLog::~AccessLog()
{
  std::unique_lock lock(this->Lines->mutex);
  this->Lines->ending = true;
  this->Lines->changed.notify_all();
  this->Lines->changed.wait_for(
    lock, std::chrono::seconds(1), [this] { return this->Lines->ended; });
}

void AccessLog::Write(const AccessRecord& record)
{
  this->Write(LineOf(record));
}

void AccessLog::Write(const PartitionRecord& record)
{
  this->Write(LineOf(record));
}

void AccessLog::Write(const std::string& line)
{
  const std::lock_guard lock(this->Lines->mutex);
  if (this->Lines->waiting.size() + line.size() > waitingBytes)
  {
    ++this->Lines->lost;
    return;
  }
  this->Lines->waiting += line;
  this->Lines->changed.notify_all();
}

Status AccessLog::Reopen()
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
