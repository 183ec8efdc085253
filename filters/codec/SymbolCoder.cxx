// SPDX-License-Identifier: BSD-3-Clause
#include "filters/codec/SymbolCoder.h"

#include <bit>
#include <cmath>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::uint32_t lowestState = 1U << 16;
constexpr unsigned lengthBits = 7, classBits = 4, mostClass = 15;

// The weights of the classes are half octaves: 0, 2, 3, 4, 6, 8, 12, … 256.
constexpr std::uint32_t WeightOf(unsigned weightClass)
{
  return weightClass == 0
           ? 0
           : (weightClass % 2 == 1 ? 2U << (weightClass / 2) : 3U << (weightClass / 2 - 1));
}

// Computes frequencies that sum to 2^bits. Each symbol whose class is not 0 gets one slot; the
// other slots are divided by weight, and slots left by rounding go to the first of the heaviest
// symbols. Returns false if there is no symbol.
bool FrequenciesOf(
  std::span<const std::uint8_t> classes, unsigned bits, std::span<std::uint32_t> frequencies)
{
  std::uint32_t used = 0, sum = 0;
  std::size_t heaviest = 0;
  for (std::size_t s = 0; s < classes.size(); ++s)
  {
    used += classes[s] != 0;
    sum += WeightOf(classes[s]);
    heaviest = classes[s] > classes[heaviest] ? s : heaviest;
  }
  if (used == 0)
  {
    return false;
  }
  std::uint32_t left = 1U << bits;
  const std::uint32_t shared = left - used;
  for (std::size_t s = 0; s < classes.size(); ++s)
  {
    frequencies[s] = classes[s] == 0 ? 0 : 1 + WeightOf(classes[s]) * shared / sum;
    left -= frequencies[s];
  }
  frequencies[heaviest] += left;
  return true;
}

// The class whose weight is nearest to `count`, scaled so that `most` has the weight of the highest
// class.
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

// What a writer must know of a symbol under a context.
struct CodedSymbol
{
  std::uint32_t count = 0, frequency = 0, start = 0;
};
using CodedSymbols = std::span<CodedSymbol, symbolCount>;

// Chooses the frequencies of a context's symbols and writes its table.
void WriteTable(BitPacker& tables, CodedSymbols symbols, unsigned bits)
{
  std::size_t first = symbolCount, last = 0;
  std::uint32_t most = 0;
  for (std::size_t s = 0; s < symbolCount; ++s)
  {
    if (symbols[s].count > 0)
    {
      first = std::min(first, s);
      last = s;
      most = std::max(most, symbols[s].count);
    }
  }
  const bool there = last > 0; // without a table, symbol 0 is the only one
  tables.Add(there, 1);
  if (!there)
  {
    symbols[0].frequency = 1U << bits;
    return;
  }
  std::array<std::uint8_t, symbolCount> classes{};
  std::array<std::uint32_t, symbolCount> frequencies{};
  tables.Add(first, lengthBits);
  tables.Add(last, lengthBits);
  for (std::size_t s = first; s <= last; ++s)
  {
    classes[s] = ClassOf(symbols[s].count, most);
    tables.Add(classes[s], classBits);
  }
  FrequenciesOf({ classes.data() + first, last + 1 - first }, bits,
    { frequencies.data() + first, last + 1 - first });
  std::uint32_t start = 0;
  for (std::size_t s = first; s <= last; ++s)
  {
    symbols[s].frequency = frequencies[s];
    symbols[s].start = start;
    start += frequencies[s];
  }
}

double BitsOf(CodedSymbols symbols, unsigned bits)
{
  double sum = 0;
  for (const CodedSymbol& symbol : symbols)
  {
    sum += symbol.count > 0 ? symbol.count * (bits - std::log2(double(symbol.frequency))) : 0;
  }
  return sum;
}

}

void SymbolWriter::Number(std::size_t context, std::uint64_t value)
{
  if (value < 2)
  {
    this->Symbol(context, static_cast<unsigned>(value));
    return;
  }
  const unsigned low = static_cast<unsigned>(std::bit_width(value)) - 2;
  this->Symbol(context, 2 * (low + 1) + static_cast<unsigned>(value >> low & 1));
  this->RawBits(context, value & ((std::uint64_t{ 1 } << low) - 1), low);
}

