// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/journal/PhaseJournal.h"

#include "filters/outofcore/files/Blob.h"

#include <algorithm>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace kdstream
{
namespace
{

constexpr std::uint64_t mark = 0x4C414E52554F4A4B; // "KJOURNAL" in little-endian order
constexpr std::uint32_t layoutVersion = 3;

std::uint64_t Checksum(std::span<const std::byte> bytes)
{
  return XXH3_64bits(bytes.data(), bytes.size());
}

JournalPhase ReadPhase(BlobReader& reader)
{
  JournalPhase phase;
  phase.name = reader.ReadText();
  phase.blob = reader.ReadList<std::byte>();
  const auto files = reader.Read<std::uint64_t>();
  for (std::uint64_t i = 0; i < files && reader.Good(); ++i)
  {
    JournalFile file;
    file.name = reader.ReadText();
    file.number = reader.Read<std::uint64_t>();
    file.bytes = reader.Read<std::uint64_t>();
    file.releasedAfter = reader.Read<std::uint64_t>();
    file.changed = reader.Read<std::int64_t>();
    file.sum = reader.Read<std::uint64_t>();
    phase.files.push_back(std::move(file));
  }
  return phase;
}

BlobWriter Contents(const PhaseJournal& journal)
{
  BlobWriter writer;
  writer.AddText(journal.fingerprint);
  writer.Add(static_cast<std::uint64_t>(journal.phases.size()));
  for (const JournalPhase& phase : journal.phases)
  {
    writer.AddText(phase.name);
    writer.AddList(phase.blob);
    writer.Add(static_cast<std::uint64_t>(phase.files.size()));
    for (const JournalFile& file : phase.files)
    {
      writer.AddText(file.name);
      writer.Add(file.number);
      writer.Add(file.bytes);
      writer.Add(file.releasedAfter);
      writer.Add(file.changed);
      writer.Add(file.sum);
    }
  }
  return writer;
}

}

std::vector<std::byte> EncodeJournal(const PhaseJournal& journal)
{
  const std::vector<std::byte> contents = Contents(journal).Bytes();
  BlobWriter writer;
  writer.Add(mark);
  writer.Add(layoutVersion);
  writer.Add(std::uint64_t{ journalHeadBytes } + contents.size() + sizeof(std::uint64_t));
  writer.AddBytes(contents);
  writer.Add(Checksum(writer.Bytes()));
  return writer.Bytes();
}

std::uint64_t ClaimedJournalBytes(std::span<const std::byte> head)
{
  BlobReader reader(head);
  const bool isOurs =
    reader.Read<std::uint64_t>() == mark && reader.Read<std::uint32_t>() == layoutVersion;
  const auto bytes = reader.Read<std::uint64_t>();
  return isOurs && reader.Good() ? bytes : 0;
}

Result<PhaseJournal> DecodeJournal(std::span<const std::byte> bytes)
{
  const std::size_t checked = bytes.size() - std::min(bytes.size(), sizeof(std::uint64_t));
  BlobReader checksum(bytes.subspan(checked));
  BlobReader reader(bytes.first(checked));
  if (checksum.Read<std::uint64_t>() != Checksum(bytes.first(checked)) || !checksum.Finish())
  {
    return Error{ ErrorCode::Damaged, "wrong checksum" };
  }
  if (reader.Read<std::uint64_t>() != mark || reader.Read<std::uint32_t>() != layoutVersion ||
      reader.Read<std::uint64_t>() != bytes.size())
  {
    return Error{ ErrorCode::Damaged, "not a build journal of this version" };
  }
  PhaseJournal journal;
  journal.fingerprint = reader.ReadText();
  const auto phases = reader.Read<std::uint64_t>();
  for (std::uint64_t i = 0; i < phases && reader.Good(); ++i)
  {
    journal.phases.push_back(ReadPhase(reader));
  }
  KDSTREAM_TRY(reader.Finish());
  return journal;
}

}
