// SPDX-License-Identifier: BSD-3-Clause
// The speed of the chunked readers, compared with a floor: a bare fread that parses the bytes into
// arrays of known size. All on one thread, in one run; they take turns for several rounds, and the
// best round counts. VTK's readers run once, too. Usage:
//   BenchReaders [MILLIONS_OF_TRIANGLES] [ROUNDS]
// Writes a closed mesh in every format into a temporary folder. For each format it prints the
// seconds, and the ratio to the floor, of our reader: into one mesh, and in chunks that are freed.
#include "filters/meshio/MeshReader.h"
#include "filters/meshio/MeshWriter.h"
#include "filters/meshio/OutputFile.h"

#include <vtkNew.h>
#include <vtkOBJReader.h>
#include <vtkPLYReader.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace
{

using namespace kdstream;

constexpr double pi = 3.14159265358979323846;
constexpr std::size_t block = std::size_t{ 1 } << 20;
constexpr std::size_t chunk = std::size_t{ 1 } << 16;

[[noreturn]] void Fail(const std::string& what)
{
  std::fprintf(stderr, "BenchReaders: error: %s\n", what.c_str());
  std::exit(1);
}

Mesh MakeMesh(double millions)
{
  const auto side = static_cast<unsigned>(std::sqrt(millions * 1e6 / 2));
  Mesh mesh;
  for (unsigned i = 0; i < side; ++i)
  {
    for (unsigned j = 0; j < side; ++j)
    {
      const double u = 2 * pi * i / side, v = 2 * pi * j / side;
      const double r = 0.45 + 0.03 * std::sin(9 * u) * std::cos(5 * v) +
                       0.001 * std::sin(411 * u + 3) * std::sin(723 * v);
      const auto single = [](double x) { return double(float(x)); };
      mesh.points.push_back({ single((1.2 + r * std::cos(v)) * std::cos(u)),
        single((1.2 + r * std::cos(v)) * std::sin(u)), single(r * std::sin(v)) });
      const auto at = [side](unsigned a, unsigned b) { return (a % side) * side + b % side; };
      mesh.triangles.push_back({ at(i, j), at(i + 1, j), at(i + 1, j + 1) });
      mesh.triangles.push_back({ at(i, j), at(i + 1, j + 1), at(i, j + 1) });
    }
  }
  return mesh;
}

// ---- files in formats that MeshWriter does not write

class Text
{
public:
  explicit Text(const std::filesystem::path& file)
    : File(std::fopen(file.c_str(), "wb"))
  {
    if (!this->File)
    {
      Fail("cannot write " + file.string());
    }
  }
  ~Text()
  {
    std::fwrite(this->Bytes.data(), 1, this->Bytes.size(), this->File);
    std::fclose(this->File);
  }
  Text& operator<<(const char* text)
  {
    this->Bytes += text;
    return *this;
  }
  template <class T>
  Text& Number(T value)
  {
    char text[40];
    this->Bytes.append(text, std::to_chars(text, text + sizeof(text), value).ptr);
    return this->Flush();
  }
  // Adds the bits in big-endian order.
  Text& Bits(std::uint32_t bits)
  {
    for (int shift = 24; shift >= 0; shift -= 8)
    {
      this->Bytes += static_cast<char>(bits >> shift);
    }
    return this->Flush();
  }
  Text& Byte(char byte)
  {
    this->Bytes += byte;
    return *this;
  }

private:
  Text& Flush()
  {
    if (this->Bytes.size() > block)
    {
      std::fwrite(this->Bytes.data(), 1, this->Bytes.size(), this->File);
      this->Bytes.clear();
    }
    return *this;
  }

  std::FILE* File;
  std::string Bytes;
};

std::string PlyHeader(const char* format, const Mesh& mesh)
{
  return "ply\nformat " + std::string(format) + " 1.0\nelement vertex " +
         std::to_string(mesh.points.size()) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
         std::to_string(mesh.triangles.size()) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

void WriteBigEndianPly(const std::filesystem::path& file, const Mesh& mesh)
{
  Text text(file);
  text << PlyHeader("binary_big_endian", mesh).c_str();
  for (const Vec3& point : mesh.points)
  {
    for (const double value : point)
    {
      const auto single = static_cast<float>(value);
      std::uint32_t bits = 0;
      std::memcpy(&bits, &single, 4);
      text.Bits(bits);
    }
  }
  for (const Triangle& triangle : mesh.triangles)
  {
    text.Byte(3).Bits(triangle[0]).Bits(triangle[1]).Bits(triangle[2]);
  }
}

void WriteTextPly(const std::filesystem::path& file, const Mesh& mesh)
{
  Text text(file);
  text << PlyHeader("ascii", mesh).c_str();
  for (const Vec3& point : mesh.points)
  {
    text.Number(float(point[0])) << " ";
    text.Number(float(point[1])) << " ";
    text.Number(float(point[2])) << "\n";
  }
  for (const Triangle& t : mesh.triangles)
  {
    text << "3 ";
    text.Number(t[0]) << " ";
    text.Number(t[1]) << " ";
    text.Number(t[2]) << "\n";
  }
}

void WriteTextStl(const std::filesystem::path& file, const Mesh& mesh)
{
  Text text(file);
  text << "solid bench\n";
  for (const Triangle& triangle : mesh.triangles)
  {
    text << " facet normal 0 0 1\n  outer loop\n";
    for (const VertexId vertex : triangle)
    {
      text << "   vertex ";
      text.Number(float(mesh.points[vertex][0])) << " ";
      text.Number(float(mesh.points[vertex][1])) << " ";
      text.Number(float(mesh.points[vertex][2])) << "\n";
    }
    text << "  endloop\n endfacet\n";
  }
  text << "endsolid bench\n";
}

// ---- floors

// Arrays of the same types as a Mesh has, with known sizes.
struct Arrays
{
  Arrays(std::size_t pointCount, std::size_t triangleCount)
    : points(new Vec3[pointCount])
    , triangles(new Triangle[triangleCount])
  {
  }
  std::unique_ptr<Vec3[]> points;
  std::unique_ptr<Triangle[]> triangles;
};

// Reads a file by fread, in blocks.
class Bare
{
public:
  explicit Bare(const std::filesystem::path& file)
    : File(std::fopen(file.c_str(), "rb"))
    , Buffer(block + 1)
  {
    if (!this->File)
    {
      Fail("cannot read " + file.string());
    }
    std::setvbuf(this->File, nullptr, _IONBF, 0);
  }
  Bare(const Bare&) = delete;
  Bare& operator=(const Bare&) = delete;
  ~Bare() { std::fclose(this->File); }

  // Makes sure that at least `wanted` bytes are in the buffer, or all that the file still has.
  const char* Need(std::size_t wanted)
  {
    if (this->End - this->Begin < wanted)
    {
      std::memmove(this->Buffer.data(), this->Buffer.data() + this->Begin, this->End - this->Begin);
      this->End -= this->Begin;
      this->Begin = 0;
      this->End += std::fread(this->Buffer.data() + this->End, 1, block - this->End, this->File);
      this->Buffer[this->End] = '\n'; // so that the last number ends there
    }
    return this->Buffer.data() + this->Begin;
  }
  void Take(std::size_t bytes) { this->Begin += bytes; }
  std::size_t Ahead() const { return this->End - this->Begin; }

  void SkipLines(std::size_t lines)
  {
    for (; lines > 0; --lines)
    {
      const char* const begin = this->Need(4096);
      this->Take(static_cast<std::size_t>(
                   static_cast<const char*>(std::memchr(begin, '\n', this->Ahead())) - begin) +
                 1);
    }
  }
  // The next number of a text; skips everything before it.
  template <class T>
  T Number()
  {
    const char* const begin = this->Need(64);
    const char* at = begin;
    while (*at <= ' ' || *at > '9')
    {
      ++at;
    }
    T value{};
    const char* const end = std::from_chars(at, at + 40, value).ptr;
    this->Take(static_cast<std::size_t>(end - begin));
    return value;
  }

private:
  std::FILE* File;
  std::vector<char> Buffer;
  std::size_t Begin = 0, End = 0;
};

template <bool Swap, class T>
T Load(const char* bytes)
{
  std::uint32_t bits = 0;
  std::memcpy(&bits, bytes, 4);
  bits = Swap ? __builtin_bswap32(bits) : bits;
  T value;
  std::memcpy(&value, &bits, 4);
  return value;
}

constexpr std::size_t plyHeaderLines = 9;

template <bool Swap>
void BareBinaryPly(
  const std::filesystem::path& file, Arrays& arrays, std::size_t points, std::size_t triangles)
{
  Bare bare(file);
  bare.SkipLines(plyHeaderLines);
  for (std::size_t i = 0; i < points; ++i)
  {
    const char* const record = bare.Need(12);
    for (std::size_t k = 0; k < 3; ++k)
    {
      arrays.points[i][k] = double(Load<Swap, float>(record + 4 * k));
    }
    bare.Take(12);
  }
  for (std::size_t i = 0; i < triangles; ++i)
  {
    const char* const record = bare.Need(13);
    for (std::size_t k = 0; k < 3; ++k)
    {
      arrays.triangles[i][k] = Load<Swap, std::uint32_t>(record + 1 + 4 * k);
    }
    bare.Take(13);
  }
}

void BareTextPly(
  const std::filesystem::path& file, Arrays& arrays, std::size_t points, std::size_t triangles)
{
  Bare bare(file);
  bare.SkipLines(plyHeaderLines);
  for (std::size_t i = 0; i < points; ++i)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      arrays.points[i][k] = double(bare.Number<float>());
    }
  }
  for (std::size_t i = 0; i < triangles; ++i)
  {
    bare.Number<std::uint32_t>();
    for (std::size_t k = 0; k < 3; ++k)
    {
      arrays.triangles[i][k] = bare.Number<std::uint32_t>();
    }
  }
}