void SymbolWriter::RawBits(std::size_t context, std::uint64_t value, unsigned count)
{
  this->Raws[context] += count;
  if (count > 32)
  {
    this->FewRawBits(value & 0xFFFFFFFFU, 32);
    value >>= 32;
    count -= 32;
  }
  this->FewRawBits(value, count);
}

// REQUIRES: count <= 32, value < 2^count.
void SymbolWriter::FewRawBits(std::uint64_t value, unsigned count)
{
  this->Pending |= value << this->PendingBits;
  this->PendingBits += count;
  if (this->PendingBits >= 32)
  {
    this->RawWords.push_back(static_cast<std::uint32_t>(this->Pending));
    this->Pending >>= 32;
    this->PendingBits -= 32;
  }
}

// All raw bits as bytes, low byte first.
std::vector<std::uint8_t> SymbolWriter::RawBytes() const
{
  const std::size_t inWords = 4 * this->RawWords.size();
  std::vector<std::uint8_t> bytes(inWords + (this->PendingBits + 7) / 8);
  for (std::size_t i = 0; i < inWords; ++i)
  {
    bytes[i] = static_cast<std::uint8_t>(this->RawWords[i / 4] >> (8 * (i % 4)));
  }
  for (std::size_t i = inWords; i < bytes.size(); ++i)
  {
    bytes[i] = static_cast<std::uint8_t>(this->Pending >> (8 * (i - inWords)));
  }
  return bytes;
}

void SymbolWriter::Finish(
  ByteWriter& writer, std::size_t fewestBytes, std::vector<double>* bitsOfContexts)
{
  const auto bitsOf = [this](std::size_t context)
  { return context < this->Contexts.choices ? choiceBits : numberBits; };
  std::vector<CodedSymbol> coded(this->Contexts.all * symbolCount);
  for (const std::vector<std::uint32_t>* symbols : { &this->Pairs, &this->Symbols })
  {
    for (const std::uint32_t entry : *symbols)
    {
      ++coded[entry].count;
    }
  }
  BitPacker tables;
  for (std::size_t c = 0; c < this->Contexts.all; ++c)
  {
    const std::size_t before = tables.Count;
    const CodedSymbols symbols(coded.data() + c * symbolCount, symbolCount);
    WriteTable(tables, symbols, bitsOf(c));
    if (bitsOfContexts)
    {
      bitsOfContexts->push_back(
        double(tables.Count - before) + double(this->Raws[c]) + BitsOf(symbols, bitsOf(c)));
    }
  }

  // Codes backwards, so that a reader goes forwards. The two states take turns.
  std::vector<std::uint16_t> words;
  words.reserve((this->Pairs.size() + this->Symbols.size()) / 2 + 4);
  std::uint32_t now = lowestState, later = lowestState;
  for (const std::vector<std::uint32_t>* symbols : { &this->Symbols, &this->Pairs })
  {
    for (std::size_t i = symbols->size(); i-- > 0;)
    {
      const std::uint32_t entry = (*symbols)[i];
      const CodedSymbol& symbol = coded[entry];
      const unsigned bits = bitsOf(entry / symbolCount);
      std::swap(now, later);
      if (now >= std::uint64_t{ symbol.frequency } << (32 - bits))
      {
        words.push_back(static_cast<std::uint16_t>(now));
        now >>= 16;
      }
      now = (now / symbol.frequency << bits) + now % symbol.frequency + symbol.start;
    }
  }
  for (const std::uint32_t state : { later, now }) // the state of the first symbol comes last
  {
    words.push_back(static_cast<std::uint16_t>(state >> 16));
    words.push_back(static_cast<std::uint16_t>(state));
  }

  std::vector<std::uint8_t> bits = std::move(tables.Bytes);
  const std::vector<std::uint8_t> raw = this->RawBytes();
  bits.insert(bits.end(), raw.begin(), raw.end());
  bits.resize(std::max(bits.size(), fewestBytes - std::min(fewestBytes, 2 * words.size())), 0);
  writer.Varint(bits.size());
  writer.Raw(bits);
  bits.clear();
  for (std::size_t i = words.size(); i-- > 0;)
  {
    bits.push_back(static_cast<std::uint8_t>(words[i]));
    bits.push_back(static_cast<std::uint8_t>(words[i] >> 8));
  }
  writer.Raw(bits);
}

