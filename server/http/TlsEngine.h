// SPDX-License-Identifier: BSD-3-Clause
// TLS of one connection without its socket: bytes go in, bytes come out. Internal to the server.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

struct ssl_st;
struct ssl_ctx_st;
struct bio_st;

namespace kdstream
{

// Functions: one at a time, from any thread. They do not wait; the handshake computes for a
// millisecond or more.
class TlsEngine
{
public:
  // The server's side. Throws std::bad_alloc.
  explicit TlsEngine(ssl_ctx_st& context);

  enum class Outcome
  {
    Done,
    WantsInput, // needs input from the other side; then call it again
    Ended,      // the other side has announced that it sends nothing more
    Failed      // the input is not TLS, or not for this server
  };

  Outcome Handshake();
  // Reads up to `bytes` bytes from the other side; got: their number, if Done.
  Outcome Read(void* place, std::size_t bytes, std::size_t& got);
  // At most mostWritten bytes.
  Outcome Write(const void* place, std::size_t bytes);
  static constexpr std::size_t mostWritten = 16384; // what one record holds
  // Informs the other side that nothing more will be written.
  void EndOutput();

  // What the socket has brought. Throws std::bad_alloc.
  void PutInput(const void* place, std::size_t bytes);
  // Whether any of the calls has made something to send.
  bool HasOutput() const;
  // Takes it, in place of what `bytes` held.
  void TakeOutput(std::vector<char>& bytes);

private:
  Outcome Explain(int result);

  std::unique_ptr<ssl_st, void (*)(ssl_st*)> Connection;
  bio_st* Input = nullptr; // the connection's
  bio_st* Output = nullptr;
};

}
