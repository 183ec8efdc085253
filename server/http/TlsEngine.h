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

// Call one function at a time, from any thread. The functions never wait, but the handshake
// computes for a millisecond or more.
class TlsEngine
{
public:
  // The engine of the server's side. Throws std::bad_alloc.
  explicit TlsEngine(ssl_ctx_st& context);

  enum class Outcome
  {
    Done,
    WantsInput, // needs input from the other side; then call it again
    Ended,      // the other side has announced that it sends nothing more
    Failed      // the input is not TLS, or not for this server
  };

  Outcome Handshake();
  // Reads up to `bytes` bytes that the other side has sent. got: their number, if the outcome is
  // Done.
  Outcome Read(void* place, std::size_t bytes, std::size_t& got);
  // Writes at most mostWritten bytes.
  Outcome Write(const void* place, std::size_t bytes);
  static constexpr std::size_t mostWritten = 16384; // what one record holds
  // Informs the other side that nothing more will be written.
  void EndOutput();

  // Passes bytes from the socket to the engine. Throws std::bad_alloc.
  void PutInput(const void* place, std::size_t bytes);
  // Whether any of the calls has produced bytes to send.
  bool HasOutput() const;
  // Takes the bytes to send; they replace the content of `bytes`.
  void TakeOutput(std::vector<char>& bytes);

private:
  Outcome Explain(int result);

  std::unique_ptr<ssl_st, void (*)(ssl_st*)> Connection;
  bio_st* Input = nullptr; // belongs to the connection
  bio_st* Output = nullptr;
};

}
