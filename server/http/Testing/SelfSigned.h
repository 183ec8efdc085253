// SPDX-License-Identifier: BSD-3-Clause
// Makes certificates for tests.
#pragma once

#include <openssl/pem.h>
#include <openssl/x509.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

namespace kdstream
{

using PrivateKey = std::unique_ptr<EVP_PKEY, void (*)(EVP_PKEY*)>;

inline PrivateKey MakeKey()
{
  return { EVP_RSA_gen(2048), EVP_PKEY_free };
}

// Writes the key, protected by a passphrase unless that is empty.
inline void WriteKey(const std::filesystem::path& file, EVP_PKEY* key, std::string passphrase = {})
{
  std::FILE* out = std::fopen(file.c_str(), "w");
  PEM_write_PrivateKey(out, key, passphrase.empty() ? nullptr : EVP_aes_128_cbc(),
    reinterpret_cast<unsigned char*>(passphrase.data()), static_cast<int>(passphrase.size()),
    nullptr, nullptr);
  std::fclose(out);
}

// Writes a self-signed certificate. Its validity begins an hour ago and lasts for this number of
// seconds.
inline void WriteCertificate(
  const std::filesystem::path& file, EVP_PKEY* key, const std::string& name, long seconds = 7200)
{
  const std::unique_ptr<X509, void (*)(X509*)> x509(X509_new(), X509_free);
  ASN1_INTEGER_set(X509_get_serialNumber(x509.get()), 1);
  X509_gmtime_adj(X509_getm_notBefore(x509.get()), -3600);
  X509_gmtime_adj(X509_getm_notAfter(x509.get()), seconds - 3600);
  X509_set_pubkey(x509.get(), key);
  X509_NAME* subject = X509_get_subject_name(x509.get());
  X509_NAME_add_entry_by_txt(
    subject, "CN", MBSTRING_ASC, reinterpret_cast<const unsigned char*>(name.c_str()), -1, -1, 0);
  X509_set_issuer_name(x509.get(), subject);
  X509_sign(x509.get(), key, EVP_sha256());
  std::FILE* out = std::fopen(file.c_str(), "w");
  PEM_write_X509(out, x509.get());
  std::fclose(out);
}

// Writes a new key and a certificate for it.
inline void WriteSelfSigned(const std::filesystem::path& certificate,
  const std::filesystem::path& key, const std::string& name = "localhost")
{
  const auto pair = MakeKey();
  WriteCertificate(certificate, pair.get(), name);
  WriteKey(key, pair.get());
}

}
