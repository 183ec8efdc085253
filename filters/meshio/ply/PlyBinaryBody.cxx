// SPDX-License-Identifier: BSD-3-Clause
// Binary PLY records of either byte order. Records of fixed size are decoded a batch at a time,
// column by column; runs of triangles have their own loop; everything else is read value by value.
// Part of step "read".
#include "filters/core/WithType.h"
#include "filters/meshio/MakeRoom.h"
#include "filters/meshio/ply/PlyBinaryRecord.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace kdstream
{

namespace
{

// Records decoded together: their bytes and their points stay in the nearest caches.
constexpr std::size_t elementBatch = 1024;

template <bool Swap>
class BinaryBody : public PlyBody
{
public:
  explicit BinaryBody(ByteSource& source)
    : Source(source)
  {
  }

  Status SkipRecords(const PlyElement& element, std::uint64_t first, std::uint64_t count) override;
  Result<bool> ReadPoints(const PlyElement& element, const std::array<std::size_t, 3>& coordinates,
    std::uint64_t first, std::uint64_t count, std::vector<Vec3>& points,
    PlyArraySink& arrays) override;
  Status ReadFaces(const PlyElement& element, std::size_t list, std::uint64_t first,
    std::uint64_t count, PlyFaceSink& sink, PlyArraySink& arrays) override;

private:
  Status SkipProperties(const PlyPlace& place, std::size_t begin, std::size_t end);
  Status KeepOrSkip(
    const PlyPlace& place, std::size_t begin, std::size_t end, PlyArraySink& arrays);
  Result<std::string_view> Need(const PlyPlace& place, std::size_t bytes);
  Result<std::int64_t> ReadListCount(const PlyPlace& place, const PlyProperty& property);
  Result<bool> ReadFixedPoints(const PlyElement& element,
    const std::array<std::size_t, 3>& coordinates, std::size_t recordSize, std::uint64_t first,
    std::uint64_t count, std::vector<Vec3>& points, PlyArraySink& arrays);
  Status ReadPoint(const PlyPlace& place, const std::array<std::size_t, 3>& coordinates,
    Vec3& point, PlyArraySink& arrays);
  Status ReadFace(const PlyPlace& place, std::size_t list, PlyFaceSink& sink, PlyArraySink& arrays);
  template <bool Keeps>
  Result<std::size_t> ReadFaceRun(const FaceLayout& layout, const PlyPlace& first,
    std::uint64_t count, PlyFaceSink& sink, PlyArraySink& arrays);
  static void KeepRecord(
    const FaceLayout& layout, const char* list, const char* afterList, PlyArraySink& arrays);

  static std::int64_t LoadInteger(AttributeType type, const char* bytes);
  static std::optional<std::int64_t> LoadWhole(AttributeType type, const char* bytes);
  static double LoadReal(AttributeType type, const char* bytes);
  // Reads coordinate k of records that are `stride` bytes apart; true if all values are finite.
  template <class T>
  static bool DecodeColumn(
    const char* bytes, std::size_t stride, std::size_t count, Vec3* points, std::size_t k);

  // Copies `count` values of records that are `stride` bytes apart.
  template <class T>
  static void CopyColumn(const char* from, std::size_t stride, std::size_t count, std::uint8_t* to,
    std::size_t toStride);

  ByteSource& Source;
};

template <bool Swap>
std::int64_t BinaryBody<Swap>::LoadInteger(AttributeType type, const char* bytes)
{
  return WithType(
    type, [bytes]<class T>() { return static_cast<std::int64_t>(Load<T, Swap>(bytes)); });
}

template <bool Swap>
std::optional<std::int64_t> BinaryBody<Swap>::LoadWhole(AttributeType type, const char* bytes)
{
  return WithType(type, [bytes]<class T>() { return WholeNumber(Load<T, Swap>(bytes)); });
}

template <bool Swap>
double BinaryBody<Swap>::LoadReal(AttributeType type, const char* bytes)
{
  return WithType(type, [bytes]<class T>() { return static_cast<double>(Load<T, Swap>(bytes)); });
}

// Returns the next `bytes` bytes, which belong to the record at `place`.
template <bool Swap>
Result<std::string_view> BinaryBody<Swap>::Need(const PlyPlace& place, std::size_t bytes)
{
  Result<std::string_view> ahead = this->Source.Peek(bytes);
  if (ahead && ahead->size() < bytes)
  {
    return place.Truncated(this->Source.Position());
  }
  return ahead;
}

template <bool Swap>
Result<std::int64_t> BinaryBody<Swap>::ReadListCount(
  const PlyPlace& place, const PlyProperty& property)
{
  const std::size_t countSize = SizeOf(property.countType);
  const Result<std::string_view> ahead = this->Need(place, countSize);
  KDSTREAM_TRY(ahead);
  const std::optional<std::int64_t> count = LoadWhole(property.countType, ahead->data());
  if (!count)
  {
    return place.Bad("the count of list " + property.name + " is not a whole number");
  }
  this->Source.Consume(countSize);
  if (*count < 0)
  {
    return place.BadListCount(property, *count);
  }
  if (static_cast<std::uint64_t>(*count) > this->Source.Remaining() / SizeOf(property.type))
  {
    return place.ListPastEnd(property, *count, this->Source.Position());
  }
  return *count;
}

template <bool Swap>
Status BinaryBody<Swap>::SkipProperties(const PlyPlace& place, std::size_t begin, std::size_t end)
{
  for (std::size_t k = begin; k < end; ++k)
  {
    const PlyProperty& property = place.element.properties[k];
    std::uint64_t bytes = SizeOf(property.type);
    if (property.isList)
    {
      const Result<std::int64_t> count = this->ReadListCount(place, property);
      KDSTREAM_TRY(count);
      bytes *= static_cast<std::uint64_t>(*count);
    }
    if (bytes > this->Source.Remaining())
    {
      return place.Truncated(this->Source.Position());
    }
    this->Source.Seek(this->Source.Position() + bytes);
  }
  return {};
}

// Like SkipProperties, but values that belong to an array are kept in it.
template <bool Swap>
Status BinaryBody<Swap>::KeepOrSkip(
  const PlyPlace& place, std::size_t begin, std::size_t end, PlyArraySink& arrays)
{
  if (arrays.Empty())
  {
    return this->SkipProperties(place, begin, end);
  }
  for (std::size_t k = begin; k < end; ++k)
  {
    std::uint8_t* const to = arrays.PlaceOf(k);
    if (!to)
    {
      KDSTREAM_TRY(this->SkipProperties(place, k, k + 1));
      continue;
    }
    const AttributeType type = place.element.properties[k].type;
    const Result<std::string_view> ahead = this->Need(place, SizeOf(type));
    KDSTREAM_TRY(ahead);
    WithType(type, [&]<class T>() { CopyColumn<T>(ahead->data(), 0, 1, to, 0); });
    this->Source.Consume(SizeOf(type));
  }
  return {};
}

template <bool Swap>
Status BinaryBody<Swap>::SkipRecords(
  const PlyElement& element, std::uint64_t first, std::uint64_t count)
{
  const RecordSize size = SizeOfProperties(element, 0, element.properties.size());
  if (size.fixed)
  {
    if (size.bytes == 0)
    {
      return {};
    }
    const std::uint64_t whole = this->Source.Remaining() / size.bytes;
    if (whole < count)
    {
      return PlyPlace{ element, first + whole }.Truncated(
        this->Source.Position() + whole * size.bytes);
    }
    this->Source.Seek(this->Source.Position() + count * size.bytes);
    return {};
  }
  for (std::uint64_t i = 0; i < count; ++i)
  {
    KDSTREAM_TRY(
      this->SkipProperties(PlyPlace{ element, first + i }, 0, element.properties.size()));
  }
  return {};
}

template <bool Swap>
template <class T>
bool BinaryBody<Swap>::DecodeColumn(
  const char* bytes, std::size_t stride, std::size_t count, Vec3* points, std::size_t k)
{
  bool finite = true;
  for (std::size_t i = 0; i < count; ++i)
  {
    const double value = static_cast<double>(Load<T, Swap>(bytes + i * stride));
    points[i][k] = value;
    finite &= std::isfinite(value);
  }
  return finite;
}

template <bool Swap>
template <class T>
void BinaryBody<Swap>::CopyColumn(
  const char* from, std::size_t stride, std::size_t count, std::uint8_t* to, std::size_t toStride)
{
  for (std::size_t i = 0; i < count; ++i)
  {
    const T value = Load<T, Swap>(from + i * stride);
    std::memcpy(to + i * toStride, &value, sizeof(T));
  }
}

template <bool Swap>
Result<bool> BinaryBody<Swap>::ReadFixedPoints(const PlyElement& element,
  const std::array<std::size_t, 3>& coordinates, std::size_t recordSize, std::uint64_t first,
  std::uint64_t count, std::vector<Vec3>& points, PlyArraySink& arrays)
{
  const std::vector<std::size_t> offsets = OffsetsOf(element);
  MakeRoom(points, std::min(count, this->Source.Remaining() / recordSize));
  std::array<Vec3, elementBatch> batch;
  bool finite = true;
  for (std::uint64_t done = 0; done < count;)
  {
    const Result<std::string_view> ahead =
      this->Need(PlyPlace{ element, first + done }, recordSize);
    KDSTREAM_TRY(ahead);
    const std::size_t number = static_cast<std::size_t>(
      std::min<std::uint64_t>({ count - done, ahead->size() / recordSize, elementBatch }));
    for (std::size_t k = 0; k < 3; ++k)
    {
      const char* column = ahead->data() + offsets[coordinates[k]];
      finite &= WithType(element.properties[coordinates[k]].type,
        [&]<class T>() { return DecodeColumn<T>(column, recordSize, number, batch.data(), k); });
    }
    points.insert(points.end(), batch.begin(), batch.begin() + static_cast<std::ptrdiff_t>(number));
    for (const PlyArraySink::Column& column : arrays.Columns())
    {
      const std::size_t tuple = arrays.TupleSize(column.array);
      // The first column of an array makes room for the array's tuples.
      std::uint8_t* const to = column.tupleOffset == 0
                                 ? arrays.Extend(column.array, number)
                                 : arrays.Last(column.array, number) + column.tupleOffset;
      WithType(column.type,
        [&]<class T>() {
          CopyColumn<T>(ahead->data() + offsets[column.property], recordSize, number, to, tuple);
        });
    }
    this->Source.Consume(number * recordSize);
    done += number;
  }
  return finite;
}

// Reads a point whose record has lists, too.
template <bool Swap>
Status BinaryBody<Swap>::ReadPoint(const PlyPlace& place,
  const std::array<std::size_t, 3>& coordinates, Vec3& point, PlyArraySink& arrays)
{
  for (std::size_t p = 0; p < place.element.properties.size(); ++p)
  {
    const auto* wanted = std::find(coordinates.begin(), coordinates.end(), p);
    if (wanted == coordinates.end())
    {
      KDSTREAM_TRY(this->KeepOrSkip(place, p, p + 1, arrays));
      continue;
    }
    const PlyProperty& property = place.element.properties[p];
    const std::size_t bytes = SizeOf(property.type);
    const Result<std::string_view> ahead = this->Need(place, bytes);
    KDSTREAM_TRY(ahead);
    const double value = LoadReal(property.type, ahead->data());
    this->Source.Consume(bytes);
    point[static_cast<std::size_t>(wanted - coordinates.begin())] = value;
  }
  return {};
}

template <bool Swap>
Result<bool> BinaryBody<Swap>::ReadPoints(const PlyElement& element,
  const std::array<std::size_t, 3>& coordinates, std::uint64_t first, std::uint64_t count,
  std::vector<Vec3>& points, PlyArraySink& arrays)
{
  const RecordSize size = SizeOfProperties(element, 0, element.properties.size());
  if (size.fixed && size.bytes <= ByteSource::blockSize)
  {
    return this->ReadFixedPoints(element, coordinates, size.bytes, first, count, points, arrays);
  }
  for (std::uint64_t i = 0; i < count; ++i)
  {
    Vec3 point{};
    KDSTREAM_TRY(this->ReadPoint(PlyPlace{ element, first + i }, coordinates, point, arrays));
    points.push_back(point);
    arrays.Append(1);
  }
  return false;
}

// The fast path: reads faces while they are completely in memory and have few corners and valid
// indices; returns how many. ReadFace handles the face at which it stops, or reports what is wrong
// with it. Keeps: whether there are arrays.
template <bool Swap>
template <bool Keeps>
Result<std::size_t> BinaryBody<Swap>::ReadFaceRun(const FaceLayout& layout, const PlyPlace& first,
  std::uint64_t count, PlyFaceSink& sink, PlyArraySink& arrays)
{
  const Result<std::string_view> ahead = this->Source.Peek(layout.triangleSize);
  KDSTREAM_TRY(ahead);
  std::array<Triangle, elementBatch + mostFastCorners> batch;
  std::size_t used = 0;
  std::size_t number = 0;
  std::size_t at = 0;
  while (number < count && used < elementBatch && ahead->size() - at >= layout.triangleSize)
  {
    const char* list = ahead->data() + at + layout.listOffset;
    const std::int64_t corners = LoadInteger(layout.countType, list);
    if (corners < 3 || corners > mostFastCorners)
    {
      break;
    }
    const std::size_t triangles = static_cast<std::size_t>(corners) - 2;
    const std::size_t recordSize = layout.triangleSize + (triangles - 1) * sizeof(VertexId);
    if (ahead->size() - at < recordSize)
    {
      break;
    }
    const char* index = list + layout.countSize;
    const VertexId apex = Load<VertexId, Swap>(index);
    VertexId second = Load<VertexId, Swap>(index + sizeof(VertexId));
    VertexId largest = std::max(apex, second);
    for (std::size_t i = 0; i < triangles; ++i)
    {
      const VertexId third = Load<VertexId, Swap>(index + (2 + i) * sizeof(VertexId));
      batch[used + i] = { apex, second, third };
      largest = std::max(largest, third);
      second = third;
    }
    if (largest >= layout.indexLimit)
    {
      break;
    }
    if constexpr (Keeps)
    {
      KeepRecord(
        layout, list, index + static_cast<std::size_t>(corners) * sizeof(VertexId), arrays);
      if (!arrays.Append(triangles))
      {
        return PlyPlace{ first.element, first.record + number }.RepeatsTooMuch();
      }
    }
    sink.EndFace(sink.GetTriangles().size() + used, triangles);
    used += triangles;
    at += recordSize;
    ++number;
  }
  sink.GetTriangles().insert(
    sink.GetTriangles().end(), batch.begin(), batch.begin() + static_cast<std::ptrdiff_t>(used));
  this->Source.Consume(at);
  return number;
}

// Keeps the array values of a face whose whole record is in memory.
template <bool Swap>
void BinaryBody<Swap>::KeepRecord(
  const FaceLayout& layout, const char* list, const char* afterList, PlyArraySink& arrays)
{
  for (const PlyArraySink::Column& column : arrays.Columns())
  {
    const char* const from =
      column.property < layout.cornerList
        ? list - layout.listOffset + layout.offsets[column.property]
        : afterList + layout.offsets[column.property] - layout.offsets[layout.cornerList + 1];
    WithType(column.type,
      [&]<class T>() { CopyColumn<T>(from, 0, 1, arrays.PlaceOf(column.property), 0); });
  }
}

template <bool Swap>
Status BinaryBody<Swap>::ReadFace(
  const PlyPlace& place, std::size_t list, PlyFaceSink& sink, PlyArraySink& arrays)
{
  const std::size_t before = sink.GetTriangles().size();
  KDSTREAM_TRY(this->KeepOrSkip(place, 0, list, arrays));
  const PlyProperty& property = place.element.properties[list];
  const Result<std::int64_t> count = this->ReadListCount(place, property);
  KDSTREAM_TRY(count);
  const std::size_t itemSize = SizeOf(property.type);
  sink.Begin();
  for (std::uint64_t left = static_cast<std::uint64_t>(*count); left > 0;)
  {
    const Result<std::string_view> ahead = this->Need(place, itemSize);
    KDSTREAM_TRY(ahead);
    const std::size_t number =
      static_cast<std::size_t>(std::min<std::uint64_t>(left, ahead->size() / itemSize));
    for (std::size_t i = 0; i < number; ++i)
    {
      const auto index = LoadWhole(property.type, ahead->data() + i * itemSize);
      if (!index)
      {
        return place.Bad("an index of list " + property.name + " is not a whole number");
      }
      if (!sink.Add(*index))
      {
        return place.BadIndex(*index, sink);
      }
    }
    this->Source.Consume(number * itemSize);
    left -= number;
  }
  sink.End(place.record);
  KDSTREAM_TRY(this->KeepOrSkip(place, list + 1, place.element.properties.size(), arrays));
  const std::size_t triangles = sink.GetTriangles().size() - before;
  sink.EndFace(before, triangles);
  return arrays.Append(triangles) ? Status{} : place.RepeatsTooMuch();
}

template <bool Swap>
Status BinaryBody<Swap>::ReadFaces(const PlyElement& element, std::size_t list, std::uint64_t first,
  std::uint64_t count, PlyFaceSink& sink, PlyArraySink& arrays)
{
  const FaceLayout layout(element, list, sink);
  if (layout.applies)
  {
    MakeRoom(sink.GetTriangles(), std::min(count, this->Source.Remaining() / layout.triangleSize));
  }
  for (std::uint64_t done = 0; done < count;)
  {
    if (layout.applies)
    {
      const PlyPlace place{ element, first + done };
      const Result<std::size_t> run =
        arrays.Empty()
          ? this->template ReadFaceRun<false>(layout, place, count - done, sink, arrays)
          : this->template ReadFaceRun<true>(layout, place, count - done, sink, arrays);
      KDSTREAM_TRY(run);
      done += *run;
      if (*run > 0)
      {
        continue;
      }
    }
    KDSTREAM_TRY(this->ReadFace(PlyPlace{ element, first + done }, list, sink, arrays));
    ++done;
  }
  return {};
}

}

std::unique_ptr<PlyBody> MakePlyBinaryBody(ByteSource& source, bool bigEndian)
{
  if (bigEndian == (std::endian::native == std::endian::big))
  {
    return std::make_unique<BinaryBody<false>>(source);
  }
  return std::make_unique<BinaryBody<true>>(source);
}

}
