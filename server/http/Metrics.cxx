// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/Metrics.h"

#include <algorithm>
#include <cstdio>
#include <string_view>

namespace kdstream
{

namespace
{

void Put(std::string& text, const char* name, const char* type, const char* help)
{
  text += std::string("# HELP ") + name + " " + help + "\n# TYPE " + name + " " + type + "\n";
}

void Put(
  std::string& text, const char* name, const char* type, const char* help, std::uint64_t value)
{
  Put(text, name, type, help);
  text += std::string(name) + " " + std::to_string(value) + "\n";
}

// Writes a line for each label.
template <class Labels, class Counters>
void PutEach(std::string& text, const char* start, const Labels& labels, const Counters& counters)
{
  for (std::size_t i = 0; i < labels.size(); ++i)
  {
    text += std::string(start) + "=\"" + labels[i] + "\"} " + std::to_string(counters[i]) + "\n";
  }
}

}

void Histogram::Count(double value)
{
  const auto place =
    std::lower_bound(this->Bounds.begin(), this->Bounds.end(), value) - this->Bounds.begin();
  ++this->Counts[static_cast<std::size_t>(place)];
  this->Sum += value;
}

void Histogram::Write(std::string& text, const char* name, const char* help) const
{
  Put(text, name, "histogram", help);
  const std::string start(name);
  std::uint64_t count = 0;
  const auto bucket = [&](std::string_view bound)
  { text += start + "_bucket{le=\"" + std::string(bound) + "\"} " + std::to_string(count) + "\n"; };
  for (std::size_t i = 0; i < this->Bounds.size(); ++i)
  {
    count += this->Counts[i];
    char bound[32];
    std::snprintf(bound, sizeof bound, "%g", this->Bounds[i]);
    bucket(bound);
  }
  count += this->Counts[this->Bounds.size()];
  bucket("+Inf");
  char sum[32];
  std::snprintf(sum, sizeof sum, "%.9g", this->Sum.load());
  text += start + "_sum " + sum + "\n" + start + "_count " + std::to_string(count) + "\n";
}

void Metrics::CountRequest(unsigned status)
{
  if (status < this->Requests.size())
  {
    ++this->Requests[status];
  }
}

std::string Metrics::Text(
  const CacheUse& memory, std::uint64_t lostLines, const CacheUse& tiles) const
{
  std::string text;
  Put(text, "kdstream_requests_total", "counter", "HTTP requests answered, by status.");
  for (std::size_t status = 0; status < this->Requests.size(); ++status)
  {
    if (const std::uint64_t count = this->Requests[status])
    {
      text += "kdstream_requests_total{status=\"" + std::to_string(status) + "\"} " +
              std::to_string(count) + "\n";
    }
  }
  Put(text, "kdstream_sent_bytes_total", "counter", "Bytes of bodies and stream messages sent.",
    this->SentBytes);
  Put(text, "kdstream_connections", "gauge", "Open connections, including streams.",
    this->OpenConnections);
  Put(text, "kdstream_refused_connections_total", "counter",
    "Connections refused because there were too many.", this->RefusedConnections);
  constexpr std::array<const char*, static_cast<std::size_t>(Reason::Count)> reasons{ "address",
    "requests", "host", "slow", "idle", "descriptors", "stopping", "handshake", "proxy", "token",
    "quota", "origin" };
  Put(text, "kdstream_refusals_total", "counter", "Clients refused or disconnected, by reason.");
  PutEach(text, "kdstream_refusals_total{reason", reasons, this->Refusals);
  constexpr std::array<const char*, static_cast<std::size_t>(Failure::Count)> failures{ "accept",
    "connection", "answer", "quota", "disk" };
  Put(text, "kdstream_failures_total", "counter",
    "Failures caused by memory, descriptors or the disk.");
  PutEach(text, "kdstream_failures_total{what", failures, this->Failures);
  Put(text, "kdstream_lost_log_lines_total", "counter", "Log lines that could not be written.",
    lostLines);
  Put(text, "kdstream_streams", "gauge", "Open WebSocket streams.", this->OpenStreams);
  Put(text, "kdstream_streams_total", "counter", "WebSocket streams opened.", this->TotalStreams);
  Put(text, "kdstream_failed_blobs_total", "counter",
    "Blobs that could not be read from their store.", this->FailedBlobs);
  Put(text, "kdstream_cache_hits_total", "counter", "Blobs found in memory.", memory.hits);
  Put(text, "kdstream_cache_misses_total", "counter", "Blobs read from a store.", memory.misses);
  Put(text, "kdstream_cache_bytes", "gauge", "Bytes of the blobs in memory.", memory.bytes);
  Put(
    text, "kdstream_tile_hits_total", "counter", "Files of tilesets found in memory.", tiles.hits);
  Put(text, "kdstream_tile_misses_total", "counter", "Files of tilesets that were made.",
    tiles.misses);
  Put(text, "kdstream_tile_bytes", "gauge", "Bytes of the tiles and tilesets in memory.",
    tiles.bytes);
  const std::uint64_t begun = this->Begun;
  const std::uint64_t queued = this->Queued;
  Put(text, "kdstream_reader_queue", "gauge", "Requests waiting for a reader.",
    queued > begun ? queued - begun : 0);
  this->Lengths.Write(text, "kdstream_reader_queue_length",
    "Requests waiting for a reader when another one arrived.");
  this->Waits.Write(
    text, "kdstream_reader_wait_seconds", "Time that requests waited for a reader.");
  this->Answers.Write(
    text, "kdstream_answer_seconds", "Time from an HTTP request to the end of its response.");
  this->FirstBlobs.Write(
    text, "kdstream_first_blob_seconds", "Time from a request on a stream to its first blob.");
  this->LastBlobs.Write(
    text, "kdstream_last_blob_seconds", "Time from a request on a stream to its last blob.");
  return text;
}

}