void BareBinaryStl(
  const std::filesystem::path& file, Arrays& arrays, std::size_t, std::size_t triangles)
{
  Bare bare(file);
  bare.Need(84);
  bare.Take(84);
  for (std::size_t i = 0; i < triangles; ++i)
  {
    const char* const record = bare.Need(50);
    for (std::size_t k = 0; k < 9; ++k)
    {
      arrays.points[3 * i + k / 3][k % 3] = double(Load<false, float>(record + 12 + 4 * k));
    }
    arrays.triangles[i] = { VertexId(3 * i), VertexId(3 * i + 1), VertexId(3 * i + 2) };
    bare.Take(50);
  }
}

void BareTextStl(
  const std::filesystem::path& file, Arrays& arrays, std::size_t, std::size_t triangles)
{
  Bare bare(file);
  bare.SkipLines(1);
  for (std::size_t i = 0; i < triangles; ++i)
  {
    bare.SkipLines(2);
    for (std::size_t k = 0; k < 9; ++k)
    {
      bare.Take(k % 3 == 0 ? 9 : 0);
      arrays.points[3 * i + k / 3][k % 3] = double(bare.Number<float>());
    }
    arrays.triangles[i] = { VertexId(3 * i), VertexId(3 * i + 1), VertexId(3 * i + 2) };
    bare.SkipLines(3);
  }
}

