// SPDX-License-Identifier: BSD-3-Clause
// Stores small integers in few bits: an entropy coder with static tables. Layout: doc/formats.md,
// "Symbols".
//
// Symbols (0-127) are coded by range asymmetric numeral systems (rANS: J. Duda, arXiv:1311.2540;
// the form with 16-bit words follows F. Giesen, "Interleaved entropy coders", arXiv:1402.3392),
// with two states that take turns. Each symbol is coded under one of several tables ("contexts").
// Tables take few bytes, because frequencies are rounded to half octaves. A number becomes a symbol
// for its size, and raw bits for the rest. The first contexts are for choices among a few symbols:
// their tables are smaller.
//
// SymbolWriter and SymbolReader have methods of the same names. A method of the reader returns what
// the writer's method took, if they are called in the same order and with the same contexts.
#pragma once

#include "filters/codec/ByteStream.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

namespace kdstream
{

// Marks the few functions in hot loops: they are inlined, unless code is optimised for size.
#ifdef __OPTIMIZE_SIZE__
#define KDSTREAM_IN_LOOPS inline
#else
#define KDSTREAM_IN_LOOPS [[gnu::always_inline]] inline
#endif

inline constexpr unsigned symbolCount = 128;
inline constexpr unsigned numberBits = 10; // in contexts of numbers, frequencies sum to 2^10
inline constexpr unsigned choiceBits = 8;  // in contexts of choices, to 2^8

// The number of contexts; the first `choices` of them are for choices.
struct SymbolContexts
{
  std::size_t choices = 0, all = 0;
};

class SymbolWriter
{
public:
  explicit SymbolWriter(const SymbolContexts& contexts)
    : Contexts(contexts)
    , Raws(contexts.all, 0)
  {
  }

  // REQUIRES: context < choices, symbol < symbolCount.
  void Choice(std::size_t context, unsigned symbol) { this->Symbol(context, symbol); }
  // The same under a context of numbers. Symbols stored by this method come first in the output,
  // whenever they are stored.
  void Pair(std::size_t context, unsigned symbol)
  {
    this->Pairs.push_back(EntryOf(context, symbol));
  }
  // Stores any number; smaller ones take fewer bits. REQUIRES: choices <= context < all.
  void Number(std::size_t context, std::uint64_t value);
  // Stores a signed number, modulo 2^64; numbers near 0 take fewer bits.
  void Signed(std::size_t context, std::int64_t value) { this->Number(context, Zigzag(value)); }

  // Writes the tables and raw bits, then zeros so that the result has at least `fewestBytes`, then
  // the words. bitsOfContexts: gets the number of bits that each context took, including its table.
  // REQUIRES: called once.
  void Finish(
    ByteWriter& writer, std::size_t fewestBytes, std::vector<double>* bitsOfContexts = nullptr);

private:
  void Symbol(std::size_t context, unsigned symbol)
  {
    this->Symbols.push_back(EntryOf(context, symbol));
  }
  // The index of a symbol in a list of the symbols of all contexts.
  static std::uint32_t EntryOf(std::size_t context, unsigned symbol)
  {
    return static_cast<std::uint32_t>(context * symbolCount + symbol);
  }
  void RawBits(std::size_t context, std::uint64_t value, unsigned count);
  void FewRawBits(std::uint64_t value, unsigned count);
  std::vector<std::uint8_t> RawBytes() const;

  SymbolContexts Contexts;
  std::vector<std::uint32_t> Pairs, Symbols; // EntryOf
  std::vector<std::uint32_t> RawWords;
  std::uint64_t Pending = 0; // raw bits that do not fill a word yet
  unsigned PendingBits = 0;
  std::vector<std::uint64_t> Raws;
};

// A reader's position. A loop reads from its own copy, which compilers keep in registers, and hands
// it back at the end (SymbolReader::Continue).
class SymbolCursor
{
public:
  // Whether reading went past the end. Values read after that are arbitrary.
  bool Failed() const { return this->Failure; }

