// SPDX-License-Identifier: BSD-3-Clause
// Ranks exchange a hash. Only if hashes differ, they exchange texts too, for the message.
#include "filters/Parallel/RankAgreement.h"

#include "filters/build/PhaseValues.h"
#include "filters/core/SeededHash.h"
#include "filters/meshio/ByteSource.h"
#include "filters/meshio/FileEnding.h"

#include <algorithm>
#include <cassert>
#include <optional>
#include <span>
#include <string_view>

namespace kdstream
{
namespace
{

// Identifies the messages of this file and of MpiGroup: change it whenever they change.
constexpr std::uint64_t layoutOfMessages = 0x6b647374726d0001;

struct Difference
{
  std::string name;              // of the first value that differs
  std::string whereFirst, where; // "rank 1 on node7"
  std::string valueFirst, value; // on rank 0, and on the other rank
};

// Joins texts that contain no zeros; a zero ends each.
std::string Join(const std::string& where, const NamedValues& values)
{
  std::string text = where + '\0';
  for (const auto& [name, value] : values)
  {
    text += name + '\0' + value + '\0';
  }
  return text;
}

std::vector<std::string> Split(std::span<const char> text)
{
  std::vector<std::string> parts;
  for (auto begin = text.begin(); begin != text.end();)
  {
    const auto end = std::find(begin, text.end(), '\0');
    parts.emplace_back(begin, end);
    begin = end == text.end() ? end : end + 1;
  }
  return parts;
}

// The first rank that differs from rank 0, and the first value that differs.
Difference Compare(const std::vector<std::vector<std::string>>& ranks)
{
  const std::vector<std::string>& first = ranks[0];
  for (const std::vector<std::string>& other : ranks)
  {
    for (std::size_t i = 1; i + 1 < std::min(first.size(), other.size()); i += 2)
    {
      if (first[i] != other[i] || first[i + 1] != other[i + 1])
      {
        return { first[i], first[0], other[0], first[i + 1], other[i + 1] };
      }
    }
  }
  return { "its request", first[0], ranks.back()[0], {}, {} };
}

// Called by all ranks. Nothing if all ranks have the same values.
Result<std::optional<Difference>> FindDifference(MpiGroup& group, const NamedValues& values)
{
  const std::string mine = Join({}, values);
  const Result<std::vector<std::uint64_t>> hashes =
    group.Gather(HashOfBytes(std::as_bytes(std::span(mine)), agreedSeed));
  KDSTREAM_TRY(hashes);
  if (std::all_of(hashes->begin(), hashes->end(),
        [&](std::uint64_t hash) { return hash == hashes->front(); }))
  {
    return std::optional<Difference>();
  }
  const std::string reported = Join(group.Where(), values);
  const RankLists<char> out(group.Count(), std::vector<char>(reported.begin(), reported.end()));
  const Result<RankLists<char>> in = group.Exchange(out);
  KDSTREAM_TRY(in);
  std::vector<std::vector<std::string>> ranks;
  std::transform(in->begin(), in->end(), std::back_inserter(ranks),
    [](const std::vector<char>& text) { return Split(text); });
  return std::optional(Compare(ranks));
}

// A value for a message: "20", "not given", "\"Statue of somebody\"".
std::string ValueText(const std::string& value)
{
  const bool plain = std::all_of(value.begin(), value.end(),
    [](char c) { return c > ' ' && c <= '~' && c != '"' && c != ',' && c != ';'; });
  return value.empty() ? "not given" : plain ? value : "\"" + value + "\"";
}

Status CheckSameFile(MpiGroup& group, const NamedValues& values)
{
  const Result<std::optional<Difference>> found = FindDifference(group, values);
  KDSTREAM_TRY(found);
  if (!*found)
  {
    return {};
  }
  const Difference& other = **found;
  return group.FailCollectively(
    { ErrorCode::InvalidInput, "the ranks have different files of this name: " + other.name +
                                 " is " + ValueText(other.valueFirst) + " on " + other.whereFirst +
                                 ", and " + ValueText(other.value) + " on " + other.where });
}

// The hash of at most 18 parts of the file, which include its beginning and its end.
Result<std::uint64_t> HashOfPlaces(ByteSource& file)
{
  constexpr std::uint64_t steps = 17;
  const std::uint64_t bytes = std::min<std::uint64_t>(ByteSource::blockSize, file.Size());
  const std::uint64_t last = file.Size() - bytes;
  std::uint64_t hash = agreedSeed;
  for (std::uint64_t step = 0; step <= (last == 0 ? 0 : steps); ++step)
  {
    file.Seek(last / steps * step + last % steps * step / steps);
    const Result<std::string_view> view = file.Peek(static_cast<std::size_t>(bytes));
    KDSTREAM_TRY(view);
    hash = HashOfBytes(std::as_bytes(std::span(*view)), hash);
  }
  return hash;
}

}

Status AgreeOnProgram(MpiGroup& group)
{
  const Result<std::vector<std::uint64_t>> layouts = group.Gather(layoutOfMessages);
  KDSTREAM_TRY(layouts);
  for (std::size_t rank = 0; rank < layouts->size(); ++rank)
  {
    if ((*layouts)[rank] != layoutOfMessages)
    {
      throw BrokenGroup{ { ErrorCode::Unsupported,
        "rank " + std::to_string(rank) + " runs another version of this program" } };
    }
  }
  return {};
}

Status AgreeOnOptions(MpiGroup& group, const BuildOptions& options, const NamedValues& more)
{
  NamedValues values = more;
  const NamedValues shaping = DescribeOptions(options);
  values.insert(values.end(), shaping.begin(), shaping.end());
  const Result<std::optional<Difference>> found = FindDifference(group, values);
  KDSTREAM_TRY(found);
  if (!*found)
  {
    return {};
  }
  const Difference& other = **found;
  return group.FailCollectively({ ErrorCode::InvalidArgument,
    "all ranks need the same options: " + other.name + " is " + ValueText(other.valueFirst) +
      " on " + other.whereFirst + ", and " + ValueText(other.value) + " on " + other.where });
}

Status AgreeOnInput(MpiGroup& group, const std::filesystem::path& input)
{
  Result<ByteSource> file = OfFile(input.string(), ByteSource::Open(input));
  KDSTREAM_TRY(file);
  const Result<std::uint64_t> hash = OfFile(input.string(), HashOfPlaces(*file));
  KDSTREAM_TRY(hash);
  return CheckSameFile(group,
    { { "the ending", FileEnding(input) }, { "the size in bytes", std::to_string(file->Size()) },
      { "the hash of its content", std::to_string(*hash) } });
}

Status AgreeOnHeader(MpiGroup& group, const MeshFileInfo& info)
{
  std::string arrays;
  for (const AttributeInfo& array : info.attributes)
  {
    arrays += array.name + " " + std::string(NameOf(array.type)) + " " +
              std::to_string(array.components) +
              (array.association == AttributeAssociation::Point ? " of vertices; " : " of faces; ");
  }
  return CheckSameFile(group,
    { { "the number of vertices", std::to_string(info.vertices) },
      { "the number of faces", std::to_string(info.faces) },
      { "the type of coordinates", info.scalarType == ScalarType::Float32 ? "float32" : "float64" },
      { "the list of arrays", arrays } });
}

}
