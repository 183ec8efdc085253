// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/ServeOptions.h"

#include "filters/page/PagePlace.h"

#include <arpa/inet.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <thread>

namespace kdstream
{

namespace
{

// Parses "HOST:PORT", with [brackets] around an IPv6 address. Throws the error that CLI11 reports.
ListenAddress ParseAddress(const std::string& text)
{
  const auto colon = text.rfind(':');
  const auto digits = colon == text.npos ? std::string() : text.substr(colon + 1);
  const bool isPort = !digits.empty() && digits.size() <= 5 &&
                      digits.find_first_not_of("0123456789") == digits.npos &&
                      std::stoul(digits) <= 65535;
  auto host = text.substr(0, colon);
  const bool inBrackets = host.size() > 2 && host.front() == '[' && host.back() == ']';
  host = inBrackets ? host.substr(1, host.size() - 2) : host;
  if (!isPort || host.empty() || (!inBrackets && host.find(':') != host.npos))
  {
    throw CLI::ValidationError(
      "--admin", text + " is not an address and a port, such as 127.0.0.1:9100");
  }
  return { host, static_cast<std::uint16_t>(std::stoul(digits)) };
}

// A check whose message begins with the value: "…" is not WHAT.
template <class Holds>
CLI::Validator Must(const std::string& be, const Holds& holds)
{
  return { [be, holds](const std::string& text)
    { return holds(text) ? std::string() : "\"" + text + "\" is not " + be; },
    "" };
}

// Used instead of CLI::Range, which accepts a text that is not a number at all ("nan") for any
// range.
CLI::Validator NumberFrom(double least, double most)
{
  char words[80], range[80];
  std::snprintf(words, sizeof words, "a number from %.10g to %.10g", least, most);
  std::snprintf(range, sizeof range, "FLOAT in [%.10g - %.10g]", least, most); // for the help
  return Must(words,
    [least, most](const std::string& text)
    {
      double value = 0;
      return CLI::detail::lexical_cast(text, value) && value >= least && value <= most;
    })
    .description(range);
}

CLI::Validator SizeFromOne()
{
  return Must("a size of at least 1", // other errors are reported by the option itself
    [](const std::string& text)
    {
      const auto size = ParseSize(text);
      return !size || *size != 0;
    });
}

bool IsOf(std::string_view text, std::string_view characters)
{
  return !text.empty() && text.find_first_not_of(characters) == text.npos;
}

bool IsAddressOf6(const std::string& text)
{
  in6_addr address{};
  return ::inet_pton(AF_INET6, text.c_str(), &address) == 1;
}

constexpr std::string_view smallAndDigits = "abcdefghijklmnopqrstuvwxyz0123456789";

// Whether the text is a host as in the field Host, without the port: a name, or an address (IPv6 in
// brackets).
bool IsHost(const std::string& text)
{
  if (text.size() > 2 && text.front() == '[' && text.back() == ']')
  {
    return IsAddressOf6(text.substr(1, text.size() - 2));
  }
  auto small = text;
  std::transform(small.begin(), small.end(), small.begin(),
    [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return IsOf(small, std::string(smallAndDigits) + ".-_") && small.front() != '.';
}

// Whether the text is an origin as browsers send it: SCHEME://HOST or SCHEME://HOST:PORT, in lower
// case, without the scheme's default port.
bool IsOrigin(const std::string& text)
{
  const auto colon = text.find("://");
  if (colon == text.npos || !IsOf(text.substr(0, colon), std::string(smallAndDigits) + "+.-"))
  {
    return false;
  }
  const auto scheme = text.substr(0, colon), rest = text.substr(colon + 3);
  const auto bracket = rest.rfind(']');
  const auto before = rest.find(':', bracket == rest.npos ? 0 : bracket);
  const auto host = rest.substr(0, before);
  const auto port = before == rest.npos ? std::string("1") : rest.substr(before + 1);
  const bool isSmall =
    std::none_of(host.begin(), host.end(), [](unsigned char c) { return std::isupper(c) != 0; });
  const bool isPort = IsOf(port, "0123456789") && port.size() <= 5 && port.front() != '0' &&
                      std::stoul(port) <= 65535;
  const bool isSchemesOwn =
    (scheme == "http" && port == "80") || (scheme == "https" && port == "443");
  return isSmall && IsHost(host) && isPort && !isSchemesOwn;
}

void AddAddress(CLI::App& app, HttpServerOptions& server)
{
  const char* const address = "Address";
  app
    .add_option(
      "--host", server.address.host, "name or address to listen on; 0.0.0.0: all networks")
    ->type_name("ADDRESS")
    ->capture_default_str()
    ->group(address);
  app.add_option("--port", server.address.port, "port to listen on; 0: any free port")
    ->check(CLI::Range(0, 65535))
    ->type_name("N")
    ->capture_default_str()
    ->group(address);
  auto* certificate =
    app.add_option("--tls-cert", server.tlsCertificate, "serve HTTPS with this certificate (PEM)")
      ->type_name("FILE")
      ->group(address);
  auto* key = app
                .add_option("--tls-key", server.tlsKey,
                  "private key of the certificate (PEM, without a passphrase)")
                ->type_name("FILE")
                ->group(address);
  certificate->needs(key);
  key->needs(certificate);
  app
    .add_option_function<std::int64_t>(
      "--hsts",
      [&server](std::int64_t value) { server.strictTransport = std::chrono::seconds(value); },
      "with HTTPS: how long browsers must refuse plain HTTP for this host (HSTS); 0: not at all")
    ->check(CLI::Range(std::int64_t{ 0 }, std::int64_t{ 1000000000 }))
    ->type_name("SECONDS")
    ->default_str(std::to_string(server.strictTransport.count()))
    ->group(address);
  app
    .add_option_function<std::string>(
      "--admin", [&server](const std::string& text) { server.admin = ParseAddress(text); },
      "serve the metrics only at this HOST:PORT, over plain HTTP")
    ->type_name("ADDRESS")
    ->group(address);
}

void AddProxies(CLI::App& app, HttpServerOptions& server)
{
  const char* const address = "Address";
  auto* proxies =
    app
      .add_option("--trusted-proxy", server.trustedProxies,
        "address or network of a trusted proxy, whose X-Forwarded-For is used; may be repeated")
      ->check(Must("an address or a network, such as 10.0.0.1 or 10.0.0.0/8", IsNetwork))
      ->type_name("ADDRESS")
      ->allow_extra_args(false)
      ->group(address);
  app
    .add_flag("--proxy-protocol", server.proxyProtocol,
      "connections of the trusted proxy begin with a PROXY protocol header, version 1 or 2")
    ->needs(proxies)
    ->group(address);
  app
    .add_option("--allow-host", server.allowedHosts,
      "host name that requests may use; may be repeated [default: any; on loopback: localhost, "
      "addresses, names without a dot]")
    ->check(Must(
      "a host, without scheme and port, such as models.example.org, 192.0.2.1 or [2001:db8::1]",
      IsHost))
    ->type_name("HOST")
    ->allow_extra_args(false)
    ->group(address);
}

void AddPages(CLI::App& app, ServeOptions& line)
{
  const char* const pages = "Pages";
  app
    .add_option("--web", line.web,
      "serve the files of this folder at / [default: the web viewer installed with this program]")
    ->type_name("DIR")
    ->group(pages);
  app
    .add_option("--address", line.server.publicAddress,
      "public address of the viewer, which models' pages name to messengers and search engines "
      "[default: that of a request whose host --allow-host names; else none]")
    ->check(Must("an address such as https://models.example.org or https://example.org/3d/",
      [](const std::string& text) { return IsPageRoot(text); }))
    ->transform([](const std::string& text) { return text.ends_with('/') ? text : text + "/"; })
    ->type_name("URL")
    ->group(pages);
  CheckText(
    app.add_option("--site-title", line.site.title, "title that the page shows above the list"))
    ->group(pages);
  CheckText(
    app.add_option("--site-text", line.site.text, "a line that the page shows below the title"))
    ->group(pages);
  app
    .add_option("--allow-origin", line.server.allowOrigin,
      "allow web pages of this origin to read from this server (CORS); *: any origin")
    ->check(Must("* or an origin in the form that browsers send, such as https://example.org or "
                 "http://localhost:3000",
      [](const std::string& text) { return text == "*" || IsOrigin(text); }))
    ->type_name("ORIGIN")
    ->group(pages);
}

// Removes the percent sign from a number in percent: "5%" means 5.
std::string WithoutPercent(std::string text)
{
  if (text.size() > 1 && text.back() == '%')
  {
    text.pop_back();
  }
  return text;
}

// The options that limit how much of the original the bearers of tokens may have.
void AddQuotas(CLI::App& app, ServeOptions& line, CLI::Option* tokens)
{
  const char* const access = "Access";
  auto* const file = app
                       .add_option("--quota-file", line.quotaFile,
                         "database of the quotas (SQLite); servers that share it share the quotas")
                       ->type_name("FILE")
                       ->needs(tokens)
                       ->group(access);
  const auto add = [file, access](CLI::Option* option) { option->needs(file)->group(access); };
  add(
    app
      .add_option_function<double>(
        "--quota-partitions", [&line](double percent) { line.quotas.share = percent / 100; },
        "percentage of a model's partitions that a name (--sub) may load per window [default: all]")
      ->transform(WithoutPercent)
      ->check(NumberFrom(1e-9, 100))
      ->type_name("PERCENT"));
  add(app
        .add_option_function<std::int64_t>(
          "--quota-window",
          [&line](std::int64_t value) { line.quotas.window = std::chrono::seconds(value); },
          "length of the window for --quota-partitions")
        ->check(CLI::Range(std::int64_t{ 1 }, std::int64_t{ 1000000000 }))
        ->type_name("SECONDS")
        ->default_str(std::to_string(line.quotas.window.count())));
  add(AddSizeOption(app, "--quota-bytes", line.quotas.bytesPerSecond,
    "bytes per second that a name may load of a model's partitions [default: no limit]")
        ->check(SizeFromOne()));
  add(app
        .add_option("--quota-regions", line.quotas.regionsPerMinute,
          "regions per minute that a name may request of a model [default: no limit]")
        ->check(CLI::Range(1U, 1000000U))
        ->type_name("N"));
}

void AddAccess(CLI::App& app, ServeOptions& line)
{
  auto* const tokens =
    app
      .add_option("--tokens", line.tokens,
        "require a token that is signed with a key in this file (JSON); kdstream-serve token makes "
        "tokens [default: everybody may load everything]")
      ->type_name("FILE")
      ->group("Access");
  CheckText(app.add_option("--contact", line.server.contact,
              "who runs this server and how to get a token, for visitors who have none"))
    ->needs(tokens)
    ->group("Access");
  AddQuotas(app, line, tokens);
  app
    .add_option("--audit-log", line.auditLog,
      "log each partition that a client gets, as a line of JSON, to this file; -: stderr")
    ->type_name("FILE")
    ->group("Access");
}

// The options that limit each client, and all clients together.
void AddLimits(CLI::App& app, HttpServerOptions& server)
{
  const char* const limits = "Limits";
  app
    .add_option("--max-connections", server.maximumConnections,
      "maximum simultaneous clients; more get status 503")
    ->check(CLI::Range(std::size_t{ 1 }, std::size_t{ 1000000 }))
    ->capture_default_str()
    ->group(limits);
  app
    .add_option("--max-per-address", server.connectionsOfAddress,
      "maximum simultaneous clients per address; more get status 429; 0: no limit [default: 100, "
      "no limit for this machine]")
    ->type_name("N")
    ->group(limits);
  app
    .add_option("--requests-per-minute", server.requestsOfAddress,
      "maximum requests per minute and address; more get status 429; 0: no limit [default: 6000, "
      "no limit for this machine]")
    ->type_name("N")
    ->group(limits);
  app
    .add_option("--max-header", server.headerBytes,
      "maximum size of a request's header, with its token; larger ones get status 431")
    ->check(CLI::Range(std::size_t{ 1024 }, std::size_t{ 1 } << 20))
    ->type_name("N")
    ->capture_default_str()
    ->group(limits);
}

// The options that limit the requests of one stream.
void AddStreamLimits(CLI::App& app, ConversationLimits& stream)
{
  const char* const limits = "Limits";
  app
    .add_option("--max-message", stream.message.bytes,
      "maximum size of a message on a stream; larger ones close the stream (413); viewers send at "
      "most 4096 bytes")
    ->check(CLI::Range(protocol::maximumClientMessageBytes, std::size_t{ 1 } << 20))
    ->type_name("N")
    ->capture_default_str()
    ->group(limits);
  app
    .add_option("--max-list", stream.message.listed,
      "maximum pieces, partitions or nodes in a message on a stream; more are refused")
    ->check(CLI::Range(std::size_t{ 1 }, std::size_t{ 1 } << 20))
    ->type_name("N")
    ->capture_default_str()
    ->group(limits);
  app
    .add_option("--max-requests", stream.requests,
      "maximum unfinished requests per stream; more are refused (429)")
    ->check(CLI::Range(std::size_t{ 1 }, std::size_t{ 1024 }))
    ->type_name("N")
    ->capture_default_str()
    ->group(limits);
  app.add_option("--max-region", stream.partitions, "maximum partitions of a requested region")
    ->check(CLI::Range(std::size_t{ 1 }, std::size_t{ 1 } << 30))
    ->type_name("N")
    ->capture_default_str()
    ->group(limits);
}

CLI::Option* AddSeconds(CLI::App& app, const std::string& name, std::chrono::milliseconds& time,
  double least, const std::string& help)
{
  return app
    .add_option_function<double>(
      name, [&time](double value) { time = std::chrono::milliseconds(std::llround(value * 1000)); },
      help)
    ->check(NumberFrom(least, 1e6))
    ->type_name("SECONDS")
    ->default_str(std::to_string(time.count() / 1000));
}

// The options for how long a client may take.
void AddPatience(CLI::App& app, ServeOptions& line)
{
  const char* const patience = "Timeouts";
  constexpr double least = 0.001;
  auto& server = line.server;
  AddSeconds(app, "--request-timeout", server.requestTimeout, least,
    "maximum time for a TLS handshake and for sending a request")
    ->group(patience);
  AddSeconds(app, "--answer-timeout", server.answerTimeout, least,
    "maximum time for receiving a response, or 64 KiB of a stream, plus a second for each "
    "--slowest bytes")
    ->group(patience);
  AddSizeOption(
    app, "--slowest", line.slowest, "minimum bytes per second that a client must receive")
    ->check(SizeFromOne())
    ->default_str("16K")
    ->group(patience);
  AddSeconds(app, "--stream-timeout", server.streamTimeout, least,
    "time after which a silent stream is closed")
    ->group(patience);
  AddSeconds(app, "--idle-timeout", server.idleTimeout, least,
    "time after which an idle stream may be closed to make room for another client")
    ->group(patience);
  AddSeconds(app, "--drain", server.drainTimeout, 0,
    "maximum time for finishing the requests in flight when the server stops; new ones are refused")
    ->group(patience);
}

// The options for threads, memory and similar resources.
void AddWork(CLI::App& app, ServeOptions& line)
{
  const char* const work = "Work";
  app.add_option("--threads", line.server.threads, "threads that serve requests")
    ->check(CLI::Range(1U, 1024U))
    ->capture_default_str()
    ->group(work);
  app.add_option("--readers", line.server.readers, "threads that read from disk")
    ->check(CLI::Range(1U, 1024U))
    ->capture_default_str()
    ->group(work);
  AddSizeOption(app, "--cache-memory", line.cacheBytes, "memory for caching blobs")
    ->default_str("256M")
    ->group(work);
  app
    .add_option(
      "--grace", line.grace, "how long the old digest of a replaced store is still served")
    ->check(CLI::Range(std::chrono::seconds::rep{ 0 }, std::chrono::seconds::rep{ 1000000 }))
    ->type_name("SECONDS")
    ->capture_default_str()
    ->group(work);
  app.add_option("--access-log", line.accessLog, "log each request to this file; -: stderr")
    ->type_name("FILE")
    ->group(work);
}

}

void AddServeOptions(CLI::App& app, ServeOptions& line)
{
  line.server.address.port = 8700;
  line.server.threads = std::max(2U, std::thread::hardware_concurrency());
  app.add_option("DIR", line.folder, "the folder of the stores")->required();
  AddAddress(app, line.server);
  AddProxies(app, line.server);
  AddPages(app, line);
  AddAccess(app, line);
  AddLimits(app, line.server);
  AddStreamLimits(app, line.server.stream);
  AddPatience(app, line);
  AddWork(app, line);
}

}
