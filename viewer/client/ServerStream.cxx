// SPDX-License-Identifier: BSD-3-Clause
// Bytes to and from a server, plain or in TLS.
#include "viewer/client/ServerStream.h"

#include "filters/core/SystemReason.h"

#include <boost/asio/ip/address.hpp>

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include <cerrno>
#include <fstream>

namespace kdstream
{
namespace
{

namespace asio = boost::asio;
using boost::system::error_code;

bool IsAddress(const std::string& host)
{
  error_code error;
  asio::ip::make_address(host, error);
  return !error;
}

}

Result<std::shared_ptr<asio::ssl::context>> MakeTlsContext(const std::string& authorities)
{
  auto context = std::make_shared<asio::ssl::context>(asio::ssl::context::tls_client);
  SSL_CTX_set_min_proto_version(context->native_handle(), TLS1_2_VERSION);
  context->set_verify_mode(asio::ssl::verify_peer);
  if (authorities.empty())
  {
    context->set_default_verify_paths();
    return context;
  }
  errno = 0;
  if (!std::ifstream(authorities))
  {
    return Error{ ErrorCode::NotFound, authorities + ": cannot be read: " + SystemReason(errno) };
  }
  error_code error;
  context->load_verify_file(authorities, error);
  if (error)
  {
    return Error{ ErrorCode::InvalidInput,
      authorities + ": contains no certificate in PEM format" };
  }
  return context;
}

ServerStream::ServerStream(
  asio::io_context& context, ServerUrl server, std::shared_ptr<asio::ssl::context> tls)
  : Server(std::move(server))
  , Resolver(context)
  , Plain(context)
  , Tls(std::move(tls))
{
}

void ServerStream::Connect(std::chrono::seconds atMost, std::function<void(Status)> done)
{
  this->Secure.reset();
  this->Resolver.async_resolve(this->Server.host, this->Server.port,
    [this, atMost, done = std::move(done)](error_code error, const auto& endpoints)
    {
      if (error)
      {
        done(Error{ ErrorCode::InputOutput, error.message() });
        return;
      }
      this->Plain.expires_after(atMost);
      this->Plain.async_connect(endpoints,
        [this, atMost, done](error_code failure, const auto&)
        {
          failure ? done(Error{ ErrorCode::InputOutput, failure.message() })
                  : this->Introduce(atMost, done);
        });
    });
}

// The TLS handshake, in which the server's certificate is checked.
void ServerStream::Introduce(std::chrono::seconds atMost, std::function<void(Status)> done)
{
  if (!this->Tls)
  {
    done({});
    return;
  }
  const Status prepared = this->PrepareTls();
  if (!prepared)
  {
    done(prepared);
    return;
  }
  this->Plain.expires_after(atMost);
  this->Secure->async_handshake(asio::ssl::stream_base::client,
    [this, done = std::move(done)](error_code error)
    { done(error ? Status(this->NotTrusted(error)) : Status()); });
}

Status ServerStream::PrepareTls()
{
  this->Secure.emplace(this->Plain, *this->Tls);
  SSL* const tls = this->Secure->native_handle();
  const std::string& host = this->Server.host;
  const bool ready =
    IsAddress(host)
      ? X509_VERIFY_PARAM_set1_ip_asc(SSL_get0_param(tls), host.c_str()) == 1
      : SSL_set1_host(tls, host.c_str()) == 1 && SSL_set_tlsext_host_name(tls, host.c_str()) == 1;
  return ready ? Status() : Error{ ErrorCode::LimitExceeded, "out of memory for TLS" };
}

Error ServerStream::NotTrusted(const error_code& error)
{
  const long trust = SSL_get_verify_result(this->Secure->native_handle());
  if (trust != X509_V_OK)
  {
    return { ErrorCode::InvalidInput,
      std::string("its certificate is not trusted: ") + X509_verify_cert_error_string(trust) };
  }
  return error.category() == asio::error::get_ssl_category()
           ? Error{ ErrorCode::InvalidInput, "the TLS handshake failed: " + error.message() }
           : Error{ ErrorCode::InputOutput, error.message() };
}

void ServerStream::Close()
{
  this->Resolver.cancel();
  this->Plain.close();
}

}
