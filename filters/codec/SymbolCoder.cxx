#include "filters/codec/SymbolCoder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace kdstream
{
namespace
{

constexpr std::uint32_t slots = 1U << probabilityBits;
constexpr std::uint32_t lowestState = 1U << 16;
constexpr unsigned lengthBits = 7, classBits = 4, mostClass = 15;

using Frequencies = std::array<std::uint32_t, symbolCount>;

// Half octaves: 0, 2, 3, 4, 6, 8, 12, … 256.
constexpr std::uint32_t WeightOf(unsigned weightClass)
{
  return weightClass == 0
           ? 0
           : (weightClass % 2 == 1 ? 2U << (weightClass / 2) : 3U << (weightClass / 2 - 1));
}

// Frequencies that sum to `slots`, each at least 1 where its class is not 0: a slot each, the
// others by weight, and what rounding leaves to the first of the heaviest. False if there is no
// symbol.
bool FrequenciesOf(const std::array<std::uint8_t, symbolCount>& classes, Frequencies& frequencies)
{
  std::uint32_t used = 0, sum = 0;
  std::size_t heaviest = 0;
  for (std::size_t s = 0; s < symbolCount; ++s)
  {
    used += classes[s] != 0;
    sum += WeightOf(classes[s]);
    heaviest = classes[s] > classes[heaviest] ? s : heaviest;
  }
  if (used == 0)
  {
    return false;
  }
  std::uint32_t left = slots;
  for (std::size_t s = 0; s < symbolCount; ++s)
  {
    frequencies[s] = classes[s] == 0 ? 0 : 1 + WeightOf(classes[s]) * (slots - used) / sum;
    left -= frequencies[s];
  }
  frequencies[heaviest] += left;
  return true;
}

// The class whose weight is nearest to `count` where `most` has that of the highest.
std::uint8_t ClassOf(std::uint64_t count, std::uint64_t most)
{
  if (count == 0)
  {
    return 0;
  }
  unsigned best = 1;
  while (best < mostClass && count * count * WeightOf(mostClass) * WeightOf(mostClass) >=
                               most * most * WeightOf(best) * WeightOf(best + 1))
  {
    ++best;
  }
  return static_cast<std::uint8_t>(best);
}

class BitPacker
{
public:
  void Add(std::uint64_t value, unsigned count)
  {
    for (unsigned i = 0; i < count; ++i, ++this->Count)
    {
      if (this->Count % 8 == 0)
      {
        this->Bytes.push_back(0);
      }
      this->Bytes.back() |= static_cast<std::uint8_t>((value >> i & 1) << (this->Count % 8));
    }
  }
  std::vector<std::uint8_t> Bytes;
  std::size_t Count = 0;
};

}

std::uint64_t SymbolWriter::Number(std::size_t context, std::uint64_t value)
{
  if (value < 2)
  {
    this->Symbol(context, static_cast<unsigned>(value));
    return value;
  }
  const unsigned low = static_cast<unsigned>(std::bit_width(value)) - 2;
  this->Symbol(context, 2 * (low + 1) + static_cast<unsigned>(value >> low & 1));
  this->RawBits(context, value & ((std::uint64_t{ 1 } << low) - 1), low);
  return value;
}

std::int64_t SymbolWriter::Signed(std::size_t context, std::int64_t value)
{
  const auto bits = static_cast<std::uint64_t>(value);
  this->Number(context, (bits << 1) ^ (std::uint64_t{ 0 } - (bits >> 63)));
  return value;
}

void SymbolWriter::RawBits(std::size_t context, std::uint64_t value, unsigned count)
{
  this->Raws[context] += count;
  while (count > 0)
  {
    const unsigned now = std::min(count, 32U);
    this->Pending |= (value & 0xFFFFFFFFU) << this->PendingBits;
    this->PendingBits += now;
    value >>= now;
    count -= now;
    for (; this->PendingBits >= 8; this->PendingBits -= 8, this->Pending >>= 8)
    {
      this->RawBytes.push_back(static_cast<std::uint8_t>(this->Pending));
    }
  }
}

void SymbolWriter::Finish(ByteWriter& writer, std::size_t fewestBytes)
{
  if (this->PendingBits > 0)
  {
    this->RawBytes.push_back(static_cast<std::uint8_t>(this->Pending));
  }
  const std::size_t contexts = this->Raws.size();
  std::vector<Frequencies> counts(contexts, Frequencies{}), frequencies = counts, starts = counts;
  for (const std::uint32_t symbol : this->Symbols)
  {
    ++counts[symbol >> 8][symbol & 0xFF];
  }
  BitPacker tables;
  this->Bits.assign(contexts, 0);
  for (std::size_t c = 0; c < contexts; ++c)
  {
    const std::size_t before = tables.Count;
    std::size_t first = symbolCount, last = 0;
    for (std::size_t s = 0; s < symbolCount; ++s)
    {
      first = counts[c][s] > 0 ? std::min(first, s) : first;
      last = counts[c][s] > 0 ? s : last;
    }
    const bool there = first < symbolCount && last > 0; // symbol 0 alone needs no table
    std::array<std::uint8_t, symbolCount> classes{};
    classes[0] = mostClass;
    tables.Add(there, 1);
    if (there)
    {
      tables.Add(first, lengthBits);
      tables.Add(last, lengthBits);
      const std::uint32_t most = *std::max_element(counts[c].begin(), counts[c].end());
      for (std::size_t s = 0; s < symbolCount; ++s)
      {
        classes[s] = ClassOf(counts[c][s], most);
        if (s >= first && s <= last)
        {
          tables.Add(classes[s], classBits);
        }
      }
    }
    FrequenciesOf(classes, frequencies[c]);
    this->Bits[c] = double(tables.Count - before) + double(this->Raws[c]);
    std::uint32_t start = 0;
    for (std::size_t s = 0; s < symbolCount; ++s)
    {
      starts[c][s] = start;
      start += frequencies[c][s];
      if (counts[c][s] > 0)
      {
        this->Bits[c] += counts[c][s] * (probabilityBits - std::log2(double(frequencies[c][s])));
      }
    }
  }

  std::vector<std::uint16_t> words;
  std::array<std::uint64_t, 2> states{ lowestState, lowestState };
  for (std::size_t i = this->Symbols.size(); i-- > 0;)
  {
    const std::uint32_t context = this->Symbols[i] >> 8, symbol = this->Symbols[i] & 0xFF;
    const std::uint64_t frequency = frequencies[context][symbol];
    std::uint64_t& state = states[i % 2];
    if (state >= frequency << (32 - probabilityBits))
    {
      words.push_back(static_cast<std::uint16_t>(state));
      state >>= 16;
    }
    state = (state / frequency << probabilityBits) + state % frequency + starts[context][symbol];
  }
  for (const unsigned i : { 1U, 0U })
  {
    words.push_back(static_cast<std::uint16_t>(states[i] >> 16));
    words.push_back(static_cast<std::uint16_t>(states[i]));
  }

  std::vector<std::uint8_t> bits = std::move(tables.Bytes);
  bits.insert(bits.end(), this->RawBytes.begin(), this->RawBytes.end());
  bits.resize(std::max(bits.size(), fewestBytes - std::min(fewestBytes, 2 * words.size())), 0);
  writer.Varint(bits.size());
  writer.Raw(bits);
  for (std::size_t i = words.size(); i-- > 0;)
  {
    writer.Byte(static_cast<std::uint8_t>(words[i]));
    writer.Byte(static_cast<std::uint8_t>(words[i] >> 8));
  }
}

SymbolReader::SymbolReader(std::span<const std::uint8_t> bytes, std::size_t contexts)
  : TableOf(contexts, 0)
{
  ByteReader reader(bytes);
  this->Bits = reader.Raw(reader.Count(bytes.size()));
  this->Words = reader.Raw(reader.Remaining());
  // As many tables as the bits may hold, and that of contexts without one.
  constexpr std::size_t fewestTableBits = 1 + 2 * lengthBits + classBits;
  const std::size_t most = std::min(contexts, 8 * this->Bits.size() / fewestTableBits) + 1;
  this->Slots.reset(new std::uint32_t[most * slots]);
  this->AddTable({ slots });
  for (std::size_t c = 0; c < contexts && !this->Failure; ++c)
  {
    this->ReadTable(c);
  }
  this->PoolSize = 0; // raw bits start at a byte
  this->Pool = 0;
  this->Now = this->Word();
  this->Now |= this->Word() << 16;
  this->Later = this->Word();
  this->Later |= this->Word() << 16;
  this->Failure = this->Failure || reader.Failed();
}

void SymbolReader::ReadTable(std::size_t context)
{
  if (this->RawBits(1) == 0)
  {
    return;
  }
  const auto first = static_cast<std::size_t>(this->RawBits(lengthBits));
  const auto last = static_cast<std::size_t>(this->RawBits(lengthBits));
  std::array<std::uint8_t, symbolCount> classes{};
  for (std::size_t s = first; s <= last; ++s)
  {
    classes[s] = static_cast<std::uint8_t>(this->RawBits(classBits));
  }
  Frequencies frequencies;
  // A table that is cut off is none: it was not counted among those that the bits may hold.
  if (this->Failure || !FrequenciesOf(classes, frequencies))
  {
    this->Failure = true;
    return;
  }
  this->TableOf[context] = static_cast<std::uint32_t>(this->SlotCount);
  this->AddTable(frequencies);
}

void SymbolReader::AddTable(const std::array<std::uint32_t, symbolCount>& frequencies)
{
  std::uint32_t* entry = this->Slots.get() + this->SlotCount;
  for (std::uint32_t s = 0; s < symbolCount; ++s)
  {
    const std::uint32_t frequency = frequencies[s], all = frequency << 17 | s;
    for (std::uint32_t slot = 0; slot < frequency; ++slot)
    {
      *entry++ = all | slot << 7;
    }
  }
  this->SlotCount += slots;
}

bool SymbolReader::AtEnd() const
{
  std::uint64_t left = this->Pool;
  for (const std::uint8_t byte : this->Bits.subspan(this->NextByte))
  {
    left |= byte;
  }
  return !this->Failure && left == 0 && this->NextWord == this->Words.size() &&
         this->Now == lowestState && this->Later == lowestState;
}

}
