// SPDX-License-Identifier: BSD-3-Clause
// The cost of one arriving piece when 250,000 triangles or more are shown, compared with drawing
// everything again (doc/benchmarks.md#arrivals): natively, and as WebAssembly under Node.
//
//   BenchArrival NAME TAPE      a tape of TapeArrivals; exit code 1 if a limit is missed
//
// Prints two ratios: of drawing only (parts, normals, and the chunks for graphics memory), and of
// drawing together with the choice of what is shown, which goes through all wanted pieces. Also
// measures drawing with geomorphs, as on the page (one arrival in 150 ms morphs). Prints, too, the
// number of frames that an arrival delays by more than a third of a sixtieth of a second. The
// session is played five times, and the fastest time of each arrival counts, so that other work on
// the machine matters less.
#include "Testing/Benchmarks/Arrivals.h"
#include "filters/codec/PieceCodec.h"
#include "viewer/mobile/SurfaceChunks.h"
#include "viewer/session/SessionParts.h"

#include <algorithm>
#include <ctime>
#include <vector>

#ifdef __EMSCRIPTEN__
#include <emscripten.h>
#endif

using namespace kdstream;
using kdstream::bench::Arrivals;
using kdstream::bench::Bytes;
using kdstream::bench::Tape;

namespace
{

// Processor time of the process in seconds, which depends less on other work on the machine. A
// session runs on one thread.
double ProcessorSeconds()
{
#ifdef __EMSCRIPTEN__
  return 1e-6 * EM_ASM_DOUBLE({
    const used = process.cpuUsage();
    return used.user + used.system;
  });
#else
  return double(std::clock()) / CLOCKS_PER_SEC;
#endif
}

double SecondsOf(const std::function<void()>& work)
{
  const double begin = ProcessorSeconds();
  work();
  return ProcessorSeconds() - begin;
}

bool IsNew(const DrawnSurface::Part& part, const std::vector<DrawnSurface::Part>& before)
{
  return std::none_of(before.begin(), before.end(),
    [&part](const DrawnSurface::Part& each) { return each.LooksLike(part); });
}

std::size_t CutIntoChunks(const DrawnSurface::Part& part, const ViewerScene& scene)
{
  const Vec3 center = scene.box.lo * 0.5 + scene.box.hi * 0.5;
  const Coloring own;
  ChunkCutter cutter(
    part.part->surface, UnitNormalsOf(*part.normals), {}, scene.depths, own, center, 1);
  if (part.geomorph)
  {
    cutter.SetGeomorph(*part.geomorph);
  }
  SurfaceChunk chunk;
  std::size_t bytes = 0;
  while (cutter.Next(chunk))
  {
    bytes += sizeof(ChunkVertex) * (chunk.vertices.size() + chunk.geomorphs.size()) +
             2 * chunk.indices.size();
  }
  return bytes;
}

// The parts of a frame's delay, in seconds: the session, which decodes the arrived blob and chooses
// what is shown; the new surface; its chunks for graphics memory.
struct Wait
{
  double session = 0, surface = 0, chunks = 0;

  double All() const { return this->session + this->surface + this->chunks; }
  void TakeFaster(const Wait& other)
  {
    this->session = std::min(this->session, other.session);
    this->surface = std::min(this->surface, other.surface);
    this->chunks = std::min(this->chunks, other.chunks);
  }
};

class Stopwatch
{
public:
  // compares: whether to compare with drawing everything again, which takes long.
  Stopwatch(const ModelDescription& model, bool compares)
    : Context(model.Codec())
    , Compares(compares)
  {
  }

  void Arrive(const protocol::BlobId& blob, const Bytes& bytes)
  {
    if (IsOfPiece(blob))
    {
      const PieceId id = PieceOfBlob(blob, this->Context.depths);
      auto piece = DecodePiece(bytes, id, this->Context);
      if (piece)
      {
        this->Pieces[id] = std::move(*piece);
      }
    }
  }

