// SPDX-License-Identifier: BSD-3-Clause
// A program for runs with faults. It does work that none of our programs does alone: an out-of-core
// build of a small mesh, saving notes as a window does, recording quotas as a server does.
#include "filters/build/ExternalBuilder.h"
#include "filters/core/CaughtError.h"
#include "filters/program/Program.h"
#include "filters/store/StoreNotes.h"
#include "server/access/QuotaBook.h"

#include <chrono>
#include <iostream>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <vector>

namespace
{

using namespace kdstream;

int Report(const std::string& file, const Status& status)
{
  return status ? exitDone : PrintError("faulty-work", file, status.GetError());
}

int BuildExternally(const std::string& input, const std::string& store)
{
  BuildOptions options;
  options.memory = leastMemory;
  options.tree.verticesPerPartition = 40;
  const auto report = BuildStoreExternally(input, store, options);
  return Report(input, report ? Status() : Status(report.GetError()));
}

int SaveNotes(const std::string& file)
{
  const std::vector<Note> notes{ { "nose", "it was added later", "" },
    { "arm", std::string(2000, 'x'), "" } };
  return Report(file, WriteNotes(file, notes));
}

// Requests partitions, each until it is allowed, because a failure is temporary. Prints those that
// were allowed.
int TakeAll(const std::string& file)
{
  QuotaLimits limits;
  limits.share = 0.5;
  limits.bytesPerSecond = 1000000;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  const auto isLate = [&] { return std::chrono::steady_clock::now() > end; };
  constexpr auto pause = std::chrono::milliseconds(10);
  std::unique_ptr<QuotaBook> book;
  while (!book)
  {
    auto opened = QuotaBook::Open(file, limits);
    if (opened)
    {
      book = std::move(*opened);
    }
    else if (isLate())
    {
      return Report(file, opened.GetError());
    }
    else
    {
      std::this_thread::sleep_for(pause);
    }
  }
  for (std::uint32_t partition = 0; partition < 3; ++partition)
  {
    for (;;)
    {
      auto taken = QuotaBook::Taken(Error{});
      try
      {
        taken = book->TakePartition("ann", { "model", "input", "tree", 8 }, partition, 100);
      }
      catch (const std::bad_alloc&)
      {
        taken = Error{ ErrorCode::LimitExceeded, "out of memory" };
      }
      if (taken)
      {
        std::cout << (*taken ? "refused " : "given ") << partition << std::endl;
        break;
      }
      if (isLate())
      {
        return Report(file, taken.GetError());
      }
      std::this_thread::sleep_for(pause);
    }
  }
  return exitDone;
}

}

int main(int argc, char** argv)
try
{
  CLI::App app("Work for tests of faults.", "faulty-work");
  std::string work, file, output;
  app.add_option("WORK", work)->required();
  app.add_option("FILE", file)->required();
  app.add_option("OUTPUT", output);
  return RunProgram(app, argc, argv,
    [&]()
    {
      return work == "build"   ? BuildExternally(file, output)
             : work == "notes" ? SaveNotes(file)
                               : TakeAll(file);
    });
}
catch (...) // memory runs out before the work begins
{
  return kdstream::PrintError("faulty-work", "", kdstream::CaughtError());
}
