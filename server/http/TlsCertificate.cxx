// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/TlsCertificate.h"

#include "filters/core/SystemReason.h"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509err.h>

#include <cerrno>
#include <fstream>
#include <new>
#include <string>
#include <utility>

namespace kdstream
{

namespace
{

Status CheckPem(const std::string& file)
{
  std::error_code error;
  if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error))
  {
    // Reading a pipe might wait forever.
    return Error{ ErrorCode::InputOutput, file + ": is not a file" };
  }
  errno = 0;
  if (!std::ifstream(file))
  {
    return SystemError(file + ": cannot be read", errno);
  }
  return {};
}

std::shared_ptr<SSL_CTX> MakeContext()
{
  std::shared_ptr<SSL_CTX> context(SSL_CTX_new(TLS_server_method()), SSL_CTX_free);
  if (!context)
  {
    throw std::bad_alloc();
  }
  SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION);
  SSL_CTX_set_options(context.get(), SSL_OP_NO_RENEGOTIATION);
  // An idle connection releases its buffers.
  SSL_CTX_set_mode(context.get(), SSL_MODE_RELEASE_BUFFERS);
  // Without this OpenSSL asks the terminal for the passphrase.
  SSL_CTX_set_default_passwd_cb(context.get(), [](char*, int, int, void*) { return 0; });
  return context;
}

}

Status TlsCertificate::Load(
  const std::filesystem::path& certificateFile, const std::filesystem::path& keyFile)
{
  const std::string certificate = certificateFile.string(), key = keyFile.string();
  auto context = MakeContext();
  ERR_clear_error();
  KDSTREAM_TRY(CheckPem(certificate));
  if (SSL_CTX_use_certificate_chain_file(context.get(), certificate.c_str()) != 1)
  {
    return Error{ ErrorCode::InvalidInput,
      certificate + ": contains no certificate in PEM format" };
  }
  KDSTREAM_TRY(CheckPem(key));
  ERR_clear_error();
  if (SSL_CTX_use_PrivateKey_file(context.get(), key.c_str(), SSL_FILETYPE_PEM) != 1)
  {
    const bool another = ERR_GET_REASON(ERR_peek_error()) == X509_R_KEY_VALUES_MISMATCH;
    return Error{ ErrorCode::InvalidInput,
      key + (another ? ": contains the private key of another certificate than " + certificate
                     : ": contains no private key in PEM format without a passphrase") };
  }
  const std::lock_guard lock(this->Mutex);
  this->Loaded = std::move(context);
  return {};
}

std::shared_ptr<ssl_ctx_st> TlsCertificate::Current() const
{
  const std::lock_guard lock(this->Mutex);
  return this->Loaded;
}

}
