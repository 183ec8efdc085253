// SPDX-License-Identifier: BSD-3-Clause
// Reads PCL's point clouds. Steps:
// 1. check the header against the file's size
// 2. let PCL read the file
// 3. convert points and attributes.
#include "filters/convert/FloatCoordinates.h"
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/PcdHeader.h"
#include "filters/convert/PointAttributes.h"
#include "filters/core/VectorMath.h"
#include "filters/meshio/NumberText.h"
#include "filters/meshio/TextLines.h"

#include <pcl/PCLPointCloud2.h>
#include <pcl/console/print.h>
#include <pcl/io/pcd_io.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>
#include <sstream>
#include <vector>

namespace kdstream
{
namespace
{

using Cloud = pcl::PCLPointCloud2;
using Field = pcl::PCLPointField;

std::optional<AttributeType> TypeOf(const Field& field)
{
  switch (field.datatype)
  {
    case Field::INT8:
      return AttributeType::Int8;
    case Field::UINT8:
      return AttributeType::UInt8;
    case Field::INT16:
      return AttributeType::Int16;
    case Field::UINT16:
      return AttributeType::UInt16;
    case Field::INT32:
      return AttributeType::Int32;
    case Field::UINT32:
      return AttributeType::UInt32;
    case Field::INT64:
      return AttributeType::Int64;
    case Field::UINT64:
      return AttributeType::UInt64;
    case Field::FLOAT32:
      return AttributeType::Float32;
    case Field::FLOAT64:
      return AttributeType::Float64;
    default:
      return std::nullopt;
  }
}

// Appends the words of a line, with exponents and numbers that are not finite as PCL needs them.
void AppendPlainWords(std::string_view line, std::ostream& lines)
{
  std::vector<std::string_view> words;
  SplitWords(line, " \t\r", words);
  for (const std::string_view word : words)
  {
    const std::string_view special = SpecialNumber(word);
    const std::string plain = WithPlainExponent(word);
    lines << (!special.empty() ? special : !plain.empty() ? std::string_view(plain) : word) << ' ';
  }
  lines << '\n';
}

// The text without comments, with line breaks and numbers as PCL needs them.
std::stringstream PlainLines(std::istream& text)
{
  std::stringstream lines;
  for (std::string several; std::getline(text, several);)
  {
    std::replace(several.begin(), several.end(), '\r', '\n');
    std::istringstream parts(several);
    for (std::string line; std::getline(parts, line);)
    {
      const std::size_t begin = line.find_first_not_of(" \t");
      if (begin != std::string::npos && line[begin] != '#')
      {
        AppendPlainWords(line, lines);
      }
    }
  }
  return lines;
}

// For a compressed body whose points are not compressed: some programs write this if compression
// does not help. Makes it valid LZF: before every 32 bytes, adds the mark of a run that is copied.
// REQUIRES: the body begins with its two sizes, and has this number of bytes after them.
std::vector<unsigned char> WithRunsMarked(const std::vector<unsigned char>& body)
{
  constexpr std::size_t sizes = 8, longest = 32;
  std::vector<unsigned char> marked(body.begin(), body.begin() + sizes);
  for (std::size_t at = sizes; at < body.size(); at += longest)
  {
    const std::size_t run = std::min(longest, body.size() - at);
    marked.push_back(static_cast<unsigned char>(run - 1));
    marked.insert(marked.end(), body.begin() + static_cast<std::ptrdiff_t>(at),
      body.begin() + static_cast<std::ptrdiff_t>(at + run));
  }
  const auto bytes = static_cast<std::uint32_t>(marked.size() - sizes);
  std::memcpy(marked.data(), &bytes, sizeof(bytes));
  return marked;
}

// Returns a value below 0 if PCL cannot read it. PCL gets an equivalent header, not the file's
// text.
Result<int> ReadByPcl(const std::filesystem::path& file, const PcdHeader& header, Cloud& cloud)
{
  pcl::PCDReader reader;
  Eigen::Vector4f origin;
  Eigen::Quaternionf orientation;
  int version = 0, data = 0;
  unsigned bodyBegin = 0;
  std::istringstream text(header.text);
  if (reader.readHeader(text, cloud, origin, orientation, version, data, bodyBegin) < 0)
  {
    return -1;
  }
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(header.bodyBegin));
  if (header.data == PcdData::Ascii && header.hasOddLines)
  {
    std::stringstream points = PlainLines(stream);
    return reader.readBodyASCII(points, cloud, version);
  }
  if (header.data == PcdData::Ascii)
  {
    return reader.readBodyASCII(stream, cloud, version);
  }
  std::error_code unknown;
  const std::uint64_t size = std::filesystem::file_size(file, unknown);
  const std::uint64_t bytes = header.data == PcdData::Compressed
                                ? size - header.bodyBegin
                                : header.points * header.pointBytes;
  std::vector<unsigned char> body(bytes);
  stream.read(reinterpret_cast<char*>(body.data()), static_cast<std::streamsize>(bytes));
  if (unknown || !stream)
  {
    return BadInput("truncated: the file has changed since it was opened", Remedy::Retry);
  }
  const bool isCompressed = header.data == PcdData::Compressed;
  const int read = reader.readBodyBinary(body.data(), cloud, version, isCompressed, 0);
  std::array<std::uint32_t, 2> sizes{};
  std::memcpy(sizes.data(), body.data(), isCompressed ? sizeof(sizes) : 0);
  if (read >= 0 || !isCompressed || sizes[0] != sizes[1])
  {
    return read;
  }
  body.resize(sizeof(sizes) + sizes[0]);
  return reader.readBodyBinary(WithRunsMarked(body).data(), cloud, version, true, 0);
}

Result<Cloud> ReadCloud(const std::filesystem::path& file, const PcdHeader& header)
{
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS); // our own message says what is wrong
  Cloud cloud;
  std::string reason;
  try
  {
    const Result<int> read = ReadByPcl(file, header, cloud);
    KDSTREAM_TRY(read);
    if (*read < 0)
    {
      reason = header.data == PcdData::Compressed
                 ? "its compressed points are damaged: write it again, with DATA binary"
                 : "its points cannot be read: write it again, with DATA ascii";
    }
  }
  catch (const std::bad_alloc&)
  {
    throw;
  }
  catch (const std::exception&) // of PCL and Boost
  {
    reason = "its points cannot be read: write it again, with DATA ascii";
  }
  const std::uint64_t points = std::uint64_t{ cloud.width } * cloud.height;
  if (reason.empty() && (points != header.points || cloud.data.size() != points * cloud.point_step))
  {
    reason = "the header claims " + std::to_string(header.points) + " points, PCL found " +
             std::to_string(points) + ": write it again, with DATA ascii";
  }
  if (!reason.empty())
  {
    return BadInput(reason, Remedy::InMessage);
  }
  return cloud;
}

