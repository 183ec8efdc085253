// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/Metrics.h"

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

}

void Metrics::CountRequest(unsigned status)
{
  if (status < this->Requests.size())
  {
    ++this->Requests[status];
  }
}

std::string Metrics::Text() const
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
  Put(text, "kdstream_connections", "gauge", "Connections that are open, streams included.",
    this->OpenConnections);
  Put(text, "kdstream_refused_connections_total", "counter",
    "Connections refused because there were too many.", this->RefusedConnections);
  Put(text, "kdstream_streams", "gauge", "WebSocket streams that are open.", this->OpenStreams);
  Put(text, "kdstream_streams_total", "counter", "WebSocket streams opened.", this->TotalStreams);
  Put(text, "kdstream_failed_blobs_total", "counter",
    "Blobs that could not be read from their store.", this->FailedBlobs);
  return text;
}

}