void BareObj(
  const std::filesystem::path& file, Arrays& arrays, std::size_t points, std::size_t triangles)
{
  Bare bare(file);
  for (std::size_t i = 0; i < points; ++i)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      arrays.points[i][k] = double(bare.Number<float>());
    }
  }
  for (std::size_t i = 0; i < triangles; ++i)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      arrays.triangles[i][k] = bare.Number<std::uint32_t>() - 1;
    }
  }
}

// ---- our reader

// Returns the vertices and triangles that were read.
std::pair<std::size_t, std::size_t> ReadOurs(const std::filesystem::path& file, bool inChunks)
{
  Result<std::unique_ptr<MeshReader>> reader = MeshReader::Open(file);
  if (!reader)
  {
    Fail(file.string() + ": " + reader.GetError().message);
  }
  Mesh mesh;
  std::pair<std::size_t, std::size_t> counts;
  for (const bool triangles : { false, true })
  {
    for (;;)
    {
      const std::size_t limit = inChunks ? chunk : static_cast<std::size_t>(-1);
      const Result<std::size_t> read =
        triangles ? (*reader)->ReadTriangles(mesh, limit) : (*reader)->ReadVertices(mesh, limit);
      if (!read)
      {
        Fail(file.string() + ": " + read.GetError().message);
      }
      if (*read == 0)
      {
        break;
      }
      (triangles ? counts.second : counts.first) += *read;
      if (inChunks)
      {
        mesh.points.clear();
        mesh.triangles.clear();
      }
    }
  }
  return counts;
}

// ---- peers

template <class Reader>
void ReadByVtk(const std::filesystem::path& file)
{
  vtkNew<Reader> reader;
  reader->SetFileName(file.c_str());
  if constexpr (std::is_same_v<Reader, vtkSTLReader>)
  {
    reader->MergingOff();
  }
  reader->Update();
  if (reader->GetOutput()->GetNumberOfCells() == 0)
  {
    Fail("VTK read nothing from " + file.string());
  }
}

