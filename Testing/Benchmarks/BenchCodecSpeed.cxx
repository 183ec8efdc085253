// SPDX-License-Identifier: BSD-3-Clause
// The speed of only the piece codec, on one thread: decodes every blob of a file several times, and
// encodes the pieces again. The same program runs natively and as WebAssembly under Node, for
// comparison. Usage:
//   BenchCodecSpeed NAME FILE [ROUNDS]
// FILE was written by BenchCodec --blobs (CodecBlobs.h). The fastest round of each piece counts,
// because other work on the machine only makes a round slower.
#include "Testing/Benchmarks/CodecBlobs.h"
#include "filters/codec/PieceCodec.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace
{

using namespace kdstream;
using namespace kdstream::bench;

double Seconds()
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Separate functions, because engines of WebAssembly never optimise a function that is entered only
// once.
[[gnu::noinline]] Result<Piece> Decode(const Blob& blob, const CodecContext& context)
{
  return DecodePiece(blob.bytes, blob.id, context);
}
[[gnu::noinline]] std::vector<std::uint8_t> Encode(const Piece& piece, const CodecContext& context)
{
  return EncodePiece(piece, context);
}

int Fail(const char* what)
{
  std::fprintf(stderr, "BenchCodecSpeed: error: %s\n", what);
  return 1;
}

}

int main(int argc, char** argv)
{
  if (argc < 3)
  {
    std::fprintf(stderr, "usage: BenchCodecSpeed NAME FILE [ROUNDS]\n");
    return 2;
  }
  const int rounds = argc > 3 ? std::max(1, std::atoi(argv[3])) : 10;
  BlobFile file;
  if (!ReadBlobFile(argv[2], file))
  {
    return Fail("cannot read the blobs");
  }
  double decoding = 0, encoding = 0;
  std::size_t triangles = 0;
  std::vector<Piece> pieces(file.blobs.size());
  std::vector<double> fastest(pieces.size(), 1e9);
  for (int round = 0; round < rounds; ++round)
  {
    for (std::size_t i = 0; i < pieces.size(); ++i)
    {
      const double start = Seconds();
      Result<Piece> piece = Decode(file.blobs[i], file.context);
      fastest[i] = std::min(fastest[i], Seconds() - start);
      if (!piece)
      {
        return Fail(piece.GetError().message.c_str());
      }
      pieces[i] = std::move(*piece); // kept, as a viewer keeps pieces
    }
  }
  for (std::size_t i = 0; i < pieces.size(); ++i)
  {
    triangles += pieces[i].triangles.size();
    decoding += fastest[i];
    double least = 1e9;
    for (int round = 0; round < rounds; ++round)
    {
      const double start = Seconds();
      const std::vector<std::uint8_t> bytes = Encode(pieces[i], file.context);
      least = std::min(least, Seconds() - start);
      if (bytes != file.blobs[i].bytes)
      {
        return Fail("encoding again gives other bytes");
      }
    }
    encoding += least;
  }
  std::printf("%-34s %zu pieces: decoding %.1f, encoding %.1f million triangles a second\n",
    argv[1], file.blobs.size(), double(triangles) / decoding * 1e-6,
    double(triangles) / encoding * 1e-6);
  return 0;
}
