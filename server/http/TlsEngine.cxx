// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/TlsEngine.h"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/ssl.h>

#include <algorithm>
#include <new>

namespace kdstream
{

TlsEngine::TlsEngine(ssl_ctx_st& context)
  : Connection(SSL_new(&context), SSL_free)
{
  this->Input = BIO_new(BIO_s_mem());
  this->Output = BIO_new(BIO_s_mem());
  if (!this->Connection || this->Input == nullptr || this->Output == nullptr)
  {
    BIO_free(this->Input);
    BIO_free(this->Output);
    ERR_clear_error();
    throw std::bad_alloc();
  }
  SSL_set_bio(this->Connection.get(), this->Input, this->Output);
  SSL_set_accept_state(this->Connection.get());
}

TlsEngine::Outcome TlsEngine::Handshake()
{
  ERR_clear_error();
  return this->Explain(SSL_do_handshake(this->Connection.get()));
}

TlsEngine::Outcome TlsEngine::Read(void* place, std::size_t bytes, std::size_t& got)
{
  ERR_clear_error();
  return this->Explain(SSL_read_ex(this->Connection.get(), place, bytes, &got));
}

TlsEngine::Outcome TlsEngine::Write(const void* place, std::size_t bytes)
{
  ERR_clear_error();
  std::size_t written = 0; // writing to memory takes all bytes
  return this->Explain(
    SSL_write_ex(this->Connection.get(), place, std::min(bytes, mostWritten), &written));
}

void TlsEngine::EndOutput()
{
  ERR_clear_error();
  SSL_shutdown(this->Connection.get());
  ERR_clear_error();
}

void TlsEngine::PutInput(const void* place, std::size_t bytes)
{
  if (BIO_write(this->Input, place, static_cast<int>(bytes)) != static_cast<int>(bytes))
  {
    ERR_clear_error();
    throw std::bad_alloc();
  }
}

bool TlsEngine::HasOutput() const
{
  return BIO_ctrl_pending(this->Output) != 0;
}

void TlsEngine::TakeOutput(std::vector<char>& bytes)
{
  bytes.resize(BIO_ctrl_pending(this->Output));
  BIO_read(this->Output, bytes.data(), static_cast<int>(bytes.size()));
}

TlsEngine::Outcome TlsEngine::Explain(int result)
{
  if (result > 0)
  {
    return Outcome::Done;
  }
  switch (SSL_get_error(this->Connection.get(), result))
  {
    case SSL_ERROR_WANT_READ:
      return Outcome::WantsInput;
    case SSL_ERROR_ZERO_RETURN:
      return Outcome::Ended;
    default:
      ERR_clear_error();
      return Outcome::Failed;
  }
}

}