class CloudReader
{
public:
  explicit CloudReader(const Cloud& cloud)
    : Points(cloud)
    , Size(cloud.data.size() / std::max<std::size_t>(1, cloud.point_step))
  {
  }

  Result<ForeignMesh> Read()
  {
    for (const Field& field : this->Points.fields)
    {
      const auto type = TypeOf(field);
      if (type && std::uint64_t{ field.offset } + std::uint64_t{ field.count } * SizeOf(*type) >
                    this->Points.point_step)
      {
        return Error{ ErrorCode::InvalidInput, "field '" + field.name + "' lies outside a point" };
      }
    }
    KDSTREAM_TRY(this->ReadPlaces());
    this->ReadNormals();
    this->ReadColors();
    for (const Field& field : this->Points.fields)
    {
      this->ReadOther(field);
    }
    return std::move(this->Output);
  }

private:
  const Field* Find(const char* name) const
  {
    const auto found = std::find_if(this->Points.fields.begin(), this->Points.fields.end(),
      [&](const Field& field) { return field.name == name; });
    return found == this->Points.fields.end() || !TypeOf(*found) || found->count == 0 ? nullptr
                                                                                      : &*found;
  }

  // Copies the field from the points; from all of them, or only from those that are kept.
  Attribute Copy(const Field& field, std::uint8_t components, bool all) const
  {
    const std::size_t tuples = all ? this->Size : this->Kept.size();
    Attribute copy = MakePointAttribute(field.name, *TypeOf(field), components, tuples);
    const std::size_t bytes = copy.TupleSize();
    for (std::size_t i = 0; i < tuples; ++i)
    {
      const std::size_t point = all ? i : this->Kept[i];
      std::memcpy(copy.values.data() + i * bytes,
        this->Points.data.data() + point * this->Points.point_step + field.offset, bytes);
    }
    return copy;
  }

