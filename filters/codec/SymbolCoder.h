// Small integers as few bits: an entropy coder with static tables. Layout: doc/formats.md,
// "Symbols".
//
// Symbols (0-127) are coded by range asymmetric numeral systems (rANS: J. Duda, arXiv:1311.2540;
// the form with 16-bit words follows F. Giesen, "Interleaved entropy coders", arXiv:1402.3392),
// with two states in turn, each under one of several tables ("contexts"). Tables are sent in a few
// bytes: half an octave of frequency a symbol. A number is a symbol for its size and raw bits for
// the rest.
//
// SymbolWriter and SymbolReader have the same methods, each of which returns what was coded, so
// that one template describes both directions: a writer is told the value, a reader ignores it.
#pragma once

#include "filters/codec/ByteStream.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace kdstream
{

inline constexpr unsigned symbolCount = 128;
inline constexpr unsigned probabilityBits = 10;

class SymbolWriter
{
public:
  static constexpr bool reading = false;

  explicit SymbolWriter(std::size_t contexts)
    : Raws(contexts, 0)
  {
  }

  // REQUIRES: context < contexts, symbol < symbolCount.
  unsigned Symbol(std::size_t context, unsigned symbol)
  {
    this->Symbols.push_back(static_cast<std::uint32_t>(context << 8 | symbol));
    return symbol;
  }
  // Any number: smaller ones take fewer bits.
  std::uint64_t Number(std::size_t context, std::uint64_t value);
  // Numbers near 0 of either sign, modulo 2^64.
  std::int64_t Signed(std::size_t context, std::int64_t value);
  bool Failed() const { return false; }

  // Bytes: the tables and raw bits, zeros behind them until all is at least `fewestBytes`, then the
  // words. REQUIRES: called once.
  void Finish(ByteWriter& writer, std::size_t fewestBytes);

  // After Finish: the bits that each context took, its table included.
  const std::vector<double>& BitsOfContexts() const { return this->Bits; }

private:
  void RawBits(std::size_t context, std::uint64_t value, unsigned count);

  std::vector<std::uint32_t> Symbols;
  std::vector<std::uint8_t> RawBytes;
  std::uint64_t Pending = 0;
  unsigned PendingBits = 0;
  std::vector<std::uint64_t> Raws;
  std::vector<double> Bits;
};

// Reads what a writer wrote, in the same order. Any bytes may be given: a reader that has run out
// of them gives zeros and is Failed.
class SymbolReader
{
public:
  static constexpr bool reading = true;

  // Reads the tables. Takes 4 KiB a table that is there: at most 256 bytes for a bit of the input.
  SymbolReader(std::span<const std::uint8_t> bytes, std::size_t contexts);

  unsigned Symbol(std::size_t context, unsigned = 0)
  {
    const std::uint32_t state = this->Now;
    const std::uint32_t entry = this->Slots[this->TableOf[context] + (state & slotMask)];
    std::uint32_t next = (entry >> 17) * (state >> probabilityBits) + (entry >> 7 & slotMask);
    if (next < 1U << 16)
    {
      next = next << 16 | this->Word();
    }
    this->Now = this->Later;
    this->Later = next;
    return entry & (symbolCount - 1);
  }
  std::uint64_t Number(std::size_t context, std::uint64_t = 0)
  {
    const unsigned symbol = this->Symbol(context);
    if (symbol < 2)
    {
      return symbol;
    }
    const unsigned low = symbol / 2 - 1;
    return std::uint64_t{ 2 | (symbol & 1) } << low | this->RawBits(low);
  }
  std::int64_t Signed(std::size_t context, std::int64_t = 0)
  {
    const std::uint64_t value = this->Number(context);
    return static_cast<std::int64_t>((value >> 1) ^ (std::uint64_t{ 0 } - (value & 1)));
  }

  bool Failed() const { return this->Failure; }
  // Whether all bytes were used and the coder is in the state that it starts from: REQUIRES that
  // everything was read.
  bool AtEnd() const;

private:
  static constexpr std::uint32_t slotMask = (1U << probabilityBits) - 1;

  std::uint32_t Word()
  {
    if (this->Words.size() - this->NextWord < 2)
    {
      this->Failure = true;
      return 0;
    }
    const std::uint32_t low = this->Words[this->NextWord];
    const std::uint32_t high = this->Words[this->NextWord + 1];
    this->NextWord += 2;
    return high << 8 | low;
  }
  std::uint64_t RawBits(unsigned count)
  {
    if (count > 32)
    {
      const std::uint64_t low = this->RawBits(32);
      return low | this->RawBits(count - 32) << 32;
    }
    for (; this->PoolSize < count; this->PoolSize += 8)
    {
      if (this->NextByte == this->Bits.size())
      {
        this->Failure = true;
        return 0;
      }
      this->Pool |= std::uint64_t{ this->Bits[this->NextByte++] } << this->PoolSize;
    }
    const std::uint64_t value = this->Pool & ((std::uint64_t{ 1 } << count) - 1);
    this->Pool >>= count;
    this->PoolSize -= count;
    return value;
  }
  void ReadTable(std::size_t context);
  void AddTable(const std::array<std::uint32_t, symbolCount>& frequencies);

  std::span<const std::uint8_t> Words, Bits;
  std::size_t NextWord = 0, NextByte = 0; // of Words, of Bits
  std::uint64_t Pool = 0;                 // bits that were taken out of Bits and are not used yet
  unsigned PoolSize = 0;
  std::uint32_t Now = 0, Later = 0;
  bool Failure = false;
  // Entries: frequency << 17 | slot within the symbol << 7 | symbol. The first table has symbol 0
  // alone: that of contexts without one.
  std::unique_ptr<std::uint32_t[]> Slots;
  std::size_t SlotCount = 0;
  std::vector<std::uint32_t> TableOf;
};

}