double SecondsOf(const std::function<void()>& work)
{
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

struct Case
{
  const char* name;
  const char* file;
  bool soup;
  std::function<void(const std::filesystem::path&, Arrays&, std::size_t, std::size_t)> bare;
  std::function<void(const std::filesystem::path&)> peer;
};

void Measure(const Case& each, const std::filesystem::path& folder, const Mesh& mesh, int rounds)
{
  const std::filesystem::path file = folder / each.file;
  const std::size_t triangles = mesh.triangles.size();
  const std::size_t points = each.soup ? 3 * triangles : mesh.points.size();
  double floor = 1e30, whole = 1e30, parts = 1e30;
  for (int i = 0; i < rounds; ++i)
  {
    floor = std::min(floor, SecondsOf(
                              [&]
                              {
                                Arrays arrays(points, triangles);
                                each.bare(file, arrays, points, triangles);
                                const Triangle& last = arrays.triangles[triangles - 1];
                                if (!each.soup && last != mesh.triangles.back())
                                {
                                  Fail("the floor has misread " + file.string());
                                }
                              }));
    for (const bool inChunks : { false, true })
    {
      double& best = inChunks ? parts : whole;
      best = std::min(best, SecondsOf(
                              [&]
                              {
                                if (ReadOurs(file, inChunks) != std::pair(points, triangles))
                                {
                                  Fail("ours has misread " + file.string());
                                }
                              }));
    }
  }
  const double peer = SecondsOf([&] { each.peer(file); });
  std::printf("%-22s %8.1f %9.3f %9.3f %7.2f %9.3f %7.2f %9.3f %7.2f\n", each.name,
    double(std::filesystem::file_size(file)) / 1e6, floor, whole, whole / floor, parts,
    parts / floor, peer, peer / floor);
  std::fflush(stdout);
}

}

int main(int argc, char** argv)
{
  const double millions = argc > 1 ? std::atof(argv[1]) : 3;
  const int rounds = argc > 2 ? std::atoi(argv[2]) : 5;
  if (millions < 0.001 || millions > 100 || rounds < 1)
  {
    std::fprintf(stderr, "usage: BenchReaders [MILLIONS_OF_TRIANGLES] [ROUNDS]\n");
    return 2;
  }
  std::string name = (std::filesystem::temp_directory_path() / "kdstream-readers-XXXXXX").string();
  if (!mkdtemp(name.data()))
  {
    Fail("cannot make a folder for temporary files");
  }
  const std::filesystem::path folder = name;
  const Mesh mesh = MakeMesh(millions);
  const bool written = WriteMesh(folder / "little.ply", mesh) &&
                       WriteMesh(folder / "binary.stl", mesh) &&
                       WriteMesh(folder / "mesh.obj", mesh);
  WriteBigEndianPly(folder / "big.ply", mesh);
  WriteTextPly(folder / "text.ply", mesh);
  WriteTextStl(folder / "text.stl", mesh);
  if (written)
  {
    std::printf("%zu vertices, %zu triangles; seconds on one thread, best of %d; ratios to the "
                "floor (fread and parse into arrays)\n",
      mesh.points.size(), mesh.triangles.size(), rounds);
    std::printf("%-22s %8s %9s %9s %7s %9s %7s %9s %7s\n", "", "MB", "floor", "one mesh", "ratio",
      "chunks", "ratio", "VTK, once", "ratio");
    const Case cases[] = {
      { "PLY little endian", "little.ply", false, BareBinaryPly<false>, ReadByVtk<vtkPLYReader> },
      { "PLY big endian", "big.ply", false, BareBinaryPly<true>, ReadByVtk<vtkPLYReader> },
      { "PLY ascii", "text.ply", false, BareTextPly, ReadByVtk<vtkPLYReader> },
      { "STL binary", "binary.stl", true, BareBinaryStl, ReadByVtk<vtkSTLReader> },
      { "STL ascii", "text.stl", true, BareTextStl, ReadByVtk<vtkSTLReader> },
      { "OBJ", "mesh.obj", false, BareObj, ReadByVtk<vtkOBJReader> },
    };
    for (const Case& each : cases)
    {
      Measure(each, folder, mesh, rounds);
    }
  }
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  return written ? 0 : 1;
}
