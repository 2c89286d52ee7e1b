#include "apps/open/server.h"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/random.h>

#include <array>

#include "apps/program/errors.h"

namespace tribotrack::apps {

namespace {

/// 128 bits that nobody can guess.
std::string secret() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw std::runtime_error("the system gives no random numbers");
  std::string text;
  for (const unsigned char byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

/// Takes the same time wherever two texts differ first.
bool same_text(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned differ = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    differ |= static_cast<unsigned char>(a[k]) ^ static_cast<unsigned char>(b[k]);
  return differ == 0;
}

constexpr const char* kOwnPolicy =
    "default-src 'none'; img-src 'self'; connect-src 'self'; script-src 'self'; style-src 'self'; frame-src "
    "'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

}  // namespace

struct LocalServer::Inside {
  httplib::Server server;
  std::string prefix = "/" + secret() + "/";
  int port = 0;
  std::function<Answer(const Asked&)> answer;

  bool is_allowed(const httplib::Request& request) const {
    const auto is_ours = [&](const std::string& host) {
      return host == fmt::format("127.0.0.1:{}", port) || host == fmt::format("localhost:{}", port);
    };
    if (request.get_header_value_count("Host") != 1 || !is_ours(request.get_header_value("Host")))
      return false;
    if (request.has_header("Origin")) {
      const std::string origin = request.get_header_value("Origin");
      if (!origin.starts_with("http://") || !is_ours(origin.substr(7))) return false;
    }
    return same_text(request.path.substr(0, prefix.size()), prefix);
  }

  void respond(const httplib::Request& request, httplib::Response& response) const {
    Asked asked{request.method == "POST", request.path.substr(prefix.size()), request.body,
                [&](const std::string& name) { return request.get_param_value(name); }};
    Answer given;
    try {
      given = answer(asked);
    } catch (const std::exception& error) {
      given = {error.what(), "text/plain; charset=utf-8", 400};
    }
    response.status = given.status;
    response.set_header("Content-Security-Policy", given.policy.empty() ? kOwnPolicy : given.policy);
    response.set_content(given.body, given.type);
  }
};

LocalServer::LocalServer(int port, std::function<Answer(const Asked&)> answer)
    : inside_(std::make_unique<Inside>()) {
  Inside& in = *inside_;
  in.answer = std::move(answer);
  constexpr std::size_t kLargestBody = 16 << 20;
  in.server.set_payload_max_length(kLargestBody);
  in.server.set_keep_alive_max_count(1);  // what is refused unread is not taken for a request of its own
  // Not SO_REUSEPORT, the library's own choice: a second listener would share the port.
  in.server.set_socket_options([](socket_t line) {
    const int yes = 1;
    ::setsockopt(line, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  in.server.set_default_headers({{"X-Content-Type-Options", "nosniff"},
                                 {"Referrer-Policy", "no-referrer"},
                                 {"Cross-Origin-Resource-Policy", "same-origin"},
                                 {"Cache-Control", "no-store"}});
  in.server.set_pre_routing_handler([&in](const httplib::Request& request, httplib::Response& response) {
    if (in.is_allowed(request)) return httplib::Server::HandlerResponse::Unhandled;
    response.status = 403;
    response.set_content("403: the address that `tribotrack open` printed is needed, whole\n", "text/plain");
    return httplib::Server::HandlerResponse::Handled;
  });
  const auto handle = [&in](const httplib::Request& request, httplib::Response& response) {
    in.respond(request, response);
  };
  in.server.Get(".*", handle);
  in.server.Post(".*", handle);
  in.port = port;
  if (port == 0)
    in.port = in.server.bind_to_any_port("127.0.0.1");
  else if (!in.server.bind_to_port("127.0.0.1", port))
    in.port = -1;
  if (in.port < 0)
    throw InvalidInput(
        "--port {}: cannot be listened at; another program has it, or only root may: give another, or none",
        port);
}

LocalServer::~LocalServer() = default;

std::string LocalServer::url() const {
  return fmt::format("http://127.0.0.1:{}{}", inside_->port, inside_->prefix);
}

void LocalServer::listen() {
  inside_->server.listen_after_bind();
}

}  // namespace tribotrack::apps
