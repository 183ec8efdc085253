// SPDX-License-Identifier: BSD-3-Clause
// For tests: one blocking TLS connection to 127.0.0.1 that accepts any certificate.
#pragma once

#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <algorithm>
#include <cstdint>
#include <string>

namespace kdstream
{

class TlsTestClient
{
public:
  // introduction: bytes that are sent before TLS begins.
  explicit TlsTestClient(std::uint16_t port, const std::string& introduction = {})
    : Context(SSL_CTX_new(TLS_client_method()))
  {
    BIO* plain = BIO_new_connect(("127.0.0.1:" + std::to_string(port)).c_str());
    this->Connected = BIO_do_connect(plain) == 1;
    if (!introduction.empty())
    {
      BIO_write(plain, introduction.data(), static_cast<int>(introduction.size()));
    }
    this->Connection = BIO_push(BIO_new_ssl(this->Context, 1), plain);
    this->Connected = this->Connected && BIO_do_handshake(this->Connection) == 1;
  }
  ~TlsTestClient()
  {
    BIO_free_all(this->Connection);
    SSL_CTX_free(this->Context);
  }
  TlsTestClient(const TlsTestClient&) = delete;
  TlsTestClient& operator=(const TlsTestClient&) = delete;

  bool IsConnected() const { return this->Connected; }

  // The name in the server's certificate.
  std::string ServerName() const
  {
    X509* certificate = SSL_get_peer_certificate(this->Session());
    char name[100] = "";
    X509_NAME_get_text_by_NID(
      X509_get_subject_name(certificate), NID_commonName, name, sizeof name);
    X509_free(certificate);
    return name;
  }

  // Marks the session, so that the next write makes the server change its key, and reply that it
  // has.
  void ChangeKeys() { SSL_key_update(this->Session(), SSL_KEY_UPDATE_REQUESTED); }

  void Send(const std::string& bytes)
  {
    if (this->Connected && !bytes.empty())
    {
      BIO_write(this->Connection, bytes.data(), static_cast<int>(bytes.size()));
    }
  }

  // Receives what the server sends, until that contains `end` or the server stops sending.
  std::string Receive(const std::string& end)
  {
    std::string received;
    char bytes[4096];
    for (int n = this->Connected ? 1 : 0; n > 0 && received.find(end) == std::string::npos;)
    {
      n = BIO_read(this->Connection, bytes, sizeof bytes);
      received.append(bytes, static_cast<std::size_t>(std::max(n, 0)));
    }
    return received;
  }
  // Receives the next `count` bytes, or fewer if the server stops sending.
  std::string Receive(std::size_t count)
  {
    std::string received(count, '\0');
    std::size_t got = 0;
    for (int n = 1; n > 0 && got < count;)
    {
      n = BIO_read(this->Connection, received.data() + got, static_cast<int>(count - got));
      got += static_cast<std::size_t>(std::max(n, 0));
    }
    received.resize(got);
    return received;
  }

  // Whether the server announces the end before its connection ends.
  bool EndsProperly()
  {
    this->Receive(std::string("\0 never", 7));
    return (SSL_get_shutdown(this->Session()) & SSL_RECEIVED_SHUTDOWN) != 0;
  }

private:
  SSL* Session() const
  {
    SSL* session = nullptr;
    BIO_get_ssl(this->Connection, &session);
    return session;
  }

  SSL_CTX* Context;
  BIO* Connection = nullptr;
  bool Connected = false;
};

}