  void Draw(ViewerSession& session)
  {
    const double frame = SecondsOf([&] { session.BeginFrame(); });
    const double taken = std::exchange(this->Taken, 0);
    const ViewerScene scene = session.Scene();
    if (std::exchange(this->Version, scene.surfaceVersion) == scene.surfaceVersion)
    {
      return;
    }
    const std::vector<DrawnSurface::Part> before =
      std::exchange(this->Before, scene.surface->Parts());
    double kept = 0;
    std::size_t changed = 0;
    for (const DrawnSurface::Part& part : this->Before)
    {
      if (IsNew(part, before))
      {
        kept += SecondsOf([&] { this->Sink += CutIntoChunks(part, scene); });
        ++changed;
      }
    }
    const bool full = scene.surface->TriangleCount() >= 250'000;
    if (full)
    {
      this->Waited.push_back({ taken, frame, kept });
    }
    if (!this->Compares)
    {
      return;
    }
    const PieceLookup lookup = [this](PieceId id)
    {
      const auto found = this->Pieces.find(id);
      return found == this->Pieces.end() ? nullptr : &found->second;
    };
    const double drawn = this->DrawParts(*session.Parts().model.surface.GetCut(), lookup);
    const double morphing =
      this->DrawMorphing(*session.Parts().model.surface.GetCut(), lookup, scene);
    if (!full)
    {
      return;
    }
    this->Parts += changed;
    this->Arrival += drawn + kept;
    this->Morphing += morphing;
    this->WithChoice += frame + kept;
    const double choice = SecondsOf(
      [&]
      {
        MakeClosure(scene.depths, session.Parts().model.surface.GetCut()->base,
          session.Parts().model.surface.GetCut()->active, lookup);
      });
    const double anew =
      std::min(this->DrawAnew(*session.Parts().model.surface.GetCut(), lookup, scene),
        this->DrawAnew(*session.Parts().model.surface.GetCut(), lookup,
          scene)); // the second in memory that is warm
    this->Anew += anew;
    this->AnewWithChoice += choice + anew;
    this->Shown += this->Before.size();
    ++this->Count;
  }

  void Give(const std::function<void()>& work) { this->Taken += SecondsOf(work); }
  const std::vector<Wait>& Waits() const { return this->Waited; }

  // Returns false if a limit is missed.
  bool Print(const char* name) const
  {
    std::printf("%s: %d arrivals, each changes %.1f of %.1f parts\n", name, this->Count,
      double(this->Parts) / this->Count, double(this->Shown) / this->Count);
    const bool drawing = this->PrintRatio("drawing", this->Arrival, this->Anew);
    std::printf("  %-16s %7.2f ms each: %5.3f\n", "and glides", 1e3 * this->Morphing / this->Count,
      this->Morphing / this->Anew);
    return this->PrintRatio("with choosing", this->WithChoice, this->AnewWithChoice) && drawing;
  }

private:
  // Draws as a session does in a frame, without the rest of the frame.
  double DrawParts(const Cut& cut, const PieceLookup& lookup)
  {
    return SecondsOf(
      [&]
      {
        static_cast<void>(this->KeptParts.GoTo(cut, lookup));
        this->KeptNormals.GoTo(this->KeptParts.Parts());
      });
  }

  // Draws with geomorphs, and also makes the chunks.
  double DrawMorphing(const Cut& cut, const PieceLookup& lookup, const ViewerScene& scene)
  {
    return SecondsOf(
      [&]
      {
        const std::shared_ptr<const DrawnSurface> before = this->Geomorphs;
        this->MorphingParts.Follow(true);
        static_cast<void>(this->MorphingParts.GoTo(cut, lookup));
        this->MorphingNormals.GoTo(this->MorphingParts.Parts());
        this->Geomorphs = std::make_shared<DrawnSurface>(this->MorphingParts.Parts(),
          this->MorphingNormals.Of(), *before, this->MorphingParts.Parents());
        for (const DrawnSurface::Part& part : this->Geomorphs->Parts())
        {
          this->Sink += IsNew(part, before->Parts()) ? CutIntoChunks(part, scene) : 0;
        }
      });
  }

  double DrawAnew(const Cut& cut, const PieceLookup& lookup, const ViewerScene& scene)
  {
    return SecondsOf(
      [&]
      {
        SurfaceParts parts;
        static_cast<void>(parts.GoTo(cut, lookup));
        PartNormals normals;
        normals.GoTo(parts.Parts());
        const DrawnSurface surface(parts.Parts(), normals.Of());
        for (const DrawnSurface::Part& part : surface.Parts())
        {
          this->Sink += CutIntoChunks(part, scene);
        }
      });
  }

