// Pages for one reader on this machine: what asks for them must know a secret that stands in their address.
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace tribotrack::apps {

struct Asked {
  bool post = false;
  std::string path;  ///< below the secret: "", "state", "out/report.html"
  std::string body;
  std::function<std::string(const std::string& name)> parameter;  ///< of the query; "" where it is missing
};

struct Answer {
  std::string body;
  std::string type = "application/json";
  int status = 200;
  std::string policy = {};  ///< Content-Security-Policy instead of the one that lets a page load its own
};

/// Listens at 127.0.0.1 alone. A request without the secret, to another host's name or from another origin's
/// page is answered 403 and goes no further.
class LocalServer {
 public:
  /// `port` 0: a free one. Throws InvalidInput where it is taken.
  LocalServer(int port, std::function<Answer(const Asked&)> answer);
  ~LocalServer();
  LocalServer(const LocalServer&) = delete;
  LocalServer& operator=(const LocalServer&) = delete;
  std::string url() const;  ///< "http://127.0.0.1:8137/SECRET/"
  void listen();            ///< until the process ends

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace tribotrack::apps
