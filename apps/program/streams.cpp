#include "apps/program/streams.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace tribotrack::apps {

namespace {

[[noreturn]] void fail() {
  throw WriteError(fmt::format("write error: {}", std::strerror(errno)));
}

}  // namespace

void print_text(std::string_view text) {
  errno = 0;
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size()) fail();
}

void flush_output() {
  errno = 0;
  if (std::fflush(stdout) != 0) fail();
}

void print_error(std::string_view line) {
  std::string text(line);
  text += '\n';
  std::fwrite(text.data(), 1, text.size(), stderr);
}

void complain(std::string_view message) {
  std::string shown(message);
  const auto controls_terminals = [](unsigned char c) {
    return (c < 0x20 && c != '\n' && c != '\t') || c == 0x7F;
  };
  std::ranges::replace_if(shown, controls_terminals, '?');  // messages repeat what a damaged file holds
  print_error(fmt::format("tribotrack: {}", shown));
}

void occupy_standard_streams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream)
    if (::fcntl(stream, F_GETFD) == -1 && errno == EBADF) {
      // Writing to a stdout opened for reading fails: results that nobody receives are an error.
      const int opened = ::open("/dev/null", stream == STDOUT_FILENO ? O_RDONLY : O_RDWR);
      if (opened != stream && opened >= 0) {
        ::dup2(opened, stream);
        ::close(opened);
      }
    }
}

}  // namespace tribotrack::apps