  bool PrintRatio(const char* what, double arrival, double anew) const
  {
    const double ratio = arrival / anew;
    std::printf("  %-16s %7.2f ms each, all anew %7.2f ms: %5.3f (at most 0.1: %s)\n", what,
      1e3 * arrival / this->Count, 1e3 * anew / this->Count, ratio,
      ratio <= 0.1 ? "met" : "MISSED");
    return ratio <= 0.1;
  }

  CodecContext Context;
  bool Compares;
  std::map<PieceId, Piece> Pieces;
  SurfaceParts KeptParts, MorphingParts;
  PartNormals KeptNormals, MorphingNormals;
  std::shared_ptr<const DrawnSurface> Geomorphs = std::make_shared<DrawnSurface>();
  std::vector<DrawnSurface::Part> Before;
  std::uint64_t Version = 0;
  double Arrival = 0, Morphing = 0, WithChoice = 0, Anew = 0, AnewWithChoice = 0;
  std::size_t Parts = 0, Shown = 0, Sink = 0;
  int Count = 0;
  double Taken = 0; // by the session since the last frame, in seconds
  std::vector<Wait> Waited;
};

void PrintWaits(const char* what, const std::vector<Wait>& waits, double (*secondsOf)(const Wait&))
{
  constexpr double third = 1.0 / 3 / 60;
  std::vector<double> seconds;
  for (const Wait& wait : waits)
  {
    seconds.push_back(secondsOf(wait));
  }
  std::sort(seconds.begin(), seconds.end());
  const auto longer = seconds.end() - std::upper_bound(seconds.begin(), seconds.end(), third);
  std::printf("  %-26s %6.2f ms in the middle, %6.2f at most; longer than %.1f ms: %5.1f %%\n",
    what, 1e3 * seconds[seconds.size() / 2], 1e3 * seconds.back(), 1e3 * third,
    100.0 * double(longer) / double(seconds.size()));
}

void PrintWaits(const std::vector<Wait>& waits)
{
  PrintWaits("session", waits, [](const Wait& wait) { return wait.session; });
  PrintWaits("surface", waits, [](const Wait& wait) { return wait.surface; });
  PrintWaits("chunks", waits, [](const Wait& wait) { return wait.chunks; });
  PrintWaits("surface or chunks", waits, // each in its own frame, as on the page
    [](const Wait& wait) { return std::max(wait.surface, wait.chunks); });
  PrintWaits("all in one frame", waits, [](const Wait& wait) { return wait.All(); });
}

}

int main(int count, char** arguments)
{
  Tape tape;
  if (count != 3 || !tape.Read(arguments[2]))
  {
    std::fprintf(stderr, "usage: BenchArrival NAME TAPE, which must be whole\n");
    return 2;
  }
  const auto model = ParseModel(tape.model);
  if (!model)
  {
    std::fprintf(stderr, "BenchArrival: %s\n", model.GetError().message.c_str());
    return 2;
  }
  constexpr unsigned rounds = 5;
  std::vector<Wait> waits;
  bool met = true;
  for (unsigned round = 0; round < rounds; ++round)
  {
    Stopwatch watch(*model, round == 0);
    Arrivals{
      *model, tape.zoom,
      [&](const protocol::BlobId& blob) { return tape.blobs[protocol::BlobName(blob)]; },
      [&](const protocol::BlobId& blob, const Bytes& bytes) { watch.Arrive(blob, bytes); },
      [&](ViewerSession& session) { watch.Draw(session); },
      [&](const std::function<void()>& work) { watch.Give(work); }
    }.Run();
    met = (round > 0 || watch.Print(arguments[1])) && met;
    waits = round == 0 ? watch.Waits() : waits;
    for (std::size_t i = 0; i < waits.size(); ++i)
    {
      waits[i].TakeFaster(watch.Waits()[i]);
    }
  }
  if (!waits.empty())
  {
    PrintWaits(waits);
  }
  return met ? 0 : 1;
}