  Status ReadPlaces()
  {
    const Field* const fields[] = { this->Find("x"), this->Find("y"), this->Find("z") };
    std::array<Attribute, 3> axes;
    Mesh& mesh = this->Output.mesh;
    for (std::size_t k = 0; k < 3; ++k)
    {
      if (!fields[k])
      {
        return Error{ ErrorCode::InvalidInput, std::string("has no field ") + "xyz"[k] };
      }
      axes[k] = this->Copy(*fields[k], 1, true);
      const bool fitsFloat = axes[k].type == AttributeType::Float32 || SizeOf(axes[k].type) <= 2;
      mesh.scalarType = fitsFloat ? mesh.scalarType : ScalarType::Float64;
    }
    for (std::size_t i = 0; i < this->Size; ++i)
    {
      const Vec3 point{ axes[0].Get(i, 0), axes[1].Get(i, 0), axes[2].Get(i, 0) };
      if (IsFinite(point))
      {
        mesh.points.push_back(point);
        this->Kept.push_back(i);
        continue;
      }
      this->Output.tolerance.Count(Lapse::PointNotFinite, 1,
        this->Kept.size() == i ? "point " + std::to_string(i) : std::string());
    }
    return {};
  }

  void ReadNormals()
  {
    const Field* const fields[] = { this->Find("normal_x"), this->Find("normal_y"),
      this->Find("normal_z") };
    if (!fields[0] || !fields[1] || !fields[2])
    {
      return;
    }
    Attribute normals = MakeNormals(this->Kept.size());
    for (std::size_t k = 0; k < 3; ++k)
    {
      const Attribute axis = this->Copy(*fields[k], 1, false);
      for (std::size_t i = 0; i < this->Kept.size(); ++i)
      {
        normals.Set(i, k, axis.Get(i, 0));
      }
    }
    this->Output.mesh.attributes.push_back(std::move(normals));
  }

  // PCL packs colours into four bytes: blue, green, red, alpha.
  void ReadColors()
  {
    const Field* const rgba = this->Find("rgba");
    const Field* const packed = rgba ? rgba : this->Find("rgb");
    if (!packed || SizeOf(*TypeOf(*packed)) != 4)
    {
      return;
    }
    Attribute colors = MakeColors(this->Kept.size(), rgba != nullptr);
    const Attribute bytes = this->Copy(*packed, 1, false);
    for (std::size_t i = 0; i < this->Kept.size(); ++i)
    {
      constexpr std::array<std::size_t, 4> order{ 2, 1, 0, 3 };
      for (std::size_t k = 0; k < colors.components; ++k)
      {
        colors.values[i * colors.components + k] = bytes.values[i * 4 + order[k]];
      }
    }
    this->Output.mesh.attributes.push_back(std::move(colors));
  }

  void ReadOther(const Field& field)
  {
    constexpr std::array<const char*, 9> read{ "x", "y", "z", "normal_x", "normal_y", "normal_z",
      "rgb", "rgba", "_" };
    if (std::find(read.begin(), read.end(), field.name) != read.end())
    {
      return;
    }
    if (!TypeOf(field) || field.count < 1 || field.count > 255)
    {
      this->Output.warnings.push_back("field '" + field.name + "' was dropped");
      return;
    }
    this->Output.mesh.attributes.push_back(
      this->Copy(field, static_cast<std::uint8_t>(field.count), false));
  }

  const Cloud& Points;
  std::size_t Size;
  std::vector<std::size_t> Kept; // the points that are finite
  ForeignMesh Output;
};

}

Result<ForeignMesh> ReadPcd(const std::filesystem::path& file, const Execution& execution)
{
  const Result<PcdHeader> header = CheckPcdHeader(file);
  KDSTREAM_TRY(header);
  KDSTREAM_TRY(execution.Report("read", 0));
  const Result<Cloud> cloud = ReadCloud(file, *header);
  KDSTREAM_TRY(cloud);
  Result<ForeignMesh> read = CloudReader(*cloud).Read();
  if (read)
  {
    read->tolerance.Add(header->tolerance);
  }
  if (read && header->hasViewpoint)
  {
    read->warnings.emplace_back("its VIEWPOINT (the scanner's position) is not applied: the "
                                "coordinates are read as they are written");
  }
  if (read && header->textOfFloats)
  {
    WarnOfFloats(*read);
  }
  return read;
}

}
