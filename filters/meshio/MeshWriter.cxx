// Writing a mesh: .ply (binary, little endian), .stl (binary), .obj, .vtp and .wrl.
#include "filters/meshio/MeshWriter.h"

#include "filters/meshio/FileEnding.h"
#include "filters/meshio/OutputFile.h"

#include <cmath>
#include <limits>
#include <string>

namespace kdstream
{

namespace
{

// Calls `write(value)` for every coordinate in the type of the mesh.
template <class Write>
void ForEachCoordinate(const Mesh& mesh, Write&& write)
{
  for (const Vec3& point : mesh.points)
  {
    for (double value : point)
    {
      if (mesh.scalarType == ScalarType::Float32)
      {
        write(static_cast<float>(value));
      }
      else
      {
        write(value);
      }
    }
  }
}

void WritePly(OutputFile& file, const Mesh& mesh)
{
  const std::string type = mesh.scalarType == ScalarType::Float32 ? "float" : "double";
  file.Write("ply\nformat binary_little_endian 1.0\nelement vertex ");
  file.WriteText(mesh.points.size());
  for (const char* name : { "x", "y", "z" })
  {
    file.Write("\nproperty " + type + " " + name);
  }
  if (!mesh.triangles.empty())
  {
    file.Write("\nelement face ");
    file.WriteText(mesh.triangles.size());
    file.Write("\nproperty list uchar int vertex_indices");
  }
  file.Write("\nend_header\n");
  ForEachCoordinate(mesh, [&file](auto value) { file.WriteLittleEndian(value); });
  for (const Triangle& triangle : mesh.triangles)
  {
    file.WriteLittleEndian(std::uint8_t{ 3 });
    for (VertexId corner : triangle)
    {
      file.WriteLittleEndian(corner);
    }
  }
}

// Unit normal of a triangle; zero if it has none.
Vec3 NormalOf(const Vec3& a, const Vec3& b, const Vec3& c)
{
  const Vec3 u{ b[0] - a[0], b[1] - a[1], b[2] - a[2] };
  const Vec3 v{ c[0] - a[0], c[1] - a[1], c[2] - a[2] };
  const Vec3 n{ u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0] };
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (!(length > 0) || !std::isfinite(length))
  {
    return { 0, 0, 0 };
  }
  return { n[0] / length, n[1] / length, n[2] / length };
}

void WriteStl(OutputFile& file, const Mesh& mesh)
{
  // It must not begin with "solid", by which text files are told; VTK looks for a byte that is not
  // ASCII instead.
  std::string header = "binary STL written by KdStream";
  header.resize(80, '\xff');
  file.Write(header);
  file.WriteLittleEndian(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Triangle& triangle : mesh.triangles)
  {
    const Vec3& a = mesh.points[triangle[0]];
    const Vec3& b = mesh.points[triangle[1]];
    const Vec3& c = mesh.points[triangle[2]];
    for (const Vec3& vector : { NormalOf(a, b, c), a, b, c })
    {
      for (double value : vector)
      {
        file.WriteLittleEndian(static_cast<float>(value));
      }
    }
    file.WriteLittleEndian(std::uint16_t{ 0 });
  }
}

// "x y z" and the line's end for every point, with `before` in front.
void WritePointLines(OutputFile& file, const Mesh& mesh, std::string_view before)
{
  unsigned axis = 0;
  ForEachCoordinate(mesh,
    [&](auto value)
    {
      file.Write(axis == 0 ? before : " ");
      file.WriteText(value);
      axis = (axis + 1) % 3;
      file.Write(axis == 0 ? "\n" : "");
    });
}

void WriteObj(OutputFile& file, const Mesh& mesh)
{
  WritePointLines(file, mesh, "v ");
  for (const Triangle& triangle : mesh.triangles)
  {
    file.Write("f");
    for (VertexId corner : triangle)
    {
      file.Write(" ");
      file.WriteText(std::uint64_t{ corner } + 1);
    }
    file.Write("\n");
  }
}

void WriteVrml(OutputFile& file, const Mesh& mesh)
{
  const bool cloud = mesh.triangles.empty();
  file.Write(
    "#VRML V2.0 utf8\nShape {\nappearance Appearance { material Material { } }\ngeometry ");
  file.Write(cloud ? "PointSet {\n" : "IndexedFaceSet {\nsolid FALSE\n");
  file.Write("coord Coordinate { point [\n");
  WritePointLines(file, mesh, "");
  file.Write("] }\n");
  if (!cloud)
  {
    file.Write("coordIndex [\n");
    for (const Triangle& triangle : mesh.triangles)
    {
      for (VertexId corner : triangle)
      {
        file.WriteText(corner);
        file.Write(" ");
      }
      file.Write("-1\n");
    }
    file.Write("]\n");
  }
  file.Write("}\n}\n");
}

// One array of a .vtp, whose bytes lie in the appended block, each array's after its length.
class VtpArrays
{
public:
  // The XML of an array of `bytes` bytes.
  std::string Declare(const char* type, const char* name, int components, std::uint64_t bytes)
  {
    std::string text = "<DataArray type=\"" + std::string(type) + "\" Name=\"" + name +
                       "\" NumberOfComponents=\"" + std::to_string(components) +
                       "\" format=\"appended\" offset=\"" + std::to_string(this->Offset) + "\"/>\n";
    this->Offset += sizeof(std::uint64_t) + bytes;
    return text;
  }

private:
  std::uint64_t Offset = 0;
};

// VTK's XML with raw appended data: VTK and ParaView read it bit for bit.
void WriteVtp(OutputFile& file, const Mesh& mesh)
{
  const bool cloud = mesh.triangles.empty();
  const bool single = mesh.scalarType == ScalarType::Float32;
  const std::uint64_t cells = cloud ? mesh.points.size() : mesh.triangles.size();
  const std::uint64_t corners = cloud ? 1 : 3;
  const std::uint64_t pointBytes =
    mesh.points.size() * 3 * (single ? sizeof(float) : sizeof(double));
  const std::uint64_t connectivityBytes = cells * corners * sizeof(std::int64_t);
  const std::uint64_t offsetBytes = cells * sizeof(std::int64_t);
  const std::string number = std::to_string(cells);
  const std::string section = cloud ? "Verts" : "Polys";

  VtpArrays arrays;
  file.Write("<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
             "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n");
  file.Write("<Piece NumberOfPoints=\"" + std::to_string(mesh.points.size()) +
             "\" NumberOfVerts=\"" + (cloud ? number : "0") +
             "\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"" +
             (cloud ? "0" : number) + "\">\n");
  file.Write("<Points>\n" +
             arrays.Declare(single ? "Float32" : "Float64", "Points", 3, pointBytes) +
             "</Points>\n");
  // One statement each: every declaration takes the next place in the appended block.
  file.Write("<" + section + ">\n");
  file.Write(arrays.Declare("Int64", "connectivity", 1, connectivityBytes));
  file.Write(arrays.Declare("Int64", "offsets", 1, offsetBytes));
  file.Write("</" + section + ">\n");
  file.Write("</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_");

  file.WriteLittleEndian(pointBytes);
  ForEachCoordinate(mesh, [&file](auto value) { file.WriteLittleEndian(value); });
  file.WriteLittleEndian(connectivityBytes);
  for (std::uint64_t i = 0; i < cells; ++i)
  {
    for (std::uint64_t k = 0; k < corners; ++k)
    {
      file.WriteLittleEndian(static_cast<std::int64_t>(cloud ? i : mesh.triangles[i][k]));
    }
  }
  file.WriteLittleEndian(offsetBytes);
  for (std::uint64_t i = 0; i < cells; ++i)
  {
    file.WriteLittleEndian(static_cast<std::int64_t>((i + 1) * corners));
  }
  file.Write("\n</AppendedData>\n</VTKFile>\n");
}

using WriteFormat = void (*)(OutputFile&, const Mesh&);

WriteFormat FormatOf(const std::string& ending)
{
  return ending == ".ply"   ? WritePly
         : ending == ".stl" ? WriteStl
         : ending == ".obj" ? WriteObj
         : ending == ".vtp" ? WriteVtp
         : ending == ".wrl" ? WriteVrml
                            : nullptr;
}

Status CheckMesh(const Mesh& mesh, bool isStl)
{
  constexpr std::uint64_t mostPoints =
    std::uint64_t{ std::numeric_limits<std::int32_t>::max() } + 1;
  constexpr std::uint64_t mostStlTriangles = std::numeric_limits<std::uint32_t>::max();
  if (mesh.points.size() > mostPoints)
  {
    return Error{ ErrorCode::LimitExceeded, std::to_string(mesh.points.size()) +
                                              " points: more than " + std::to_string(mostPoints) +
                                              ", which the format can number" };
  }
  if (isStl && mesh.triangles.size() > mostStlTriangles)
  {
    return Error{ ErrorCode::LimitExceeded,
      std::to_string(mesh.triangles.size()) + " triangles: more than " +
        std::to_string(mostStlTriangles) + ", which STL can count" };
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
  {
    for (VertexId corner : mesh.triangles[i])
    {
      if (corner >= mesh.points.size())
      {
        return Error{ ErrorCode::InvalidInput,
          "triangle " + std::to_string(i) + ": index " + std::to_string(corner) +
            " out of range (" + std::to_string(mesh.points.size()) + " vertices)" };
      }
    }
  }
  return {};
}

}

Status WriteMesh(const std::filesystem::path& file, const Mesh& mesh)
{
  const std::string ending = FileEnding(file);
  const WriteFormat write = FormatOf(ending);
  if (write == nullptr)
  {
    return Error{ ErrorCode::Unsupported,
      "the ending '" + ending +
        "' names no format that can be written (.ply, .stl, .obj, .vtp, .wrl)" };
  }
  if (Status checked = CheckMesh(mesh, ending == ".stl"); !checked)
  {
    return checked;
  }
  OutputFile output;
  if (Status opened = output.Open(file); !opened)
  {
    return opened;
  }
  write(output, mesh);
  return output.Finish();
}

}