SymbolReader::SymbolReader(std::span<const std::uint8_t> bytes, const SymbolContexts& contexts)
  : Begins(contexts.all)
{
  ByteReader reader(bytes);
  const auto bits = reader.Raw(reader.Count(bytes.size()));
  const auto words = reader.Raw(reader.Remaining());
  this->Failure = reader.Failed() || words.size() < 8;
  this->Bits = bytes.data() + reader.Position() - words.size() - bits.size();
  this->BitEnd = 8 * bits.size();
  this->WordEnd = bytes.data() + reader.Position();
  this->Word = this->WordEnd - words.size();
  // Memory for at most as many tables as the bits can hold, and for the two tables of contexts
  // without one.
  constexpr std::size_t fewestTableBits = 1 + 2 * lengthBits + classBits;
  const std::size_t most = this->BitEnd / fewestTableBits;
  const std::size_t numbers = std::min(contexts.all - contexts.choices, most);
  const std::size_t choices = std::min(contexts.choices, most - numbers);
  this->Entries.reset(
    new std::uint32_t[((choices + 1) << choiceBits) + ((numbers + 1) << numberBits)]);
  constexpr std::array<std::uint32_t, 2> alone{ 1U << choiceBits, 1U << numberBits };
  this->AddTable({ &alone[0], 1 }, 0);
  this->AddTable({ &alone[1], 1 }, 0);
  for (std::size_t c = 0; c < contexts.all && !this->Failure; ++c)
  {
    const bool isNumber = c >= contexts.choices;
    this->Begins[c] = isNumber ? 1U << choiceBits : 0;
    this->ReadTable(c, isNumber ? numberBits : choiceBits);
  }
  this->Slots = this->Entries.get();
  this->TableOf = this->Begins.data();
  this->Bit = (this->Bit + 7) / 8 * 8; // raw bits start at a whole byte
  if (!this->Failure)
  {
    this->Now = Load16(this->Word) | Load16(this->Word + 2) << 16;
    this->Later = Load16(this->Word + 4) | Load16(this->Word + 6) << 16;
    this->Word += 8;
  }
}

void SymbolReader::ReadTable(std::size_t context, unsigned bits)
{
  if (this->RawBits(1) == 0)
  {
    return;
  }
  const auto first = static_cast<std::size_t>(this->RawBits(lengthBits));
  const auto last = static_cast<std::size_t>(this->RawBits(lengthBits));
  std::array<std::uint8_t, symbolCount> classes;
  std::array<std::uint32_t, symbolCount> frequencies;
  std::size_t count = 0;
  for (std::size_t s = first; s <= last; ++s)
  {
    classes[count++] = static_cast<std::uint8_t>(this->RawBits(classBits));
  }
  // A table that is cut off must not be added: memory was only allocated for complete tables.
  if (this->Failure || !FrequenciesOf({ classes.data(), count }, bits, frequencies))
  {
    this->Failure = true;
    return;
  }
  this->Begins[context] = static_cast<std::uint32_t>(this->EntryCount);
  this->AddTable({ frequencies.data(), count }, first);
}

void SymbolReader::AddTable(std::span<const std::uint32_t> frequencies, std::size_t firstSymbol)
{
  std::uint32_t* entry = this->Entries.get() + this->EntryCount;
  auto symbol = static_cast<std::uint32_t>(firstSymbol);
  for (const std::uint32_t frequency : frequencies)
  {
    const std::uint32_t all = frequency << 17 | symbol++;
    for (std::uint32_t slot = 0; slot < frequency; ++slot)
    {
      *entry++ = all | slot << 7;
    }
    this->EntryCount += frequency;
  }
}

bool SymbolReader::AtEnd() const
{
  std::uint8_t left = 0;
  for (std::size_t bit = this->Bit; bit < this->BitEnd; bit = (bit / 8 + 1) * 8)
  {
    left = static_cast<std::uint8_t>(left | this->Bits[bit / 8] >> bit % 8);
  }
  return !this->Failure && left == 0 && this->Word == this->WordEnd && this->Now == lowestState &&
         this->Later == lowestState;
}

}