  KDSTREAM_IN_LOOPS unsigned Choice(std::size_t context)
  {
    return this->Symbol(context, choiceBits);
  }
  KDSTREAM_IN_LOOPS unsigned Pair(std::size_t context) { return this->Symbol(context, numberBits); }
  KDSTREAM_IN_LOOPS std::uint64_t Number(std::size_t context)
  {
    return this->NumberUnder(this->TableFor(context));
  }
  // The same for a number below 2^48: faster, because it calls no function. If the number is
  // greater, Failed() becomes true.
  KDSTREAM_IN_LOOPS std::uint64_t Small(std::size_t context)
  {
    return this->SmallUnder(this->TableFor(context));
  }
  // Lets a loop look up a context's table only once, and read with the table.
  KDSTREAM_IN_LOOPS const std::uint32_t* TableFor(std::size_t context) const
  {
    return this->Slots + this->TableOf[context];
  }
  KDSTREAM_IN_LOOPS std::uint64_t NumberUnder(const std::uint32_t* table)
  {
    const unsigned symbol = this->SymbolOf(table, numberBits);
    const unsigned low = std::max(symbol / 2, 1U) - 1;
    const std::uint64_t high = symbol < 2 ? symbol : 2 | (symbol & 1);
    return high << low | this->RawBits(low);
  }
  KDSTREAM_IN_LOOPS std::uint64_t SmallUnder(const std::uint32_t* table)
  {
    const unsigned symbol = this->SymbolOf(table, numberBits);
    const unsigned low = std::max(symbol / 2, 1U) - 1;
    const std::uint64_t high = symbol < 2 ? symbol : 2 | (symbol & 1);
    if (low > 46)
    {
      this->Failure = true;
      return 0;
    }
    return high << low | this->FewRawBits(low);
  }
  KDSTREAM_IN_LOOPS std::int64_t Signed(std::size_t context)
  {
    return Unzigzag(this->Number(context));
  }

protected:
  // Loads 8 bytes, low byte first.
  static std::uint64_t Load(const std::uint8_t* bytes)
  {
    std::uint64_t value = 0;
    if constexpr (std::endian::native == std::endian::little)
    {
      std::memcpy(&value, bytes, sizeof(value));
      return value;
    }
    for (unsigned i = 0; i < 8; ++i)
    {
      value |= std::uint64_t{ bytes[i] } << (8 * i);
    }
    return value;
  }
  static std::uint32_t Load16(const std::uint8_t* bytes)
  {
    return static_cast<std::uint32_t>(bytes[0] | bytes[1] << 8);
  }

  KDSTREAM_IN_LOOPS unsigned Symbol(std::size_t context, unsigned bits)
  {
    return this->SymbolOf(this->TableFor(context), bits);
  }
  KDSTREAM_IN_LOOPS unsigned SymbolOf(const std::uint32_t* table, unsigned bits)
  {
    const std::uint32_t state = this->Now;
    const std::uint32_t entry = table[state & ((1U << bits) - 1)];
    std::uint32_t next = (entry >> 17) * (state >> bits) + (entry >> 7 & 1023);
    // No branch, because processors would often predict it wrongly.
    const std::uint32_t more = next < 1U << 16 ? 16 : 0;
    next = next << more | (Load16(this->Word) & ((0U - more) >> 16));
    this->Word += more / 8;
    if (this->Word > this->WordEnd)
    {
      this->Word = this->WordEnd;
      this->Failure = true;
    }
    this->Now = this->Later;
    this->Later = next;
    return entry & (symbolCount - 1);
  }
  // REQUIRES: count <= 64.
  KDSTREAM_IN_LOOPS std::uint64_t RawBits(unsigned count)
  {
    return count > 56 ? this->ManyRawBits(count) : this->FewRawBits(count);
  }
  KDSTREAM_IN_LOOPS std::uint64_t ManyRawBits(unsigned count)
  {
    const std::uint64_t low = this->FewRawBits(32);
    return low | this->FewRawBits(count - 32) << 32;
  }
  KDSTREAM_IN_LOOPS std::uint64_t FewRawBits(unsigned count) // at most 56
  {
    const std::uint64_t value = Load(this->Bits + this->Bit / 8) >> this->Bit % 8;
    this->Bit += count;
    if (this->Bit > this->BitEnd)
    {
      this->Bit = this->BitEnd;
      this->Failure = true;
    }
    return value & ((std::uint64_t{ 1 } << count) - 1);
  }

  const std::uint8_t *Word = nullptr, *WordEnd = nullptr;
  const std::uint8_t* Bits = nullptr;
  std::size_t Bit = 0, BitEnd = 0;
  const std::uint32_t* Slots = nullptr;
  const std::uint32_t* TableOf = nullptr; // where each context's table begins in Slots
  std::uint32_t Now = 0, Later = 0;
  bool Failure = false;
};

// Reads what a writer wrote, in the same order. The bytes may be hostile.
class SymbolReader : public SymbolCursor
{
public:
  // Reads the tables. Memory: up to 4 KiB for each table that is present, and at most 256 bytes for
  // each bit of the input. REQUIRES: at least 8 bytes follow `bytes` in memory, with any content: a
  // blob's checksum.
  SymbolReader(std::span<const std::uint8_t> bytes, const SymbolContexts& contexts);

  // Goes on from the position that a copy has reached.
  void Continue(const SymbolCursor& cursor) { static_cast<SymbolCursor&>(*this) = cursor; }
  // Whether all bytes were used, and the coder is back in its initial state. Call it after
  // everything was read.
  bool AtEnd() const;

private:
  void ReadTable(std::size_t context, unsigned bits);
  void AddTable(std::span<const std::uint32_t> frequencies, std::size_t firstSymbol);

  // Entries: frequency << 17 | slot within the symbol << 7 | symbol. The first two tables have only
  // symbol 0, for contexts without a table: one for choices, one for numbers.
  std::unique_ptr<std::uint32_t[]> Entries;
  std::size_t EntryCount = 0;
  std::vector<std::uint32_t> Begins;
};

}
